// SPDX-License-Identifier: Apache-2.0
// Unity Standard: BRDF1, the full-quality shading of Unity's built-in render pipeline.
//
// Source: "PBR theory, part 1: foundations" (SZ's temple, 2019), section 5, which walks through
// UnityStandardBRDF.cginc of Unity 2018.2. Unity's own value is pi times f: its diffuse term is not divided
// by pi and its highlight is multiplied by it. The article misses a division by 4 mu_i mu_o, but Unity's V
// holds it already.
// Where it departs from physics: k_d is the constant 0.96 (1 - metallic) in place of 1 - F, so that the
// diffuse term takes no notice of the Fresnel reflection above it; V replaces sqrt(mu^2 + alpha^2 sin^2) of
// Smith by mu (1 - alpha) + alpha.
// Deviation: Unity adds 1e-5 to V's and 1e-7 to D's denominator, against division by zero; neither is here.
// The second dims its highlights: the peak by 4 % at roughness 0.2, 28 % at 0.15 and 91 % at 0.1.
//
// C++, made by gonio from gonio/models/unity_standard.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: gonio_unity_standard::UnityStandard params; params.base_color = ...; ... gonio_unity_standard::unity_standard_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_unity_standard {

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

constexpr float F0_DIELECTRIC = 0.04f;  // reflectance of dielectrics (linear colour space)
constexpr float ALPHA_UNITY = 0.002f;  // lower limit of alpha
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
// Steps of the rule in unity_standard_albedo: a Fibonacci number, and the golden ratio.
constexpr float ALBEDO_SAMPLES = 987.0f;
constexpr float GOLDEN = 0.618034f;
// Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
constexpr float HORIZON = 1.0e-6f;

// A sampled direction and its density.
struct UnityStandardSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// unity_standard: Burley diffuse plus a GGX highlight with a cheaper Smith term. Reciprocal; gains energy.
struct UnityStandard {
    // diffuse colour, or F0 of metals, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    Vec3 base_color;
    float metallic;  // 0 for dielectrics, 1 for metals; 0 to 1, default 0
    float roughness;  // perceptual roughness, 1 - Unity's smoothness; 0 to 1, default 0.5
};

// Facets of GGX with the same width in all directions.
struct UnityStandardRoundGGX {
    float alpha;  // width of the slopes
};

// Which of two lobes a sample is taken from.
struct UnityStandardChoice {
    bool is_first;  // Whether it is the first one
    Vec2 u;  // Fresh random numbers, made of those that chose
};

