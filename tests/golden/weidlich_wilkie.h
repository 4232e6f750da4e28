// SPDX-License-Identifier: Apache-2.0
// Weidlich-Wilkie: a rough clear coat over any base, which may be coated itself.
//
// Source: Elek, "Layered materials in real-time rendering", CESCG 2010, Eq. 2 to 4 and Algorithm 1, after
// Weidlich, Wilkie, "Arbitrarily layered micro-facet surfaces", GRAPHITE 2007. Symbols are Elek's.
// Deviations: refracted directions keep the azimuth of the ones they belong to (Algorithm 1 mirrors them at
// the normal, which would turn an anisotropic base by 180 degrees); F is exact by default, not
// Lazanyi's fit;
// D carries the 1 / pi that Elek's lacks; a coloured coat, which has an index and an extinction for each
// channel as in Algorithm 1, refracts by one index. What Eq. 2 leaves out can be switched on: Fresnel's
// reflection at both crossings, the compression of solid angles, and the light that bounces between base
// and surface.
//
// Lambert: ideal diffuse reflection.
//
// Source: Johann Heinrich Lambert, "Photometria", 1760.
//
// C++, made by gonio from gonio/models/weidlich_wilkie.py, gonio/models/lambert.py; free to use under
// Apache-2.0. wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: gonio_weidlich_wilkie::WeidlichWilkie params; params.eta = ...; ... gonio_weidlich_wilkie::weidlich_wilkie_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_weidlich_wilkie {

struct Vec2 {
    float x, y;
};

struct Vec3 {
    float x, y, z;
};

inline Vec3 splat(float a) {
    return Vec3{a, a, a};
}

