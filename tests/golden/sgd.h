// SPDX-License-Identifier: Apache-2.0
// SGD: the shifted gamma distribution of facets, which was fitted to a hundred measured materials.
//
// Source: Bagher, Soler, Holzschuch, "Accurate fitting of measured reflectances using a shifted gamma
// micro-facet distribution", Computer Graphics Forum 31(4), 2012. Every number has three channels; K, the
// masking and F are free of each other, as in the published fits. Deviations: c (theta - theta_0)^k is
// ((theta - theta_0) / width)^k with width = c^(-1/k), as c of some fits is above 10^100; F and G are never
// below 0.
//
// C++, made by gonio from gonio/models/sgd.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: gonio_sgd::Sgd params; params.rho = ...; ... gonio_sgd::sgd_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_sgd {

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

inline Vec3 select(Bool3 c, Vec3 yes, Vec3 no) {
    return Vec3{c.x ? yes.x : no.x, c.y ? yes.y : no.y, c.z ? yes.z : no.z};
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

inline Vec3 operator/(Vec3 a, float b) {
    return Vec3{a.x / b, a.y / b, a.z / b};
}

inline Vec3 operator/(float a, Vec3 b) {
    return Vec3{a / b.x, a / b.y, a / b.z};
}

inline Bool3 operator>(Vec3 a, Vec3 b) {
    return Bool3{a.x > b.x, a.y > b.y, a.z > b.z};
}

inline Vec3 minimum(Vec3 a, Vec3 b) {
    return Vec3{fminf(a.x, b.x), fminf(a.y, b.y), fminf(a.z, b.z)};
}

inline Vec3 maximum(Vec3 a, Vec3 b) {
    return Vec3{fmaxf(a.x, b.x), fmaxf(a.y, b.y), fmaxf(a.z, b.z)};
}

inline Vec3 clamp(Vec3 a, Vec3 b, Vec3 c) {
    return Vec3{fminf(fmaxf(a.x, b.x), c.x), fminf(fmaxf(a.y, b.y), c.y), fminf(fmaxf(a.z, b.z), c.z)};
}

inline Vec3 exp(Vec3 a) {
    return Vec3{expf(a.x), expf(a.y), expf(a.z)};
}

inline Vec3 log(Vec3 a) {
    return Vec3{logf(a.x), logf(a.y), logf(a.z)};
}

// wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
// squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
// much longer.
constexpr float LENGTHENED = 1.0995116e12f;
// Steps of the rule in sgd_albedo: a Fibonacci number, and the golden ratio.
constexpr float ALBEDO_SAMPLES = 987.0f;
constexpr float GOLDEN = 0.618034f;
// Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
constexpr float HORIZON = 1.0e-6f;
// 2 atan(v) / v in v^2 on [0, 1]; fitted, relative error below 2e-8.
constexpr float ATAN_0 = 2.0f;
constexpr float ATAN_1 = -0.66666144f;
constexpr float ATAN_2 = 0.3998524f;
constexpr float ATAN_3 = -0.28407288f;
constexpr float ATAN_4 = 0.21281867f;
constexpr float ATAN_5 = -0.15008585f;
constexpr float ATAN_6 = 0.085383f;
constexpr float ATAN_7 = -0.03213723f;
constexpr float ATAN_8 = 0.005699773f;
// Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
constexpr float LOG1P_SMALL = 0.25f;
// Below this the series needs few terms; above, the plain difference is exact to 2e-7 in float32.
constexpr float EXPM1_SMALL = 0.3f;
// Nearer to 1 than this, 1 - p is taken as this: what is divided by it differs by as little.
constexpr float POWER_MIN = 1.0e-4f;
// Largest x of exp(x) in the masking, where G of all fits is 0 before; and the smallest, where 1.8e-35 of
// Lambda changes no G and still is a normal float32.
constexpr float LOG_MAX = 3.0f;
constexpr float LOG_MIN = -80.0f;
// Largest squared slope over alpha, where D is 0 in every precision.
constexpr float SLOPE_MAX = 10000.0f;
// Largest 1 / (mu_i mu_o), at cosines of 1e-4: times D and its derivatives it still is a float32.
constexpr float V_SGD = 1.0e8f;
// Angles and squared cosines below which a logarithm or quotient leaves a float32.
constexpr float ANGLE_MIN = 1.0e-12f;
constexpr float COS2_MIN = 1.0e-30f;
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

// A sampled direction and its density.
struct SgdSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// sgd: Paints, metals and plastics as they were measured; the default is a gold paint. Reciprocal.
struct Sgd {
    Vec3 rho;  // diffuse albedo, linear RGB; 0 to 1, default (0.147708, 0.0806975, 0.033172)
    // weight of the highlight, linear RGB; 0 to 10, default (0.160592, 0.217282, 0.236425)
    Vec3 specular;
    // shift, and width of the squared slopes; 1e-05 to 1, default (0.122506, 0.108069, 0.12187)
    Vec3 alpha;
    Vec3 p;  // power of the distribution's tail; 0 to 2, default (0.795078, 0.637578, 0.936117)
    Vec3 f0;  // F's constant; 0 to 10, default (0, 0, 0.0024589)
    // F's slope: f0 - f1 at normal incidence; -2 to 10, default (-0.596835, -0.331147, -0.140729)
    Vec3 f1;
    // K: 1 / (alpha Gamma(1 - p, alpha)) where D is normalized; 0 to 100000, default (5.98176,
    // 7.35539, 5.29722)
    Vec3 normalization;
    Vec3 masking_strength;  // Lambda; 0 to 1e+08, default (2.64832, 3.04253, 2.3013)
    // theta_0 in radians: G is 1 up to there; -1 to 1.5, default (-0.284195, -0.277297, -0.245352)
    Vec3 masking_angle;
    // c^(-1/k): radians from there on; 0.01 to 100, default (1.943735, 1.94587, 1.890624)
    Vec3 masking_width;
    // k: how suddenly masking begins; 1 to 1000, default (24.3593, 24.4037, 25.3623)
    Vec3 masking_exponent;
};

// Densities of one channel's facets for samples: s^-p up to s = 1, and exp(1 - s) beyond.
//
// s is alpha + tan^2 / alpha. The distribution itself, s^-p exp(-s), has no inverse; it is at most the one
// for samples, and at least a third of that before s = 1.
struct SgdShiftedGamma {
    float alpha;  // Shift, and width of the squared slopes
    float p;  // Power of the tail
};

// Which of two lobes a sample is taken from.
struct SgdChoice {
    bool is_first;  // Whether it is the first one
    Vec2 u;  // Fresh random numbers, made of those that chose
};

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
inline float sgd_length2(Vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
inline Vec3 sgd_half_vector(Vec3 wi, Vec3 wo) {
    Vec3 h = LENGTHENED * (wi + wo);
    return h / sqrtf(sgd_length2(h));  // the root is the cosine's as well
}

// 2 atan(v) / v for v in [-1, 1], the angle whose half has the tangent v; 2 at v = 0.
inline float sgd_twice_atan_over(float v) {
    float q = v * v;
    float p = ATAN_4 + q * (ATAN_5 + q * (ATAN_6 + q * (ATAN_7 + q * ATAN_8)));
    return ATAN_0 + q * (ATAN_1 + q * (ATAN_2 + q * (ATAN_3 + q * p)));
}

// exp(x) - 1, exact where x is small.
inline float sgd_expm1(float x) {
    float near = fmaxf(fminf(x, EXPM1_SMALL), -EXPM1_SMALL);
    // Taylor's series
    float over = 1.0f + near
        * (0.5f + near * (0.16666667f
            + near * (0.041666668f
                + near * (0.008333334f + near * (0.0013888889f + near * 0.0001984127f)))));
    return x > -EXPM1_SMALL && x < EXPM1_SMALL ? near * over : expf(x) - 1.0f;
}

// 1 + Lambda (1 - exp(((theta - theta_0) / width)^k)).
inline Vec3 sgd_G(const Sgd& params, Vec3 w) {
    float v = sqrtf(w.x * w.x + w.y * w.y) / (1.0f + w.z);
    Vec3 beyond = v * sgd_twice_atan_over(v) - params.masking_angle;
    Vec3 x = log(maximum(beyond, splat(ANGLE_MIN))) - log(params.masking_width);
    Vec3 t = maximum(minimum(params.masking_exponent * x, splat(LOG_MAX)), splat(LOG_MIN));
    // expm1 of each channel
    Vec3 lost = exp(t);
    Vec3 masked = params.masking_strength
        * Vec3{sgd_expm1(lost.x), sgd_expm1(lost.y), sgd_expm1(lost.z)};
    return select(beyond > splat(0.0f), clamp(1.0f - masked, splat(0.0f), splat(1.0f)),
        splat(1.0f));
}

// K s^-p exp(-s) / cos^4 with s = alpha + tan^2 / alpha.
inline Vec3 sgd_D(const Sgd& params, Vec3 m) {
    float z2 = fmaxf(m.z * m.z, COS2_MIN);
    Vec3 s = params.alpha + minimum((m.x * m.x + m.y * m.y) / z2 / params.alpha, splat(SLOPE_MAX));
    return params.normalization * exp(-params.p * log(s) - s - 2.0f * logf(z2));
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
inline float sgd_cos_half(Vec3 wi, Vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5f * sqrtf(sgd_length2(wi + wo));
}

// Schlick's with a slope.
inline Vec3 sgd_F(const Sgd& params, float cos_h) {
    float c = 1.0f - fminf(cos_h, 1.0f);
    float c5 = c * c * (c * c) * c;
    return maximum(params.f0 - params.f1 * cos_h + (1.0f - params.f0) * c5, splat(0.0f));
}

// rho / pi + specular / pi F D G / (mu_i mu_o): BRDF value in 1/sr, without the cosine.
inline Vec3 sgd_eval(const Sgd& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    Vec3 m = sgd_half_vector(wi, wo);
    Vec3 G = sgd_G(params, wi) * sgd_G(params, wo);
    Vec3 D = sgd_D(params, m) * fminf(1.0f / wi.z / wo.z, V_SGD);
    return inv_pi * (params.rho + params.specular * sgd_F(params, sgd_cos_half(wi, wo)) * (G * D));
}

// ---- sampling ------------------------------------------------------------------------------

// The facets of a channel.
inline SgdShiftedGamma sgd_red(const Sgd& params) {
    return SgdShiftedGamma{params.alpha.x, params.p.x};
}

// 1 - p, not quite 0.
inline float sgd_shifted_gamma_one_less(SgdShiftedGamma shifted_gamma) {
    float q = 1.0f - shifted_gamma.p;
    return q < 0.0f ? fminf(q, -POWER_MIN) : fmaxf(q, POWER_MIN);
}

// The integral of s^-p from alpha to 1; that of the rest is 1.
inline float sgd_shifted_gamma_near(SgdShiftedGamma shifted_gamma) {
    float q = sgd_shifted_gamma_one_less(shifted_gamma);
    return -sgd_expm1(q * logf(shifted_gamma.alpha)) / q;
}

// The facets of a channel.
inline SgdShiftedGamma sgd_green(const Sgd& params) {
    return SgdShiftedGamma{params.alpha.y, params.p.y};
}

// The facets of a channel.
inline SgdShiftedGamma sgd_blue(const Sgd& params) {
    return SgdShiftedGamma{params.alpha.z, params.p.z};
}

// Mean of the three channels, by which lobes are weighed against each other.
inline float sgd_average(Vec3 color) {
    return (color.x + color.y + color.z) / 3.0f;
}

inline float sgd_raised(float probability) {
    return fmaxf(probability, fminf(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
inline Vec2 sgd_lobes_shares(float first, float second) {
    float a = first + BLACK;
    float b = fmaxf(second, WEIGHT_MIN);
    float inv = 1.0f / (a + b);
    float P_first = sgd_raised(a * inv);
    float P_second = sgd_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return Vec2{smaller ? P_first : 1.0f - P_second, smaller ? 1.0f - P_first : P_second};
}

// Probabilities of the diffuse part and of the highlight, as if it was a mirror.
inline Vec2 sgd_shares(const Sgd& params, Vec3 wo) {
    Vec3 near = Vec3{sgd_shifted_gamma_near(sgd_red(params)),
        sgd_shifted_gamma_near(sgd_green(params)), sgd_shifted_gamma_near(sgd_blue(params))};
    Vec3 mass = params.normalization * params.alpha * (near + 1.0f);
    return sgd_lobes_shares(sgd_average(params.rho),
        4.0f * sgd_average(params.specular * sgd_F(params, wo.z) * mass));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
inline SgdChoice sgd_choose(float probability, Vec2 u) {
    bool first = u.x < probability;
    float below = u.x / fmaxf(probability, SHARE_MIN);
    float above = (u.x - probability) / fmaxf(1.0f - probability, SHARE_MIN);
    return SgdChoice{first, Vec2{fminf(fmaxf(first ? below : above, 0.0f), RANDOM_MAX), u.y}};
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
inline float sgd_atanh_over(float y) {
    float y2 = y * y;
    return 1.0f + y2 * (1.0f / 3.0f + y2 * (1.0f / 5.0f + y2 * (1.0f / 7.0f + y2 * (1.0f / 9.0f))));
}

// log(1 + x) / x for x > -1; 1 at x = 0.
inline float sgd_log1p_over(float x) {
    float near = fmaxf(fminf(x, LOG1P_SMALL), -LOG1P_SMALL);
    bool small = x > -LOG1P_SMALL && x < LOG1P_SMALL;
    float far = small ? 1.0f : x;
    float series = sgd_atanh_over(near / (2.0f + near));
    return small ? 2.0f / (2.0f + near) * series : logf(1.0f + far) / far;
}

// log(1 + x) for x > -1, exact where x is small.
inline float sgd_log1p(float x) {
    return x * sgd_log1p_over(x);
}

// A normal.
inline Vec3 sgd_shifted_gamma_sample(SgdShiftedGamma shifted_gamma, Vec2 u) {
    float near = sgd_shifted_gamma_near(shifted_gamma);
    float q = sgd_shifted_gamma_one_less(shifted_gamma);
    float v = u.x * (near + 1.0f);
    bool inside = v < near;
    // s = alpha (1 + q v alpha^-q)^(1/q), less alpha
    float grown = sgd_log1p(q * fminf(v, near) * expf(-q * logf(shifted_gamma.alpha))) / q;
    float x = shifted_gamma.alpha * sgd_expm1(grown);
    float far = 1.0f - shifted_gamma.alpha - logf(fmaxf(1.0f + near - v, ANGLE_MIN));
    float tangent = sqrtf(shifted_gamma.alpha * fmaxf(inside ? x : far, 0.0f));
    float phi = two_pi * u.y;
    return normalize(Vec3{tangent * cosf(phi), tangent * sinf(phi), 1.0f});
}

// A direction with density cos(theta) / pi.
inline Vec3 sgd_sample_cosine(Vec2 u) {
    float r = sqrtf(fmaxf(u.x, 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), sqrtf(fmaxf(1.0f - u.x, 0.0f))};
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
inline Vec3 sgd_mirror(Vec3 wo, Vec3 m) {
    return 2.0f * dot(wo, m) * m - wo;
}

// Of normals in 1/sr.
inline float sgd_shifted_gamma_density(SgdShiftedGamma shifted_gamma, Vec3 m) {
    float z2 = fmaxf(m.z * m.z, COS2_MIN);
    float x = fminf((m.x * m.x + m.y * m.y) / z2 / shifted_gamma.alpha, SLOPE_MAX);
    float s = shifted_gamma.alpha + x;
    float tail = s < 1.0f ? expf(-shifted_gamma.p * logf(fminf(s, 1.0f)))
        : expf(fminf(1.0f - s, 0.0f));
    return inv_pi * tail / ((sgd_shifted_gamma_near(shifted_gamma) + 1.0f) * shifted_gamma.alpha)
        / z2 * (m.z / z2);
}

// Density of sgd_sample_cosine in 1/sr, for w above the horizon.
inline float sgd_pdf_cosine(Vec3 w) {
    return w.z * inv_pi;
}

// |wi + wo| / 2, the same with all digits however short it is: for what is divided by it.
inline float sgd_half_length(Vec3 wi, Vec3 wo) {
    return 0.5f / LENGTHENED * sqrtf(sgd_length2(LENGTHENED * (wi + wo)));
}

// Density of sgd_mirror in 1/sr, if m has the given density and cos_h = wo . m.
inline float sgd_pdf_mirror(float density, float cos_h) {
    // Walter et al., Eq. 14
    return 0.25f * density / cos_h;
}

// Density of sgd_sample in 1/sr.
inline float sgd_pdf(const Sgd& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    Vec2 P = sgd_shares(params, wo);
    Vec3 m = sgd_half_vector(wi, wo);
    float facets = sgd_shifted_gamma_density(sgd_red(params), m)
        + sgd_shifted_gamma_density(sgd_green(params), m);
    facets = (facets + sgd_shifted_gamma_density(sgd_blue(params), m)) / 3.0f;
    return P.x * sgd_pdf_cosine(wi) + P.y * sgd_pdf_mirror(facets, sgd_half_length(wi, wo));
}

// Cosine-weighted, or wo mirrored at a normal of one of the channels.
inline SgdSample sgd_sample(const Sgd& params, Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return SgdSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    SgdChoice choose_result = sgd_choose(sgd_shares(params, wo).x, u);
    bool matte = choose_result.is_first;
    Vec2 v = choose_result.u;
    float thirds = 3.0f * v.x;
    Vec2 w = Vec2{fract(thirds), v.y};
    Vec3 m = sgd_shifted_gamma_sample(sgd_red(params), w);
    m = thirds < 1.0f ? m : sgd_shifted_gamma_sample(sgd_green(params), w);
    m = thirds < 2.0f ? m : sgd_shifted_gamma_sample(sgd_blue(params), w);
    Vec3 wi = matte ? sgd_sample_cosine(v) : sgd_mirror(wo, m);
    return SgdSample{wi, sgd_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline Vec3 sgd_albedo(const Sgd& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    Vec3 w = Vec3{wo.x, wo.y, fmaxf(wo.z, HORIZON)};
    Vec3 total = Vec3{0.0f, 0.0f, 0.0f};
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        Vec2 u = Vec2{(i + 0.5f) / ALBEDO_SAMPLES, fract((i + 0.5f) * GOLDEN)};
        SgdSample drawn = sgd_sample(params, w, u);
        float weight = drawn.pdf > 0.0f ? drawn.wi.z / fmaxf(drawn.pdf, mu_min) : 0.0f;
        total = total + sgd_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}

}  // namespace gonio_sgd
