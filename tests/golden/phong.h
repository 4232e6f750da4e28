// SPDX-License-Identifier: Apache-2.0
// Phong: a diffuse term and a highlight around the mirror direction.
//
// Sources: Phong, "Illumination for computer generated pictures", Communications of the ACM 18(6), 1975;
// Lafortune, Willems, "Using the modified Phong reflectance model for physically based rendering", 1994,
// for the normalised form. alpha is the angle between wi and the mirror direction of wo.
// Phong's formula gives the radiance f cos(theta_i); "classical" is that formula divided by the cosine.
//
// C++, made by gonio from gonio/models/phong.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: gonio_phong::Phong params; params.rho = ...; ... gonio_phong::phong_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_phong {

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

inline Vec3 operator*(Vec3 a, float b) {
    return Vec3{a.x * b, a.y * b, a.z * b};
}

inline Vec3 operator/(Vec3 a, float b) {
    return Vec3{a.x / b, a.y / b, a.z / b};
}

// Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
constexpr float LOG1P_SMALL = 0.25f;
// Below this the series needs few terms; above, the plain difference is exact to 2e-7 in float32.
constexpr float EXPM1_SMALL = 0.3f;
// Smallest cosine whose logarithm is taken: its reciprocal, the derivative, still is a float32.
constexpr float COS_MIN = 1.0e-37f;
constexpr float pi = 3.1415927f;
constexpr float two_pi = 6.2831855f;
constexpr float inv_pi = 0.31830987f;
constexpr float inv_two_pi = 0.15915494f;
constexpr float mu_min = 1.0e-18f;  // cosine of the horizon
// Added to the first lobe's weight, so that two black lobes still leave something to choose and the
// reciprocal of their sum has a derivative; no albedo that can be seen is that small.
constexpr float BLACK = 1.0e-12f;
// The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
// grazing direction may have a density of 1e22 in that lobe.
constexpr float WEIGHT_MIN = 1.0e-37f;
// The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
// its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
constexpr float SHARE_LEAST = 0.1f;
constexpr float ESTIMATE_TRUST = 50.0f;
// Smallest probability that is divided by: a random number falls below it once in a million million.
constexpr float SHARE_MIN = 1.0e-12f;
// The largest float32 below 1, up to which random numbers go.
constexpr float RANDOM_MAX = 0.99999994f;
// Below this squared sine the azimuth of wo is taken as 0: any azimuth is right there, and the square of
// its reciprocal still fits into a float32.
constexpr float SIN2_MIN = 1.0e-18f;
// Steps of the rule in phong_albedo: a Fibonacci number, and the golden ratio.
constexpr float ALBEDO_SAMPLES = 987.0f;
constexpr float GOLDEN = 0.618034f;
// Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
constexpr float HORIZON = 1.0e-6f;

// A sampled direction and its density.
struct PhongSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// phong: Diffuse with a round highlight around the mirror direction, the classic of computer graphics.
// Exported with form='normalized'.
struct Phong {
    Vec3 rho;  // albedo of the diffuse term, linear RGB; 0 to 1, default (0.5, 0.5, 0.5)
    Vec3 specular;  // weight of the highlight, linear RGB; 0 to 1, default (0.3, 0.3, 0.3)
    float shininess;  // exponent n of the highlight; 0 to 100000, default 20
};

// Which of two lobes a sample is taken from.
struct PhongChoice {
    bool is_first;  // Whether it is the first one
    Vec2 u;  // Fresh random numbers, made of those that chose
};

// ---- evaluation ----------------------------------------------------------------------------

