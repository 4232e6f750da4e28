// SPDX-License-Identifier: Apache-2.0
// Lambert sphere: light in a half space of white or coloured balls, each of them Lambertian.
//
// Source: d'Eon, "An analytic BRDF for materials with spherical Lambertian scatterers", Computer Graphics
// Forum 40(4), 2021: the phase function of a Lambertian ball once, and even scattering after that, with the
// function H of Hapke, "Bidirectional reflectance spectroscopy, 1: theory", Journal of Geophysical
// Research, 1981, which d'Eon compares his own fit with.
//
// Metal, made by gonio from gonio/models/lambert_sphere.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: LambertSphere params; params.rho = ...; ... lambert_sphere_eval(params, wi, wo)

#include <metal_stdlib>
using namespace metal;

// A sampled direction and its density.
struct LambertSphereSample {
    float3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// lambert_sphere: Chalk and other powders: flatter than Lambert, brighter back to the light. Reciprocal.
struct LambertSphere {
    float3 rho;  // albedo of a single ball, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
};

// ---- evaluation ----------------------------------------------------------------------------

// H - 1 of H = (1 + 2 mu) / (1 + 2 mu gamma) with gamma = sqrt(1 - w).
inline float3 lambert_sphere_H_minus_1(LambertSphere params, float mu) {
    float3 gamma = sqrt(1.0 - params.rho);
    return 2.0 * mu * params.rho / ((1.0 + gamma) * (1.0 + 2.0 * mu * gamma));
}

// 2 atan(v) / v for v in [-1, 1], the angle whose half has the tangent v; 2 at v = 0.
inline float lambert_sphere_twice_atan_over(float v) {
    const float ATAN_0 = 2.0;  // 2 atan(v) / v in v^2 on [0, 1]; fitted, relative error below 2e-8.
    const float ATAN_1 = -0.66666144;
    const float ATAN_2 = 0.3998524;
    const float ATAN_3 = -0.28407288;
    const float ATAN_4 = 0.21281867;
    const float ATAN_5 = -0.15008585;
    const float ATAN_6 = 0.085383;
    const float ATAN_7 = -0.03213723;
    const float ATAN_8 = 0.005699773;
    float q = v * v;
    float p = ATAN_4 + q * (ATAN_5 + q * (ATAN_6 + q * (ATAN_7 + q * ATAN_8)));
    return ATAN_0 + q * (ATAN_1 + q * (ATAN_2 + q * (ATAN_3 + q * p)));
}

// 2 (sin y - y cos y) / (3 pi^2) at the angle y that light is turned from its way.
inline float lambert_sphere_phase(float3 wi, float3 wo) {
    const float pi = 3.1415927;
    // 2 / (3 pi^2) makes the mean of the phase function over all directions 1 / (4 pi).
    const float PHASE = 0.067547455;
    // Below this angle to the straight direction sin y - y cos y is taken by its series: it would cancel.
    const float SMALL = 0.4;
    // Twice the sine and cosine of half the angle between wi and wo; the smaller has all its digits
    float across = sqrt(dot(wi - wo, wi - wo));
    float along = length(wi + wo);
    float t = min(across, along) / max(across, along);
    float small = t * lambert_sphere_twice_atan_over(t);
    float y = across < along ? pi - small : small;
    float y2 = y * y;
    float series = y * y2 / 3.0 * (1.0 - y2 / 10.0 * (1.0 - y2 / 28.0 * (1.0 - y2 / 54.0)));
    float exact = 0.5 * across * along + y * dot(wi, wo);
    return PHASE * (y < SMALL ? series : exact);
}

// BRDF value in 1/sr, without the cosine.
inline float3 lambert_sphere_eval(LambertSphere params, float3 wi, float3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    const float INV_FOUR_PI = 0.07957747;
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return float3(0.0);
    }
    float3 h_i = lambert_sphere_H_minus_1(params, wi.z);
    float3 h_o = lambert_sphere_H_minus_1(params, wo.z);
    float3 often = INV_FOUR_PI * (h_i + h_o + h_i * h_o);
    return params.rho * (lambert_sphere_phase(wi, wo) + often) / (wi.z + wo.z);
}

// ---- sampling ------------------------------------------------------------------------------

// A direction with density 1 / (2 pi).
inline float3 lambert_sphere_sample_uniform(float2 u) {
    const float two_pi = 6.2831855;
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    float z = 1.0 - u.x;
    float r = sqrt(max(u.x * (1.0 + z), 0.0));
    float phi = two_pi * u.y;
    return float3(r * cos(phi), r * sin(phi), z);
}

// Density of lambert_sphere_sample in 1/sr.
inline float lambert_sphere_pdf(LambertSphere params, float3 wi, float3 wo) {
    const float inv_two_pi = 0.15915494;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return inv_two_pi;
}

// Uniform: mu_i / (mu_i + mu_o) has a bound.
inline LambertSphereSample lambert_sphere_sample(LambertSphere params, float3 wo, float2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return LambertSphereSample{float3(0.0, 0.0, 1.0), 0.0};
    }
    float3 wi = lambert_sphere_sample_uniform(u);
    return LambertSphereSample{wi, lambert_sphere_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline float3 lambert_sphere_albedo(LambertSphere params, float3 wo) {
    // Steps of the rule in lambert_sphere_albedo: a Fibonacci number, and the golden ratio.
    const float ALBEDO_SAMPLES = 987.0;
    const float GOLDEN = 0.618034;
    // Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
    const float HORIZON = 1.0e-6;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z < 0.0) {  // below the horizon
        return float3(0.0);
    }
    float3 w = float3(wo.x, wo.y, max(wo.z, HORIZON));
    float3 total = float3(0.0);
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        float2 u = float2((i + 0.5) / ALBEDO_SAMPLES, fract((i + 0.5) * GOLDEN));
        LambertSphereSample drawn = lambert_sphere_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + lambert_sphere_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
