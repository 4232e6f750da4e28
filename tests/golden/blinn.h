// SPDX-License-Identifier: Apache-2.0
// Blinn: a diffuse term and a highlight around the half vector, as early hardware shaded it.
//
// Source: Blinn, "Models of light reflection for computer synthesized pictures", SIGGRAPH 1977: Phong's
// formula with the angle between the normal and the half vector in place of that to the mirror direction.
// The formula gives the radiance f cos(theta_i), which is divided by the cosine here.
//
// C++, made by gonio from gonio/models/blinn.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: gonio_blinn::Blinn params; params.rho = ...; ... gonio_blinn::blinn_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_blinn {

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

// Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
constexpr float LOG1P_SMALL = 0.25f;
constexpr float pi = 3.1415927f;
constexpr float two_pi = 6.2831855f;
constexpr float inv_pi = 0.31830987f;
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
// Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
constexpr float RANDOM_MARGIN = 5.9604645e-8f;
// Steps of the rule in blinn_albedo: a Fibonacci number, and the golden ratio.
constexpr float ALBEDO_SAMPLES = 987.0f;
constexpr float GOLDEN = 0.618034f;
// Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
constexpr float HORIZON = 1.0e-6f;

// A sampled direction and its density.
struct BlinnSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// blinn: The classic Blinn-Phong: diffuse, specular and gloss, without Fresnel or normalisation.
struct Blinn {
    Vec3 rho;  // albedo of the diffuse term, linear RGB; 0 to 1, default (0.5, 0.5, 0.5)
    Vec3 specular;  // weight of the highlight, linear RGB; 0 to 1, default (0.3, 0.3, 0.3)
    float shininess;  // exponent n of the highlight, its gloss; 0 to 100000, default 50
};

// Which of two lobes a sample is taken from.
struct BlinnChoice {
    bool is_first;  // Whether it is the first one
    Vec2 u;  // Fresh random numbers, made of those that chose
};

// Facets of GGX with the same width in all directions.
struct BlinnRoundGGX {
    float alpha;  // width of the slopes
};

