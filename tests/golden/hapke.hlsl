// SPDX-License-Identifier: Apache-2.0
// Hapke: light in a half space of grains, as planetary science reads the Moon and asteroids.
//
// Source: Hapke, "Bidirectional reflectance spectroscopy, 1: theory", Journal of Geophysical Research,
// 1981: Eq. 16 with the function H of its two-stream solution; the opposition effect in the form of
// "Bidirectional reflectance spectroscopy, 4: the extinction coefficient and the opposition effect", Icarus
// 67, 1986. Grains scatter by the function of Henyey, Greenstein, "Diffuse radiation in the galaxy",
// Astrophysical Journal 93,
// 1941. Macroscopic roughness is not there.
//
// HLSL, made by gonio from gonio/models/hapke.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: Hapke params; params.rho = ...; ... hapke_eval(params, wi, wo)

// A sampled direction and its density.
struct HapkeSample {
    float3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// hapke: Regolith: dust that scatters once by its phase function, and often. Reciprocal.
struct Hapke {
    // single-scattering albedo w of a grain, linear RGB; 0 to 1, default (0.3, 0.3, 0.3)
    float3 rho;
    // b of Henyey and Greenstein: below 0 back to the light, above 0 onwards; -0.8 to 0.8, default -0.2
    float asymmetry;
    float opposition;  // strength B0 of the brighter spot around the light; 0 to 1, default 0.8
    float opposition_width;  // width h of that spot; radians, about; 0.02 to 1, default 0.06
};

// ---- evaluation ----------------------------------------------------------------------------

// B0 / (1 + tan(g / 2) / h), with the tangent from the lengths of difference and sum.
float hapke_opposition(Hapke params, float3 wi, float3 wo) {
    float scaled = params.opposition_width * length(wi + wo);
    return params.opposition * scaled / (scaled + sqrt(dot(wi - wo, wi - wo)));
}

// Henyey and Greenstein's function at the phase angle between light and viewer, mean 1.
float hapke_phase(Hapke params, float3 wi, float3 wo) {
    float b = params.asymmetry;
    // 1 + 2 b cos(g) + b^2 as a sum of squares
    float3 v = wi + b * wo;
    float q = dot(v, v);
    return (1.0 - b) * (1.0 + b) / (q * sqrt(q));
}

// H - 1 of H = (1 + 2 mu) / (1 + 2 mu gamma) with gamma = sqrt(1 - w).
float3 hapke_H_minus_1(Hapke params, float mu) {
    float3 gamma = sqrt(1.0 - params.rho);
    return 2.0 * mu * params.rho / ((1.0 + gamma) * (1.0 + 2.0 * mu * gamma));
}

// Eq. 16 over mu_i: BRDF value in 1/sr, without the cosine.
float3 hapke_eval(Hapke params, float3 wi, float3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    const float INV_FOUR_PI = 0.07957747;
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return float3(0.0, 0.0, 0.0);
    }
    float once = (1.0 + hapke_opposition(params, wi, wo)) * hapke_phase(params, wi, wo);
    // H_i H_o - 1 without its cancellation
    float3 h_i = hapke_H_minus_1(params, wi.z);
    float3 h_o = hapke_H_minus_1(params, wo.z);
    float3 often = h_i + h_o + h_i * h_o;
    return params.rho * (once + often) * (INV_FOUR_PI / (wi.z + wo.z));
}

// ---- sampling ------------------------------------------------------------------------------

// A direction with density 1 / (2 pi).
float3 hapke_sample_uniform(float2 u) {
    const float two_pi = 6.2831855;
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    float z = 1.0 - u.x;
    float r = sqrt(max(u.x * (1.0 + z), 0.0));
    float phi = two_pi * u.y;
    return float3(r * cos(phi), r * sin(phi), z);
}

// Density of hapke_sample in 1/sr.
float hapke_pdf(Hapke params, float3 wi, float3 wo) {
    const float inv_two_pi = 0.15915494;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return inv_two_pi;
}

// Uniform: mu_i / (mu_i + mu_o) has a bound.
HapkeSample hapke_sample(Hapke params, float3 wo, float2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        HapkeSample result;
        result.wi = float3(0.0, 0.0, 1.0);
        result.pdf = 0.0;
        return result;
    }
    float3 wi = hapke_sample_uniform(u);
    HapkeSample result;
    result.wi = wi;
    result.pdf = hapke_pdf(params, wi, wo);
    return result;
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
float3 hapke_albedo(Hapke params, float3 wo) {
    // Steps of the rule in hapke_albedo: a Fibonacci number, and the golden ratio.
    const float ALBEDO_SAMPLES = 987.0;
    const float GOLDEN = 0.618034;
    // Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
    const float HORIZON = 1.0e-6;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z < 0.0) {  // below the horizon
        return float3(0.0, 0.0, 0.0);
    }
    float3 w = float3(wo.x, wo.y, max(wo.z, HORIZON));
    float3 total = float3(0.0, 0.0, 0.0);
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        float2 u = float2((i + 0.5) / ALBEDO_SAMPLES, frac((i + 0.5) * GOLDEN));
        HapkeSample drawn = hapke_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + hapke_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