// Facets of GGX, also called Trowbridge-Reitz.
struct UnityStandardGGX {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// ---- evaluation ----------------------------------------------------------------------------

// (1 - cos_theta)^5 of Schlick's approximation.
inline float unity_standard_schlick_weight(float cos_theta) {
    float k = 1.0f - cos_theta;
    float k2 = k * k;
    return k2 * k2 * k;
}

inline Vec3 unity_standard_f0(const UnityStandard& params) {
    return lerp(splat(F0_DIELECTRIC), params.base_color, splat(params.metallic));
}

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
inline float unity_standard_length2(Vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
inline float unity_standard_cos_half(Vec3 wi, Vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5f * sqrtf(unity_standard_length2(wi + wo));
}

// 1 - unity_standard_cos_half^2, the squared sine at which light meets the facet: of half the length of wi
// - wo.
inline float unity_standard_sin2_half(Vec3 wi, Vec3 wo) {
    Vec3 apart = wi - wo;
    return 0.25f * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
inline float unity_standard_weight(float cos_h, float sin2_h) {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    float k = sin2_h / (1.0f + cos_h);
    float k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
inline float unity_standard_schlick_weight_half(Vec3 wi, Vec3 wo) {
    return unity_standard_weight(unity_standard_cos_half(wi, wo), unity_standard_sin2_half(wi, wo));
}

inline Vec3 unity_standard_diffuse(const UnityStandard& params) {
    return (1.0f - F0_DIELECTRIC) * (1.0f - params.metallic) * params.base_color;
}

inline float unity_standard_alpha(const UnityStandard& params) {
    return fmaxf(params.roughness * params.roughness, ALPHA_UNITY);
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
inline Vec2 unity_standard_slopes(Vec3 h) {
    float inv = 1.0f / h.z;
    return Vec2{h.x * inv, h.y * inv};
}

// Squared tangent of that facet's angle.
inline float unity_standard_tangent2(Vec3 h) {
    Vec2 t = unity_standard_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
inline float unity_standard_round_ggx_D_along(UnityStandardRoundGGX round_ggx, Vec3 h) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    float tan2 = unity_standard_tangent2(h);
    float r = (1.0f + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// D V: the highlight without F.
inline float unity_standard_highlight(const UnityStandard& params, Vec3 wi, Vec3 wo) {
    float alpha = unity_standard_alpha(params);
    float lambda_v = wi.z * lerp(alpha, 1.0f, wo.z);
    float lambda_l = wo.z * lerp(alpha, 1.0f, wi.z);
    float D = unity_standard_round_ggx_D_along(UnityStandardRoundGGX{alpha}, wi + wo);
    return D * (0.5f / (lambda_v + lambda_l));
}

// BRDF value in 1/sr, without the cosine.
inline Vec3 unity_standard_eval(const UnityStandard& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    float r = params.roughness;
    // F90 = 0.5 + 2 roughness cos^2(theta_d), and 2 cos^2(theta_d) = 1 + dot(wi, wo)
    float rise = r * (1.0f + dot(wi, wo)) - 0.5f;
    float burley = (1.0f + rise * unity_standard_schlick_weight(wi.z))
        * (1.0f + rise * unity_standard_schlick_weight(wo.z));
    Vec3 F = lerp(unity_standard_f0(params), splat(1.0f),
        splat(unity_standard_schlick_weight_half(wi, wo)));
    return inv_pi * burley * unity_standard_diffuse(params)
        + F * unity_standard_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// Mean of the three channels, by which lobes are weighed against each other.
inline float unity_standard_average(Vec3 color) {
    return (color.x + color.y + color.z) / 3.0f;
}

inline float unity_standard_raised(float probability) {
    return fmaxf(probability, fminf(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
inline Vec2 unity_standard_lobes_shares(float first, float second) {
    float a = first + BLACK;
    float b = fmaxf(second, WEIGHT_MIN);
    float inv = 1.0f / (a + b);
    float P_first = unity_standard_raised(a * inv);
    float P_second = unity_standard_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return Vec2{smaller ? P_first : 1.0f - P_second, smaller ? 1.0f - P_first : P_second};
}

// Probabilities of the diffuse lobe and of the highlight.
inline Vec2 unity_standard_shares(const UnityStandard& params, Vec3 wo) {
    Vec3 F = lerp(unity_standard_f0(params), splat(1.0f),
        splat(unity_standard_schlick_weight(wo.z)));
    return unity_standard_lobes_shares(unity_standard_average(unity_standard_diffuse(params)),
        unity_standard_average(F));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
inline UnityStandardChoice unity_standard_choose(float probability, Vec2 u) {
    bool first = u.x < probability;
    float below = u.x / fmaxf(probability, SHARE_MIN);
    float above = (u.x - probability) / fmaxf(1.0f - probability, SHARE_MIN);
    return UnityStandardChoice{first,
        Vec2{fminf(fmaxf(first ? below : above, 0.0f), RANDOM_MAX), u.y}};
}

// A direction with density cos(theta) / pi.
inline Vec3 unity_standard_sample_cosine(Vec2 u) {
    float r = sqrtf(fmaxf(u.x, 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), sqrtf(fmaxf(1.0f - u.x, 0.0f))};
}

// w where all facets are those of a unit sphere.
inline Vec3 unity_standard_ggx_unstretched(UnityStandardGGX ggx, Vec3 w) {
    return normalize(Vec3{ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z});
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
inline Vec3 unity_standard_ggx_half_way(UnityStandardGGX ggx, Vec3 w, float drop, float z,
    float v) {
    float r = sqrtf(fmaxf(drop * (2.0f - drop), 0.0f));
    float phi = two_pi * v;
    Vec3 h = Vec3{r * cosf(phi) + w.x, r * sinf(phi) + w.y, z};
    return normalize(Vec3{ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z});
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
inline Vec3 unity_standard_ggx_sample_visible(UnityStandardGGX ggx, Vec3 wo, Vec2 u) {
    Vec3 w = unity_standard_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    float u1 = fminf(u.x, 1.0f - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    float height = 1.0f + w.z;
    return unity_standard_ggx_half_way(ggx, w, u1 * height, (1.0f - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see unity_standard_ggx_sample_visible.
inline Vec3 unity_standard_round_ggx_sample_visible(UnityStandardRoundGGX round_ggx, Vec3 wo,
    Vec2 u) {
    return unity_standard_ggx_sample_visible(UnityStandardGGX{round_ggx.alpha, round_ggx.alpha}, wo,
        u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
inline Vec3 unity_standard_mirror(Vec3 wo, Vec3 m) {
    return 2.0f * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
inline Vec3 unity_standard_sample_ggx_lobe(UnityStandardRoundGGX facets, Vec3 wo, Vec2 u) {
    Vec3 w = unity_standard_mirror(wo, unity_standard_round_ggx_sample_visible(facets, wo, u));
    return Vec3{w.x, w.y, fabsf(w.z)};
}

// A direction of one of the two lobes; shares: the probabilities of the matte one and of the other.
inline Vec3 unity_standard_sample_matte_gloss(Vec3 wo, float alpha, Vec2 shares, Vec2 u) {
    UnityStandardChoice choose_result = unity_standard_choose(shares.x, u);
    bool matte = choose_result.is_first;
    Vec2 v = choose_result.u;
    return matte ? unity_standard_sample_cosine(v)
        : unity_standard_sample_ggx_lobe(UnityStandardRoundGGX{alpha}, wo, v);
}

// Density of unity_standard_sample_cosine in 1/sr, for w above the horizon.
inline float unity_standard_pdf_cosine(Vec3 w) {
    return w.z * inv_pi;
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
inline float unity_standard_round_ggx_area(UnityStandardRoundGGX round_ggx, Vec3 w) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrtf(a2 + (1.0f - a2) * (w.z * w.z));
}

// Density of unity_standard_sample_ggx_lobe in 1/sr.
inline float unity_standard_pdf_ggx_lobe(UnityStandardRoundGGX facets, Vec3 wi, Vec3 wo) {
    // Smith's G1 over 4 mu_o
    float seen = 0.5f / (wo.z + unity_standard_round_ggx_area(facets, wo));
    float straight = unity_standard_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    bool exists = wo.z > wi.z;
    Vec3 across = Vec3{wi.x, wi.y, exists ? wo.z - wi.z : wi.z};
    float folded = unity_standard_round_ggx_D_along(facets, across
        + Vec3{wo.x, wo.y, exists ? mu_min : wo.z});
    return (straight + (exists ? folded : 0.0f)) * seen;
}

// Density of unity_standard_sample_matte_gloss in 1/sr.
inline float unity_standard_pdf_matte_gloss(Vec3 wi, Vec3 wo, float alpha, Vec2 shares) {
    return shares.x * unity_standard_pdf_cosine(wi)
        + shares.y * unity_standard_pdf_ggx_lobe(UnityStandardRoundGGX{alpha}, wi, wo);
}

// Density of unity_standard_sample in 1/sr.
inline float unity_standard_pdf(const UnityStandard& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    return unity_standard_pdf_matte_gloss(wi, wo, unity_standard_alpha(params),
        unity_standard_shares(params, wo));
}

// Cosine-weighted or a visible GGX normal, by the estimated albedos.
inline UnityStandardSample unity_standard_sample(const UnityStandard& params, Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return UnityStandardSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    Vec3 wi = unity_standard_sample_matte_gloss(wo, unity_standard_alpha(params),
        unity_standard_shares(params, wo), u);
    return UnityStandardSample{wi, unity_standard_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline Vec3 unity_standard_albedo(const UnityStandard& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    Vec3 w = Vec3{wo.x, wo.y, fmaxf(wo.z, HORIZON)};
    Vec3 total = Vec3{0.0f, 0.0f, 0.0f};
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        Vec2 u = Vec2{(i + 0.5f) / ALBEDO_SAMPLES, fract((i + 0.5f) * GOLDEN)};
        UnityStandardSample drawn = unity_standard_sample(params, w, u);
        float weight = drawn.pdf > 0.0f ? drawn.wi.z / fmaxf(drawn.pdf, mu_min) : 0.0f;
        total = total + unity_standard_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}

}  // namespace gonio_unity_standard