// Facets of GGX, also called Trowbridge-Reitz.
struct BlinnGGX {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// ---- evaluation ----------------------------------------------------------------------------

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
inline Vec2 blinn_slopes(Vec3 h) {
    float inv = 1.0f / h.z;
    return Vec2{h.x * inv, h.y * inv};
}

// Squared tangent of that facet's angle.
inline float blinn_tangent2(Vec3 h) {
    Vec2 t = blinn_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
inline float blinn_atanh_over(float y) {
    float y2 = y * y;
    return 1.0f + y2 * (1.0f / 3.0f + y2 * (1.0f / 5.0f + y2 * (1.0f / 7.0f + y2 * (1.0f / 9.0f))));
}

// log(cos) of the angle between the normal and h, which need not be unit.
inline float blinn_log_cos_along(Vec3 h) {
    // log(cos) = -log(1 + tan^2) / 2 = -atanh(y)
    float tan2 = blinn_tangent2(h);
    float y = tan2 / (2.0f + tan2);
    return tan2 < LOG1P_SMALL ? -y * blinn_atanh_over(y) : -0.5f * logf(1.0f + tan2);
}

// (N.m)^exponent of the normal m along h, exact for sharp lobes.
inline float blinn_cos_power(Vec3 h, float exponent) {
    return expf(exponent * blinn_log_cos_along(h));
}

// The highlight without its weight.
inline float blinn_highlight(const Blinn& params, Vec3 wi, Vec3 wo) {
    return blinn_cos_power(wi + wo, params.shininess) / wi.z;
}

// BRDF value in 1/sr, without the cosine.
inline Vec3 blinn_eval(const Blinn& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    return params.rho * inv_pi + params.specular * blinn_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// The width that matches an exponent n: sqrt(2 / (n + 2)).
inline float blinn_blinn_phong_alpha(float exponent) {
    return sqrtf(2.0f / (exponent + 2.0f));
}

// Mean of the three channels, by which lobes are weighed against each other.
inline float blinn_average(Vec3 color) {
    return (color.x + color.y + color.z) / 3.0f;
}

inline float blinn_raised(float probability) {
    return fmaxf(probability, fminf(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
inline Vec2 blinn_lobes_shares(float first, float second) {
    float a = first + BLACK;
    float b = fmaxf(second, WEIGHT_MIN);
    float inv = 1.0f / (a + b);
    float P_first = blinn_raised(a * inv);
    float P_second = blinn_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return Vec2{smaller ? P_first : 1.0f - P_second, smaller ? 1.0f - P_first : P_second};
}

// Probabilities of the diffuse lobe and of the highlight.
inline Vec2 blinn_shares(const Blinn& params, Vec3 wo) {
    // 4 mu_h dw_h of a narrow lobe; half of it lies below the horizon at grazing angles
    float highlight = 4.0f * pi / (params.shininess + 2.0f) * (1.0f + wo.z);
    return blinn_lobes_shares(blinn_average(params.rho),
        blinn_average(params.specular) * highlight);
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
inline BlinnChoice blinn_choose(float probability, Vec2 u) {
    bool first = u.x < probability;
    float below = u.x / fmaxf(probability, SHARE_MIN);
    float above = (u.x - probability) / fmaxf(1.0f - probability, SHARE_MIN);
    return BlinnChoice{first, Vec2{fminf(fmaxf(first ? below : above, 0.0f), RANDOM_MAX), u.y}};
}

// A direction with density cos(theta) / pi.
inline Vec3 blinn_sample_cosine(Vec2 u) {
    float r = sqrtf(fmaxf(u.x, 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), sqrtf(fmaxf(1.0f - u.x, 0.0f))};
}

// w where all facets are those of a unit sphere.
inline Vec3 blinn_ggx_unstretched(BlinnGGX ggx, Vec3 w) {
    return normalize(Vec3{ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z});
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
inline Vec3 blinn_ggx_half_way(BlinnGGX ggx, Vec3 w, float drop, float z, float v) {
    float r = sqrtf(fmaxf(drop * (2.0f - drop), 0.0f));
    float phi = two_pi * v;
    Vec3 h = Vec3{r * cosf(phi) + w.x, r * sinf(phi) + w.y, z};
    return normalize(Vec3{ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z});
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
inline Vec3 blinn_ggx_sample_visible(BlinnGGX ggx, Vec3 wo, Vec2 u) {
    Vec3 w = blinn_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    float u1 = fminf(u.x, 1.0f - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    float height = 1.0f + w.z;
    return blinn_ggx_half_way(ggx, w, u1 * height, (1.0f - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see blinn_ggx_sample_visible.
inline Vec3 blinn_round_ggx_sample_visible(BlinnRoundGGX round_ggx, Vec3 wo, Vec2 u) {
    return blinn_ggx_sample_visible(BlinnGGX{round_ggx.alpha, round_ggx.alpha}, wo, u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
inline Vec3 blinn_mirror(Vec3 wo, Vec3 m) {
    return 2.0f * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
inline Vec3 blinn_sample_ggx_lobe(BlinnRoundGGX facets, Vec3 wo, Vec2 u) {
    Vec3 w = blinn_mirror(wo, blinn_round_ggx_sample_visible(facets, wo, u));
    return Vec3{w.x, w.y, fabsf(w.z)};
}

// A direction of one of the two lobes; shares: the probabilities of the matte one and of the other.
inline Vec3 blinn_sample_matte_gloss(Vec3 wo, float alpha, Vec2 shares, Vec2 u) {
    BlinnChoice choose_result = blinn_choose(shares.x, u);
    bool matte = choose_result.is_first;
    Vec2 v = choose_result.u;
    return matte ? blinn_sample_cosine(v) : blinn_sample_ggx_lobe(BlinnRoundGGX{alpha}, wo, v);
}

// Density of blinn_sample_cosine in 1/sr, for w above the horizon.
inline float blinn_pdf_cosine(Vec3 w) {
    return w.z * inv_pi;
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
inline float blinn_round_ggx_area(BlinnRoundGGX round_ggx, Vec3 w) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrtf(a2 + (1.0f - a2) * (w.z * w.z));
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
inline float blinn_round_ggx_D_along(BlinnRoundGGX round_ggx, Vec3 h) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    float tan2 = blinn_tangent2(h);
    float r = (1.0f + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// Density of blinn_sample_ggx_lobe in 1/sr.
inline float blinn_pdf_ggx_lobe(BlinnRoundGGX facets, Vec3 wi, Vec3 wo) {
    float seen = 0.5f / (wo.z + blinn_round_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    float straight = blinn_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    bool exists = wo.z > wi.z;
    Vec3 across = Vec3{wi.x, wi.y, exists ? wo.z - wi.z : wi.z};
    float folded = blinn_round_ggx_D_along(facets, across
        + Vec3{wo.x, wo.y, exists ? mu_min : wo.z});
    return (straight + (exists ? folded : 0.0f)) * seen;
}

// Density of blinn_sample_matte_gloss in 1/sr.
inline float blinn_pdf_matte_gloss(Vec3 wi, Vec3 wo, float alpha, Vec2 shares) {
    return shares.x * blinn_pdf_cosine(wi)
        + shares.y * blinn_pdf_ggx_lobe(BlinnRoundGGX{alpha}, wi, wo);
}

// Density of blinn_sample in 1/sr.
inline float blinn_pdf(const Blinn& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    return blinn_pdf_matte_gloss(wi, wo, blinn_blinn_phong_alpha(params.shininess),
        blinn_shares(params, wo));
}

// Cosine-weighted, or the GGX lobe of the same width, whose longer tail bounds the weights.
inline BlinnSample blinn_sample(const Blinn& params, Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return BlinnSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    Vec3 wi = blinn_sample_matte_gloss(wo, blinn_blinn_phong_alpha(params.shininess),
        blinn_shares(params, wo), u);
    return BlinnSample{wi, blinn_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline Vec3 blinn_albedo(const Blinn& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    Vec3 w = Vec3{wo.x, wo.y, fmaxf(wo.z, HORIZON)};
    Vec3 total = Vec3{0.0f, 0.0f, 0.0f};
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        Vec2 u = Vec2{(i + 0.5f) / ALBEDO_SAMPLES, fract((i + 0.5f) * GOLDEN)};
        BlinnSample drawn = blinn_sample(params, w, u);
        float weight = drawn.pdf > 0.0f ? drawn.wi.z / fmaxf(drawn.pdf, mu_min) : 0.0f;
        total = total + blinn_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}

}  // namespace gonio_blinn
