// SPDX-License-Identifier: Apache-2.0
// Ashikhmin-Shirley: an anisotropic Phong highlight over a diffuse part that it takes its light from.
//
// Source: Ashikhmin, Shirley, "An anisotropic Phong BRDF model", Journal of Graphics Tools 5(2), 2000: Eq.
// 4, 5 and, for samples, 6 to 9.
// Deviation: (N.H) to its power is taken from the slopes of H, which a sharp lobe needs in float32.
//
// C++, made by gonio from gonio/models/ashikhmin_shirley.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: gonio_ashikhmin_shirley::AshikhminShirley params; params.rho = ...; ... gonio_ashikhmin_shirley::ashikhmin_shirley_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_ashikhmin_shirley {

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

inline Vec3 operator/(Vec3 a, float b) {
    return Vec3{a.x / b, a.y / b, a.z / b};
}

inline Vec3 lerp(Vec3 a, Vec3 b, Vec3 c) {
    return Vec3{lerp(a.x, b.x, c.x), lerp(a.y, b.y, c.y), lerp(a.z, b.z, c.z)};
}

// Eq. 5: 28 / 23 makes the diffuse part of a black highlight lose nothing.
constexpr float DIFFUSE = 1.2173913f;
constexpr float two_pi = 6.2831855f;
constexpr float inv_pi = 0.31830987f;
constexpr float inv_two_pi = 0.15915494f;
constexpr float mu_min = 1.0e-18f;  // cosine of the horizon
// wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
// squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
// much longer.
constexpr float LENGTHENED = 1.0995116e12f;
// Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
constexpr float LOG1P_SMALL = 0.25f;
// Below this the series needs few terms; above, the plain difference is exact to 2e-7 in float32.
constexpr float EXPM1_SMALL = 0.3f;
// Largest V of the maskings that grow like 1 / mu^2 where both directions graze: times the largest D, 3e7,
// it still is a float32. It is reached at cosines of 5e-16.
constexpr float V_MAX = 1.0e30f;
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
// Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
constexpr float RANDOM_MARGIN = 5.9604645e-8f;
// Steps of the rule in ashikhmin_shirley_albedo: a Fibonacci number, and the golden ratio.
constexpr float ALBEDO_SAMPLES = 987.0f;
constexpr float GOLDEN = 0.618034f;
// Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
constexpr float HORIZON = 1.0e-6f;

// A sampled direction and its density.
struct AshikhminShirleySample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// ashikhmin_shirley: Brushed metal and varnished wood by two exponents. Reciprocal.
struct AshikhminShirley {
    Vec3 rho;  // diffuse reflectance R_d, linear RGB; 0 to 1, default (0.5, 0.5, 0.5)
    Vec3 f0;  // reflectance R_s at normal incidence, linear RGB; 0 to 1, default (0.04, 0.04, 0.04)
    float shininess_x;  // exponent n_u along x; 0 to 100000, default 100
    float shininess_y;  // exponent n_v along y; 0 to 100000, default 100
};

