// SPDX-License-Identifier: Apache-2.0
// Lambert: ideal diffuse reflection.
//
// Source: Johann Heinrich Lambert, "Photometria", 1760.
//
// C++, made by gonio from gonio/models/lambert.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose normal is
// +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// Usage: gonio_lambert::Lambert params; params.rho = ...; ... gonio_lambert::lambert_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_lambert {

struct Vec2 {
    float x, y;
};

struct Vec3 {
    float x, y, z;
};

inline Vec3 splat(float a) {
    return Vec3{a, a, a};
}

inline Vec3 operator*(Vec3 a, float b) {
    return Vec3{a.x * b, a.y * b, a.z * b};
}

constexpr float two_pi = 6.2831855f;
constexpr float inv_pi = 0.31830987f;
constexpr float mu_min = 1.0e-18f;  // cosine of the horizon

// A sampled direction and its density.
struct LambertSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// lambert: Ideal diffuse: the same radiance in every direction. Reciprocal; the albedo is rho.
struct Lambert {
    Vec3 rho;  // albedo, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
};

// ---- evaluation ----------------------------------------------------------------------------

// rho / pi.
inline Vec3 lambert_eval(const Lambert& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    return params.rho * inv_pi;
}

// ---- sampling ------------------------------------------------------------------------------

// A direction with density cos(theta) / pi.
inline Vec3 lambert_sample_cosine(Vec2 u) {
    float r = sqrtf(fmaxf(u.x, 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), sqrtf(fmaxf(1.0f - u.x, 0.0f))};
}

// Density of lambert_sample_cosine in 1/sr, for w above the horizon.
inline float lambert_pdf_cosine(Vec3 w) {
    return w.z * inv_pi;
}

// Cosine-weighted, which is exact here.
inline LambertSample lambert_sample(const Lambert& params, Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return LambertSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    Vec3 wi = lambert_sample_cosine(u);
    return LambertSample{wi, wi.z > mu_min ? lambert_pdf_cosine(wi) : 0.0f};
}

// cos(theta_i) / pi.
inline float lambert_pdf(const Lambert& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    return lambert_pdf_cosine(wi);
}

// ---- albedo --------------------------------------------------------------------------------

// rho.
inline Vec3 lambert_albedo(const Lambert& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    return params.rho;
}

}  // namespace gonio_lambert
