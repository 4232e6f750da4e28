// SPDX-License-Identifier: Apache-2.0
// Oren-Nayar: the full model of 1994, with interreflection.
//
// Source: Oren, Nayar, "Generalization of Lambert's reflectance model", SIGGRAPH 1994, Eq. 27 to 29.
// Deviations: tangents and differences of nearly equal terms are rearranged so that they stay exact at
// grazing angles; the values are the same. Where the value passes through zero on its way to a negative
// one, float32 keeps an absolute accuracy of 1e-6 rho / pi, not a relative one.
//
// C++, made by gonio from gonio/models/oren_nayar.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: gonio_oren_nayar::OrenNayar params; params.rho = ...; ... gonio_oren_nayar::oren_nayar_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_oren_nayar {

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

inline Vec3 operator*(Vec3 a, Vec3 b) {
    return Vec3{a.x * b.x, a.y * b.y, a.z * b.z};
}

inline Vec3 operator*(Vec3 a, float b) {
    return Vec3{a.x * b, a.y * b, a.z * b};
}

inline Vec3 operator/(Vec3 a, float b) {
    return Vec3{a.x / b, a.y / b, a.z / b};
}

constexpr float pi = 3.1415927f;
constexpr float two_pi = 6.2831855f;
constexpr float inv_pi = 0.31830987f;
constexpr float inv_two_pi = 0.15915494f;
constexpr float mu_min = 1.0e-18f;  // cosine of the horizon
// Smallest product of squared sines that is divided by. Directions nearer to the normal have no azimuth
// that matters, and the reciprocal's derivative still fits into a float32.
constexpr float SIN4_MIN = 1.0e-20f;
// Smallest probability that is divided by: no 0 / 0, and no infinite derivative, in samples that are
// not taken.
constexpr float P_MIN = 1.0e-6f;
// Up to this roughness oren_nayar_sample_cltc_matched is cosine sampling. A lobe sheared by d leaves a
// wedge of height r above the horizon to the uniform lobe, which costs a variance of r^2 log(1 / r); that
// of cosine sampling is of order r^2, and the smaller of the two below r = 3e-4.
constexpr float R_COSINE = 1.0e-4f;
// A sample that rounding pushed below the horizon is lifted to this cosine, 1/16 of a float32 epsilon.
constexpr float Z_MIN = 7.450581e-9f;
// Below this squared sine the azimuth of wo is taken as 0: any azimuth is right there, and the square of
// its reciprocal still fits into a float32.
constexpr float SIN2_MIN = 1.0e-18f;
// Steps of the rule in oren_nayar_albedo: a Fibonacci number, and the golden ratio.
constexpr float ALBEDO_SAMPLES = 987.0f;
constexpr float GOLDEN = 0.618034f;
// Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
constexpr float HORIZON = 1.0e-6f;

// A sampled direction and its density.
struct OrenNayarSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// oren_nayar: Rough diffuse from V-shaped grooves, single and double scattering. Reciprocal; loses energy.
struct OrenNayar {
    Vec3 rho;  // albedo of the facets, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    float sigma;  // standard deviation of the facet angle, radians; 0 to 1.570796, default 0.5
};

// What oren_nayar_qualitative_coefficients returns.
struct OrenNayarQualitativeCoefficients {
    float A;
    float B;
};

// What oren_nayar_coefficients returns.
struct OrenNayarCoefficients {
    float a;
    float b;
    float c;
    float d;
};

// ---- evaluation ----------------------------------------------------------------------------

// s = cos(phi_i - phi_o) sin(theta_i) sin(theta_o), the inner product of the tangential parts.
//
// It is divided by cosines that may be tiny, so its last bits count: the rounding error of one
// product is carried along (Kahan), which plain wi.x wo.x + wi.y wo.y or dot(wi, wo) - mu_i mu_o loses.
inline float oren_nayar_tangential_dot(Vec3 wi, Vec3 wo) {
    float q = wi.y * wo.y;
    float error = fmaf(wi.y, wo.y, -q);
    return fmaf(wi.x, wo.x, q) + error;
}

// sin(phi_o - phi_i) sin(theta_i) sin(theta_o), as exact as oren_nayar_tangential_dot.
inline float oren_nayar_tangential_cross(Vec3 wi, Vec3 wo) {
    float q = wi.y * wo.x;
    float error = fmaf(wi.y, wo.x, -q);
    return fmaf(wi.x, wo.y, -q) - error;
}

