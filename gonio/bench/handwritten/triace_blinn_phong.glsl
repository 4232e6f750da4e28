// tri-Ace's normalised Blinn-Phong with Schlick's Fresnel over Lambert, written by hand: the yardstick for the
// GLSL that `gonio export triace_blinn_phong` makes.
//
// From Gotanda 2012, Eq. 1, by an engine programmer who wants all digits of a float32 and normalises no vector.
// `gonio bench shaders` and `gonio cost --by-hand` compare the two.

struct TriaceBlinnPhong {
    vec3 rho;
    vec3 f0;
    float shininess;
};

vec3 triace_blinn_phong_eval(TriaceBlinnPhong params, vec3 wi, vec3 wo) {
    if (min(wi.z, wo.z) <= 0.0) {
        return vec3(0.0);
    }
    vec3 h = wi + wo;
    vec3 apart = wi - wo;

    // 1 - cos, of the half vector with wi, from its squared sine
    float k = 0.25 * dot(apart, apart) / (1.0 + 0.5 * sqrt(dot(h, h)));
    float k2 = k * k;
    vec3 F = mix(params.f0, vec3(1.0), k2 * k2 * k);

    // log(N.H) = -atanh(y), by its series near the normal. Of slopes: between opposite directions at the
    // horizon the squares of h.xy are 0 on a GPU.
    vec2 slopes = h.xy * (1.0 / h.z);
    float tan2 = dot(slopes, slopes);
    float y = tan2 / (2.0 + tan2);
    float y2 = y * y;
    float near = -y * (1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0 + y2 / 9.0))));
    float log_cos = y < 0.14 ? near : -0.5 * log(1.0 + tan2);
    float highlight = exp(params.shininess * log_cos) / max(wi.z, wo.z);
    highlight *= 0.0397436 * params.shininess + 0.0856832;

    return 0.3183098862 * params.rho * (1.0 - params.f0) + F * highlight;
}
