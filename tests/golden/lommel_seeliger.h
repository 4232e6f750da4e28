// SPDX-License-Identifier: Apache-2.0
// Lommel-Seeliger: single scattering in a half space of dark dust, such as the Moon's.
//
// Source: Seeliger, "Zur Photometrie des Saturnringes", Astronomische Nachrichten 109, 1884, in the form
// of Hapke, "Bidirectional reflectance spectroscopy, 1: theory", Journal of Geophysical Research 86, 1981,
// Eq. 15 without its other orders, for grains that scatter evenly in all directions. The albedos are
// integrated here.
//
// C++, made by gonio from gonio/models/lommel_seeliger.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// Usage: gonio_lommel_seeliger::LommelSeeliger params; params.rho = ...; ... gonio_lommel_seeliger::lommel_seeliger_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_lommel_seeliger {

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
constexpr float INV_FOUR_PI = 0.07957747f;
// Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
constexpr float LOG1P_SMALL = 0.25f;

// A sampled direction and its density.
struct LommelSeeligerSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// lommel_seeliger: Dark dust that scatters light once; a full moon without dark limbs. Reciprocal.
struct LommelSeeliger {
    Vec3 rho;  // single-scattering albedo w of a grain, linear RGB; 0 to 1, default (0.3, 0.3, 0.3)
};

// ---- evaluation ----------------------------------------------------------------------------

// w / (4 pi (mu_i + mu_o)): BRDF value in 1/sr, without the cosine.
inline Vec3 lommel_seeliger_eval(const LommelSeeliger& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    return params.rho * (INV_FOUR_PI / (wi.z + wo.z));
}

// ---- sampling ------------------------------------------------------------------------------

// A direction with density 1 / (2 pi).
inline Vec3 lommel_seeliger_sample_uniform(Vec2 u) {
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    float z = 1.0f - u.x;
    float r = sqrtf(fmaxf(u.x * (1.0f + z), 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), z};
}

// Density of lommel_seeliger_sample in 1/sr.
inline float lommel_seeliger_pdf(const LommelSeeliger& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    return inv_two_pi;
}

// Uniform: the weight, w / 2 mu_i / (mu_i + mu_o), has a bound.
inline LommelSeeligerSample lommel_seeliger_sample(const LommelSeeliger& params, Vec3 wo,
    Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return LommelSeeligerSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    Vec3 wi = lommel_seeliger_sample_uniform(u);
    return LommelSeeligerSample{wi, lommel_seeliger_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
inline float lommel_seeliger_atanh_over(float y) {
    float y2 = y * y;
    return 1.0f + y2 * (1.0f / 3.0f + y2 * (1.0f / 5.0f + y2 * (1.0f / 7.0f + y2 * (1.0f / 9.0f))));
}

// log(1 + x) / x for x > -1; 1 at x = 0.
inline float lommel_seeliger_log1p_over(float x) {
    float near = fmaxf(fminf(x, LOG1P_SMALL), -LOG1P_SMALL);
    bool small = x > -LOG1P_SMALL && x < LOG1P_SMALL;
    float far = small ? 1.0f : x;
    float series = lommel_seeliger_atanh_over(near / (2.0f + near));
    return small ? 2.0f / (2.0f + near) * series : logf(1.0f + far) / far;
}

// log(1 + x) for x > -1, exact where x is small.
inline float lommel_seeliger_log1p(float x) {
    return x * lommel_seeliger_log1p_over(x);
}

// w / 2 (1 - mu_o log((1 + mu_o) / mu_o)).
inline Vec3 lommel_seeliger_albedo(const LommelSeeliger& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    float mu = wo.z;
    return params.rho * (0.5f - 0.5f * mu * (lommel_seeliger_log1p(mu) - logf(fmaxf(mu, mu_min))));
}

}  // namespace gonio_lommel_seeliger
