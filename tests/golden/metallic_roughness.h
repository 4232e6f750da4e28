// SPDX-License-Identifier: Apache-2.0
// Metallic-roughness: one colour, a metalness and a roughness, the way games describe materials.
//
// Source: "PBR theory, part 1: foundations" (SZ's temple, 2019), section 4, after Burley 2012: Lambert with
// k_d = 1 - F and c_d = base_color (1 - metallic), Cook-Torrance with GGX, Smith and Schlick, F0 between
// 0.04 and the base colour. The text leaves Smith's form open: both are here.
// Deviation: alpha = roughness^2 is at least ALPHA_MIN, where the highlight still is a function.
//
// C++, made by gonio from gonio/models/metallic_roughness.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: gonio_metallic_roughness::MetallicRoughness params; params.base_color = ...; ... gonio_metallic_roughness::metallic_roughness_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_metallic_roughness {

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

constexpr float F0_DIELECTRIC = 0.04f;  // Reflectance of every dielectric at normal incidence.
// Sharpest facets: a float32 direction is good to 6e-8, a thousandth of this width, so the shape of the
// highlight is still resolved. The peak of D, 3e7, and its derivatives fit into a float32.
constexpr float ALPHA_MIN = 1.0e-4f;
// Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
constexpr float RANDOM_MARGIN = 5.9604645e-8f;
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
// Steps of the rule in metallic_roughness_albedo: a Fibonacci number, and the golden ratio.
constexpr float ALBEDO_SAMPLES = 987.0f;
constexpr float GOLDEN = 0.618034f;
// Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
constexpr float HORIZON = 1.0e-6f;

// A sampled direction and its density.
struct MetallicRoughnessSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// metallic_roughness: Diffuse below a GGX highlight, which takes its share of the light facet by facet.
// Reciprocal. Exported with masking='smith_correlated'.
struct MetallicRoughness {
    // diffuse colour, or F0 of metals, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    Vec3 base_color;
    float metallic;  // 0 for dielectrics, 1 for metals; 0 to 1, default 0
    float roughness;  // perceptual roughness, alpha = roughness^2; 0 to 1, default 0.5
};

// Facets of GGX with the same width in all directions.
struct MetallicRoughnessRoundGGX {
    float alpha;  // width of the slopes
};

// Which of two lobes a sample is taken from.
struct MetallicRoughnessChoice {
    bool is_first;  // Whether it is the first one
    Vec2 u;  // Fresh random numbers, made of those that chose
};

