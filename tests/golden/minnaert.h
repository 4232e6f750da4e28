// SPDX-License-Identifier: Apache-2.0
// Minnaert: limb darkening of planets as a power of both cosines.
//
// Source: Minnaert, "The reciprocity principle in lunar photometry", Astrophysical Journal 93, 1941,
// normalised such that rho is the albedo at the normal. k = 1 is Lambert; the full Moon has about k = 0.5.
//
// C++, made by gonio from gonio/models/minnaert.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// Usage: gonio_minnaert::Minnaert params; params.rho = ...; ... gonio_minnaert::minnaert_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_minnaert {

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
constexpr float inv_two_pi = 0.15915494f;
constexpr float mu_min = 1.0e-18f;  // cosine of the horizon
// Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
constexpr float LOG1P_SMALL = 0.25f;
// Below this the series needs few terms; above, the plain difference is exact to 2e-7 in float32.
constexpr float EXPM1_SMALL = 0.3f;

// A sampled direction and its density.
struct MinnaertSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// minnaert: Planets and moons by one exponent: darker limbs above k = 1, brighter ones below. Reciprocal.
struct Minnaert {
    Vec3 rho;  // albedo at the normal, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    float k;  // limb darkening: 1 is Lambert, 0.5 a flat full moon; 0 to 2, default 0.7
};

// ---- evaluation ----------------------------------------------------------------------------

// rho (k + 1) / (2 pi) (mu_i mu_o)^(k - 1): BRDF value in 1/sr, without the cosine.
inline Vec3 minnaert_eval(const Minnaert& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    float k = params.k;
    return params.rho * (inv_two_pi * (k + 1.0f) * powf(wi.z, k - 1.0f) * powf(wo.z, k - 1.0f));
}

// ---- sampling ------------------------------------------------------------------------------

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
inline float minnaert_atanh_over(float y) {
    float y2 = y * y;
    return 1.0f + y2 * (1.0f / 3.0f + y2 * (1.0f / 5.0f + y2 * (1.0f / 7.0f + y2 * (1.0f / 9.0f))));
}

// log(1 + x) / x for x > -1; 1 at x = 0.
inline float minnaert_log1p_over(float x) {
    float near = fmaxf(fminf(x, LOG1P_SMALL), -LOG1P_SMALL);
    bool small = x > -LOG1P_SMALL && x < LOG1P_SMALL;
    float far = small ? 1.0f : x;
    float series = minnaert_atanh_over(near / (2.0f + near));
    return small ? 2.0f / (2.0f + near) * series : logf(1.0f + far) / far;
}

// log(1 + x) for x > -1, exact where x is small.
inline float minnaert_log1p(float x) {
    return x * minnaert_log1p_over(x);
}

// exp(x) - 1, exact where x is small.
inline float minnaert_expm1(float x) {
    float near = fmaxf(fminf(x, EXPM1_SMALL), -EXPM1_SMALL);
    // Taylor's series
    float over = 1.0f + near
        * (0.5f + near * (0.16666667f
            + near * (0.041666668f
                + near * (0.008333334f + near * (0.0013888889f + near * 0.0001984127f)))));
    return x > -EXPM1_SMALL && x < EXPM1_SMALL ? near * over : expf(x) - 1.0f;
}

// Density of minnaert_sample in 1/sr.
inline float minnaert_pdf(const Minnaert& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    return inv_two_pi * (params.k + 1.0f) * powf(wi.z, params.k);
}

// A direction with a density like mu_i^k, which leaves a constant weight.
inline MinnaertSample minnaert_sample(const Minnaert& params, Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return MinnaertSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    float t = minnaert_log1p(-u.x) / (params.k + 1.0f);
    float r = sqrtf(fmaxf(-minnaert_expm1(2.0f * t), 0.0f));
    float phi = two_pi * u.y;
    Vec3 wi = Vec3{r * cosf(phi), r * sinf(phi), expf(t)};
    return MinnaertSample{wi, minnaert_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// rho mu_o^(k - 1).
inline Vec3 minnaert_albedo(const Minnaert& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    return params.rho * powf(fmaxf(wo.z, mu_min), params.k - 1.0f);
}

}  // namespace gonio_minnaert
