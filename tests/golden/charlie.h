// SPDX-License-Identifier: Apache-2.0
// Charlie: sheen of cloth, fibres that stand up.
//
// Source: Estevez, Kulla, "Production friendly microfacet sheen BRDF", SIGGRAPH 2017 course, Eq. 2 for the
// distribution; its masking grows without bound in the horizon, and real-time renderers took that of
// Neubelt, Pettineo, "Crafting a next-gen material pipeline for The Order: 1886", SIGGRAPH 2013 course,
// which is here.
//
// C++, made by gonio from gonio/models/charlie.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: gonio_charlie::Charlie params; params.rho = ...; ... gonio_charlie::charlie_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_charlie {

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

inline Vec3 operator+(Vec3 a, Vec3 b) {
    return Vec3{a.x + b.x, a.y + b.y, a.z + b.z};
}

inline Vec3 operator*(Vec3 a, float b) {
    return Vec3{a.x * b, a.y * b, a.z * b};
}

inline Vec3 operator*(float a, Vec3 b) {
    return Vec3{a * b.x, a * b.y, a * b.z};
}

inline Vec3 operator/(Vec3 a, float b) {
    return Vec3{a.x / b, a.y / b, a.z / b};
}

// wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
// squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
// much longer.
constexpr float LENGTHENED = 1.0995116e12f;
constexpr float two_pi = 6.2831855f;
constexpr float inv_two_pi = 0.15915494f;
constexpr float mu_min = 1.0e-18f;  // cosine of the horizon
// Smallest squared sine of a half vector: below it grazing directions have no digits left for it.
constexpr float SIN2_LEAST = 1.0e-12f;
// Steps of the rule in charlie_albedo: a Fibonacci number, and the golden ratio.
constexpr float ALBEDO_SAMPLES = 987.0f;
constexpr float GOLDEN = 0.618034f;
// Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
constexpr float HORIZON = 1.0e-6f;

// A sampled direction and its density.
struct CharlieSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// charlie: Velvet and felt: bright at the edges, to be laid over a base. Reciprocal.
struct Charlie {
    Vec3 rho;  // colour of the sheen, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    // roughness of the fibres; 1 / alpha is the sine's exponent; 0.05 to 1, default 0.4
    float alpha;
};

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
inline float charlie_length2(Vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
inline Vec3 charlie_half_vector(Vec3 wi, Vec3 wo) {
    Vec3 h = LENGTHENED * (wi + wo);
    return h / sqrtf(charlie_length2(h));  // the root is the cosine's as well
}

// D / (4 (mu_i + mu_o - mu_i mu_o)): BRDF value in 1/sr, without the cosine.
inline Vec3 charlie_eval(const Charlie& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    Vec3 m = charlie_half_vector(wi, wo);
    float inv = 1.0f / params.alpha;
    float sin2 = fmaxf(m.x * m.x + m.y * m.y, SIN2_LEAST);
    float D = inv_two_pi * (2.0f + inv) * expf(0.5f * inv * logf(sin2));
    return params.rho * (0.25f * D / (wi.z + wo.z * (1.0f - wi.z)));
}

// ---- sampling ------------------------------------------------------------------------------

// A direction with density 1 / (2 pi).
inline Vec3 charlie_sample_uniform(Vec2 u) {
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    float z = 1.0f - u.x;
    float r = sqrtf(fmaxf(u.x * (1.0f + z), 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), z};
}

// Density of charlie_sample in 1/sr.
inline float charlie_pdf(const Charlie& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    return inv_two_pi;
}

// Uniform: mu_i / (mu_i + mu_o) has a bound.
inline CharlieSample charlie_sample(const Charlie& params, Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return CharlieSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    Vec3 wi = charlie_sample_uniform(u);
    return CharlieSample{wi, charlie_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline Vec3 charlie_albedo(const Charlie& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    Vec3 w = Vec3{wo.x, wo.y, fmaxf(wo.z, HORIZON)};
    Vec3 total = Vec3{0.0f, 0.0f, 0.0f};
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        Vec2 u = Vec2{(i + 0.5f) / ALBEDO_SAMPLES, fract((i + 0.5f) * GOLDEN)};
        CharlieSample drawn = charlie_sample(params, w, u);
        float weight = drawn.pdf > 0.0f ? drawn.wi.z / fmaxf(drawn.pdf, mu_min) : 0.0f;
        total = total + charlie_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}

}  // namespace gonio_charlie
