// EON with the exact E_F, written by hand: the yardstick for the GLSL that `gonio export eon` makes.
//
// From Portsmouth, Kutz, Hill, "EON: A practical energy-preserving rough diffuse BRDF", arXiv:2410.18026, as
// an engine programmer would tune it who wants all digits of a float32. `gonio bench shaders` and
// `gonio cost --by-hand` compare the two.

struct Eon {
    vec3 rho;
    float roughness;
};

// pi (C1 - G_F / pi) of Eq. 13, without differences that cancel: asin(mu) = 2 atan(v), 1 - s = mu v.
float eon_lost(float mu) {
    float s = sqrt(max(1.0 - mu * mu, 0.0));
    float v = mu / (1.0 + s);
    float q = v * v;
    // 2 atan(v) / v on [0, 1], relative error 2e-8
    float p = 0.00569977264 * q - 0.03213723158;
    p = p * q + 0.08538299588;
    p = p * q - 0.1500858548;
    p = p * q + 0.2128186638;
    p = p * q - 0.284072885;
    p = p * q + 0.3998523874;
    p = p * q - 0.6666614668;
    p = p * q + 1.9999999696;
    return v * (s * p + mu * (0.9041296601 - v * s * (0.3333333333 * s + 0.6666666667)));
}

vec3 eon_eval(Eon params, vec3 wi, vec3 wo) {
    if (min(wi.z, wo.z) <= 0.0) {
        return vec3(0.0);
    }
    float r = params.roughness;
    float A = 1.0 / (1.0 + 0.2877934092 * r);

    // s = sin sin cos(phi); the error of one product is kept, because s is divided by a small cosine
    float q = wi.y * wo.y;
    float s = fma(wi.x, wo.x, q) + fma(wi.y, wo.y, -q);
    // 2 (1 + s) as a sum of squares
    float x = wi.x + wo.x;
    float y = wi.y + wo.y;
    float squares = x * x + y * y + wi.z * wi.z + wo.z * wo.z;
    float shape = s > 0.0 ? 1.0 + r * (s / max(wi.z, wo.z)) : 1.0 - r + 0.5 * r * squares;

    // 0.2153051968 = C1 - C2, so that 1 - <E> = 0.2153051968 r A; 0.1497945006 = 1 / (pi^3 (C1 - C2))
    float rA = r * A;
    float lost = 0.2153051968 * rA;
    float multiple = 0.1497945006 * rA * (1.0 - lost) * eon_lost(wi.z) * eon_lost(wo.z);
    vec3 rho = params.rho;
    return rho * (0.3183098862 * A * shape + rho * multiple / (1.0 - rho * lost));
}
