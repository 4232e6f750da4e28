// SPDX-License-Identifier: Apache-2.0
// Patina: copper that turns green, from bare metal to a closed layer.
//
// Source: Elek, "Layered materials in real-time rendering", CESCG 2010, section 4.2: the layered model of
// `weidlich_wilkie` with a coat of cuprite that also scatters, faded in by a map, which
// `gonio.mitsuba.textures.growth_map` makes. Spatial variation is the host's business: growth is a number
// here, and a texture gives each point its own.
// Deviations: by default light that leaves the coat spreads by 1 / eta^2, without which the metal below is
// eta^2 = 9.5 times too bright; facets are GGX's with Smith's masking instead of Beckmann's with
// V-cavities, and F is exact instead of Lazanyi's fit. Options restore each of these. The index that Elek
// mixes with the patina's as that grows is the one of the environment's reflection alone: the metal below
// stays copper.
//
// C++, made by gonio from gonio/models/patina.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: gonio_patina::Patina params; params.growth = ...; ... gonio_patina::patina_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_patina {

struct Vec2 {
    float x, y;
};

struct Vec3 {
    float x, y, z;
};

struct Bool3 {
    bool x, y, z;
};

inline Vec3 splat(float a) {
    return Vec3{a, a, a};
}

inline Vec3 operator-(Vec3 a) {
    return Vec3{-a.x, -a.y, -a.z};
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

inline float length(Vec3 a) {
    return sqrtf(a.x * a.x + a.y * a.y + a.z * a.z);
}

inline Vec3 normalize(Vec3 a) {
    float inv = 1.0f / sqrtf(a.x * a.x + a.y * a.y + a.z * a.z);
    return Vec3{a.x * inv, a.y * inv, a.z * inv};
}

inline Vec3 select(Bool3 c, Vec3 yes, Vec3 no) {
    return Vec3{c.x ? yes.x : no.x, c.y ? yes.y : no.y, c.z ? yes.z : no.z};
}

inline Vec3 operator+(Vec3 a, Vec3 b) {
    return Vec3{a.x + b.x, a.y + b.y, a.z + b.z};
}

inline Vec3 operator+(Vec3 a, float b) {
    return Vec3{a.x + b, a.y + b, a.z + b};
}

inline Vec3 operator+(float a, Vec3 b) {
    return Vec3{a + b.x, a + b.y, a + b.z};
}

inline Vec3 operator-(Vec3 a, Vec3 b) {
    return Vec3{a.x - b.x, a.y - b.y, a.z - b.z};
}

inline Vec3 operator-(Vec3 a, float b) {
    return Vec3{a.x - b, a.y - b, a.z - b};
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

inline Vec3 operator/(Vec3 a, Vec3 b) {
    return Vec3{a.x / b.x, a.y / b.y, a.z / b.z};
}

inline Vec3 operator/(Vec3 a, float b) {
    return Vec3{a.x / b, a.y / b, a.z / b};
}

inline Vec3 operator/(float a, Vec3 b) {
    return Vec3{a / b.x, a / b.y, a / b.z};
}

inline Bool3 operator>(Vec3 a, Vec3 b) {
    return Bool3{a.x > b.x, a.y > b.y, a.z > b.z};
}

inline Vec3 lerp(Vec3 a, Vec3 b, Vec3 c) {
    return Vec3{lerp(a.x, b.x, c.x), lerp(a.y, b.y, c.y), lerp(a.z, b.z, c.z)};
}

inline Vec3 absolute(Vec3 a) {
    return Vec3{fabsf(a.x), fabsf(a.y), fabsf(a.z)};
}

inline Vec3 sqrt(Vec3 a) {
    return Vec3{sqrtf(a.x), sqrtf(a.y), sqrtf(a.z)};
}

inline Vec3 exp(Vec3 a) {
    return Vec3{expf(a.x), expf(a.y), expf(a.z)};
}

// Below this squared sine the azimuth of wo is taken as 0: any azimuth is right there, and the square of
// its reciprocal still fits into a float32.
constexpr float SIN2_MIN = 1.0e-18f;
// wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
// squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
// much longer.
constexpr float LENGTHENED = 1.0995116e12f;
// A trace of absorption, which keeps a conductor's roots from 0, and their squares from where GPUs
// take them for 0. By itself it reflects where the index is matched in the horizon, (ABSORPTION_MIN /
// (2 mu^2))^2.
constexpr float ABSORPTION_MIN = 1.0e-17f;
// Cosine from which on the square of the sine is the smaller of the two, and keeps the digits.
constexpr float NEAR_NORMAL = 0.75f;
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
// Added to the weight of a lobe, so that the reciprocal of two black lobes' sum has a finite derivative.
constexpr float LOBE_MIN = 1.0e-12f;
// Flattest direction that a sample leaves in: derivatives by the index fit in a float32 there.
constexpr float LEAVE_MIN = 1.0e-12f;
// Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
constexpr float RANDOM_MARGIN = 5.9604645e-8f;
// Steps of the rule in patina_albedo: a Fibonacci number, and the golden ratio.
constexpr float ALBEDO_SAMPLES = 987.0f;
constexpr float GOLDEN = 0.618034f;
// Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
constexpr float HORIZON = 1.0e-6f;

// A sampled direction and its density.
struct PatinaSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// patina: Copper under a growing green layer of cuprite. Reciprocal.
// Exported with solid_angle='compressed', distribution='ggx', masking='smith_correlated', fresnel='exact'.
struct Patina {
    float growth;  // the map: where it is dark, the patina grows first; 0 to 1, default 0.5
    float extent;  // from -transition (bare) to 1 + transition (closed); -1 to 2, default 0.45
    float transition;  // softness of the patina's edges; 0.001 to 1, default 0.65
    float thickness;  // thickness of the patina, in the unit of sigma_a; 0 to 5, default 1
    Vec3 sigma_a;  // absorption; 1 - sigma_a is the colour; 0 to 1, default (0.66, 0.3, 0.42)
    float alpha;  // slope width of the patina's facets; 0.0001 to 1, default 0.5
    float bare_alpha;  // slope width of the metal's facets where bare; 0.0001 to 1, default 0.15
    float grown_alpha;  // slope width of the metal's facets below patina; 0.0001 to 1, default 0.5
    // the metal's index; the default is copper; 0.01 to 20, default (0.201005, 0.923749, 1.10221)
    Vec3 metal_eta;
    Vec3 metal_k;  // the metal's extinction; 0 to 20, default (3.91326, 2.45304, 2.14209)
    // the patina's index; the default is cuprite; 1 to 5, default (2.947821, 3.110926, 3.026471)
    Vec3 coat_eta;
    // the patina's extinction, at its surface only; 0 to 3, default (0.09478703, 0.2044823, 0.6666183)
    Vec3 coat_k;
    float tarnish;  // how much the metal has darkened; a texture can drive it; 0 to 1, default 0.5
    Vec3 tarnish_tint;  // colour of the metal at tarnish 1; 0 to 1, default (0.45, 0.2, 0.08)
};

// Facets of GGX with the same width in all directions.
struct PatinaRoundGGX {
    float alpha;  // width of the slopes
};

// What becomes of light at a surface.
struct PatinaSplit {
    Vec3 F;  // Is reflected
    Vec3 T;  // Enters
};

// What patina_shares returns.
struct PatinaShares {
    Vec2 P_bare;
    Vec2 P_coat;
    Vec2 P_diffuse;
};

// Which of two lobes a sample is taken from.
struct PatinaChoice {
    bool is_first;  // Whether it is the first one
    Vec2 u;  // Fresh random numbers, made of those that chose
};

// Facets of GGX, also called Trowbridge-Reitz.
struct PatinaGGX {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
inline float patina_length2(Vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
inline Vec3 patina_half_vector(Vec3 wi, Vec3 wo) {
    Vec3 h = LENGTHENED * (wi + wo);
    return h / sqrtf(patina_length2(h));  // the root is the cosine's as well
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
inline float patina_cos_half(Vec3 wi, Vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5f * sqrtf(patina_length2(wi + wo));
}

// 1 - patina_cos_half^2, the squared sine at which light meets the facet: of half the length of wi - wo.
inline float patina_sin2_half(Vec3 wi, Vec3 wo) {
    Vec3 apart = wi - wo;
    return 0.25f * dot(apart, apart);
}

// |re + i im| for im of at least 2 ABSORPTION_MIN.
inline Vec3 patina_size(Vec3 re, Vec3 im) {
    return sqrt(re * re + im * im);
}

// |re + i im|^2 / s2^2 p / q.
inline Vec3 patina_reflected(Vec3 re, Vec3 im, Vec3 s2, Vec3 p, Vec3 q) {
    // In two quotients, as the square of s2 is 1e-34 for a matched index in the horizon
    return (re * re + im * im) / s2 * (p / (s2 * q));
}

// Exact reflectance of a conductor, eta + i k, from cosine and squared sine at a facet.
inline Vec3 patina_F_conductor_half(float cos_h, float sin2_h, Vec3 eta, Vec3 k) {
    // As for a dielectric, in complex numbers: contrast = (eta + i k)^2 - 1, g^2 = w = contrast + c^2
    float c = cos_h;
    Vec3 contrast_re = (eta - 1.0f) * (eta + 1.0f) - k * k;
    Vec3 half_im = eta * k + ABSORPTION_MIN;
    float c2 = c * c;
    // The same as eta^2 - k^2 - sin^2, of which a small index leaves little else near the normal
    Vec3 w_re = cos_h > NEAR_NORMAL ? eta * eta - k * k - sin2_h : contrast_re + c2;
    Vec3 im = 2.0f * half_im;
    Vec3 w_abs = patina_size(w_re, im);
    // Of the two parts of the root, the larger has no cancellation; the smaller follows from it.
    Vec3 g2 = 0.5f * (w_abs + absolute(w_re));
    Vec3 g_re = select(w_re > splat(0.0f), g2, half_im) * (1.0f / sqrt(g2));
    // |c + g|^2 = c^2 + |w| + cross, and |c g -+ sin2_h|^2 = p -+ cross sin2_h
    Vec3 cross = 2.0f * c * g_re;
    Vec3 s_abs2 = c2 + w_abs + cross;
    Vec3 p = c2 * w_abs + sin2_h * sin2_h;
    return patina_reflected(contrast_re, im, s_abs2, p, p + cross * sin2_h);
}

// The metal's reflectance, as far as it has tarnished.
inline Vec3 patina_metal_F(const Patina& params, float cos_h, float sin2_h) {
    Vec3 tint = lerp(splat(1.0f), params.tarnish_tint, splat(params.tarnish));
    return patina_F_conductor_half(cos_h, sin2_h, params.metal_eta, params.metal_k) * tint;
}

// a + b + c with the rounding error of a + b carried along (Knuth), for a c that cancels it.
inline float patina_sum3(float a, float b, float c) {
    float ab = a + b;
    float back = ab - a;
    float error = a - (ab - back) + (b - back);
    return ab + c + error;
}

// 1 - extentFactor, with all its digits: a sharp highlight counts however little of it is left.
inline float patina_bare(const Patina& params) {
    float rise = patina_sum3(params.growth, -params.extent, params.transition)
        / (2.0f * params.transition);
    float t = fminf(fmaxf(rise, 0.0f), 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

// extentFactor: 1 - smoothstep(extent - transition, extent + transition, growth).
inline float patina_grown(const Patina& params) {
    float rest = patina_sum3(params.extent, -params.growth, params.transition)
        / (2.0f * params.transition);
    float t = fminf(fmaxf(rest, 0.0f), 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

inline float patina_metal_alpha(const Patina& params) {
    return patina_bare(params) * params.bare_alpha + patina_grown(params) * params.grown_alpha;
}

inline PatinaRoundGGX patina_bare_facets(const Patina& params) {
    return PatinaRoundGGX{patina_metal_alpha(params)};
}

// Density of facets, in 1/sr. Walter et al., Eq. 33.
inline float patina_round_ggx_D(PatinaRoundGGX round_ggx, Vec3 m) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    float s = a2 + (1.0f - a2) * (m.x * m.x + m.y * m.y);
    return inv_pi * a2 / (s * s);
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
inline float patina_round_ggx_area(PatinaRoundGGX round_ggx, Vec3 w) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrtf(a2 + (1.0f - a2) * (w.z * w.z));
}

// G = 1 / (1 + Lambda_i + Lambda_o): correlated by the facet's height. Heitz 2014, Eq. 99.
inline float patina_V_smith_correlated(PatinaRoundGGX facets, Vec3 wi, Vec3 wo) {
    return 0.5f / (wo.z * patina_round_ggx_area(facets, wi)
        + wi.z * patina_round_ggx_area(facets, wo));
}

// D G / (4 mu_i mu_o); F is missing.
inline float patina_reflected_by(PatinaRoundGGX facets, Vec3 wi, Vec3 wo, Vec3 m) {
    return patina_round_ggx_D(facets, m) * patina_V_smith_correlated(facets, wi, wo);
}

// Mean of the three channels, by which lobes are weighed against each other.
inline float patina_average(Vec3 color) {
    return (color.x + color.y + color.z) / 3.0f;
}

// The patina's index for refraction, the mean of its channels, minus 1.
inline float patina_excess(const Patina& params) {
    return patina_average(params.coat_eta - 1.0f);
}

inline float patina_sin2(float cos_theta) {
    return (1.0f - cos_theta) * (1.0f + cos_theta);
}

// F of a conductor denser than the medium above, and 1 - F, exact where it nearly vanishes.
inline PatinaSplit patina_split_conductor(float cos_theta, Vec3 eta, Vec3 k) {
    // With eps = (eta + i k)^2 and g^2 = eps - 1 + c^2: 1 - R_s = 4 c Re(g) / |c + g|^2, and 1 - R_p is 4 c
    // Re(conj(g) eps) / |eps c + g|^2. The roots are those of F.
    float c = cos_theta;
    Vec3 contrast_re = (eta - 1.0f) * (eta + 1.0f) - k * k;
    Vec3 half_im = eta * k + ABSORPTION_MIN;
    Vec3 eps_re = (eta - k) * (eta + k);
    Vec3 eps_im = 2.0f * half_im;
    float c2 = c * c;
    float sin2 = patina_sin2(c);
    Vec3 w_re = contrast_re + c2;
    Vec3 w_abs = patina_size(w_re, eps_im);
    Vec3 g2 = 0.5f * (w_abs + absolute(w_re));
    Vec3 inv = 1.0f / sqrt(g2);
    Vec3 large = g2 * inv;
    Vec3 small = half_im * inv;
    Vec3 g_re = select(w_re > splat(0.0f), large, small);
    Vec3 g_im = select(w_re > splat(0.0f), small, large);
    Vec3 cross = 2.0f * c * g_re;
    Vec3 s_abs2 = c2 + w_abs + cross;
    Vec3 p = c2 * w_abs + sin2 * sin2;
    Vec3 p_re = eps_re * c + g_re;
    Vec3 p_im = eps_im * c + g_im;
    Vec3 T_p = (eps_re * g_re + eps_im * g_im) / (p_re * p_re + p_im * p_im);
    Vec3 F = patina_reflected(contrast_re, eps_im, s_abs2, p, p + cross * sin2);
    return PatinaSplit{F, 2.0f * c * (g_re / s_abs2 + T_p)};
}

inline PatinaRoundGGX patina_facets(const Patina& params) {
    return PatinaRoundGGX{params.alpha};
}

// 2 mu Lambda, patina_round_ggx_area without mu, exact where it is little.
inline float patina_round_ggx_hidden(PatinaRoundGGX round_ggx, Vec3 w) {
    // The difference would have few digits, which count beside a coat that transmits as little
    float rest = round_ggx.alpha * round_ggx.alpha * ((1.0f - w.z) * (1.0f + w.z));
    return rest / (patina_round_ggx_area(round_ggx, w) + w.z);
}

// 1 - G of patina_V_smith_correlated, exact where G is nearly 1.
inline float patina_lost_smith_correlated(PatinaRoundGGX facets, Vec3 wi, Vec3 wo) {
    float rest = wo.z * patina_round_ggx_hidden(facets, wi)
        + wi.z * patina_round_ggx_hidden(facets, wo);
    return 2.0f * rest * patina_V_smith_correlated(facets, wi, wo);
}

// T12 t of Eq. 2 and 4 with lost = 1 - G.
inline Vec3 patina_past_facets(Vec3 T, float lost) {
    // 1 - G F would lose the digits of a small T
    return T * (T + lost * (1.0f - T));
}

// T12 t of Eq. 2 and 4 with t = (1 - G) + T21 G, T21 = T12 = T at the half vector.
inline Vec3 patina_through_facets(PatinaRoundGGX facets, Vec3 wi, Vec3 wo, Vec3 T) {
    return patina_past_facets(T, patina_lost_smith_correlated(facets, wi, wo));
}

// eta^2 - 1.
inline float patina_contrast(float excess) {
    return excess * (2.0f + excess);
}

// eta^2 cos^2(theta_t) = mu^2 + eta^2 - 1.
inline float patina_eta2_cos2(float mu, float excess) {
    // mu^2 with its rounding error: at grazing angles little else is left
    return fmaf(mu, mu, patina_contrast(excess));
}

// The direction inside a layer with eta >= 1 that belongs to w outside.
inline Vec3 patina_refract(Vec3 w, float excess) {
    return Vec3{w.x, w.y, sqrtf(patina_eta2_cos2(w.z, excess))} * (1.0f / (1.0f + excess));
}

// exp(-sigma_a d (1 / mu_i + 1 / mu_o)): what is left of light after its way in and out (Bouguer).
//
// wi, wo: refracted directions. sigma_a: absorption per unit of the thickness d.
inline Vec3 patina_attenuation(Vec3 sigma_a, float thickness, Vec3 wi, Vec3 wo) {
    return exp(-sigma_a * (thickness * ((wi.z + wo.z) / (wi.z * wo.z))));
}

// eta times the sum of both refracted directions, which has their half vector's direction.
//
// Where the two are nearly mirrored the tangential parts cancel: they are summed before they are rounded by
// refraction, so that a sharp highlight below keeps its place.
inline Vec3 patina_refracted_sum(Vec3 wi, Vec3 wo, float excess) {
    float z_i = patina_eta2_cos2(wi.z, excess);
    float z_o = patina_eta2_cos2(wo.z, excess);
    return Vec3{wi.x + wo.x, wi.y + wo.y, sqrtf(z_i) + sqrtf(z_o)};
}

// Squared sine at which refracted light meets a facet, from a difference before it is rounded.
inline float patina_refracted_sin2_half(Vec3 wi, Vec3 wo, float excess) {
    float z_i = patina_eta2_cos2(wi.z, excess);
    float z_o = patina_eta2_cos2(wo.z, excess);
    // A difference of two roots is that of their squares over their sum
    float z = (wi.z - wo.z) * (wi.z + wo.z) / (sqrtf(z_i) + sqrtf(z_o));
    Vec3 apart = Vec3{wi.x - wo.x, wi.y - wo.y, z} / (1.0f + excess);
    return 0.25f * dot(apart, apart);
}

// The metal's under the patina, at least as wide as those of the patina itself (Figure 2).
inline PatinaRoundGGX patina_facets_below(const Patina& params) {
    return PatinaRoundGGX{fmaxf(patina_metal_alpha(params), params.alpha)};
}

// Eq. 2 with a coat that scatters.
inline Vec3 patina_coated(const Patina& params, Vec3 wi, Vec3 wo) {
    Vec3 m = patina_half_vector(wi, wo);
    float cos_h = patina_cos_half(wi, wo);
    float excess = patina_excess(params);
    float index = 1.0f + excess;
    PatinaSplit surface = patina_split_conductor(cos_h, params.coat_eta, params.coat_k);
    PatinaRoundGGX facets = patina_facets(params);
    float glossy = patina_reflected_by(facets, wi, wo, m);
    Vec3 coat = surface.F * glossy + (1.0f - params.sigma_a) * surface.T * inv_pi;

    Vec3 through = patina_through_facets(facets, wi, wo, surface.T);
    through = through / (index * index);
    Vec3 wi_t = patina_refract(wi, excess);
    Vec3 wo_t = patina_refract(wo, excess);
    Vec3 kept = patina_attenuation(params.sigma_a, params.thickness, wi_t, wo_t);
    Vec3 both = patina_refracted_sum(wi, wo, excess);
    float cos_t = 0.5f * length(both) / index;
    Vec3 F = patina_metal_F(params, cos_t, patina_refracted_sin2_half(wi, wo, excess));
    PatinaRoundGGX below = patina_facets_below(params);
    Vec3 metal_ = F * patina_reflected_by(below, wi_t, wo_t, normalize(both));
    return coat + metal_ * through * kept;
}

// The bare and the coated metal, mixed: BRDF value in 1/sr, without the cosine.
inline Vec3 patina_eval(const Patina& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    Vec3 m = patina_half_vector(wi, wo);
    float cos_h = patina_cos_half(wi, wo);
    Vec3 F = patina_metal_F(params, cos_h, patina_sin2_half(wi, wo));
    Vec3 bare = F * patina_reflected_by(patina_bare_facets(params), wi, wo, m);
    return patina_bare(params) * bare + patina_grown(params) * patina_coated(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// A cosine at which light from anywhere meets the facets that it enters by, to choose lobes with.
//
// Halfway between wo.z (the mirror direction) and 1 (wi = wo): at grazing angles tilted facets let in more
// than the mean surface, whose transmittance is nearly 0 there.
inline float patina_usual_cos_half(Vec3 wo) {
    return 0.5f + 0.5f * wo.z;
}

// The most that patina_attenuation leaves of light that goes out along wo: it came in along the normal.
inline Vec3 patina_attenuation_least(Vec3 sigma_a, float thickness, Vec3 wo) {
    return patina_attenuation(sigma_a, thickness, Vec3{0.0f, 0.0f, 1.0f}, wo);
}

inline float patina_raised(float probability) {
    return fmaxf(probability, fminf(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
inline Vec2 patina_lobes_shares(float first, float second) {
    float a = first + BLACK;
    float b = fmaxf(second, WEIGHT_MIN);
    float inv = 1.0f / (a + b);
    float P_first = patina_raised(a * inv);
    float P_second = patina_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return Vec2{smaller ? P_first : 1.0f - P_second, smaller ? 1.0f - P_first : P_second};
}

// Probabilities: bare metal or patina; of that, surface or not; of the rest, diffuse or below.
inline PatinaShares patina_shares(const Patina& params, Vec3 wo) {
    float grown = patina_grown(params);
    Vec3 wo_t = patina_refract(wo, patina_excess(params));
    float mu = wo.z;
    float sin2 = (1.0f - wo.z) * (1.0f + wo.z);
    Vec3 F = patina_split_conductor(mu, params.coat_eta, params.coat_k).F;
    Vec3 T = patina_split_conductor(patina_usual_cos_half(wo), params.coat_eta, params.coat_k).T;
    Vec3 F_metal = patina_metal_F(params, mu, sin2);
    float bare = patina_bare(params) * patina_average(F_metal);
    float coat = grown * patina_average(F);
    float diffuse = grown * patina_average((1.0f - params.sigma_a) * T);
    Vec3 kept = patina_attenuation_least(params.sigma_a, params.thickness, wo_t);
    float below = grown * patina_average(T * kept * F_metal) + LOBE_MIN;
    float inside = diffuse + below;
    Vec2 P_bare = patina_lobes_shares(bare, coat + inside);
    Vec2 P_coat = patina_lobes_shares(coat, inside);
    Vec2 P_diffuse = patina_lobes_shares(diffuse, below);
    return PatinaShares{P_bare, P_coat, P_diffuse};
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
inline PatinaChoice patina_choose(float probability, Vec2 u) {
    bool first = u.x < probability;
    float below = u.x / fmaxf(probability, SHARE_MIN);
    float above = (u.x - probability) / fmaxf(1.0f - probability, SHARE_MIN);
    return PatinaChoice{first, Vec2{fminf(fmaxf(first ? below : above, 0.0f), RANDOM_MAX), u.y}};
}

// w where all facets are those of a unit sphere.
inline Vec3 patina_ggx_unstretched(PatinaGGX ggx, Vec3 w) {
    return normalize(Vec3{ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z});
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
inline Vec3 patina_ggx_half_way(PatinaGGX ggx, Vec3 w, float drop, float z, float v) {
    float r = sqrtf(fmaxf(drop * (2.0f - drop), 0.0f));
    float phi = two_pi * v;
    Vec3 h = Vec3{r * cosf(phi) + w.x, r * sinf(phi) + w.y, z};
    return normalize(Vec3{ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z});
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
inline Vec3 patina_ggx_sample_visible(PatinaGGX ggx, Vec3 wo, Vec2 u) {
    Vec3 w = patina_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    float u1 = fminf(u.x, 1.0f - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    float height = 1.0f + w.z;
    return patina_ggx_half_way(ggx, w, u1 * height, (1.0f - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see patina_ggx_sample_visible.
inline Vec3 patina_round_ggx_sample_visible(PatinaRoundGGX round_ggx, Vec3 wo, Vec2 u) {
    return patina_ggx_sample_visible(PatinaGGX{round_ggx.alpha, round_ggx.alpha}, wo, u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
inline Vec3 patina_mirror(Vec3 wo, Vec3 m) {
    return 2.0f * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
inline Vec3 patina_sample_ggx_lobe(PatinaRoundGGX facets, Vec3 wo, Vec2 u) {
    Vec3 w = patina_mirror(wo, patina_round_ggx_sample_visible(facets, wo, u));
    return Vec3{w.x, w.y, fabsf(w.z)};
}

// How far down the cap of visible normals goes that mirror wo above the horizon; 1: all the way.
//
// Eto and Tokuyoshi, Eq. 5 and 6; least: the smaller width, at most 1. No normal is left out that would
// mirror wo above the horizon. Of facets of one width 5 % at most of the others are left.
inline float patina_ggx_bound(float least, Vec3 wo) {
    float s = 1.0f + sqrtf(fmaxf(wo.x * wo.x + wo.y * wo.y, 0.0f));
    float a2 = least * least;
    float s2 = s * s;
    return (1.0f - a2) * s2 / (s2 + a2 * wo.z * wo.z);
}

// A normal that wo sees, without those that mirror wo below the horizon, or most of them.
//
// Eto and Tokuyoshi, "Bounded VNDF sampling for Smith-GGX reflections", 2023; bound: see patina_ggx_bound.
inline Vec3 patina_ggx_sample_bounded(PatinaGGX ggx, Vec3 wo, Vec2 u, float bound) {
    Vec3 w = patina_ggx_unstretched(ggx, wo);
    float u1 = fminf(u.x, 1.0f - RANDOM_MARGIN);
    // A cap down to z = -bound w.z: z = 1 - u (1 + bound w.z), and z + w.z as a sum of positive terms
    float height = 1.0f + bound * w.z;
    return patina_ggx_half_way(ggx, w, u1 * height, (1.0f - u1) * height + (1.0f - bound) * w.z,
        u.y);
}

// A normal that wo sees, without most that mirror wo downwards; see patina_ggx_sample_bounded.
inline Vec3 patina_round_ggx_sample_bounded(PatinaRoundGGX round_ggx, Vec3 wo, Vec2 u,
    float bound) {
    return patina_ggx_sample_bounded(PatinaGGX{round_ggx.alpha, round_ggx.alpha}, wo, u, bound);
}

// A facet's normal.
inline Vec3 patina_sample_facet(PatinaRoundGGX facets, Vec3 wo, Vec2 u) {
    return patina_round_ggx_sample_bounded(facets, wo, u, patina_ggx_bound(facets.alpha, wo));
}

// Cosine inside the layer of the flattest direction that leaves it; 0 for eta <= 1.
inline float patina_critical_cosine(float excess) {
    return sqrtf(fmaxf(patina_contrast(excess), 0.0f)) / (1.0f + excess);
}

// The outer direction for a direction inside: refracted, or spread out if it cannot leave.
inline Vec3 patina_leave(Vec3 w, float excess) {
    float k = patina_critical_cosine(excess);
    float eta = 1.0f + excess;
    bool refracted = w.z > k;
    float spread = fminf(w.z / fmaxf(k, mu_min), 1.0f);
    // The sine from x and y: under many layers 1 - z^2 has few digits
    float sin2 = w.x * w.x + w.y * w.y;
    float z = refracted ? sqrtf(fmaxf(1.0f - eta * eta * sin2, 0.0f)) : spread;
    // Refracted sines are eta times as large, of which 1 - z^2 would leave no digits near the normal
    float spread_out = sqrtf(fmaxf(1.0f - spread * spread, 0.0f)) / sqrtf(fmaxf(sin2, SIN2_MIN));
    float scale = refracted ? eta : spread_out;
    // A sample above the horizon stays there, however flat.
    z = w.z > 0.0f ? fmaxf(z, LEAVE_MIN) : -1.0f;
    return normalize(Vec3{w.x * scale, w.y * scale, z});
}

// A direction with density cos(theta) / pi.
inline Vec3 patina_sample_cosine(Vec2 u) {
    float r = sqrtf(fmaxf(u.x, 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), sqrtf(fmaxf(1.0f - u.x, 0.0f))};
}

// Density of wo mirrored at a visible normal m that a bound leaves, in 1/sr.
inline float patina_pdf_bounded(PatinaRoundGGX facets, Vec3 wo, Vec3 m, float bound) {
    return 0.5f * patina_round_ggx_D(facets, m)
        / (bound * wo.z + patina_round_ggx_area(facets, wo));
}

// Density of wo mirrored at patina_sample_facet, in 1/sr.
inline float patina_pdf_facet(PatinaRoundGGX facets, Vec3 wo, Vec3 m) {
    return patina_pdf_bounded(facets, wo, m, patina_ggx_bound(facets.alpha, wo));
}

// Density of what the metal below mirrors, inside the patina.
inline float patina_pdf_below(const Patina& params, Vec3 wo_t, Vec3 m) {
    return patina_pdf_facet(patina_facets_below(params), wo_t, m);
}

// The inner direction that patina_leave spreads to w; z = 0 for eta <= 1, which has none.
inline Vec3 patina_gather(Vec3 w, float excess) {
    float k = patina_critical_cosine(excess);
    float z = k * w.z;
    float sin2 = w.x * w.x + w.y * w.y;
    float scale = sqrtf(fmaxf(1.0f - z * z, 0.0f)) / sqrtf(fmaxf(sin2, SIN2_MIN));
    bool near = sin2 < SIN2_MIN;  // no azimuth: any is right
    float x = near ? sqrtf(fmaxf(1.0f - z * z, 0.0f)) : w.x * scale;
    return Vec3{x, near ? 0.0f : w.y * scale, z};
}

// Density of patina_leave at w, from the inner density at w_t = refract(w) and at gather(w).
inline float patina_pdf_leave(float pdf_refracted, float pdf_gathered, Vec3 w, Vec3 w_t,
    float excess) {
    // Solid angle over cosine-weighted one: 1 / mu. Refraction shrinks the latter by eta^2, gathering by k^2,
    // and the cosines are k mu and mu.
    float eta = 1.0f + excess;
    return pdf_refracted * w.z / (eta * eta * w_t.z)
        + pdf_gathered * patina_critical_cosine(excess);
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
inline Vec2 patina_slopes(Vec3 h) {
    float inv = 1.0f / h.z;
    return Vec2{h.x * inv, h.y * inv};
}

// Squared tangent of that facet's angle.
inline float patina_tangent2(Vec3 h) {
    Vec2 t = patina_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
inline float patina_round_ggx_D_along(PatinaRoundGGX round_ggx, Vec3 h) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    float tan2 = patina_tangent2(h);
    float r = (1.0f + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// Density of patina_sample_ggx_lobe in 1/sr.
inline float patina_pdf_ggx_lobe(PatinaRoundGGX facets, Vec3 wi, Vec3 wo) {
    float seen = 0.5f / (wo.z + patina_round_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    float straight = patina_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    bool exists = wo.z > wi.z;
    Vec3 across = Vec3{wi.x, wi.y, exists ? wo.z - wi.z : wi.z};
    float folded = patina_round_ggx_D_along(facets, across
        + Vec3{wo.x, wo.y, exists ? mu_min : wo.z});
    return (straight + (exists ? folded : 0.0f)) * seen;
}

// Density of patina_sample_cosine in 1/sr, for w above the horizon.
inline float patina_pdf_cosine(Vec3 w) {
    return w.z * inv_pi;
}

// Density of patina_sample in 1/sr.
inline float patina_pdf(const Patina& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    PatinaShares shares_result = patina_shares(params, wo);
    Vec2 P_bare = shares_result.P_bare;
    Vec2 P_coat = shares_result.P_coat;
    Vec2 P_diffuse = shares_result.P_diffuse;
    float excess = patina_excess(params);
    Vec3 wi_t = patina_refract(wi, excess);
    Vec3 wo_t = patina_refract(wo, excess);
    float refracted = patina_pdf_below(params, wo_t,
        normalize(patina_refracted_sum(wi, wo, excess)));
    Vec3 w = patina_gather(wi, excess);
    float gathered = patina_pdf_below(params, wo_t, patina_half_vector(w, wo_t));
    float below = patina_pdf_leave(refracted, gathered, wi, wi_t, excess);
    float coat = patina_pdf_ggx_lobe(patina_facets(params), wi, wo);
    float bare = patina_pdf_ggx_lobe(patina_bare_facets(params), wi, wo);
    float inside = P_diffuse.x * patina_pdf_cosine(wi) + P_diffuse.y * below;
    return P_bare.x * bare + P_bare.y * (P_coat.x * coat + P_coat.y * inside);
}

// One of the bare metal, the patina's surface, its diffuse part, and the metal below.
inline PatinaSample patina_sample(const Patina& params, Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return PatinaSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    PatinaShares shares_result = patina_shares(params, wo);
    Vec2 P_bare = shares_result.P_bare;
    Vec2 P_coat = shares_result.P_coat;
    Vec2 P_diffuse = shares_result.P_diffuse;
    float excess = patina_excess(params);
    PatinaChoice choose_result = patina_choose(P_bare.x, u);
    bool on_bare = choose_result.is_first;
    Vec2 v = choose_result.u;
    PatinaChoice choose_result_2 = patina_choose(P_coat.x, v);
    bool on_coat = choose_result_2.is_first;
    Vec2 s = choose_result_2.u;
    PatinaChoice choose_result_3 = patina_choose(P_diffuse.x, s);
    bool on_diffuse = choose_result_3.is_first;
    Vec2 t = choose_result_3.u;
    Vec3 w_bare = patina_sample_ggx_lobe(patina_bare_facets(params), wo, v);
    Vec3 w_coat = patina_sample_ggx_lobe(patina_facets(params), wo, s);
    Vec3 wo_t = patina_refract(wo, excess);
    Vec3 m = patina_sample_facet(patina_facets_below(params), wo_t, t);
    Vec3 w_below = patina_leave(patina_mirror(wo_t, m), excess);
    Vec3 w_patina = on_coat ? w_coat : on_diffuse ? patina_sample_cosine(t) : w_below;
    Vec3 wi = on_bare ? w_bare : w_patina;
    return PatinaSample{wi, patina_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline Vec3 patina_albedo(const Patina& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    Vec3 w = Vec3{wo.x, wo.y, fmaxf(wo.z, HORIZON)};
    Vec3 total = Vec3{0.0f, 0.0f, 0.0f};
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        Vec2 u = Vec2{(i + 0.5f) / ALBEDO_SAMPLES, fract((i + 0.5f) * GOLDEN)};
        PatinaSample drawn = patina_sample(params, w, u);
        float weight = drawn.pdf > 0.0f ? drawn.wi.z / fmaxf(drawn.pdf, mu_min) : 0.0f;
        total = total + patina_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}

}  // namespace gonio_patina
