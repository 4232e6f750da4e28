// SPDX-License-Identifier: Apache-2.0
// UE4: the shading model of Unreal Engine 4 as it was published.
//
// Source: Karis, "Real shading in Unreal Engine 4", SIGGRAPH 2013 course "Physically based shading in
// theory and practice": Lambert, GGX with alpha = roughness^2, Schlick's masking with
// k = (roughness + 1)^2 / 8 for punctual lights and k = alpha / 2 for image-based light, F0 = 0.08 specular
// for dielectrics.
// Deviations: the Fresnel term is Schlick's power, which the engine replaces by
// 2^((-5.55473 (wo.H) - 6.98316) (wo.H)), at most 0.0038 from it; alpha is at least ALPHA_MIN.
//
// C++, made by gonio from gonio/models/ue4.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: gonio_ue4::Ue4 params; params.base_color = ...; ... gonio_ue4::ue4_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_ue4 {

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

// F0 of a dielectric with specular = 1; the default of 0.5 gives 0.04.
constexpr float F0_SPECULAR = 0.08f;
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
// Steps of the rule in ue4_albedo: a Fibonacci number, and the golden ratio.
constexpr float ALBEDO_SAMPLES = 987.0f;
constexpr float GOLDEN = 0.618034f;
// Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
constexpr float HORIZON = 1.0e-6f;

// A sampled direction and its density.
struct Ue4Sample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// ue4: Lambert plus a GGX highlight, simply added. Reciprocal; white dielectrics gain energy. Exported
// with light='punctual'.
struct Ue4 {
    // diffuse colour, or F0 of metals, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    Vec3 base_color;
    float metallic;  // 0 for dielectrics, 1 for metals; 0 to 1, default 0
    float specular;  // F0 of dielectrics in units of 0.08; 0 to 1, default 0.5
    float roughness;  // perceptual roughness, alpha = roughness^2; 0 to 1, default 0.5
};

// Facets of GGX with the same width in all directions.
struct Ue4RoundGGX {
    float alpha;  // width of the slopes
};

// Which of two lobes a sample is taken from.
struct Ue4Choice {
    bool is_first;  // Whether it is the first one
    Vec2 u;  // Fresh random numbers, made of those that chose
};