// Eq. 27 + 29: BRDF value in 1/sr, without the cosine.
inline Vec3 oren_nayar_eval(const OrenNayar& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    float s2 = params.sigma * params.sigma;
    // alpha is the larger, beta the smaller of the two polar angles.
    float cos_alpha = fminf(wi.z, wo.z);
    float cos_beta = fmaxf(wi.z, wo.z);
    float sin2_i = wi.x * wi.x + wi.y * wi.y;
    float sin2_o = wo.x * wo.x + wo.y * wo.y;
    float sin_alpha = sqrtf(fmaxf(fmaxf(sin2_i, sin2_o), mu_min));
    float sin_beta = sqrtf(fmaxf(fminf(sin2_i, sin2_o), mu_min));
    float beta_complement = asinf(fminf(fmaxf(cos_beta, -1.0f), 1.0f));
    float beta = pi / 2.0f - beta_complement;
    float tan_beta = sin_beta / cos_beta;

    // c = cos(phi_i - phi_o), and 1 - |c| from the sine of that angle, which keeps its digits
    float s = oren_nayar_tangential_dot(wi, wo);
    float cross = oren_nayar_tangential_cross(wi, wo);
    float q = sqrtf(fmaxf(sin2_i * sin2_o, SIN4_MIN));
    float c = s / q;
    float one_minus_c = cross / q * (cross / (q + fabsf(s)));

    float C1 = 1.0f - 0.5f * s2 / (s2 + 0.33f);
    // C2 c tan(beta) for c < 0 needs sin(alpha) - (2 beta / pi)^3, in which two ones cancel when both
    // directions graze. With 2 beta / pi = 1 - delta they are gone.
    float delta = 2.0f * inv_pi * beta_complement;
    float dip = delta * (3.0f - delta * (3.0f - delta))
        - cos_alpha * cos_alpha / (1.0f + sin_alpha);
    float C2 = 0.45f * s2 / (s2 + 0.09f) * (s >= 0.0f ? sin_alpha : dip);
    float four_alpha_beta = 4.0f * inv_pi * inv_pi * acosf(fminf(fmaxf(cos_alpha, -1.0f), 1.0f))
        * beta;
    float C3 = 0.125f * s2 / (s2 + 0.09f) * four_alpha_beta * four_alpha_beta;
    float tan_half = (sin_alpha + sin_beta) / (cos_alpha + cos_beta);
    float L1 = C1 + c * C2 * tan_beta + one_minus_c * C3 * tan_half;

    float two_beta = 2.0f * inv_pi * beta;
    float L2 = 0.17f * s2 / (s2 + 0.13f) * (1.0f - c * two_beta * two_beta);
    return params.rho * (inv_pi * L1) + params.rho * params.rho * (inv_pi * L2);
}

// ---- sampling ------------------------------------------------------------------------------

// A and B of Eq. 3. sigma: angle in radians; offset: 0.33, or 0.57 for the footnote's variant.
inline OrenNayarQualitativeCoefficients oren_nayar_qualitative_coefficients(float sigma,
    float offset) {
    float s2 = sigma * sigma;
    float A = 1.0f - 0.5f * s2 / (s2 + offset);
    float B = 0.45f * s2 / (s2 + 0.09f);
    return OrenNayarQualitativeCoefficients{A, B};
}

inline float oren_nayar_matched_roughness(float r) {
    return fmaxf(r - R_COSINE, 0.0f);
}

// How many samples oren_nayar_sample_cltc_matched gives to the uniform lobe: 0 at r = 0, at most 0.13.
//
// Fitted to the shares of least variance over (mu, r), on condition that the variance stays 4 %
// below those of cosine sampling and of the paper's choice. On average it is 5 % above the least.
inline float oren_nayar_matched_share(float mu, float r) {
    float k = 1.0f - mu;
    float steep = 0.0169f + k * (0.2136f + k * (0.445f * k - 0.2345f));
    return r * steep * (1.0f + r * (0.315f * r - 0.602f - 0.5736f * k));
}

// A direction with density 1 / (2 pi).
inline Vec3 oren_nayar_sample_uniform(Vec2 u) {
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    float z = 1.0f - u.x;
    float r = sqrtf(fmaxf(u.x * (1.0f + z), 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), z};
}

