// Weidlich-Wilkie, two rough absorbing coats over Lambert, written by hand: the yardstick for the GLSL that
// `gonio export weidlich_wilkie` makes of a coat whose base is a coat.
//
// From Weidlich, Wilkie, "Arbitrarily layered micro-facet surfaces", GRAPHITE 2007, as Elek, "Layered materials
// in real-time rendering", CESCG 2010, has it (Eq. 2 to 4; Beckmann, Cook and Torrance's masking, exact Fresnel),
// by an engine programmer who wants all digits of a float32. `gonio bench shaders` and
// `gonio cost --by-hand` compare the two.

struct WeidlichWilkieBaseBase {
    vec3 rho;
};

struct WeidlichWilkieBase {
    float eta;
    float alpha;
    vec3 sigma_a;
    float thickness;
    WeidlichWilkieBaseBase base;
};

struct WeidlichWilkie {
    float eta;
    float alpha;
    vec3 sigma_a;
    float thickness;
    WeidlichWilkieBase base;
};

// What one coat reflects (x), and what it lets through to the layer below and back (y), but for its absorption.
// contrast: eta2 - 1.
vec2 weidlich_wilkie_coat(vec3 wi, vec3 wo, float contrast, float eta2, float alpha) {
    vec3 h = wi + wo;
    float hz2 = h.z * h.z;
    float hxy2 = h.x * h.x + h.y * h.y;
    float length2 = hxy2 + hz2;

    // Cook and Torrance's masking
    float low = min(wi.z, wo.z);
    float G = min(4.0 * h.z * low / length2, 1.0);
    // 1 - G keeps its digits near G = 1
    float lost = max((hxy2 + h.z * (max(wi.z, wo.z) - 2.0 * low - low)) / length2, 0.0);

    // Beckmann, of slopes: between opposite directions at the horizon the squares of h.xy are 0 on a GPU. The
    // square of 1 / cos^4 and the exponential are taken last, as the first alone leaves a float32.
    vec2 slopes = h.xy * (1.0 / h.z);
    float tan2 = dot(slopes, slopes);
    float inv_a2 = 1.0 / (alpha * alpha);
    float root = (1.0 + tan2) * exp(-0.5 * tan2 * inv_a2);
    float D = 0.3183098862 * inv_a2 * root * root;

    // Fresnel: with r_s = contrast / s^2, s = c + g, and r_p = r_s (p - s2) / q, p = c g, q = p + s2, both the mean
    // F of their squares and T = 1 - F are products, which keep their digits
    float c2 = 0.25 * length2;
    float c = sqrt(c2);
    float s2 = 1.0 - c2;
    float g = sqrt(contrast + c2);
    float s = (c + g) * (c + g);
    float p = c * g;
    float q2 = (p + s2) * (p + s2);
    float inv = 1.0 / (s * q2);
    float F = contrast * contrast * (p * p + s2 * s2) * inv / s;
    float T = 2.0 * p * (q2 + eta2) * inv;
    // Bounded: where both directions are at the horizon, D alone needs the rest of a float32
    return vec2(F * D * min(0.25 * G / (wi.z * wo.z), 1.0e30), T * (lost + G * T));
}

vec3 weidlich_wilkie_eval(WeidlichWilkie params, vec3 wi, vec3 wo) {
    if (min(wi.z, wo.z) <= 0.0) {
        return vec3(0.0);
    }
    float eta = params.eta;
    float contrast = (eta - 1.0) * (eta + 1.0);
    vec2 coat = weidlich_wilkie_coat(wi, wo, contrast, eta * eta, params.alpha);

    // Refracted directions
    float inv_eta = 1.0 / eta;
    vec3 ti = vec3(wi.xy, sqrt(wi.z * wi.z + contrast)) * inv_eta;
    vec3 to = vec3(wo.xy, sqrt(wo.z * wo.z + contrast)) * inv_eta;

    float eta_2 = params.base.eta;
    float contrast_2 = (eta_2 - 1.0) * (eta_2 + 1.0);
    float alpha_2 = max(params.base.alpha, params.alpha);
    vec2 coat_2 = weidlich_wilkie_coat(ti, to, contrast_2, eta_2 * eta_2, alpha_2);
    float zi = sqrt(ti.z * ti.z + contrast_2);
    float zo = sqrt(to.z * to.z + contrast_2);

    // Both coats absorb along the refracted paths
    float path = params.thickness * (ti.z + to.z) / (ti.z * to.z);
    float path_2 = params.base.thickness * eta_2 * (zi + zo) / (zi * zo);
    vec3 through = exp(-path * params.sigma_a) * coat.y;
    vec3 through_2 = exp(-path_2 * params.base.sigma_a) * coat_2.y;
    return coat.x + through * (coat_2.x + through_2 * params.base.base.rho * 0.3183098862);
}
