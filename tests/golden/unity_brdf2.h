// SPDX-License-Identifier: Apache-2.0
// Unity BRDF2: the cheaper shading that Unity's built-in render pipeline takes on mobile devices.
//
// Source: UnityStandardBRDF.cginc of Unity 2018.2, which "PBR theory, part 1: foundations" (SZ's temple,
// 2019), section 5, names beside BRDF1; the highlight is the one of "Optimizing PBR for mobile", SIGGRAPH
// 2015 course: masking and Fresnel together are 1 / ((wo.H)^2 (alpha + 0.5)). Unity's own value is pi times
// f. Where it departs from physics: the highlight has the colour F0 at every angle, and nothing masks
// grazing directions. Unity's constants are kept: at roughness 0 there is no highlight at all.
// BRDF3, the lowest of the three, is absent: it reads its highlight from a table that is not public.
//
// C++, made by gonio from gonio/models/unity_brdf2.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: gonio_unity_brdf2::UnityBrdf2 params; params.base_color = ...; ... gonio_unity_brdf2::unity_brdf2_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_unity_brdf2 {

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

constexpr float F0_DIELECTRIC = 0.04f;  // Unity's dielectric reflectance (linear colour space).
// Unity's limits: of (wo.H)^2, and what its 1.00001 adds to the denominator of D.
constexpr float COS2_UNITY = 0.1f;
constexpr float D_UNITY = 1.0e-5f;
// wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
// squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
// much longer.
constexpr float LENGTHENED = 1.0995116e12f;
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
// Steps of the rule in unity_brdf2_albedo: a Fibonacci number, and the golden ratio.
constexpr float ALBEDO_SAMPLES = 987.0f;
constexpr float GOLDEN = 0.618034f;
// Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
constexpr float HORIZON = 1.0e-6f;

// A sampled direction and its density.
struct UnityBrdf2Sample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// unity_brdf2: Lambert plus a highlight without masking and Fresnel. Reciprocal; gains energy.
struct UnityBrdf2 {
    // diffuse colour, or F0 of metals, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    Vec3 base_color;
    float metallic;  // 0 for dielectrics, 1 for metals; 0 to 1, default 0
    float roughness;  // perceptual roughness, 1 - Unity's smoothness; 0 to 1, default 0.5
};

// Which of two lobes a sample is taken from.
struct UnityBrdf2Choice {
    bool is_first;  // Whether it is the first one
    Vec2 u;  // Fresh random numbers, made of those that chose
};

// Facets of GGX with the same width in all directions.
struct UnityBrdf2RoundGGX {
    float alpha;  // width of the slopes
};