// Facets of GGX, also called Trowbridge-Reitz.
struct Ue4GGX {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// ---- evaluation ----------------------------------------------------------------------------

inline Vec3 ue4_f0(const Ue4& params) {
    return lerp(splat(F0_SPECULAR * params.specular), params.base_color, splat(params.metallic));
}

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
inline float ue4_length2(Vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
inline float ue4_cos_half(Vec3 wi, Vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5f * sqrtf(ue4_length2(wi + wo));
}

// 1 - ue4_cos_half^2, the squared sine at which light meets the facet: of half the length of wi - wo.
inline float ue4_sin2_half(Vec3 wi, Vec3 wo) {
    Vec3 apart = wi - wo;
    return 0.25f * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
inline float ue4_weight(float cos_h, float sin2_h) {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    float k = sin2_h / (1.0f + cos_h);
    float k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
inline float ue4_schlick_weight_half(Vec3 wi, Vec3 wo) {
    return ue4_weight(ue4_cos_half(wi, wo), ue4_sin2_half(wi, wo));
}

inline float ue4_alpha(const Ue4& params) {
    return fmaxf(params.roughness * params.roughness, ALPHA_MIN);
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
inline Vec2 ue4_slopes(Vec3 h) {
    float inv = 1.0f / h.z;
    return Vec2{h.x * inv, h.y * inv};
}

// Squared tangent of that facet's angle.
inline float ue4_tangent2(Vec3 h) {
    Vec2 t = ue4_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
inline float ue4_round_ggx_D_along(Ue4RoundGGX round_ggx, Vec3 h) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    float tan2 = ue4_tangent2(h);
    float r = (1.0f + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// k = (r + 1)^2 / 8 of Unreal Engine 4's punctual lights; r is the perceptual roughness.
inline float ue4_schlick_k_ue4(float roughness) {
    float r = roughness + 1.0f;
    return r * r / 8.0f;
}

// G = G1_schlick(mu_i) G1_schlick(mu_o).
inline float ue4_V_schlick(Vec3 wi, Vec3 wo, float k) {
    return 0.25f / ((wi.z * (1.0f - k) + k) * (wo.z * (1.0f - k) + k));
}

// D G / (4 mu_i mu_o): the highlight without F.
inline float ue4_highlight(const Ue4& params, Vec3 wi, Vec3 wo) {
    float D = ue4_round_ggx_D_along(Ue4RoundGGX{ue4_alpha(params)}, wi + wo);
    return D * ue4_V_schlick(wi, wo, ue4_schlick_k_ue4(params.roughness));
}

// BRDF value in 1/sr, without the cosine.
inline Vec3 ue4_eval(const Ue4& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    Vec3 F = lerp(ue4_f0(params), splat(1.0f), splat(ue4_schlick_weight_half(wi, wo)));
    Vec3 diffuse = inv_pi * (1.0f - params.metallic) * params.base_color;
    return diffuse + F * ue4_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// (1 - cos_theta)^5 of Schlick's approximation.
inline float ue4_schlick_weight(float cos_theta) {
    float k = 1.0f - cos_theta;
    float k2 = k * k;
    return k2 * k2 * k;
}

// Mean of the three channels, by which lobes are weighed against each other.
inline float ue4_average(Vec3 color) {
    return (color.x + color.y + color.z) / 3.0f;
}

inline float ue4_raised(float probability) {
    return fmaxf(probability, fminf(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
inline Vec2 ue4_lobes_shares(float first, float second) {
    float a = first + BLACK;
    float b = fmaxf(second, WEIGHT_MIN);
    float inv = 1.0f / (a + b);
    float P_first = ue4_raised(a * inv);
    float P_second = ue4_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return Vec2{smaller ? P_first : 1.0f - P_second, smaller ? 1.0f - P_first : P_second};
}

// Probabilities of the diffuse lobe and of the highlight.
inline Vec2 ue4_shares(const Ue4& params, Vec3 wo) {
    Vec3 F = lerp(ue4_f0(params), splat(1.0f), splat(ue4_schlick_weight(wo.z)));
    return ue4_lobes_shares(ue4_average((1.0f - params.metallic) * params.base_color),
        ue4_average(F));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
inline Ue4Choice ue4_choose(float probability, Vec2 u) {
    bool first = u.x < probability;
    float below = u.x / fmaxf(probability, SHARE_MIN);
    float above = (u.x - probability) / fmaxf(1.0f - probability, SHARE_MIN);
    return Ue4Choice{first, Vec2{fminf(fmaxf(first ? below : above, 0.0f), RANDOM_MAX), u.y}};
}

// A direction with density cos(theta) / pi.
inline Vec3 ue4_sample_cosine(Vec2 u) {
    float r = sqrtf(fmaxf(u.x, 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), sqrtf(fmaxf(1.0f - u.x, 0.0f))};
}

// w where all facets are those of a unit sphere.
inline Vec3 ue4_ggx_unstretched(Ue4GGX ggx, Vec3 w) {
    return normalize(Vec3{ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z});
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
inline Vec3 ue4_ggx_half_way(Ue4GGX ggx, Vec3 w, float drop, float z, float v) {
    float r = sqrtf(fmaxf(drop * (2.0f - drop), 0.0f));
    float phi = two_pi * v;
    Vec3 h = Vec3{r * cosf(phi) + w.x, r * sinf(phi) + w.y, z};
    return normalize(Vec3{ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z});
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
inline Vec3 ue4_ggx_sample_visible(Ue4GGX ggx, Vec3 wo, Vec2 u) {
    Vec3 w = ue4_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    float u1 = fminf(u.x, 1.0f - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    float height = 1.0f + w.z;
    return ue4_ggx_half_way(ggx, w, u1 * height, (1.0f - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see ue4_ggx_sample_visible.
inline Vec3 ue4_round_ggx_sample_visible(Ue4RoundGGX round_ggx, Vec3 wo, Vec2 u) {
    return ue4_ggx_sample_visible(Ue4GGX{round_ggx.alpha, round_ggx.alpha}, wo, u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
inline Vec3 ue4_mirror(Vec3 wo, Vec3 m) {
    return 2.0f * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
inline Vec3 ue4_sample_ggx_lobe(Ue4RoundGGX facets, Vec3 wo, Vec2 u) {
    Vec3 w = ue4_mirror(wo, ue4_round_ggx_sample_visible(facets, wo, u));
    return Vec3{w.x, w.y, fabsf(w.z)};
}

// A direction of one of the two lobes; shares: the probabilities of the matte one and of the other.
inline Vec3 ue4_sample_matte_gloss(Vec3 wo, float alpha, Vec2 shares, Vec2 u) {
    Ue4Choice choose_result = ue4_choose(shares.x, u);
    bool matte = choose_result.is_first;
    Vec2 v = choose_result.u;
    return matte ? ue4_sample_cosine(v) : ue4_sample_ggx_lobe(Ue4RoundGGX{alpha}, wo, v);
}

// Density of ue4_sample_cosine in 1/sr, for w above the horizon.
inline float ue4_pdf_cosine(Vec3 w) {
    return w.z * inv_pi;
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
inline float ue4_round_ggx_area(Ue4RoundGGX round_ggx, Vec3 w) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrtf(a2 + (1.0f - a2) * (w.z * w.z));
}

// Density of ue4_sample_ggx_lobe in 1/sr.
inline float ue4_pdf_ggx_lobe(Ue4RoundGGX facets, Vec3 wi, Vec3 wo) {
    float seen = 0.5f / (wo.z + ue4_round_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    float straight = ue4_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    bool exists = wo.z > wi.z;
    Vec3 across = Vec3{wi.x, wi.y, exists ? wo.z - wi.z : wi.z};
    float folded = ue4_round_ggx_D_along(facets, across + Vec3{wo.x, wo.y, exists ? mu_min : wo.z});
    return (straight + (exists ? folded : 0.0f)) * seen;
}

// Density of ue4_sample_matte_gloss in 1/sr.
inline float ue4_pdf_matte_gloss(Vec3 wi, Vec3 wo, float alpha, Vec2 shares) {
    return shares.x * ue4_pdf_cosine(wi) + shares.y * ue4_pdf_ggx_lobe(Ue4RoundGGX{alpha}, wi, wo);
}

// Density of ue4_sample in 1/sr.
inline float ue4_pdf(const Ue4& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    return ue4_pdf_matte_gloss(wi, wo, ue4_alpha(params), ue4_shares(params, wo));
}

// Cosine-weighted or a visible GGX normal, by the estimated albedos.
inline Ue4Sample ue4_sample(const Ue4& params, Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return Ue4Sample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    Vec3 wi = ue4_sample_matte_gloss(wo, ue4_alpha(params), ue4_shares(params, wo), u);
    return Ue4Sample{wi, ue4_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline Vec3 ue4_albedo(const Ue4& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    Vec3 w = Vec3{wo.x, wo.y, fmaxf(wo.z, HORIZON)};
    Vec3 total = Vec3{0.0f, 0.0f, 0.0f};
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        Vec2 u = Vec2{(i + 0.5f) / ALBEDO_SAMPLES, fract((i + 0.5f) * GOLDEN)};
        Ue4Sample drawn = ue4_sample(params, w, u);
        float weight = drawn.pdf > 0.0f ? drawn.wi.z / fmaxf(drawn.pdf, mu_min) : 0.0f;
        total = total + ue4_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}

}  // namespace gonio_ue4
