// Phong with a normalised highlight, written by hand: the yardstick for the GLSL that `gonio export phong`
// makes.
//
// From Phong 1975 and Lafortune and Willems 1994, by an engine programmer who wants all digits of a float32:
// those of sharp lobes are in 1 - cos(alpha), and those of broad ones where the cosine fades out.
// `gonio bench shaders` and `gonio cost --by-hand` compare the two.

struct Phong {
    vec3 rho;
    vec3 specular;
    float shininess;
};

// mu_i mu_o - dot(wi.xy, wo.xy), with the rounding errors of the second part.
float phong_cosine(vec3 wi, vec3 wo) {
    vec2 xy = wi.xy * wo.xy;
    vec2 lost = fma(wi.xy, wo.xy, -xy);
    float s = xy.x + xy.y;
    float y = s - xy.x;
    float lost_s = (xy.x - (s - y)) + (xy.y - y);
    return fma(wi.z, wo.z, -s) - (lost.x + lost.y + lost_s);
}

vec3 phong_eval(Phong params, vec3 wi, vec3 wo) {
    if (min(wi.z, wo.z) <= 0.0) {
        return vec3(0.0);
    }
    vec3 apart = vec3(wi.xy + wo.xy, wi.z - wo.z);
    float q = 0.5 * dot(apart, apart);  // 1 - cos(alpha)
    float c = phong_cosine(wi, wo);
    // log(1 - q) = 2 atanh(y) with y = q / (q - 2), by its series
    float y = q / (min(q, 1.0) - 2.0);
    float y2 = y * y;
    float near = 2.0 * y * (1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0 + y2 / 9.0))));
    float log_c = q < 0.25 ? near : log(max(c, 1.0e-37));
    float lobe = c > 0.0 ? exp(params.shininess * log_c) : 0.0;
    return 0.3183098862 * params.rho + (0.1591549431 * (params.shininess + 2.0) * lobe) * params.specular;
}