// 1 - w.z, with the digits that w.z has lost beside the normal, where d needs them.
inline float oren_nayar_one_minus_cos(Vec3 w) {
    return (w.x * w.x + w.y * w.y) / (1.0f + w.z);
}

// a, b, c, d of M = [[a, 0, b], [0, c, 0], [d, 0, 1]] (Eq. 25, Listing 2) at mu = wo.z, k = 1 - mu.
inline OrenNayarCoefficients oren_nayar_coefficients(float mu, float k, float r) {
    float a = 1.0f + r * (0.303392f + (-0.518982f + 0.111709f * mu) * mu
        + (-0.276266f + 0.335918f * mu) * r);
    float b = r * (-1.16407f + 1.15859f * mu + (0.150815f - 0.150105f * mu) * r)
        / (mu * mu * mu - 1.43545f);
    float c = 1.0f + (0.20013f + (-0.506373f + 0.261777f * mu) * mu) * r;
    // Numerator and denominator of d nearly vanish at mu = 1: the paper's polynomials in mu,
    // 0.540852 - 1.01625 mu + 0.475392 mu^2 and -1.0743 + 0.0725628 mu + mu^2, are written in k = 1 - mu.
    float d = r * (-6.0e-6f + (0.065466f + 0.475392f * k) * k)
        / (-0.0017372f - (2.0725627f - k) * k);
    return OrenNayarCoefficients{a, b, c, d};
}

// Share of the unit disk that clipping keeps (Eq. 28): (1 + cos(theta_P)) / 2.
inline float oren_nayar_kept_area(float d) {
    return 0.5f + 0.5f / sqrtf(1.0f + d * d);
}

// Cosine and sine of wo's azimuth; (1, 0) at normal incidence.
inline Vec2 oren_nayar_azimuth(Vec3 wo) {
    float sin2 = wo.x * wo.x + wo.y * wo.y;
    bool tilted = sin2 > SIN2_MIN;
    float inv = 1.0f / sqrtf(fmaxf(sin2, SIN2_MIN));
    return Vec2{tilted ? wo.x * inv : 1.0f, tilted ? wo.y * inv : 0.0f};
}

// A direction given relative to an azimuth (cosine, sine), about the normal turned by it.
inline Vec3 oren_nayar_from_frame(Vec3 w, Vec2 axis) {
    return Vec3{axis.x * w.x - axis.y * w.y, axis.y * w.x + axis.x * w.y, w.z};
}

// M applied to the cosine lobe's direction above (x, y), turned to wo's azimuth, normalised.
inline Vec3 oren_nayar_transform(float x, float y, Vec3 wo, float r, float d) {
    OrenNayarCoefficients coefficients_result = oren_nayar_coefficients(wo.z,
        oren_nayar_one_minus_cos(wo), r);
    float a = coefficients_result.a;
    float b = coefficients_result.b;
    float c = coefficients_result.c;
    float z = sqrtf(fmaxf(1.0f - x * x - y * y, 0.0f));
    return normalize(oren_nayar_from_frame(Vec3{a * x + b * z, c * y, d * x + z},
        oren_nayar_azimuth(wo)));
}

// Clipped to the directions that M keeps above the horizon (Listing 3).
inline Vec3 oren_nayar_sample_cltc(Vec3 wo, float r, Vec2 u) {
    OrenNayarCoefficients coefficients_result = oren_nayar_coefficients(wo.z,
        oren_nayar_one_minus_cos(wo), r);
    float d = coefficients_result.d;
    float R = sqrtf(fmaxf(u.x, 0.0f));
    float phi = two_pi * u.y;
    float y = R * sinf(phi);
    // A half-disk and a half-ellipse (Heitz 2018); the plane cuts the side on which d x is negative.
    float x = lerp(sqrtf(fmaxf(1.0f - y * y, 0.0f)), R * cosf(phi), oren_nayar_kept_area(d));
    Vec3 wi = oren_nayar_transform(d < 0.0f ? -x : x, y, wo, r, d);
    return Vec3{wi.x, wi.y, fmaxf(wi.z, Z_MIN)};
}