// Which of two lobes a sample is taken from.
struct AshikhminShirleyChoice {
    bool is_first;  // Whether it is the first one
    Vec2 u;  // Fresh random numbers, made of those that chose
};

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
inline float ashikhmin_shirley_length2(Vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
inline float ashikhmin_shirley_cos_half(Vec3 wi, Vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5f * sqrtf(ashikhmin_shirley_length2(wi + wo));
}

// 1 - ashikhmin_shirley_cos_half^2, the squared sine at which light meets the facet: of half the length of
// wi - wo.
inline float ashikhmin_shirley_sin2_half(Vec3 wi, Vec3 wo) {
    Vec3 apart = wi - wo;
    return 0.25f * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
inline float ashikhmin_shirley_weight(float cos_h, float sin2_h) {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    float k = sin2_h / (1.0f + cos_h);
    float k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
inline float ashikhmin_shirley_schlick_weight_half(Vec3 wi, Vec3 wo) {
    return ashikhmin_shirley_weight(ashikhmin_shirley_cos_half(wi, wo),
        ashikhmin_shirley_sin2_half(wi, wo));
}

// 1 - (1 - mu / 2)^5, with the factor mu taken out.
inline float ashikhmin_shirley_below(float mu) {
    float k = 1.0f - 0.5f * mu;
    return 0.5f * mu * (1.0f + k * (1.0f + k * (1.0f + k * (1.0f + k))));
}

// The diffuse part, which is not stretched (Eq. 5).
inline Vec3 ashikhmin_shirley_eval_round(const AshikhminShirley& params, Vec3 wi, Vec3 wo) {
    float below = ashikhmin_shirley_below(wi.z) * ashikhmin_shirley_below(wo.z);
    return DIFFUSE * inv_pi * below * params.rho * (1.0f - params.f0);
}

// |wi + wo| / 2, the same with all digits however short it is: for what is divided by it.
inline float ashikhmin_shirley_half_length(Vec3 wi, Vec3 wo) {
    return 0.5f / LENGTHENED * sqrtf(ashikhmin_shirley_length2(LENGTHENED * (wi + wo)));
}

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
inline Vec3 ashikhmin_shirley_half_vector(Vec3 wi, Vec3 wo) {
    Vec3 h = LENGTHENED * (wi + wo);
    return h / sqrtf(ashikhmin_shirley_length2(h));  // the root is the cosine's as well
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
inline float ashikhmin_shirley_atanh_over(float y) {
    float y2 = y * y;
    return 1.0f + y2 * (1.0f / 3.0f + y2 * (1.0f / 5.0f + y2 * (1.0f / 7.0f + y2 * (1.0f / 9.0f))));
}

// log(1 + x) / x for x > -1; 1 at x = 0.
inline float ashikhmin_shirley_log1p_over(float x) {
    float near = fmaxf(fminf(x, LOG1P_SMALL), -LOG1P_SMALL);
    bool small = x > -LOG1P_SMALL && x < LOG1P_SMALL;
    float far = small ? 1.0f : x;
    float series = ashikhmin_shirley_atanh_over(near / (2.0f + near));
    return small ? 2.0f / (2.0f + near) * series : logf(1.0f + far) / far;
}

// Density of normals, times a weight.
//
// sqrt((n_u + 1) (n_v + 1)) / (2 pi) (N.m)^(n_u cos^2 + n_v sin^2 of the azimuth).
inline float ashikhmin_shirley_weighed(const AshikhminShirley& params, Vec3 m, float weight) {
    // -log(N.m) (n_u x^2 + n_v y^2) / (x^2 + y^2) with log(N.m) = -log(1 + tan^2) / 2: the square of the
    // sine cancels
    float x2 = m.x * m.x;
    float y2 = m.y * m.y;
    float z2 = m.z * m.z;
    float steep = 0.25f * ashikhmin_shirley_log1p_over((x2 + y2) / z2) / z2;
    float norm = inv_two_pi * sqrtf((params.shininess_x + 1.0f) * (params.shininess_y + 1.0f));
    // The root of the power, which twice has a place in a float32 where the power by itself has none
    float root = expf(-(params.shininess_x * x2 + params.shininess_y * y2) * steep);
    return norm * root * (root * weight);
}

// The highlight of Eq. 4 without F.
inline float ashikhmin_shirley_highlight(const AshikhminShirley& params, Vec3 wi, Vec3 wo) {
    float V = fminf(0.25f / ashikhmin_shirley_half_length(wi, wo) / fmaxf(wi.z, wo.z), V_MAX);
    return ashikhmin_shirley_weighed(params, ashikhmin_shirley_half_vector(wi, wo), V);
}

// Eq. 4 and 5: BRDF value in 1/sr, without the cosine.
inline Vec3 ashikhmin_shirley_eval(const AshikhminShirley& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    Vec3 F = lerp(params.f0, splat(1.0f), splat(ashikhmin_shirley_schlick_weight_half(wi, wo)));
    return ashikhmin_shirley_eval_round(params, wi, wo)
        + F * ashikhmin_shirley_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// (1 - cos_theta)^5 of Schlick's approximation.
inline float ashikhmin_shirley_schlick_weight(float cos_theta) {
    float k = 1.0f - cos_theta;
    float k2 = k * k;
    return k2 * k2 * k;
}

// Mean of the three channels, by which lobes are weighed against each other.
inline float ashikhmin_shirley_average(Vec3 color) {
    return (color.x + color.y + color.z) / 3.0f;
}

inline float ashikhmin_shirley_raised(float probability) {
    return fmaxf(probability, fminf(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
inline Vec2 ashikhmin_shirley_lobes_shares(float first, float second) {
    float a = first + BLACK;
    float b = fmaxf(second, WEIGHT_MIN);
    float inv = 1.0f / (a + b);
    float P_first = ashikhmin_shirley_raised(a * inv);
    float P_second = ashikhmin_shirley_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return Vec2{smaller ? P_first : 1.0f - P_second, smaller ? 1.0f - P_first : P_second};
}

// Probabilities of the diffuse part and of the highlight.
inline Vec2 ashikhmin_shirley_shares(const AshikhminShirley& params, Vec3 wo) {
    Vec3 F = lerp(params.f0, splat(1.0f), splat(ashikhmin_shirley_schlick_weight(wo.z)));
    return ashikhmin_shirley_lobes_shares(ashikhmin_shirley_average(params.rho
        * (1.0f - params.f0)), ashikhmin_shirley_average(F));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
inline AshikhminShirleyChoice ashikhmin_shirley_choose(float probability, Vec2 u) {
    bool first = u.x < probability;
    float below = u.x / fmaxf(probability, SHARE_MIN);
    float above = (u.x - probability) / fmaxf(1.0f - probability, SHARE_MIN);
    return AshikhminShirleyChoice{first,
        Vec2{fminf(fmaxf(first ? below : above, 0.0f), RANDOM_MAX), u.y}};
}

// A direction with density cos(theta) / pi.
inline Vec3 ashikhmin_shirley_sample_cosine(Vec2 u) {
    float r = sqrtf(fmaxf(u.x, 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), sqrtf(fmaxf(1.0f - u.x, 0.0f))};
}

// exp(x) - 1, exact where x is small.
inline float ashikhmin_shirley_expm1(float x) {
    float near = fmaxf(fminf(x, EXPM1_SMALL), -EXPM1_SMALL);
    // Taylor's series
    float over = 1.0f + near
        * (0.5f + near * (0.16666667f
            + near * (0.041666668f
                + near * (0.008333334f + near * (0.0013888889f + near * 0.0001984127f)))));
    return x > -EXPM1_SMALL && x < EXPM1_SMALL ? near * over : expf(x) - 1.0f;
}

inline Vec3 ashikhmin_shirley_normal(const AshikhminShirley& params, Vec2 u) {
    float phi = two_pi * u.y;
    float x = cosf(phi) / sqrtf(params.shininess_x + 1.0f);
    float y = sinf(phi) / sqrtf(params.shininess_y + 1.0f);
    float r2 = x * x + y * y;
    float exponent = (params.shininess_x * x * x + params.shininess_y * y * y) / r2;
    float tan2 = ashikhmin_shirley_expm1(-2.0f / (exponent + 1.0f)
        * logf(fmaxf(1.0f - u.x, RANDOM_MARGIN)));
    float scale = sqrtf(fmaxf(tan2, 0.0f)) / sqrtf(r2);
    return normalize(Vec3{x * scale, y * scale, 1.0f});
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
inline Vec3 ashikhmin_shirley_mirror(Vec3 wo, Vec3 m) {
    return 2.0f * dot(wo, m) * m - wo;
}

// Density of ashikhmin_shirley_sample_cosine in 1/sr, for w above the horizon.
inline float ashikhmin_shirley_pdf_cosine(Vec3 w) {
    return w.z * inv_pi;
}

// Density of ashikhmin_shirley_sample in 1/sr (Eq. 8).
inline float ashikhmin_shirley_pdf(const AshikhminShirley& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    Vec2 P = ashikhmin_shirley_shares(params, wo);
    float facets = ashikhmin_shirley_weighed(params, ashikhmin_shirley_half_vector(wi, wo),
        0.25f / ashikhmin_shirley_half_length(wi, wo));
    return P.x * ashikhmin_shirley_pdf_cosine(wi) + P.y * facets;
}

// Cosine-weighted, or wo mirrored at a normal by its density (Eq. 6, 7 and 9).
inline AshikhminShirleySample ashikhmin_shirley_sample(const AshikhminShirley& params, Vec3 wo,
    Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return AshikhminShirleySample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    AshikhminShirleyChoice choose_result = ashikhmin_shirley_choose(ashikhmin_shirley_shares(params,
        wo).x, u);
    bool matte = choose_result.is_first;
    Vec2 v = choose_result.u;
    Vec3 wi = matte ? ashikhmin_shirley_sample_cosine(v)
        : ashikhmin_shirley_mirror(wo, ashikhmin_shirley_normal(params, v));
    return AshikhminShirleySample{wi, ashikhmin_shirley_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline Vec3 ashikhmin_shirley_albedo(const AshikhminShirley& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    Vec3 w = Vec3{wo.x, wo.y, fmaxf(wo.z, HORIZON)};
    Vec3 total = Vec3{0.0f, 0.0f, 0.0f};
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        Vec2 u = Vec2{(i + 0.5f) / ALBEDO_SAMPLES, fract((i + 0.5f) * GOLDEN)};
        AshikhminShirleySample drawn = ashikhmin_shirley_sample(params, w, u);
        float weight = drawn.pdf > 0.0f ? drawn.wi.z / fmaxf(drawn.pdf, mu_min) : 0.0f;
        total = total + ashikhmin_shirley_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}

}  // namespace gonio_ashikhmin_shirley
