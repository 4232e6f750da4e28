// SPDX-License-Identifier: Apache-2.0
// Minnaert: limb darkening of planets as a power of both cosines.
//
// Source: Minnaert, "The reciprocity principle in lunar photometry", Astrophysical Journal 93, 1941,
// normalised such that rho is the albedo at the normal. k = 1 is Lambert; the full Moon has about k = 0.5.
//
// HLSL, made by gonio from gonio/models/minnaert.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// Usage: Minnaert params; params.rho = ...; ... minnaert_eval(params, wi, wo)

// A sampled direction and its density.
struct MinnaertSample {
    float3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// minnaert: Planets and moons by one exponent: darker limbs above k = 1, brighter ones below. Reciprocal.
struct Minnaert {
    float3 rho;  // albedo at the normal, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    float k;  // limb darkening: 1 is Lambert, 0.5 a flat full moon; 0 to 2, default 0.7
};

// ---- evaluation ----------------------------------------------------------------------------

// rho (k + 1) / (2 pi) (mu_i mu_o)^(k - 1): BRDF value in 1/sr, without the cosine.
float3 minnaert_eval(Minnaert params, float3 wi, float3 wo) {
    const float inv_two_pi = 0.15915494;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return float3(0.0, 0.0, 0.0);
    }
    float k = params.k;
    return params.rho * (inv_two_pi * (k + 1.0) * pow(wi.z, k - 1.0) * pow(wo.z, k - 1.0));
}

// ---- sampling ------------------------------------------------------------------------------

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
float minnaert_atanh_over(float y) {
    float y2 = y * y;
    return 1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0 + y2 * (1.0 / 9.0))));
}

// log(1 + x) / x for x > -1; 1 at x = 0.
float minnaert_log1p_over(float x) {
    // Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
    const float LOG1P_SMALL = 0.25;
    float near = max(min(x, LOG1P_SMALL), -LOG1P_SMALL);
    bool small = x > -LOG1P_SMALL && x < LOG1P_SMALL;
    float far = small ? 1.0 : x;
    float series = minnaert_atanh_over(near / (2.0 + near));
    return small ? 2.0 / (2.0 + near) * series : log(1.0 + far) / far;
}

// log(1 + x) for x > -1, exact where x is small.
float minnaert_log1p(float x) {
    return x * minnaert_log1p_over(x);
}

// exp(x) - 1, exact where x is small.
float minnaert_expm1(float x) {
    // Below this the series needs few terms; above, the plain difference is exact to 2e-7 in float32.
    const float EXPM1_SMALL = 0.3;
    float near = max(min(x, EXPM1_SMALL), -EXPM1_SMALL);
    // Taylor's series
    float over = 1.0 + near
        * (0.5 + near * (0.16666667
            + near * (0.041666668
                + near * (0.008333334 + near * (0.0013888889 + near * 0.0001984127)))));
    return x > -EXPM1_SMALL && x < EXPM1_SMALL ? near * over : exp(x) - 1.0;
}

// Density of minnaert_sample in 1/sr.
float minnaert_pdf(Minnaert params, float3 wi, float3 wo) {
    const float inv_two_pi = 0.15915494;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return inv_two_pi * (params.k + 1.0) * pow(wi.z, params.k);
}

// A direction with a density like mu_i^k, which leaves a constant weight.
MinnaertSample minnaert_sample(Minnaert params, float3 wo, float2 u) {
    const float two_pi = 6.2831855;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        MinnaertSample result;
        result.wi = float3(0.0, 0.0, 1.0);
        result.pdf = 0.0;
        return result;
    }
    float t = minnaert_log1p(-u.x) / (params.k + 1.0);
    float r = sqrt(max(-minnaert_expm1(2.0 * t), 0.0));
    float phi = two_pi * u.y;
    float3 wi = float3(r * cos(phi), r * sin(phi), exp(t));
    MinnaertSample result;
    result.wi = wi;
    result.pdf = minnaert_pdf(params, wi, wo);
    return result;
}

// ---- albedo --------------------------------------------------------------------------------

// rho mu_o^(k - 1).
float3 minnaert_albedo(Minnaert params, float3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z < 0.0) {  // below the horizon
        return float3(0.0, 0.0, 0.0);
    }
    return params.rho * pow(max(wo.z, mu_min), params.k - 1.0);
}
