// SPDX-License-Identifier: Apache-2.0
// Burley diffuse: the diffuse lobe of Disney's principled model.
//
// Source: Burley, "Physically-based shading at Disney", SIGGRAPH 2012 course notes, section 5.3.
// The albedo's closed form is ours: the BRDF is a polynomial in cosines once 2 cos^2(theta_d) is written as
// 1 + dot(wi, wo), so it can be integrated term by term.
//
// C++, made by gonio from gonio/models/burley_diffuse.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// Usage: gonio_burley_diffuse::BurleyDiffuse params; params.rho = ...; ... gonio_burley_diffuse::burley_diffuse_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_burley_diffuse {

struct Vec2 {
    float x, y;
};

struct Vec3 {
    float x, y, z;
};

inline Vec3 splat(float a) {
    return Vec3{a, a, a};
}

inline float dot(Vec3 a, Vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

inline Vec3 operator*(Vec3 a, float b) {
    return Vec3{a.x * b, a.y * b, a.z * b};
}

constexpr float two_pi = 6.2831855f;
constexpr float inv_pi = 0.31830987f;
constexpr float mu_min = 1.0e-18f;  // cosine of the horizon
// Integrals of (1 - mu)^5 mu^k over mu in [0, 1], k = 1, 2, 3.
constexpr float I1 = 0.023809524f;
constexpr float I2 = 0.005952381f;
constexpr float I3 = 0.001984127f;

// A sampled direction and its density.
struct BurleyDiffuseSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// burley_diffuse: Diffuse with darker edges when smooth and a bright rim when rough. Reciprocal.
struct BurleyDiffuse {
    Vec3 rho;  // base colour, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    float roughness;  // perceptual roughness, not alpha; 0 to 1, default 0.5
};

// ---- evaluation ----------------------------------------------------------------------------

// (1 - cos_theta)^5 of Schlick's approximation.
inline float burley_diffuse_schlick_weight(float cos_theta) {
    float k = 1.0f - cos_theta;
    float k2 = k * k;
    return k2 * k2 * k;
}

// BRDF value in 1/sr, without the cosine.
inline Vec3 burley_diffuse_eval(const BurleyDiffuse& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    // F90 = 0.5 + 2 roughness cos^2(theta_d), and 2 cos^2(theta_d) = 1 + dot(wi, wo)
    float rise = params.roughness * (1.0f + dot(wi, wo)) - 0.5f;
    float fresnel_i = 1.0f + rise * burley_diffuse_schlick_weight(wi.z);
    float fresnel_o = 1.0f + rise * burley_diffuse_schlick_weight(wo.z);
    return params.rho * (inv_pi * fresnel_i * fresnel_o);
}

// ---- sampling ------------------------------------------------------------------------------

// A direction with density cos(theta) / pi.
inline Vec3 burley_diffuse_sample_cosine(Vec2 u) {
    float r = sqrtf(fmaxf(u.x, 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), sqrtf(fmaxf(1.0f - u.x, 0.0f))};
}

// Density of burley_diffuse_sample_cosine in 1/sr, for w above the horizon.
inline float burley_diffuse_pdf_cosine(Vec3 w) {
    return w.z * inv_pi;
}

// Cosine-weighted: the weight is the product of two Fresnel factors of at most 2.5.
inline BurleyDiffuseSample burley_diffuse_sample(const BurleyDiffuse& params, Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return BurleyDiffuseSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    Vec3 wi = burley_diffuse_sample_cosine(u);
    return BurleyDiffuseSample{wi, wi.z > mu_min ? burley_diffuse_pdf_cosine(wi) : 0.0f};
}

// Density of burley_diffuse_sample in 1/sr.
inline float burley_diffuse_pdf(const BurleyDiffuse& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    return burley_diffuse_pdf_cosine(wi);
}

// ---- albedo --------------------------------------------------------------------------------

// Integral of burley_diffuse_eval times the cosine.
inline Vec3 burley_diffuse_albedo(const BurleyDiffuse& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    float r = params.roughness;
    float a = r - 0.5f;
    float mu = wo.z;
    float w = burley_diffuse_schlick_weight(wo.z);
    float both = a * a * I1 + 2.0f * a * r * mu * I2
        + r * r * (mu * mu * I3 + (1.0f - mu * mu) * (I1 - I3) / 2.0f);
    return params.rho * (1.0f + 2.0f * (a * I1 + r * mu * I2) + w * (a + 2.0f / 3.0f * r * mu)
        + 2.0f * w * both);
}

}  // namespace gonio_burley_diffuse