// CLTC mixed with as much of the uniform hemisphere as the roughness asks for.
inline Vec3 oren_nayar_sample_cltc_matched(Vec3 wo, float r, Vec2 u) {
    float q = oren_nayar_matched_roughness(r);
    float P_u = oren_nayar_matched_share(wo.z, q);
    bool uniform = u.x < P_u;
    float u1 = uniform ? u.x / fmaxf(P_u, P_MIN) : (u.x - P_u) / (1.0f - P_u);
    Vec3 w_u = oren_nayar_sample_uniform(Vec2{u1, u.y});
    Vec3 w_c = oren_nayar_sample_cltc(wo, q, Vec2{u1, u.y});
    return uniform ? w_u : w_c;
}

// A direction relative to an azimuth (cosine, sine): the inverse of oren_nayar_from_frame.
inline Vec3 oren_nayar_to_frame(Vec3 w, Vec2 axis) {
    return Vec3{axis.x * w.x + axis.y * w.y, axis.x * w.y - axis.y * w.x, w.z};
}

// Density of oren_nayar_transform for an unclipped cosine lobe (Eq. 23 and 24).
inline float oren_nayar_cltc_pdf(Vec3 wi, Vec3 wo, float r, float d) {
    OrenNayarCoefficients coefficients_result = oren_nayar_coefficients(wo.z,
        oren_nayar_one_minus_cos(wo), r);
    float a = coefficients_result.a;
    float b = coefficients_result.b;
    float c = coefficients_result.c;
    Vec3 w = oren_nayar_to_frame(wi, oren_nayar_azimuth(wo));
    float det = c * (a - b * d);
    // det(M) times the inverse of M, applied to w
    Vec3 h = Vec3{c * (w.x - b * w.z), (a - b * d) * w.y, c * (a * w.z - d * w.x)};
    float inv2 = 1.0f / dot(h, h);
    return inv_pi * det * det * inv2 * inv2 * fmaxf(h.z, 0.0f);
}

// Density of oren_nayar_sample_cltc.
inline float oren_nayar_pdf_cltc(Vec3 wi, Vec3 wo, float r) {
    OrenNayarCoefficients coefficients_result = oren_nayar_coefficients(wo.z,
        oren_nayar_one_minus_cos(wo), r);
    float d = coefficients_result.d;
    return oren_nayar_cltc_pdf(wi, wo, r, d) / oren_nayar_kept_area(d);
}

// Density of oren_nayar_sample_cltc_matched.
inline float oren_nayar_pdf_cltc_matched(Vec3 wi, Vec3 wo, float r) {
    float q = oren_nayar_matched_roughness(r);
    return lerp(oren_nayar_pdf_cltc(wi, wo, q), inv_two_pi, oren_nayar_matched_share(wo.z, q));
}

// Density of oren_nayar_sample in 1/sr.
inline float oren_nayar_pdf(const OrenNayar& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    OrenNayarQualitativeCoefficients qualitative_coefficients_result =
        oren_nayar_qualitative_coefficients(params.sigma, 0.33f);
    float A = qualitative_coefficients_result.A;
    float B = qualitative_coefficients_result.B;
    return oren_nayar_pdf_cltc_matched(wi, wo, B / A);
}

// EON's sampler, at the roughness that fits the qualitative model.
inline OrenNayarSample oren_nayar_sample(const OrenNayar& params, Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return OrenNayarSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    OrenNayarQualitativeCoefficients qualitative_coefficients_result =
        oren_nayar_qualitative_coefficients(params.sigma, 0.33f);
    float A = qualitative_coefficients_result.A;
    float B = qualitative_coefficients_result.B;
    Vec3 wi = oren_nayar_sample_cltc_matched(wo, B / A, u);
    return OrenNayarSample{wi, oren_nayar_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline Vec3 oren_nayar_albedo(const OrenNayar& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    Vec3 w = Vec3{wo.x, wo.y, fmaxf(wo.z, HORIZON)};
    Vec3 total = Vec3{0.0f, 0.0f, 0.0f};
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        Vec2 u = Vec2{(i + 0.5f) / ALBEDO_SAMPLES, fract((i + 0.5f) * GOLDEN)};
        OrenNayarSample drawn = oren_nayar_sample(params, w, u);
        float weight = drawn.pdf > 0.0f ? drawn.wi.z / fmaxf(drawn.pdf, mu_min) : 0.0f;
        total = total + oren_nayar_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}

}  // namespace gonio_oren_nayar