inline Vec3 operator-(Vec3 a) {
    return Vec3{-a.x, -a.y, -a.z};
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

inline Vec3 operator+(Vec3 a, float b) {
    return Vec3{a.x + b, a.y + b, a.z + b};
}

inline Vec3 operator-(Vec3 a, Vec3 b) {
    return Vec3{a.x - b.x, a.y - b.y, a.z - b.z};
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

inline Vec3 exp(Vec3 a) {
    return Vec3{expf(a.x), expf(a.y), expf(a.z)};
}

constexpr float two_pi = 6.2831855f;
constexpr float inv_pi = 0.31830987f;
constexpr float mu_min = 1.0e-18f;  // cosine of the horizon
// Below this squared sine the azimuth of wo is taken as 0: any azimuth is right there, and the square of
// its reciprocal still fits into a float32.
constexpr float SIN2_MIN = 1.0e-18f;
// wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
// squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
// much longer.
constexpr float LENGTHENED = 1.0995116e12f;
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
// The coat gets at least a tenth as many samples as the base: facets reflect more than the mean surface
// where they are tilted, and this bounds their weight.
constexpr float COAT_SHARE_MIN = 0.1f;
// Added to the weight of a lobe, so that the reciprocal of two black lobes' sum has a finite derivative.
constexpr float LOBE_MIN = 1.0e-12f;
// Flattest direction that a sample leaves in: derivatives by the index fit in a float32 there.
constexpr float LEAVE_MIN = 1.0e-12f;
// Square of the cosine below which exp(-tan^2 / alpha^2) is 0 in any precision, for alpha up to 3.2.
constexpr float COS2_MIN = 1.0e-6f;
// Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
constexpr float RANDOM_MARGIN = 5.9604645e-8f;
// Steps of the rule in weidlich_wilkie_albedo: a Fibonacci number, and the golden ratio.
constexpr float ALBEDO_SAMPLES = 987.0f;
constexpr float GOLDEN = 0.618034f;
// Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
constexpr float HORIZON = 1.0e-6f;

// A sampled direction and its density.
struct WeidlichWilkieSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// Parameters of lambert: Ideal diffuse: the same radiance in every direction. Reciprocal; the albedo
// is rho.
struct WeidlichWilkieBase {
    Vec3 rho;  // albedo, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
};

// weidlich_wilkie: A clear, tinted coat over any base; nest it for more layers. Reciprocal if the base is.
// Exported with interface='rough', distribution='beckmann', masking='cook_torrance', fresnel='exact',
// transmission='half_vector', solid_angle='none', bounces='none', roughness_clamp='on'.
struct WeidlichWilkie {
    float eta;  // index of the coat over that of the medium above it; 1 to 3, default 1.5
    float alpha;  // slope width of the coat's facets; unused when smooth; 0.0001 to 1, default 0.1
    Vec3 sigma_a;  // absorption of the coat per unit of thickness; 0 to 10, default (0, 0, 0)
    float thickness;  // thickness of the coat, in the unit of sigma_a; 0 to 1, default 1
    WeidlichWilkieBase base;  // what lies below; its indices are relative to the coat
};

// What becomes of light at the surface of something denser.
struct WeidlichWilkieEntering {
    float F;  // Is reflected
    float T;  // Enters
};

// Beckmann's facets with the same width in all directions.
struct WeidlichWilkieRoundBeckmann {
    float alpha;  // width of the slopes
};

// Which of two lobes a sample is taken from.
struct WeidlichWilkieChoice {
    bool is_first;  // Whether it is the first one
    Vec2 u;  // Fresh random numbers, made of those that chose
};

// Beckmann's facets: slopes with a normal distribution of variance alpha^2 / 2.
struct WeidlichWilkieBeckmann {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// ---- evaluation ----------------------------------------------------------------------------

// eta^2 - 1.
inline float weidlich_wilkie_contrast(float excess) {
    return excess * (2.0f + excess);
}

// eta^2 cos^2(theta_t) = mu^2 + eta^2 - 1.
inline float weidlich_wilkie_eta2_cos2(float mu, float excess) {
    // mu^2 with its rounding error: at grazing angles little else is left
    return fmaf(mu, mu, weidlich_wilkie_contrast(excess));
}

// The direction inside a layer with eta >= 1 that belongs to w outside.
inline Vec3 weidlich_wilkie_refract(Vec3 w, float excess) {
    return Vec3{w.x, w.y, sqrtf(weidlich_wilkie_eta2_cos2(w.z, excess))} * (1.0f / (1.0f + excess));
}

// exp(-sigma_a d (1 / mu_i + 1 / mu_o)): what is left of light after its way in and out (Bouguer).
//
// wi, wo: refracted directions. sigma_a: absorption per unit of the thickness d.
inline Vec3 weidlich_wilkie_attenuation(Vec3 sigma_a, float thickness, Vec3 wi, Vec3 wo) {
    return exp(-sigma_a * (thickness * ((wi.z + wo.z) / (wi.z * wo.z))));
}

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
inline float weidlich_wilkie_length2(Vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
inline float weidlich_wilkie_cos_half(Vec3 wi, Vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5f * sqrtf(weidlich_wilkie_length2(wi + wo));
}

// eta^2 cos^2(theta_t) = mu^2 + eta^2 - 1; negative where light is reflected totally.
inline float weidlich_wilkie_refracted_cos2(float mu, float eta) {
    // The difference of two squares as a product, and mu^2 with its rounding error: at grazing angles, and at
    // the critical one, little else is left.
    return fmaf(mu, mu, (eta - 1.0f) * (eta + 1.0f));
}

// F and T = 1 - F of a smooth dielectric with eta >= 1 at a cosine mu outside, mu > 0.
inline WeidlichWilkieEntering weidlich_wilkie_split_entering(float mu, float eta) {
    // r_s = (1 - eta^2) / s^2 with s = c + g, and r_p = r_s (c g - sin2) / q with q = c g + sin2. So 1 - r_s^2
    // = 4 c g / s^2, and 1 - r_p^2 = 4 c g eta^2 / (s q)^2. One quotient serves all.
    float c = mu;
    float g = sqrtf(weidlich_wilkie_refracted_cos2(c, eta));
    float s = c + g;
    float p = c * g;
    float sin2 = 1.0f - c * c;
    float q = p + sin2;
    float s2 = s * s;
    float q2 = q * q;
    float inv = 1.0f / (s2 * q2);
    float r_s = (eta - 1.0f) * (eta + 1.0f) * (q2 * inv);
    float F = r_s * r_s * ((p * p + sin2 * sin2) * (s2 * inv));
    return WeidlichWilkieEntering{F, p * inv * (2.0f * (q2 + eta * eta))};
}

// 1 - F of a smooth dielectric with eta >= 1 at a cosine mu outside; exact where it nearly vanishes.
inline float weidlich_wilkie_transmittance_entering(float mu, float eta) {
    return weidlich_wilkie_split_entering(mu, eta).T;
}

// 1 - G of V-grooves, 1 - 4 h.z min(mu_i, mu_o) / |h|^2 with h = wi + wo, exact where G is nearly 1.
//
// To within 1e-7 in float32. Shaders' compilers rearrange sums, and what was carried along would be 0.
inline float weidlich_wilkie_lost_cook_torrance(Vec3 wi, Vec3 wo) {
    Vec3 h = wi + wo;
    float low = fminf(wi.z, wo.z);
    float high = fmaxf(wi.z, wo.z);
    // h.z^2 - 4 h.z low = h.z (high - 3 low); in two steps, both are exact where G is nearly 1
    float rest = high - 2.0f * low - low;
    return fmaxf((h.x * h.x + h.y * h.y + h.z * rest) / weidlich_wilkie_length2(h), 0.0f);
}

// T12 t of Eq. 2 and 4 with lost = 1 - G.
inline float weidlich_wilkie_past_facets(float T, float lost) {
    // 1 - G F would lose the digits of a small T
    return T * (T + lost * (1.0f - T));
}

// T12 t: what the surface lets in and out again.
inline float weidlich_wilkie_transmitted(const WeidlichWilkie& params, Vec3 wi, Vec3 wo) {
    float T = weidlich_wilkie_transmittance_entering(weidlich_wilkie_cos_half(wi, wo), params.eta);
    // Eq. 4
    return weidlich_wilkie_past_facets(T, weidlich_wilkie_lost_cook_torrance(wi, wo));
}

// rho / pi.
inline Vec3 weidlich_wilkie_base_eval_above(const WeidlichWilkieBase& params) {
    return params.rho * inv_pi;
}

// Exact reflectance of a dielectric with eta >= 1, never total, at a cosine outside, mu > 0.
inline float weidlich_wilkie_F_dielectric_entering(float mu, float eta) {
    return weidlich_wilkie_split_entering(mu, eta).F;
}

inline WeidlichWilkieRoundBeckmann weidlich_wilkie_facets(const WeidlichWilkie& params) {
    return WeidlichWilkieRoundBeckmann{params.alpha};
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
inline Vec2 weidlich_wilkie_slopes(Vec3 h) {
    float inv = 1.0f / h.z;
    return Vec2{h.x * inv, h.y * inv};
}

// Squared tangent of that facet's angle.
inline float weidlich_wilkie_tangent2(Vec3 h) {
    Vec2 t = weidlich_wilkie_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
inline float weidlich_wilkie_round_beckmann_D_along(WeidlichWilkieRoundBeckmann round_beckmann,
    Vec3 h) {
    float inv_a2 = 1.0f / (round_beckmann.alpha * round_beckmann.alpha);
    float tan2 = weidlich_wilkie_tangent2(h);
    // The root of D, as 1 / cos^4 leaves a float32 where the exponential is 0
    float root = (1.0f + tan2) * expf(-0.5f * tan2 * inv_a2);
    return inv_pi * inv_a2 * (root * root);
}

// G over 4 mu_i mu_o.
inline float weidlich_wilkie_V_cook_torrance(Vec3 wi, Vec3 wo) {
    Vec3 h = wi + wo;
    return fminf(fminf(h.z / weidlich_wilkie_length2(h) * fminf(wi.z, wo.z), 0.25f) / (wi.z * wo.z),
        V_MAX);
}

// Eq. 2: BRDF value in 1/sr, without the cosine.
inline Vec3 weidlich_wilkie_eval(const WeidlichWilkie& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    Vec3 wi_t = weidlich_wilkie_refract(wi, params.eta - 1.0f);
    Vec3 wo_t = weidlich_wilkie_refract(wo, params.eta - 1.0f);
    Vec3 kept = weidlich_wilkie_attenuation(params.sigma_a, params.thickness, wi_t, wo_t);
    float through = weidlich_wilkie_transmitted(params, wi, wo);
    Vec3 below = weidlich_wilkie_base_eval_above(params.base) * (kept * through);
    float F = weidlich_wilkie_F_dielectric_entering(weidlich_wilkie_cos_half(wi, wo), params.eta);
    float coat = F * weidlich_wilkie_round_beckmann_D_along(weidlich_wilkie_facets(params), wi + wo)
        * weidlich_wilkie_V_cook_torrance(wi, wo);
    return below + coat;
}

// ---- sampling ------------------------------------------------------------------------------

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
inline Vec3 weidlich_wilkie_half_vector(Vec3 wi, Vec3 wo) {
    Vec3 h = LENGTHENED * (wi + wo);
    return h / sqrtf(weidlich_wilkie_length2(h));  // the root is the cosine's as well
}

// A cosine at which light from anywhere meets the facets that it enters by, to choose lobes with.
//
// Halfway between wo.z (the mirror direction) and 1 (wi = wo): at grazing angles tilted facets let in more
// than the mean surface, whose transmittance is nearly 0 there.
inline float weidlich_wilkie_usual_cos_half(Vec3 wo) {
    return 0.5f + 0.5f * wo.z;
}

// The most that weidlich_wilkie_attenuation leaves of light that goes out along wo: it came in along
// the normal.
inline Vec3 weidlich_wilkie_attenuation_least(Vec3 sigma_a, float thickness, Vec3 wo) {
    return weidlich_wilkie_attenuation(sigma_a, thickness, Vec3{0.0f, 0.0f, 1.0f}, wo);
}

// Mean of the three channels, by which lobes are weighed against each other.
inline float weidlich_wilkie_average(Vec3 color) {
    return (color.x + color.y + color.z) / 3.0f;
}

inline float weidlich_wilkie_raised(float probability) {
    return fmaxf(probability, fminf(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
inline Vec2 weidlich_wilkie_lobes_shares(float first, float second) {
    float a = first + BLACK;
    float b = fmaxf(second, WEIGHT_MIN);
    float inv = 1.0f / (a + b);
    float P_first = weidlich_wilkie_raised(a * inv);
    float P_second = weidlich_wilkie_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return Vec2{smaller ? P_first : 1.0f - P_second, smaller ? 1.0f - P_first : P_second};
}

// Probabilities of the coat and of the base: their parts of the light, if the base were white.
inline Vec2 weidlich_wilkie_shares(const WeidlichWilkie& params, Vec3 wo, Vec3 wo_t) {
    float mu = weidlich_wilkie_usual_cos_half(wo);
    float through = weidlich_wilkie_transmittance_entering(mu, params.eta)
        * weidlich_wilkie_average(weidlich_wilkie_attenuation_least(params.sigma_a,
            params.thickness, wo_t));
    float reflected = fmaxf(weidlich_wilkie_F_dielectric_entering(wo.z, params.eta),
        COAT_SHARE_MIN * through + LOBE_MIN);
    return weidlich_wilkie_lobes_shares(reflected, through);
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
inline WeidlichWilkieChoice weidlich_wilkie_choose(float probability, Vec2 u) {
    bool first = u.x < probability;
    float below = u.x / fmaxf(probability, SHARE_MIN);
    float above = (u.x - probability) / fmaxf(1.0f - probability, SHARE_MIN);
    return WeidlichWilkieChoice{first,
        Vec2{fminf(fmaxf(first ? below : above, 0.0f), RANDOM_MAX), u.y}};
}

// A direction with density cos(theta) / pi.
inline Vec3 weidlich_wilkie_sample_cosine(Vec2 u) {
    float r = sqrtf(fmaxf(u.x, 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), sqrtf(fmaxf(1.0f - u.x, 0.0f))};
}

// Density of weidlich_wilkie_sample_cosine in 1/sr, for w above the horizon.
inline float weidlich_wilkie_pdf_cosine(Vec3 w) {
    return w.z * inv_pi;
}

// Cosine-weighted, which is exact here.
inline WeidlichWilkieSample weidlich_wilkie_base_sample(Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return WeidlichWilkieSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    Vec3 wi = weidlich_wilkie_sample_cosine(u);
    return WeidlichWilkieSample{wi, wi.z > mu_min ? weidlich_wilkie_pdf_cosine(wi) : 0.0f};
}

// Cosine inside the layer of the flattest direction that leaves it; 0 for eta <= 1.
inline float weidlich_wilkie_critical_cosine(float excess) {
    return sqrtf(fmaxf(weidlich_wilkie_contrast(excess), 0.0f)) / (1.0f + excess);
}

// The outer direction for a direction inside: refracted, or spread out if it cannot leave.
inline Vec3 weidlich_wilkie_leave(Vec3 w, float excess) {
    float k = weidlich_wilkie_critical_cosine(excess);
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

// weidlich_wilkie_base_sample inside a kernel for a base under layers: the direction in which the light
// leaves them.
//
// wo: inside the lowest layer. excess: the product of the layers' indices, minus 1. Layers over layers
// override it: each calls the next once, whose light refracts as if there were one layer.
inline Vec3 weidlich_wilkie_base_sample_leaving(Vec3 wo, Vec2 u, float excess) {
    return weidlich_wilkie_leave(weidlich_wilkie_base_sample(wo, u).wi, excess);
}

// A normal with density D m.z. Walter et al., Eq. 28 and 29.
inline Vec3 weidlich_wilkie_beckmann_sample(WeidlichWilkieBeckmann beckmann, Vec2 u) {
    float r = sqrtf(fmaxf(-logf(fmaxf(1.0f - u.x, RANDOM_MARGIN)), 0.0f));
    float phi = two_pi * u.y;
    return normalize(Vec3{beckmann.alpha_x * r * cosf(phi), beckmann.alpha_y * r * sinf(phi),
        1.0f});
}

// A normal with density D m.z.
inline Vec3 weidlich_wilkie_round_beckmann_sample(WeidlichWilkieRoundBeckmann round_beckmann,
    Vec2 u) {
    return weidlich_wilkie_beckmann_sample(WeidlichWilkieBeckmann{round_beckmann.alpha,
        round_beckmann.alpha}, u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
inline Vec3 weidlich_wilkie_mirror(Vec3 wo, Vec3 m) {
    return 2.0f * dot(wo, m) * m - wo;
}

// A direction that the coat mirrors.
//
// Visible normals need a G that is no larger than Smith's G1: with Cook-Torrance's the weights would grow
// like alpha / mu_o in the horizon. Those of all normals are at most 2.
inline Vec3 weidlich_wilkie_sample_coat(const WeidlichWilkie& params, Vec3 wo, Vec2 u) {
    return weidlich_wilkie_mirror(wo,
        weidlich_wilkie_round_beckmann_sample(weidlich_wilkie_facets(params), u));
}

// cos(theta_i) / pi.
inline float weidlich_wilkie_base_pdf(Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    return weidlich_wilkie_pdf_cosine(wi);
}

// The inner direction that weidlich_wilkie_leave spreads to w; z = 0 for eta <= 1, which has none.
inline Vec3 weidlich_wilkie_gather(Vec3 w, float excess) {
    float k = weidlich_wilkie_critical_cosine(excess);
    float z = k * w.z;
    float sin2 = w.x * w.x + w.y * w.y;
    float scale = sqrtf(fmaxf(1.0f - z * z, 0.0f)) / sqrtf(fmaxf(sin2, SIN2_MIN));
    bool near = sin2 < SIN2_MIN;  // no azimuth: any is right
    float x = near ? sqrtf(fmaxf(1.0f - z * z, 0.0f)) : w.x * scale;
    return Vec3{x, near ? 0.0f : w.y * scale, z};
}

// Density of weidlich_wilkie_leave at w, from the inner density at w_t = refract(w) and at gather(w).
inline float weidlich_wilkie_pdf_leave(float pdf_refracted, float pdf_gathered, Vec3 w,
    Vec3 w_t, float excess) {
    // Solid angle over cosine-weighted one: 1 / mu. Refraction shrinks the latter by eta^2, gathering by k^2,
    // and the cosines are k mu and mu.
    float eta = 1.0f + excess;
    return pdf_refracted * w.z / (eta * eta * w_t.z)
        + pdf_gathered * weidlich_wilkie_critical_cosine(excess);
}

// Density of weidlich_wilkie_base_sample_leaving at wi, which is outside all layers, in 1/sr.
inline float weidlich_wilkie_base_pdf_leaving(Vec3 wi, Vec3 wo, float excess) {
    Vec3 wi_t = weidlich_wilkie_refract(wi, excess);
    return weidlich_wilkie_pdf_leave(weidlich_wilkie_base_pdf(wi_t, wo),
        weidlich_wilkie_base_pdf(weidlich_wilkie_gather(wi, excess), wo), wi, wi_t, excess);
}

// Density of facets, in 1/sr. Walter et al., Eq. 25.
inline float weidlich_wilkie_round_beckmann_D(WeidlichWilkieRoundBeckmann round_beckmann,
    Vec3 m) {
    float inv_cos2 = 1.0f / fmaxf(m.z * m.z, COS2_MIN);
    float inv_a2 = 1.0f / (round_beckmann.alpha * round_beckmann.alpha);
    float sin2 = m.x * m.x + m.y * m.y;
    return inv_pi * inv_a2 * inv_cos2 * inv_cos2 * expf(-sin2 * inv_cos2 * inv_a2);
}

// Density of weidlich_wilkie_round_beckmann_sample in 1/sr.
inline float weidlich_wilkie_round_beckmann_density(WeidlichWilkieRoundBeckmann round_beckmann,
    Vec3 m) {
    return weidlich_wilkie_round_beckmann_D(round_beckmann, m) * m.z;
}

// |wi + wo| / 2, the same with all digits however short it is: for what is divided by it.
inline float weidlich_wilkie_half_length(Vec3 wi, Vec3 wo) {
    return 0.5f / LENGTHENED * sqrtf(weidlich_wilkie_length2(LENGTHENED * (wi + wo)));
}

// Density of weidlich_wilkie_mirror in 1/sr, if m has the given density and cos_h = wo . m.
inline float weidlich_wilkie_pdf_mirror(float density, float cos_h) {
    // Walter et al., Eq. 14
    return 0.25f * density / cos_h;
}

inline float weidlich_wilkie_pdf_coat(const WeidlichWilkie& params, Vec3 wi, Vec3 wo) {
    float density = weidlich_wilkie_round_beckmann_density(weidlich_wilkie_facets(params),
        weidlich_wilkie_half_vector(wi, wo));
    return weidlich_wilkie_pdf_mirror(density, weidlich_wilkie_half_length(wi, wo));
}

// Density of weidlich_wilkie_sample in 1/sr.
inline float weidlich_wilkie_pdf(const WeidlichWilkie& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    Vec3 wo_t = weidlich_wilkie_refract(wo, params.eta - 1.0f);
    float below = weidlich_wilkie_base_pdf_leaving(wi, wo_t, params.eta - 1.0f);
    Vec2 P = weidlich_wilkie_shares(params, wo, wo_t);
    return P.x * weidlich_wilkie_pdf_coat(params, wi, wo) + P.y * below;
}

// The coat by visible normals or the base below, chosen by what the coat reflects and absorbs.
inline WeidlichWilkieSample weidlich_wilkie_sample(const WeidlichWilkie& params, Vec3 wo,
    Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return WeidlichWilkieSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    Vec3 wo_t = weidlich_wilkie_refract(wo, params.eta - 1.0f);
    WeidlichWilkieChoice choose_result = weidlich_wilkie_choose(weidlich_wilkie_shares(params, wo,
        wo_t).x, u);
    bool on_coat = choose_result.is_first;
    Vec2 v = choose_result.u;
    Vec3 w_base = weidlich_wilkie_base_sample_leaving(wo_t, v, params.eta - 1.0f);
    Vec3 wi = on_coat ? weidlich_wilkie_sample_coat(params, wo, v) : w_base;
    return WeidlichWilkieSample{wi, weidlich_wilkie_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline Vec3 weidlich_wilkie_albedo(const WeidlichWilkie& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    Vec3 w = Vec3{wo.x, wo.y, fmaxf(wo.z, HORIZON)};
    Vec3 total = Vec3{0.0f, 0.0f, 0.0f};
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        Vec2 u = Vec2{(i + 0.5f) / ALBEDO_SAMPLES, fract((i + 0.5f) * GOLDEN)};
        WeidlichWilkieSample drawn = weidlich_wilkie_sample(params, w, u);
        float weight = drawn.pdf > 0.0f ? drawn.wi.z / fmaxf(drawn.pdf, mu_min) : 0.0f;
        total = total + weidlich_wilkie_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}

}  // namespace gonio_weidlich_wilkie