// Cosine between wi and the mirror direction of wo: mu_i mu_o - wi.x wo.x - wi.y wo.y.
//
// Near 0 the three products cancel. The rounding errors of the last two and of their sum are carried along
// (Kahan's and Knuth's ways to find them), so that a broad lobe fades out with all its digits; the first
// product comes in with a single rounding, which is small beside what is left.
inline float phong_cos_alpha(Vec3 wi, Vec3 wo) {
    float x = wi.x * wo.x;
    float y = wi.y * wo.y;
    float s = x + y;
    float back_y = s - x;
    float error_s = x - (s - back_y) + (y - back_y);
    float error = fmaf(wi.x, wo.x, -x) + fmaf(wi.y, wo.y, -y) + error_s;
    return fmaf(wi.z, wo.z, -s) - error;
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
inline float phong_atanh_over(float y) {
    float y2 = y * y;
    return 1.0f + y2 * (1.0f / 3.0f + y2 * (1.0f / 5.0f + y2 * (1.0f / 7.0f + y2 * (1.0f / 9.0f))));
}

// log(1 + x) for x from -LOG1P_SMALL to LOG1P_SMALL.
inline float phong_log1p_small(float x) {
    float y = x / (2.0f + x);
    return 2.0f * y * phong_atanh_over(y);
}

// max(0, cos(alpha))^exponent; half of all directions have 0 for exponent 0 as well.
inline float phong_lobe(Vec3 wi, Vec3 wo, float exponent) {
    // Inside, the digits of a sharp lobe are in 1 - cos(alpha): half the squared distance to the
    // mirror direction.
    Vec3 apart = Vec3{wi.x + wo.x, wi.y + wo.y, wi.z - wo.z};
    float q = 0.5f * dot(apart, apart);
    float c = phong_cos_alpha(wi, wo);
    float near = phong_log1p_small(-fminf(q, LOG1P_SMALL));
    float log_cos = q < LOG1P_SMALL ? near : logf(fminf(fmaxf(c, COS_MIN), 1.0f));
    return c > 0.0f ? expf(exponent * log_cos) : 0.0f;
}

// The highlight without its weight.
inline float phong_highlight(const Phong& params, Vec3 wi, Vec3 wo) {
    float n = params.shininess;
    return inv_two_pi * (n + 2.0f) * phong_lobe(wi, wo, n);
}

// BRDF value in 1/sr, without the cosine.
inline Vec3 phong_eval(const Phong& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    return params.rho * inv_pi + params.specular * phong_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// Mean of the three channels, by which lobes are weighed against each other.
inline float phong_average(Vec3 color) {
    return (color.x + color.y + color.z) / 3.0f;
}

inline float phong_raised(float probability) {
    return fmaxf(probability, fminf(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
inline Vec2 phong_lobes_shares(float first, float second) {
    float a = first + BLACK;
    float b = fmaxf(second, WEIGHT_MIN);
    float inv = 1.0f / (a + b);
    float P_first = phong_raised(a * inv);
    float P_second = phong_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return Vec2{smaller ? P_first : 1.0f - P_second, smaller ? 1.0f - P_first : P_second};
}

// Probabilities of the diffuse lobe and of the highlight.
inline Vec2 phong_shares(const Phong& params, Vec3 wo) {
    float n = params.shininess;
    // 1 at the normal; in the horizon about 1 / sqrt(2 pi n), and 1/2 for n = 0
    float highlight = lerp(0.5f / sqrtf(1.0f + 0.5f * pi * n), 1.0f, wo.z);
    return phong_lobes_shares(phong_average(params.rho),
        phong_average(params.specular) * highlight);
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
inline PhongChoice phong_choose(float probability, Vec2 u) {
    bool first = u.x < probability;
    float below = u.x / fmaxf(probability, SHARE_MIN);
    float above = (u.x - probability) / fmaxf(1.0f - probability, SHARE_MIN);
    return PhongChoice{first, Vec2{fminf(fmaxf(first ? below : above, 0.0f), RANDOM_MAX), u.y}};
}

// A direction with density cos(theta) / pi.
inline Vec3 phong_sample_cosine(Vec2 u) {
    float r = sqrtf(fmaxf(u.x, 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), sqrtf(fmaxf(1.0f - u.x, 0.0f))};
}

// exp(x) - 1, exact where x is small.
inline float phong_expm1(float x) {
    float near = fmaxf(fminf(x, EXPM1_SMALL), -EXPM1_SMALL);
    // Taylor's series
    float over = 1.0f + near
        * (0.5f + near * (0.16666667f
            + near * (0.041666668f
                + near * (0.008333334f + near * (0.0013888889f + near * 0.0001984127f)))));
    return x > -EXPM1_SMALL && x < EXPM1_SMALL ? near * over : expf(x) - 1.0f;
}

// Cosine and sine of wo's azimuth; (1, 0) at normal incidence.
inline Vec2 phong_azimuth(Vec3 wo) {
    float sin2 = wo.x * wo.x + wo.y * wo.y;
    bool tilted = sin2 > SIN2_MIN;
    float inv = 1.0f / sqrtf(fmaxf(sin2, SIN2_MIN));
    return Vec2{tilted ? wo.x * inv : 1.0f, tilted ? wo.y * inv : 0.0f};
}

// A direction around wo's mirror image with density (n + 1) / (2 pi) cos(alpha)^n.
//
// What falls below the horizon is mirrored up again, so that no sample is wasted.
inline Vec3 phong_sample_lobe(Vec3 wo, float exponent, Vec2 u) {
    // cos(alpha) = (1 - u)^(1 / (n + 1)), and sin^2 = 1 - cos^2 without cancellation
    float t = logf(1.0f - u.x) / (exponent + 1.0f);
    float c = expf(t);
    float s = sqrtf(fmaxf(-phong_expm1(2.0f * t), 0.0f));
    float phi = two_pi * u.y;
    // A frame around the mirror direction: towards the normal, and level.
    Vec2 axis = phong_azimuth(wo);
    float sin_o = sqrtf(fmaxf(wo.x * wo.x + wo.y * wo.y, 0.0f));
    float x = s * cosf(phi);
    float y = s * sinf(phi);
    float outward = c * sin_o - x * wo.z;
    float up = c * wo.z + x * sin_o;
    Vec3 w = Vec3{-axis.x * outward + axis.y * y, -axis.y * outward - axis.x * y, up};
    return normalize(Vec3{w.x, w.y, fabsf(w.z)});
}

// Density of phong_sample_cosine in 1/sr, for w above the horizon.
inline float phong_pdf_cosine(Vec3 w) {
    return w.z * inv_pi;
}

// Density of phong_sample_lobe in 1/sr.
inline float phong_pdf_lobe(Vec3 wi, Vec3 wo, float exponent) {
    float both = phong_lobe(wi, wo, exponent) + phong_lobe(Vec3{wi.x, wi.y, -wi.z}, wo, exponent);
    return inv_two_pi * (exponent + 1.0f) * both;
}

// Density of phong_sample in 1/sr.
inline float phong_pdf(const Phong& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    Vec2 P = phong_shares(params, wo);
    return P.x * phong_pdf_cosine(wi) + P.y * phong_pdf_lobe(wi, wo, params.shininess);
}

// Cosine-weighted, or around the mirror direction, by the estimated albedos.
inline PhongSample phong_sample(const Phong& params, Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return PhongSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    PhongChoice choose_result = phong_choose(phong_shares(params, wo).x, u);
    bool first = choose_result.is_first;
    Vec2 v = choose_result.u;
    Vec3 wi = first ? phong_sample_cosine(v) : phong_sample_lobe(wo, params.shininess, v);
    return PhongSample{wi, phong_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline Vec3 phong_albedo(const Phong& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    Vec3 w = Vec3{wo.x, wo.y, fmaxf(wo.z, HORIZON)};
    Vec3 total = Vec3{0.0f, 0.0f, 0.0f};
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        Vec2 u = Vec2{(i + 0.5f) / ALBEDO_SAMPLES, fract((i + 0.5f) * GOLDEN)};
        PhongSample drawn = phong_sample(params, w, u);
        float weight = drawn.pdf > 0.0f ? drawn.wi.z / fmaxf(drawn.pdf, mu_min) : 0.0f;
        total = total + phong_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}

}  // namespace gonio_phong
