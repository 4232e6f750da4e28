// SPDX-License-Identifier: Apache-2.0
// Lambert sphere: light in a half space of white or coloured balls, each of them Lambertian.
//
// Source: d'Eon, "An analytic BRDF for materials with spherical Lambertian scatterers", Computer Graphics
// Forum 40(4), 2021: the phase function of a Lambertian ball once, and even scattering after that, with the
// function H of Hapke, "Bidirectional reflectance spectroscopy, 1: theory", Journal of Geophysical
// Research, 1981, which d'Eon compares his own fit with.
//
// C++, made by gonio from gonio/models/lambert_sphere.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: gonio_lambert_sphere::LambertSphere params; params.rho = ...; ... gonio_lambert_sphere::lambert_sphere_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_lambert_sphere {

struct Vec2 {
    float x, y;
};

struct Vec3 {
    float x, y, z;
};

inline Vec3 splat(float a) {
    return Vec3{a, a, a};
}

inline float fract(float a) {
    return a - floorf(a);
}

inline float dot(Vec3 a, Vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

inline float length(Vec3 a) {
    return sqrtf(a.x * a.x + a.y * a.y + a.z * a.z);
}

inline Vec3 operator+(Vec3 a, Vec3 b) {
    return Vec3{a.x + b.x, a.y + b.y, a.z + b.z};
}

inline Vec3 operator+(float a, Vec3 b) {
    return Vec3{a + b.x, a + b.y, a + b.z};
}

inline Vec3 operator-(Vec3 a, Vec3 b) {
    return Vec3{a.x - b.x, a.y - b.y, a.z - b.z};
}

inline Vec3 operator-(float a, Vec3 b) {
    return Vec3{a - b.x, a - b.y, a - b.z};
}

inline Vec3 operator*(Vec3 a, Vec3 b) {
    return Vec3{a.x * b.x, a.y * b.y, a.z * b.z};
}

inline Vec3 operator*(Vec3 a, float b) {
    return Vec3{a.x * b, a.y * b, a.z * b};
}

inline Vec3 operator*(float a, Vec3 b) {
    return Vec3{a * b.x, a * b.y, a * b.z};
}

inline Vec3 operator/(Vec3 a, Vec3 b) {
    return Vec3{a.x / b.x, a.y / b.y, a.z / b.z};
}

inline Vec3 operator/(Vec3 a, float b) {
    return Vec3{a.x / b, a.y / b, a.z / b};
}

inline Vec3 sqrt(Vec3 a) {
    return Vec3{sqrtf(a.x), sqrtf(a.y), sqrtf(a.z)};
}

// Steps of the rule in lambert_sphere_albedo: a Fibonacci number, and the golden ratio.
constexpr float ALBEDO_SAMPLES = 987.0f;
constexpr float GOLDEN = 0.618034f;
// Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
constexpr float HORIZON = 1.0e-6f;
// 2 atan(v) / v in v^2 on [0, 1]; fitted, relative error below 2e-8.
constexpr float ATAN_0 = 2.0f;
constexpr float ATAN_1 = -0.66666144f;
constexpr float ATAN_2 = 0.3998524f;
constexpr float ATAN_3 = -0.28407288f;
constexpr float ATAN_4 = 0.21281867f;
constexpr float ATAN_5 = -0.15008585f;
constexpr float ATAN_6 = 0.085383f;
constexpr float ATAN_7 = -0.03213723f;
constexpr float ATAN_8 = 0.005699773f;
constexpr float pi = 3.1415927f;
constexpr float two_pi = 6.2831855f;
constexpr float inv_two_pi = 0.15915494f;
constexpr float mu_min = 1.0e-18f;  // cosine of the horizon
constexpr float INV_FOUR_PI = 0.07957747f;
// 2 / (3 pi^2) makes the mean of the phase function over all directions 1 / (4 pi).
constexpr float PHASE = 0.067547455f;
// Below this angle to the straight direction sin y - y cos y is taken by its series: it would cancel.
constexpr float SMALL = 0.4f;

// A sampled direction and its density.
struct LambertSphereSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// lambert_sphere: Chalk and other powders: flatter than Lambert, brighter back to the light. Reciprocal.
struct LambertSphere {
    Vec3 rho;  // albedo of a single ball, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
};

// ---- evaluation ----------------------------------------------------------------------------

// H - 1 of H = (1 + 2 mu) / (1 + 2 mu gamma) with gamma = sqrt(1 - w).
inline Vec3 lambert_sphere_H_minus_1(const LambertSphere& params, float mu) {
    Vec3 gamma_ = sqrt(1.0f - params.rho);
    return 2.0f * mu * params.rho / ((1.0f + gamma_) * (1.0f + 2.0f * mu * gamma_));
}

// 2 atan(v) / v for v in [-1, 1], the angle whose half has the tangent v; 2 at v = 0.
inline float lambert_sphere_twice_atan_over(float v) {
    float q = v * v;
    float p = ATAN_4 + q * (ATAN_5 + q * (ATAN_6 + q * (ATAN_7 + q * ATAN_8)));
    return ATAN_0 + q * (ATAN_1 + q * (ATAN_2 + q * (ATAN_3 + q * p)));
}

// 2 (sin y - y cos y) / (3 pi^2) at the angle y that light is turned from its way.
inline float lambert_sphere_phase(Vec3 wi, Vec3 wo) {
    // Twice the sine and cosine of half the angle between wi and wo; the smaller has all its digits
    float across = sqrtf(dot(wi - wo, wi - wo));
    float along = length(wi + wo);
    float t = fminf(across, along) / fmaxf(across, along);
    float small = t * lambert_sphere_twice_atan_over(t);
    float y = across < along ? pi - small : small;
    float y2 = y * y;
    float series = y * y2 / 3.0f * (1.0f - y2 / 10.0f * (1.0f - y2 / 28.0f * (1.0f - y2 / 54.0f)));
    float exact = 0.5f * across * along + y * dot(wi, wo);
    return PHASE * (y < SMALL ? series : exact);
}

// BRDF value in 1/sr, without the cosine.
inline Vec3 lambert_sphere_eval(const LambertSphere& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    Vec3 h_i = lambert_sphere_H_minus_1(params, wi.z);
    Vec3 h_o = lambert_sphere_H_minus_1(params, wo.z);
    Vec3 often = INV_FOUR_PI * (h_i + h_o + h_i * h_o);
    return params.rho * (lambert_sphere_phase(wi, wo) + often) / (wi.z + wo.z);
}

// ---- sampling ------------------------------------------------------------------------------

// A direction with density 1 / (2 pi).
inline Vec3 lambert_sphere_sample_uniform(Vec2 u) {
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    float z = 1.0f - u.x;
    float r = sqrtf(fmaxf(u.x * (1.0f + z), 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), z};
}

// Density of lambert_sphere_sample in 1/sr.
inline float lambert_sphere_pdf(const LambertSphere& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    return inv_two_pi;
}

// Uniform: mu_i / (mu_i + mu_o) has a bound.
inline LambertSphereSample lambert_sphere_sample(const LambertSphere& params, Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return LambertSphereSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    Vec3 wi = lambert_sphere_sample_uniform(u);
    return LambertSphereSample{wi, lambert_sphere_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline Vec3 lambert_sphere_albedo(const LambertSphere& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    Vec3 w = Vec3{wo.x, wo.y, fmaxf(wo.z, HORIZON)};
    Vec3 total = Vec3{0.0f, 0.0f, 0.0f};
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        Vec2 u = Vec2{(i + 0.5f) / ALBEDO_SAMPLES, fract((i + 0.5f) * GOLDEN)};
        LambertSphereSample drawn = lambert_sphere_sample(params, w, u);
        float weight = drawn.pdf > 0.0f ? drawn.wi.z / fmaxf(drawn.pdf, mu_min) : 0.0f;
        total = total + lambert_sphere_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}

}  // namespace gonio_lambert_sphere
