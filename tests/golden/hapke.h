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
// C++, made by gonio from gonio/models/hapke.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: gonio_hapke::Hapke params; params.rho = ...; ... gonio_hapke::hapke_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_hapke {

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

constexpr float two_pi = 6.2831855f;
constexpr float inv_two_pi = 0.15915494f;
constexpr float mu_min = 1.0e-18f;  // cosine of the horizon
constexpr float INV_FOUR_PI = 0.07957747f;
// Steps of the rule in hapke_albedo: a Fibonacci number, and the golden ratio.
constexpr float ALBEDO_SAMPLES = 987.0f;
constexpr float GOLDEN = 0.618034f;
// Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
constexpr float HORIZON = 1.0e-6f;

// A sampled direction and its density.
struct HapkeSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// hapke: Regolith: dust that scatters once by its phase function, and often. Reciprocal.
struct Hapke {
    Vec3 rho;  // single-scattering albedo w of a grain, linear RGB; 0 to 1, default (0.3, 0.3, 0.3)
    // b of Henyey and Greenstein: below 0 back to the light, above 0 onwards; -0.8 to 0.8, default -0.2
    float asymmetry;
    float opposition;  // strength B0 of the brighter spot around the light; 0 to 1, default 0.8
    float opposition_width;  // width h of that spot; radians, about; 0.02 to 1, default 0.06
};

// ---- evaluation ----------------------------------------------------------------------------

// B0 / (1 + tan(g / 2) / h), with the tangent from the lengths of difference and sum.
inline float hapke_opposition(const Hapke& params, Vec3 wi, Vec3 wo) {
    float scaled = params.opposition_width * length(wi + wo);
    return params.opposition * scaled / (scaled + sqrtf(dot(wi - wo, wi - wo)));
}

// Henyey and Greenstein's function at the phase angle between light and viewer, mean 1.
inline float hapke_phase(const Hapke& params, Vec3 wi, Vec3 wo) {
    float b = params.asymmetry;
    // 1 + 2 b cos(g) + b^2 as a sum of squares
    Vec3 v = wi + b * wo;
    float q = dot(v, v);
    return (1.0f - b) * (1.0f + b) / (q * sqrtf(q));
}

// H - 1 of H = (1 + 2 mu) / (1 + 2 mu gamma) with gamma = sqrt(1 - w).
inline Vec3 hapke_H_minus_1(const Hapke& params, float mu) {
    Vec3 gamma_ = sqrt(1.0f - params.rho);
    return 2.0f * mu * params.rho / ((1.0f + gamma_) * (1.0f + 2.0f * mu * gamma_));
}

// Eq. 16 over mu_i: BRDF value in 1/sr, without the cosine.
inline Vec3 hapke_eval(const Hapke& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    float once = (1.0f + hapke_opposition(params, wi, wo)) * hapke_phase(params, wi, wo);
    // H_i H_o - 1 without its cancellation
    Vec3 h_i = hapke_H_minus_1(params, wi.z);
    Vec3 h_o = hapke_H_minus_1(params, wo.z);
    Vec3 often = h_i + h_o + h_i * h_o;
    return params.rho * (once + often) * (INV_FOUR_PI / (wi.z + wo.z));
}

// ---- sampling ------------------------------------------------------------------------------

// A direction with density 1 / (2 pi).
inline Vec3 hapke_sample_uniform(Vec2 u) {
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    float z = 1.0f - u.x;
    float r = sqrtf(fmaxf(u.x * (1.0f + z), 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), z};
}

// Density of hapke_sample in 1/sr.
inline float hapke_pdf(const Hapke& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    return inv_two_pi;
}

// Uniform: mu_i / (mu_i + mu_o) has a bound.
inline HapkeSample hapke_sample(const Hapke& params, Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return HapkeSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    Vec3 wi = hapke_sample_uniform(u);
    return HapkeSample{wi, hapke_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline Vec3 hapke_albedo(const Hapke& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    Vec3 w = Vec3{wo.x, wo.y, fmaxf(wo.z, HORIZON)};
    Vec3 total = Vec3{0.0f, 0.0f, 0.0f};
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        Vec2 u = Vec2{(i + 0.5f) / ALBEDO_SAMPLES, fract((i + 0.5f) * GOLDEN)};
        HapkeSample drawn = hapke_sample(params, w, u);
        float weight = drawn.pdf > 0.0f ? drawn.wi.z / fmaxf(drawn.pdf, mu_min) : 0.0f;
        total = total + hapke_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}

}  // namespace gonio_hapke
