// SPDX-License-Identifier: Apache-2.0
// QON: the qualitative Oren-Nayar model, the one most renderers mean by "Oren-Nayar".
//
// Source: Oren, Nayar, "Generalization of Lambert's reflectance model", SIGGRAPH 1994, Eq. 30, in the form
// of Portsmouth, Kutz, Hill, "EON", arXiv:2410.18026, Eq. 1 to 9.
//
// C++, made by gonio from gonio/models/qon.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose normal is
// +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// Usage: gonio_qon::Qon params; params.rho = ...; ... gonio_qon::qon_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_qon {

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

inline float dot(Vec3 a, Vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

inline Vec3 normalize(Vec3 a) {
    float inv = 1.0f / sqrtf(a.x * a.x + a.y * a.y + a.z * a.z);
    return Vec3{a.x * inv, a.y * inv, a.z * inv};
}

inline Vec3 operator*(Vec3 a, float b) {
    return Vec3{a.x * b, a.y * b, a.z * b};
}

constexpr float two_pi = 6.2831855f;
constexpr float inv_pi = 0.31830987f;
constexpr float inv_two_pi = 0.15915494f;
constexpr float mu_min = 1.0e-18f;  // cosine of the horizon
// Smallest probability that is divided by: no 0 / 0, and no infinite derivative, in samples that are
// not taken.
constexpr float P_MIN = 1.0e-6f;
// Up to this roughness qon_sample_cltc_matched is cosine sampling. A lobe sheared by d leaves a wedge of
// height r above the horizon to the uniform lobe, which costs a variance of r^2 log(1 / r); that of cosine
// sampling is of order r^2, and the smaller of the two below r = 3e-4.
constexpr float R_COSINE = 1.0e-4f;
// A sample that rounding pushed below the horizon is lifted to this cosine, 1/16 of a float32 epsilon.
constexpr float Z_MIN = 7.450581e-9f;
// Below this squared sine the azimuth of wo is taken as 0: any azimuth is right there, and the square of
// its reciprocal still fits into a float32.
constexpr float SIN2_MIN = 1.0e-18f;

// A sampled direction and its density.
struct QonSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// qon: Rough diffuse, qualitative form. Reciprocal; loses energy; too bright when lit from behind.
struct Qon {
    Vec3 rho;  // single-scattering albedo, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    float sigma;  // standard deviation of the facet angle, radians; 0 to 1.570796, default 0.5
};

// What qon_qualitative_coefficients returns.
struct QonQualitativeCoefficients {
    float A;
    float B;
};

// What qon_coefficients returns.
struct QonCoefficients {
    float a;
    float b;
    float c;
    float d;
};

// ---- evaluation ----------------------------------------------------------------------------

// A and B of Eq. 3. sigma: angle in radians; offset: 0.33, or 0.57 for the footnote's variant.
inline QonQualitativeCoefficients qon_qualitative_coefficients(float sigma, float offset) {
    float s2 = sigma * sigma;
    float A = 1.0f - 0.5f * s2 / (s2 + offset);
    float B = 0.45f * s2 / (s2 + 0.09f);
    return QonQualitativeCoefficients{A, B};
}

// s = cos(phi_i - phi_o) sin(theta_i) sin(theta_o), the inner product of the tangential parts.
//
// It is divided by cosines that may be tiny, so its last bits count: the rounding error of one
// product is carried along (Kahan), which plain wi.x wo.x + wi.y wo.y or dot(wi, wo) - mu_i mu_o loses.
inline float qon_tangential_dot(Vec3 wi, Vec3 wo) {
    float q = wi.y * wo.y;
    float error = fmaf(wi.y, wo.y, -q);
    return fmaf(wi.x, wo.x, q) + error;
}

// s / max(mu_i, mu_o).
inline float qon_s_over_max(float s, Vec3 wi, Vec3 wo) {
    return s / fmaxf(wi.z, wo.z);
}

// s / t of Eq. 4: nothing for s <= 0.
inline float qon_s_over_t_qualitative(float s, Vec3 wi, Vec3 wo) {
    return s > 0.0f ? qon_s_over_max(s, wi, wo) : 0.0f;
}

// Eq. 1: BRDF value in 1/sr, without the cosine.
inline Vec3 qon_eval(const Qon& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    QonQualitativeCoefficients qualitative_coefficients_result =
        qon_qualitative_coefficients(params.sigma, 0.33f);
    float A = qualitative_coefficients_result.A;
    float B = qualitative_coefficients_result.B;
    float s = qon_tangential_dot(wi, wo);
    return params.rho * (inv_pi * (A + B * qon_s_over_t_qualitative(s, wi, wo)));
}

// ---- sampling ------------------------------------------------------------------------------

inline float qon_matched_roughness(float r) {
    return fmaxf(r - R_COSINE, 0.0f);
}

// How many samples qon_sample_cltc_matched gives to the uniform lobe: 0 at r = 0, at most 0.13.
//
// Fitted to the shares of least variance over (mu, r), on condition that the variance stays 4 % below those
// of cosine sampling and of the paper's choice. On average it is 5 % above the least.
inline float qon_matched_share(float mu, float r) {
    float k = 1.0f - mu;
    float steep = 0.0169f + k * (0.2136f + k * (0.445f * k - 0.2345f));
    return r * steep * (1.0f + r * (0.315f * r - 0.602f - 0.5736f * k));
}

// A direction with density 1 / (2 pi).
inline Vec3 qon_sample_uniform(Vec2 u) {
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    float z = 1.0f - u.x;
    float r = sqrtf(fmaxf(u.x * (1.0f + z), 0.0f));
    float phi = two_pi * u.y;
    return Vec3{r * cosf(phi), r * sinf(phi), z};
}

// 1 - w.z, with the digits that w.z has lost beside the normal, where d needs them.
inline float qon_one_minus_cos(Vec3 w) {
    return (w.x * w.x + w.y * w.y) / (1.0f + w.z);
}

// a, b, c, d of M = [[a, 0, b], [0, c, 0], [d, 0, 1]] (Eq. 25, Listing 2) at mu = wo.z, k = 1 - mu.
inline QonCoefficients qon_coefficients(float mu, float k, float r) {
    float a = 1.0f + r * (0.303392f + (-0.518982f + 0.111709f * mu) * mu
        + (-0.276266f + 0.335918f * mu) * r);
    float b = r * (-1.16407f + 1.15859f * mu + (0.150815f - 0.150105f * mu) * r)
        / (mu * mu * mu - 1.43545f);
    float c = 1.0f + (0.20013f + (-0.506373f + 0.261777f * mu) * mu) * r;
    // Numerator and denominator of d nearly vanish at mu = 1: the paper's polynomials in mu,
    // 0.540852 - 1.01625 mu + 0.475392 mu^2 and -1.0743 + 0.0725628 mu + mu^2, are written in k = 1 - mu.
    float d = r * (-6.0e-6f + (0.065466f + 0.475392f * k) * k)
        / (-0.0017372f - (2.0725627f - k) * k);
    return QonCoefficients{a, b, c, d};
}

// Share of the unit disk that clipping keeps (Eq. 28): (1 + cos(theta_P)) / 2.
inline float qon_kept_area(float d) {
    return 0.5f + 0.5f / sqrtf(1.0f + d * d);
}

// Cosine and sine of wo's azimuth; (1, 0) at normal incidence.
inline Vec2 qon_azimuth(Vec3 wo) {
    float sin2 = wo.x * wo.x + wo.y * wo.y;
    bool tilted = sin2 > SIN2_MIN;
    float inv = 1.0f / sqrtf(fmaxf(sin2, SIN2_MIN));
    return Vec2{tilted ? wo.x * inv : 1.0f, tilted ? wo.y * inv : 0.0f};
}

// A direction given relative to an azimuth (cosine, sine), about the normal turned by it.
inline Vec3 qon_from_frame(Vec3 w, Vec2 axis) {
    return Vec3{axis.x * w.x - axis.y * w.y, axis.y * w.x + axis.x * w.y, w.z};
}

// M applied to the cosine lobe's direction above (x, y), turned to wo's azimuth, normalised.
inline Vec3 qon_transform(float x, float y, Vec3 wo, float r, float d) {
    QonCoefficients coefficients_result = qon_coefficients(wo.z, qon_one_minus_cos(wo), r);
    float a = coefficients_result.a;
    float b = coefficients_result.b;
    float c = coefficients_result.c;
    float z = sqrtf(fmaxf(1.0f - x * x - y * y, 0.0f));
    return normalize(qon_from_frame(Vec3{a * x + b * z, c * y, d * x + z}, qon_azimuth(wo)));
}

// Clipped to the directions that M keeps above the horizon (Listing 3).
inline Vec3 qon_sample_cltc(Vec3 wo, float r, Vec2 u) {
    QonCoefficients coefficients_result = qon_coefficients(wo.z, qon_one_minus_cos(wo), r);
    float d = coefficients_result.d;
    float R = sqrtf(fmaxf(u.x, 0.0f));
    float phi = two_pi * u.y;
    float y = R * sinf(phi);
    // A half-disk and a half-ellipse (Heitz 2018); the plane cuts the side on which d x is negative.
    float x = lerp(sqrtf(fmaxf(1.0f - y * y, 0.0f)), R * cosf(phi), qon_kept_area(d));
    Vec3 wi = qon_transform(d < 0.0f ? -x : x, y, wo, r, d);
    return Vec3{wi.x, wi.y, fmaxf(wi.z, Z_MIN)};
}

// CLTC mixed with as much of the uniform hemisphere as the roughness asks for.
inline Vec3 qon_sample_cltc_matched(Vec3 wo, float r, Vec2 u) {
    float q = qon_matched_roughness(r);
    float P_u = qon_matched_share(wo.z, q);
    bool uniform = u.x < P_u;
    float u1 = uniform ? u.x / fmaxf(P_u, P_MIN) : (u.x - P_u) / (1.0f - P_u);
    Vec3 w_u = qon_sample_uniform(Vec2{u1, u.y});
    Vec3 w_c = qon_sample_cltc(wo, q, Vec2{u1, u.y});
    return uniform ? w_u : w_c;
}

// A direction relative to an azimuth (cosine, sine): the inverse of qon_from_frame.
inline Vec3 qon_to_frame(Vec3 w, Vec2 axis) {
    return Vec3{axis.x * w.x + axis.y * w.y, axis.x * w.y - axis.y * w.x, w.z};
}

// Density of qon_transform for an unclipped cosine lobe (Eq. 23 and 24).
inline float qon_cltc_pdf(Vec3 wi, Vec3 wo, float r, float d) {
    QonCoefficients coefficients_result = qon_coefficients(wo.z, qon_one_minus_cos(wo), r);
    float a = coefficients_result.a;
    float b = coefficients_result.b;
    float c = coefficients_result.c;
    Vec3 w = qon_to_frame(wi, qon_azimuth(wo));
    float det = c * (a - b * d);
    // det(M) times the inverse of M, applied to w
    Vec3 h = Vec3{c * (w.x - b * w.z), (a - b * d) * w.y, c * (a * w.z - d * w.x)};
    float inv2 = 1.0f / dot(h, h);
    return inv_pi * det * det * inv2 * inv2 * fmaxf(h.z, 0.0f);
}

// Density of qon_sample_cltc.
inline float qon_pdf_cltc(Vec3 wi, Vec3 wo, float r) {
    QonCoefficients coefficients_result = qon_coefficients(wo.z, qon_one_minus_cos(wo), r);
    float d = coefficients_result.d;
    return qon_cltc_pdf(wi, wo, r, d) / qon_kept_area(d);
}

// Density of qon_sample_cltc_matched.
inline float qon_pdf_cltc_matched(Vec3 wi, Vec3 wo, float r) {
    float q = qon_matched_roughness(r);
    return lerp(qon_pdf_cltc(wi, wo, q), inv_two_pi, qon_matched_share(wo.z, q));
}

// Density of qon_sample in 1/sr.
inline float qon_pdf(const Qon& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    QonQualitativeCoefficients qualitative_coefficients_result =
        qon_qualitative_coefficients(params.sigma, 0.33f);
    float A = qualitative_coefficients_result.A;
    float B = qualitative_coefficients_result.B;
    return qon_pdf_cltc_matched(wi, wo, B / A);
}

// EON's sampler, at the roughness with the same weight of s/t.
inline QonSample qon_sample(const Qon& params, Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return QonSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    QonQualitativeCoefficients qualitative_coefficients_result =
        qon_qualitative_coefficients(params.sigma, 0.33f);
    float A = qualitative_coefficients_result.A;
    float B = qualitative_coefficients_result.B;
    Vec3 wi = qon_sample_cltc_matched(wo, B / A, u);
    return QonSample{wi, qon_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Eq. 8: the integral of s/t (Eq. 4) times the cosine, at a cosine mu in [0, 1]; pi/2 at mu = 0.
inline float qon_G_qualitative(float mu) {
    float s = sqrtf(fmaxf((1.0f - mu) * (1.0f + mu), 0.0f));
    // The paper has tan(theta) (1 - s^3); with 1 - s = mu^2 / (1 + s) the division by mu cancels.
    return s * (acosf(fminf(fmaxf(mu, -1.0f), 1.0f)) - s * mu)
        + 2.0f / 3.0f * s * mu * (1.0f + s + s * s) / (1.0f + s);
}

// Eq. 5.
inline Vec3 qon_albedo(const Qon& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    QonQualitativeCoefficients qualitative_coefficients_result =
        qon_qualitative_coefficients(params.sigma, 0.33f);
    float A = qualitative_coefficients_result.A;
    float B = qualitative_coefficients_result.B;
    return params.rho * (A + B * inv_pi * qon_G_qualitative(wo.z));
}

}  // namespace gonio_qon