// Facets of GGX, also called Trowbridge-Reitz.
struct UnityBrdf2GGX {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// ---- evaluation ----------------------------------------------------------------------------

inline Vec3 unity_brdf2_diffuse(const UnityBrdf2& params) {
    return (1.0f - F0_DIELECTRIC) * (1.0f - params.metallic) * params.base_color;
}

inline Vec3 unity_brdf2_specular(const UnityBrdf2& params) {
    return lerp(splat(F0_DIELECTRIC), params.base_color, splat(params.metallic));
}

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
inline float unity_brdf2_length2(Vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
inline Vec3 unity_brdf2_half_vector(Vec3 wi, Vec3 wo) {
    Vec3 h = LENGTHENED * (wi + wo);
    return h / sqrtf(unity_brdf2_length2(h));  // the root is the cosine's as well
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
inline float unity_brdf2_cos_half(Vec3 wi, Vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5f * sqrtf(unity_brdf2_length2(wi + wo));
}

// The highlight without its colour.
inline float unity_brdf2_highlight(const UnityBrdf2& params, Vec3 wi, Vec3 wo) {
    float a = params.roughness * params.roughness;
    Vec3 m = unity_brdf2_half_vector(wi, wo);
    float c = unity_brdf2_cos_half(wi, wo);
    // (N.H)^2 (a^2 - 1) + 1.00001, without its cancellation
    float d = m.x * m.x + m.y * m.y + a * a * m.z * m.z + D_UNITY;
    return inv_pi * (a * a / (4.0f * fmaxf(c * c, COS2_UNITY) * (a + 0.5f) * d * d));
}

// BRDF value in 1/sr, without the cosine.
inline Vec3 unity_brdf2_eval(const UnityBrdf2& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    return inv_pi * unity_brdf2_diffuse(params)
        + unity_brdf2_specular(params) * unity_brdf2_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// Width of the GGX that d is the denominator of: D_UNITY never lets it vanish.
inline float unity_brdf2_alpha(const UnityBrdf2& params) {
    float a2 = params.roughness * params.roughness * params.roughness * params.roughness;
    return sqrtf((a2 + D_UNITY) / (1.0f + D_UNITY));
}

// Mean of the three channels, by which lobes are weighed against each other.
inline float unity_brdf2_average(Vec3 color) {
    return (color.x + color.y + color.z) / 3.0f;
}

inline float unity_brdf2_raised(float probability) {
    return fmaxf(probability, fminf(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
inline Vec2 unity_brdf2_lobes_shares(float first, float second) {
    float a = first + BLACK;
    float b = fmaxf(second, WEIGHT_MIN);
    float inv = 1.0f / (a + b);
    float P_first = unity_brdf2_raised(a * inv);
    float P_second = unity_brdf2_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return Vec2{smaller ? P_first : 1.0f - P_second, smaller ? 1.0f - P_first : P_second};
}

// Probabilities of the diffuse lobe and of the highlight.
inline Vec2 unity_brdf2_shares(const UnityBrdf2& params) {
    // The highlight's albedo at the normal is near 1 / (a + 0.5), times the part that D_UNITY leaves.
    float a = params.roughness * params.roughness;
    // In two quotients, as alpha^2 may be less than a float32 holds.
    float reflected = a / (a * a + D_UNITY) * (a / (a + 0.5f));
    return unity_brdf2_lobes_shares(unity_brdf2_average(unity_brdf2_diffuse(params)),
        unity_brdf2_average(unity_brdf2_specular(params)) * reflected);
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
inline UnityBrdf2Choice unity_brdf2_choose(float probability, Vec2 u) {
    bool first = u.x < probability;
    float below = u.x / fmaxf(probability, SHARE_MIN);
    float above = (u.x - probability) / fmaxf(1.0f - probability, SHARE_MIN);
    return UnityBrdf2Choice{first,
        Vec2{fminf(fmaxf(first ? below : above, 0.0f), RANDOM_MAX), u.y}};
}

// A direction with density cos(theta) / pi.
inline Vec3 unity_brdf2_sample_cosine(Vec2 u) {
    float r = sqrtf(fmaxf(u.x, 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), sqrtf(fmaxf(1.0f - u.x, 0.0f))};
}

// w where all facets are those of a unit sphere.
inline Vec3 unity_brdf2_ggx_unstretched(UnityBrdf2GGX ggx, Vec3 w) {
    return normalize(Vec3{ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z});
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
inline Vec3 unity_brdf2_ggx_half_way(UnityBrdf2GGX ggx, Vec3 w, float drop, float z, float v) {
    float r = sqrtf(fmaxf(drop * (2.0f - drop), 0.0f));
    float phi = two_pi * v;
    Vec3 h = Vec3{r * cosf(phi) + w.x, r * sinf(phi) + w.y, z};
    return normalize(Vec3{ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z});
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
inline Vec3 unity_brdf2_ggx_sample_visible(UnityBrdf2GGX ggx, Vec3 wo, Vec2 u) {
    Vec3 w = unity_brdf2_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    float u1 = fminf(u.x, 1.0f - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    float height = 1.0f + w.z;
    return unity_brdf2_ggx_half_way(ggx, w, u1 * height, (1.0f - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see unity_brdf2_ggx_sample_visible.
inline Vec3 unity_brdf2_round_ggx_sample_visible(UnityBrdf2RoundGGX round_ggx, Vec3 wo,
    Vec2 u) {
    return unity_brdf2_ggx_sample_visible(UnityBrdf2GGX{round_ggx.alpha, round_ggx.alpha}, wo, u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
inline Vec3 unity_brdf2_mirror(Vec3 wo, Vec3 m) {
    return 2.0f * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
inline Vec3 unity_brdf2_sample_ggx_lobe(UnityBrdf2RoundGGX facets, Vec3 wo, Vec2 u) {
    Vec3 w = unity_brdf2_mirror(wo, unity_brdf2_round_ggx_sample_visible(facets, wo, u));
    return Vec3{w.x, w.y, fabsf(w.z)};
}

// A direction of one of the two lobes; shares: the probabilities of the matte one and of the other.
inline Vec3 unity_brdf2_sample_matte_gloss(Vec3 wo, float alpha, Vec2 shares, Vec2 u) {
    UnityBrdf2Choice choose_result = unity_brdf2_choose(shares.x, u);
    bool matte = choose_result.is_first;
    Vec2 v = choose_result.u;
    return matte ? unity_brdf2_sample_cosine(v)
        : unity_brdf2_sample_ggx_lobe(UnityBrdf2RoundGGX{alpha}, wo, v);
}

// Density of unity_brdf2_sample_cosine in 1/sr, for w above the horizon.
inline float unity_brdf2_pdf_cosine(Vec3 w) {
    return w.z * inv_pi;
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
inline float unity_brdf2_round_ggx_area(UnityBrdf2RoundGGX round_ggx, Vec3 w) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrtf(a2 + (1.0f - a2) * (w.z * w.z));
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
inline Vec2 unity_brdf2_slopes(Vec3 h) {
    float inv = 1.0f / h.z;
    return Vec2{h.x * inv, h.y * inv};
}

// Squared tangent of that facet's angle.
inline float unity_brdf2_tangent2(Vec3 h) {
    Vec2 t = unity_brdf2_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
inline float unity_brdf2_round_ggx_D_along(UnityBrdf2RoundGGX round_ggx, Vec3 h) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    float tan2 = unity_brdf2_tangent2(h);
    float r = (1.0f + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// Density of unity_brdf2_sample_ggx_lobe in 1/sr.
inline float unity_brdf2_pdf_ggx_lobe(UnityBrdf2RoundGGX facets, Vec3 wi, Vec3 wo) {
    float seen = 0.5f / (wo.z + unity_brdf2_round_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    float straight = unity_brdf2_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    bool exists = wo.z > wi.z;
    Vec3 across = Vec3{wi.x, wi.y, exists ? wo.z - wi.z : wi.z};
    float folded = unity_brdf2_round_ggx_D_along(facets, across
        + Vec3{wo.x, wo.y, exists ? mu_min : wo.z});
    return (straight + (exists ? folded : 0.0f)) * seen;
}

// Density of unity_brdf2_sample_matte_gloss in 1/sr.
inline float unity_brdf2_pdf_matte_gloss(Vec3 wi, Vec3 wo, float alpha, Vec2 shares) {
    return shares.x * unity_brdf2_pdf_cosine(wi)
        + shares.y * unity_brdf2_pdf_ggx_lobe(UnityBrdf2RoundGGX{alpha}, wi, wo);
}

// Density of unity_brdf2_sample in 1/sr.
inline float unity_brdf2_pdf(const UnityBrdf2& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    return unity_brdf2_pdf_matte_gloss(wi, wo, unity_brdf2_alpha(params),
        unity_brdf2_shares(params));
}

// Cosine-weighted or a visible GGX normal, by the estimated albedos.
inline UnityBrdf2Sample unity_brdf2_sample(const UnityBrdf2& params, Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return UnityBrdf2Sample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    Vec3 wi = unity_brdf2_sample_matte_gloss(wo, unity_brdf2_alpha(params),
        unity_brdf2_shares(params), u);
    return UnityBrdf2Sample{wi, unity_brdf2_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline Vec3 unity_brdf2_albedo(const UnityBrdf2& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    Vec3 w = Vec3{wo.x, wo.y, fmaxf(wo.z, HORIZON)};
    Vec3 total = Vec3{0.0f, 0.0f, 0.0f};
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        Vec2 u = Vec2{(i + 0.5f) / ALBEDO_SAMPLES, fract((i + 0.5f) * GOLDEN)};
        UnityBrdf2Sample drawn = unity_brdf2_sample(params, w, u);
        float weight = drawn.pdf > 0.0f ? drawn.wi.z / fmaxf(drawn.pdf, mu_min) : 0.0f;
        total = total + unity_brdf2_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}

}  // namespace gonio_unity_brdf2
