// SPDX-License-Identifier: Apache-2.0
// Student-t: facets whose slopes have tails of any length, between Beckmann's and longer than GGX's.
//
// Source: Ribardiere, Bringier, Meneveaux, Simonot, "STD: Student's t-distribution of slopes for microfacet
// based BSDFs", Computer Graphics Forum 36(2), 2017: D and its samples. gamma = 2 is GGX, and large gammas
// come near Beckmann. Burley's GTR, "Physically-based shading at Disney", 2012, has the same family of
// tails. Deviation: G is Cook and Torrance's, which is exact for V-cavities of any facets and needs no fit.
//
// C++, made by gonio from gonio/models/student_t.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: gonio_student_t::StudentT params; params.f0 = ...; ... gonio_student_t::student_t_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_student_t {

struct Vec2 {
    float x, y;
};

struct Vec3 {
    float x, y, z;
};

inline Vec3 splat(float a) {
    return Vec3{a, a, a};
}

inline float lerp(float a, float b, float t) {
    return a * (1.0f - t) + b * t;
}

inline float fract(float a) {
    return a - floorf(a);
}

inline float dot(Vec3 a, Vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

inline Vec3 normalize(Vec3 a) {
    float inv = 1.0f / sqrtf(a.x * a.x + a.y * a.y + a.z * a.z);
    return Vec3{a.x * inv, a.y * inv, a.z * inv};
}

inline Vec3 operator+(Vec3 a, Vec3 b) {
    return Vec3{a.x + b.x, a.y + b.y, a.z + b.z};
}

inline Vec3 operator-(Vec3 a, Vec3 b) {
    return Vec3{a.x - b.x, a.y - b.y, a.z - b.z};
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

inline Vec3 lerp(Vec3 a, Vec3 b, Vec3 c) {
    return Vec3{lerp(a.x, b.x, c.x), lerp(a.y, b.y, c.y), lerp(a.z, b.z, c.z)};
}

// wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
// squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
// much longer.
constexpr float LENGTHENED = 1.0995116e12f;
// Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
constexpr float LOG1P_SMALL = 0.25f;
// Below this the series needs few terms; above, the plain difference is exact to 2e-7 in float32.
constexpr float EXPM1_SMALL = 0.3f;
// Largest squared slope in units of the widths: more leaves a float32, and D is 0 long before.
constexpr float RATIO_MAX = 1.0e37f;
constexpr float two_pi = 6.2831855f;
constexpr float inv_pi = 0.31830987f;
constexpr float mu_min = 1.0e-18f;  // cosine of the horizon
// Largest V of the maskings that grow like 1 / mu^2 where both directions graze: times the largest D, 3e7,
// it still is a float32. It is reached at cosines of 5e-16.
constexpr float V_MAX = 1.0e30f;
// Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
constexpr float RANDOM_MARGIN = 5.9604645e-8f;
// Steps of the rule in student_t_albedo: a Fibonacci number, and the golden ratio.
constexpr float ALBEDO_SAMPLES = 987.0f;
constexpr float GOLDEN = 0.618034f;
// Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
constexpr float HORIZON = 1.0e-6f;

// A sampled direction and its density.
struct StudentTSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// student_t: Metals and plastics whose highlights have the tail that was measured. Reciprocal.
struct StudentT {
    Vec3 f0;  // reflectance at normal incidence, linear RGB; 0 to 1, default (0.9, 0.9, 0.9)
    float alpha;  // slope width: GGX's alpha at gamma = 2; 0.001 to 1, default 0.3
    // tail: 2 is GGX's, smaller is longer, 40 is nearly Beckmann's; 1.55 to 40, default 2
    float gamma_;
};

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
inline float student_t_length2(Vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
inline float student_t_cos_half(Vec3 wi, Vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5f * sqrtf(student_t_length2(wi + wo));
}

// 1 - student_t_cos_half^2, the squared sine at which light meets the facet: of half the length of wi - wo.
inline float student_t_sin2_half(Vec3 wi, Vec3 wo) {
    Vec3 apart = wi - wo;
    return 0.25f * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
inline float student_t_weight(float cos_h, float sin2_h) {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    float k = sin2_h / (1.0f + cos_h);
    float k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
inline float student_t_schlick_weight_half(Vec3 wi, Vec3 wo) {
    return student_t_weight(student_t_cos_half(wi, wo), student_t_sin2_half(wi, wo));
}

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
inline Vec3 student_t_half_vector(Vec3 wi, Vec3 wo) {
    Vec3 h = LENGTHENED * (wi + wo);
    return h / sqrtf(student_t_length2(h));  // the root is the cosine's as well
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
inline float student_t_atanh_over(float y) {
    float y2 = y * y;
    return 1.0f + y2 * (1.0f / 3.0f + y2 * (1.0f / 5.0f + y2 * (1.0f / 7.0f + y2 * (1.0f / 9.0f))));
}

// log(1 + x) / x for x > -1; 1 at x = 0.
inline float student_t_log1p_over(float x) {
    float near = fmaxf(fminf(x, LOG1P_SMALL), -LOG1P_SMALL);
    bool small = x > -LOG1P_SMALL && x < LOG1P_SMALL;
    float far = small ? 1.0f : x;
    float series = student_t_atanh_over(near / (2.0f + near));
    return small ? 2.0f / (2.0f + near) * series : logf(1.0f + far) / far;
}

// log(1 + x) for x > -1, exact where x is small.
inline float student_t_log1p(float x) {
    return x * student_t_log1p_over(x);
}

// 1 / (pi a^2 z^4 (1 + x)^g) with x = tan^2 / ((g - 1) a^2).
inline float student_t_D(const StudentT& params, Vec3 m) {
    float a2 = params.alpha * params.alpha;
    float z2 = m.z * m.z;
    float slope2 = (m.x * m.x + m.y * m.y) / ((params.gamma_ - 1.0f) * a2);
    // z^-4 (1 + x)^-g = (z^2 + slope2)^-2 (1 + x)^(2 - g), finite in the horizon; log1p keeps the digits that a
    // large g multiplies
    float x = fminf(slope2 / z2, RATIO_MAX);
    float whole = z2 + slope2;
    return inv_pi / a2 / (whole * whole) * expf((2.0f - params.gamma_) * student_t_log1p(x));
}

// G over 4 mu_i mu_o.
inline float student_t_V_cook_torrance(Vec3 wi, Vec3 wo) {
    Vec3 h = wi + wo;
    return fminf(fminf(h.z / student_t_length2(h) * fminf(wi.z, wo.z), 0.25f) / (wi.z * wo.z),
        V_MAX);
}

// D G / (4 mu_i mu_o): the highlight without F.
inline float student_t_highlight(const StudentT& params, Vec3 wi, Vec3 wo) {
    Vec3 m = student_t_half_vector(wi, wo);
    return student_t_D(params, m) * student_t_V_cook_torrance(wi, wo);
}

// F D G / (4 mu_i mu_o): BRDF value in 1/sr, without the cosine.
inline Vec3 student_t_eval(const StudentT& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    return lerp(params.f0, splat(1.0f), splat(student_t_schlick_weight_half(wi, wo)))
        * student_t_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// exp(x) - 1, exact where x is small.
inline float student_t_expm1(float x) {
    float near = fmaxf(fminf(x, EXPM1_SMALL), -EXPM1_SMALL);
    // Taylor's series
    float over = 1.0f + near
        * (0.5f + near * (0.16666667f
            + near * (0.041666668f
                + near * (0.008333334f + near * (0.0013888889f + near * 0.0001984127f)))));
    return x > -EXPM1_SMALL && x < EXPM1_SMALL ? near * over : expf(x) - 1.0f;
}

// tan^2 = (g - 1) a^2 ((1 - u)^(1 / (1 - g)) - 1).
inline Vec3 student_t_normal(const StudentT& params, Vec2 u) {
    float spread = student_t_expm1(logf(fmaxf(1.0f - u.x, RANDOM_MARGIN)) / (1.0f - params.gamma_));
    float tangent = params.alpha * sqrtf(fmaxf((params.gamma_ - 1.0f) * spread, 0.0f));
    float phi = two_pi * u.y;
    return normalize(Vec3{tangent * cosf(phi), tangent * sinf(phi), 1.0f});
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
inline Vec3 student_t_mirror(Vec3 wo, Vec3 m) {
    return 2.0f * dot(wo, m) * m - wo;
}

// |wi + wo| / 2, the same with all digits however short it is: for what is divided by it.
inline float student_t_half_length(Vec3 wi, Vec3 wo) {
    return 0.5f / LENGTHENED * sqrtf(student_t_length2(LENGTHENED * (wi + wo)));
}

// Density of student_t_mirror in 1/sr, if m has the given density and cos_h = wo . m.
inline float student_t_pdf_mirror(float density, float cos_h) {
    // Walter et al., Eq. 14
    return 0.25f * density / cos_h;
}

// Density of student_t_sample in 1/sr.
inline float student_t_pdf(const StudentT& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    Vec3 m = student_t_half_vector(wi, wo);
    return student_t_pdf_mirror(student_t_D(params, m) * m.z, student_t_half_length(wi, wo));
}

// wo mirrored at a normal by its density.
inline StudentTSample student_t_sample(const StudentT& params, Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return StudentTSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    Vec3 wi = student_t_mirror(wo, student_t_normal(params, u));
    return StudentTSample{wi, student_t_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline Vec3 student_t_albedo(const StudentT& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    Vec3 w = Vec3{wo.x, wo.y, fmaxf(wo.z, HORIZON)};
    Vec3 total = Vec3{0.0f, 0.0f, 0.0f};
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        Vec2 u = Vec2{(i + 0.5f) / ALBEDO_SAMPLES, fract((i + 0.5f) * GOLDEN)};
        StudentTSample drawn = student_t_sample(params, w, u);
        float weight = drawn.pdf > 0.0f ? drawn.wi.z / fmaxf(drawn.pdf, mu_min) : 0.0f;
        total = total + student_t_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}

}  // namespace gonio_student_t
