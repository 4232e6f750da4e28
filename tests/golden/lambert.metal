// SPDX-License-Identifier: Apache-2.0
// Lambert: ideal diffuse reflection.
//
// Source: Johann Heinrich Lambert, "Photometria", 1760.
//
// Metal, made by gonio from gonio/models/lambert.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose normal is
// +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// Usage: Lambert params; params.rho = ...; ... lambert_eval(params, wi, wo)

#include <metal_stdlib>
using namespace metal;

// A sampled direction and its density.
struct LambertSample {
    float3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// lambert: Ideal diffuse: the same radiance in every direction. Reciprocal; the albedo is rho.
struct Lambert {
    float3 rho;  // albedo, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
};

// ---- evaluation ----------------------------------------------------------------------------

// rho / pi.
inline float3 lambert_eval(Lambert params, float3 wi, float3 wo) {
    const float inv_pi = 0.31830987;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return float3(0.0);
    }
    return params.rho * inv_pi;
}

// ---- sampling ------------------------------------------------------------------------------

// A direction with density cos(theta) / pi.
inline float3 lambert_sample_cosine(float2 u) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(u.x, 0.0));
    float phi = two_pi * u.y;
    return float3(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// Density of lambert_sample_cosine in 1/sr, for w above the horizon.
inline float lambert_pdf_cosine(float3 w) {
    const float inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Cosine-weighted, which is exact here.
inline LambertSample lambert_sample(Lambert params, float3 wo, float2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return LambertSample{float3(0.0, 0.0, 1.0), 0.0};
    }
    float3 wi = lambert_sample_cosine(u);
    return LambertSample{wi, wi.z > mu_min ? lambert_pdf_cosine(wi) : 0.0};
}

// cos(theta_i) / pi.
inline float lambert_pdf(Lambert params, float3 wi, float3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return lambert_pdf_cosine(wi);
}

// ---- albedo --------------------------------------------------------------------------------

// rho.
inline float3 lambert_albedo(Lambert params, float3 wo) {
    if (wo.z < 0.0) {  // below the horizon
        return float3(0.0);
    }
    return params.rho;
}