// Facets of GGX, also called Trowbridge-Reitz.
struct MetallicRoughnessGGX {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// ---- evaluation ----------------------------------------------------------------------------

inline Vec3 metallic_roughness_f0(const MetallicRoughness& params) {
    return lerp(splat(F0_DIELECTRIC), params.base_color, splat(params.metallic));
}

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
inline float metallic_roughness_length2(Vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
inline float metallic_roughness_cos_half(Vec3 wi, Vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5f * sqrtf(metallic_roughness_length2(wi + wo));
}

// 1 - metallic_roughness_cos_half^2, the squared sine at which light meets the facet: of half the length of
// wi - wo.
inline float metallic_roughness_sin2_half(Vec3 wi, Vec3 wo) {
    Vec3 apart = wi - wo;
    return 0.25f * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
inline float metallic_roughness_weight(float cos_h, float sin2_h) {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    float k = sin2_h / (1.0f + cos_h);
    float k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
inline float metallic_roughness_schlick_weight_half(Vec3 wi, Vec3 wo) {
    return metallic_roughness_weight(metallic_roughness_cos_half(wi, wo),
        metallic_roughness_sin2_half(wi, wo));
}

// 1 - (1 - c)^5, with the factor c taken out so that it keeps its digits as c goes to 0.
inline float metallic_roughness_schlick_complement(float c) {
    float k = 1.0f - c;
    float k2 = k * k;
    return c * ((1.0f + k) * (1.0f + k2) + k2 * k2);
}

inline float metallic_roughness_alpha(const MetallicRoughness& params) {
    return fmaxf(params.roughness * params.roughness, ALPHA_MIN);
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
inline Vec2 metallic_roughness_slopes(Vec3 h) {
    float inv = 1.0f / h.z;
    return Vec2{h.x * inv, h.y * inv};
}

// Squared tangent of that facet's angle.
inline float metallic_roughness_tangent2(Vec3 h) {
    Vec2 t = metallic_roughness_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
inline float metallic_roughness_round_ggx_D_along(MetallicRoughnessRoundGGX round_ggx, Vec3 h) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    float tan2 = metallic_roughness_tangent2(h);
    float r = (1.0f + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
inline float metallic_roughness_round_ggx_area(MetallicRoughnessRoundGGX round_ggx, Vec3 w) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrtf(a2 + (1.0f - a2) * (w.z * w.z));
}

// G = 1 / (1 + Lambda_i + Lambda_o): correlated by the facet's height. Heitz 2014, Eq. 99.
inline float metallic_roughness_V_smith_correlated(MetallicRoughnessRoundGGX facets, Vec3 wi,
    Vec3 wo) {
    return 0.5f / (wo.z * metallic_roughness_round_ggx_area(facets, wi)
        + wi.z * metallic_roughness_round_ggx_area(facets, wo));
}

// D G / (4 mu_i mu_o): the highlight without F.
inline float metallic_roughness_highlight(const MetallicRoughness& params, Vec3 wi, Vec3 wo) {
    MetallicRoughnessRoundGGX facets = MetallicRoughnessRoundGGX{metallic_roughness_alpha(params)};
    float D = metallic_roughness_round_ggx_D_along(facets, wi + wo);
    return D * metallic_roughness_V_smith_correlated(facets, wi, wo);
}

// BRDF value in 1/sr, without the cosine.
inline Vec3 metallic_roughness_eval(const MetallicRoughness& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    Vec3 f0 = metallic_roughness_f0(params);
    Vec3 F = lerp(f0, splat(1.0f), splat(metallic_roughness_schlick_weight_half(wi, wo)));
    // 1 - F without its cancellation
    Vec3 k_d = (1.0f - f0)
        * metallic_roughness_schlick_complement(metallic_roughness_cos_half(wi, wo));
    Vec3 diffuse = inv_pi * (1.0f - params.metallic) * params.base_color * k_d;
    return diffuse + F * metallic_roughness_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// Mean of the three channels, by which lobes are weighed against each other.
inline float metallic_roughness_average(Vec3 color) {
    return (color.x + color.y + color.z) / 3.0f;
}

// (1 - cos_theta)^5 of Schlick's approximation.
inline float metallic_roughness_schlick_weight(float cos_theta) {
    float k = 1.0f - cos_theta;
    float k2 = k * k;
    return k2 * k2 * k;
}

inline float metallic_roughness_raised(float probability) {
    return fmaxf(probability, fminf(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
inline Vec2 metallic_roughness_lobes_shares(float first, float second) {
    float a = first + BLACK;
    float b = fmaxf(second, WEIGHT_MIN);
    float inv = 1.0f / (a + b);
    float P_first = metallic_roughness_raised(a * inv);
    float P_second = metallic_roughness_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return Vec2{smaller ? P_first : 1.0f - P_second, smaller ? 1.0f - P_first : P_second};
}

// Probabilities of the diffuse lobe and of the highlight.
inline Vec2 metallic_roughness_shares(const MetallicRoughness& params, Vec3 wo) {
    Vec3 f0 = metallic_roughness_f0(params);
    Vec3 diffuse = (1.0f - params.metallic) * params.base_color * (1.0f - f0);
    return metallic_roughness_lobes_shares(metallic_roughness_average(diffuse),
        metallic_roughness_average(lerp(f0, splat(1.0f),
            splat(metallic_roughness_schlick_weight(wo.z)))));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
inline MetallicRoughnessChoice metallic_roughness_choose(float probability, Vec2 u) {
    bool first = u.x < probability;
    float below = u.x / fmaxf(probability, SHARE_MIN);
    float above = (u.x - probability) / fmaxf(1.0f - probability, SHARE_MIN);
    return MetallicRoughnessChoice{first,
        Vec2{fminf(fmaxf(first ? below : above, 0.0f), RANDOM_MAX), u.y}};
}

// A direction with density cos(theta) / pi.
inline Vec3 metallic_roughness_sample_cosine(Vec2 u) {
    float r = sqrtf(fmaxf(u.x, 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), sqrtf(fmaxf(1.0f - u.x, 0.0f))};
}

// w where all facets are those of a unit sphere.
inline Vec3 metallic_roughness_ggx_unstretched(MetallicRoughnessGGX ggx, Vec3 w) {
    return normalize(Vec3{ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z});
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
inline Vec3 metallic_roughness_ggx_half_way(MetallicRoughnessGGX ggx, Vec3 w, float drop,
    float z, float v) {
    float r = sqrtf(fmaxf(drop * (2.0f - drop), 0.0f));
    float phi = two_pi * v;
    Vec3 h = Vec3{r * cosf(phi) + w.x, r * sinf(phi) + w.y, z};
    return normalize(Vec3{ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z});
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
inline Vec3 metallic_roughness_ggx_sample_visible(MetallicRoughnessGGX ggx, Vec3 wo, Vec2 u) {
    Vec3 w = metallic_roughness_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    float u1 = fminf(u.x, 1.0f - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    float height = 1.0f + w.z;
    return metallic_roughness_ggx_half_way(ggx, w, u1 * height, (1.0f - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see metallic_roughness_ggx_sample_visible.
inline Vec3 metallic_roughness_round_ggx_sample_visible(MetallicRoughnessRoundGGX round_ggx,
    Vec3 wo, Vec2 u) {
    return metallic_roughness_ggx_sample_visible(MetallicRoughnessGGX{round_ggx.alpha,
        round_ggx.alpha}, wo, u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
inline Vec3 metallic_roughness_mirror(Vec3 wo, Vec3 m) {
    return 2.0f * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
inline Vec3 metallic_roughness_sample_ggx_lobe(MetallicRoughnessRoundGGX facets, Vec3 wo,
    Vec2 u) {
    Vec3 w = metallic_roughness_mirror(wo,
        metallic_roughness_round_ggx_sample_visible(facets, wo, u));
    return Vec3{w.x, w.y, fabsf(w.z)};
}

// A direction of one of the two lobes; shares: the probabilities of the matte one and of the other.
inline Vec3 metallic_roughness_sample_matte_gloss(Vec3 wo, float alpha, Vec2 shares, Vec2 u) {
    MetallicRoughnessChoice choose_result = metallic_roughness_choose(shares.x, u);
    bool matte = choose_result.is_first;
    Vec2 v = choose_result.u;
    return matte ? metallic_roughness_sample_cosine(v)
        : metallic_roughness_sample_ggx_lobe(MetallicRoughnessRoundGGX{alpha}, wo, v);
}

// Density of metallic_roughness_sample_cosine in 1/sr, for w above the horizon.
inline float metallic_roughness_pdf_cosine(Vec3 w) {
    return w.z * inv_pi;
}

// Density of metallic_roughness_sample_ggx_lobe in 1/sr.
inline float metallic_roughness_pdf_ggx_lobe(MetallicRoughnessRoundGGX facets, Vec3 wi,
    Vec3 wo) {
    // Smith's G1 over 4 mu_o
    float seen = 0.5f / (wo.z + metallic_roughness_round_ggx_area(facets, wo));
    float straight = metallic_roughness_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    bool exists = wo.z > wi.z;
    Vec3 across = Vec3{wi.x, wi.y, exists ? wo.z - wi.z : wi.z};
    float folded = metallic_roughness_round_ggx_D_along(facets, across
        + Vec3{wo.x, wo.y, exists ? mu_min : wo.z});
    return (straight + (exists ? folded : 0.0f)) * seen;
}

// Density of metallic_roughness_sample_matte_gloss in 1/sr.
inline float metallic_roughness_pdf_matte_gloss(Vec3 wi, Vec3 wo, float alpha, Vec2 shares) {
    return shares.x * metallic_roughness_pdf_cosine(wi)
        + shares.y * metallic_roughness_pdf_ggx_lobe(MetallicRoughnessRoundGGX{alpha}, wi, wo);
}

// Density of metallic_roughness_sample in 1/sr.
inline float metallic_roughness_pdf(const MetallicRoughness& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    return metallic_roughness_pdf_matte_gloss(wi, wo, metallic_roughness_alpha(params),
        metallic_roughness_shares(params, wo));
}

// Cosine-weighted or a visible GGX normal, by the estimated albedos.
inline MetallicRoughnessSample metallic_roughness_sample(const MetallicRoughness& params,
    Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return MetallicRoughnessSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    Vec3 wi = metallic_roughness_sample_matte_gloss(wo, metallic_roughness_alpha(params),
        metallic_roughness_shares(params, wo), u);
    return MetallicRoughnessSample{wi, metallic_roughness_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline Vec3 metallic_roughness_albedo(const MetallicRoughness& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    Vec3 w = Vec3{wo.x, wo.y, fmaxf(wo.z, HORIZON)};
    Vec3 total = Vec3{0.0f, 0.0f, 0.0f};
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        Vec2 u = Vec2{(i + 0.5f) / ALBEDO_SAMPLES, fract((i + 0.5f) * GOLDEN)};
        MetallicRoughnessSample drawn = metallic_roughness_sample(params, w, u);
        float weight = drawn.pdf > 0.0f ? drawn.wi.z / fmaxf(drawn.pdf, mu_min) : 0.0f;
        total = total + metallic_roughness_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}

}  // namespace gonio_metallic_roughness
