// Disney's principled model of 2012, written by hand: the yardstick for the GLSL that `gonio export disney`
// makes.
//
// From Burley, "Physically-based shading at Disney", SIGGRAPH 2012 course notes, and its code disney.brdf,
// with linear colours and the masking of the notes, by an engine programmer who wants all digits of a float32.
// `gonio bench shaders` and `gonio cost --by-hand` compare the two.

struct Disney {
    vec3 base_color;
    float subsurface;
    float metallic;
    float specular;
    float specular_tint;
    float roughness;
    float anisotropic;
    float sheen;
    float sheen_tint;
    float clearcoat;
    float clearcoat_gloss;
};

// mu + sqrt(mu^2 + a2 sin^2) = 2 mu / G1 of GGX
float disney_smith(float mu, float a2) {
    return mu + sqrt(a2 + (1.0 - a2) * (mu * mu));
}

vec3 disney_eval(Disney params, vec3 wi, vec3 wo) {
    if (min(wi.z, wo.z) <= 0.0) {
        return vec3(0.0);
    }
    vec3 h = wi + wo;
    vec3 d = wi - wo;
    vec3 hh = h * h;
    float hxy = hh.x + hh.y;
    float length2 = max(hxy + hh.z, 1.0e-36);
    float cos2 = 0.25 * length2;

    // Schlick's (1 - c)^5; at the half vector 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is a quarter of |d|^2
    float k = 0.25 * dot(d, d) / (1.0 + sqrt(cos2));
    float F_H = k * k;
    F_H = F_H * F_H * k;
    float ki = 1.0 - wi.z;
    float ki2 = ki * ki;
    float ki4 = ki2 * ki2;
    float F_i = ki4 * ki;
    float ko = 1.0 - wo.z;
    float ko2 = ko * ko;
    float ko4 = ko2 * ko2;
    float F_o = ko4 * ko;

    // Diffuse and subsurface; 1 - k^5 = (1 - k) (1 + k + k^2 + k^3 + k^4) keeps the digits of the latter
    float F_ss90 = cos2 * params.roughness;
    float F_d90 = 2.0 * F_ss90 - 0.5;
    float F_d = (1.0 + F_d90 * F_i) * (1.0 + F_d90 * F_o);
    float F_ss = (wi.z * ((1.0 + ki) * (1.0 + ki2) + ki4) + F_ss90 * F_i)
        * (wo.z * ((1.0 + ko) * (1.0 + ko2) + ko4) + F_ss90 * F_o);
    float ss = 1.25 * (F_ss * (1.0 / (wi.z + wo.z) - 0.5) + 0.5);
    float diffuse = 0.3183098862 * mix(F_d, ss, params.subsurface);

    vec3 color = params.base_color;
    float luminance = dot(color, vec3(0.3, 0.6, 0.1));
    vec3 tint = luminance > 0.0 ? color / luminance : vec3(1.0);
    vec3 sheen = params.sheen * mix(vec3(1.0), tint, params.sheen_tint);
    vec3 base = (1.0 - params.metallic) * (diffuse * color + F_H * sheen);

    // Highlight
    float alpha = params.roughness * params.roughness;
    float aspect = sqrt(1.0 - 0.9 * params.anisotropic);
    float ax = max(alpha / aspect, 0.001);
    float ay = max(alpha * aspect, 0.001);
    vec3 v = vec3(h.x / ax, h.y / ay, h.z);
    float t = length2 / dot(v, v);
    float g = 0.5 + 0.5 * params.roughness;
    float g2 = g * g;
    float g4 = g2 * g2;
    float DV = 0.3183098862 * t * t / (ax * ay * disney_smith(wi.z, g4) * disney_smith(wo.z, g4));
    vec3 f0 = mix(0.08 * params.specular * mix(vec3(1.0), tint, params.specular_tint), color, params.metallic);
    vec3 highlight = DV * mix(f0, vec3(1.0), F_H);

    // Clearcoat: its alpha is at most 0.1, so that nothing cancels in the norm of GTR1; 0.07957747 = 1 / (4 pi)
    float a = mix(0.1, 0.001, params.clearcoat_gloss);
    float a2 = a * a;
    // By slopes: between opposite directions at the horizon all squares here are 0 on a GPU
    vec2 slopes = h.xy * (1.0 / h.z);
    float tan2 = dot(slopes, slopes);
    float D_norm = log(a2) * (tan2 + a2) * disney_smith(wi.z, 0.0625) * disney_smith(wo.z, 0.0625);
    float coat = 0.0795774715 * params.clearcoat * mix(0.04, 1.0, F_H) * (a2 - 1.0) * (1.0 + tan2) / D_norm;
    return base + highlight + coat;
}
