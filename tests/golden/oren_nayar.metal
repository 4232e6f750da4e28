// SPDX-License-Identifier: Apache-2.0
// Oren-Nayar: the full model of 1994, with interreflection.
//
// Source: Oren, Nayar, "Generalization of Lambert's reflectance model", SIGGRAPH 1994, Eq. 27 to 29.
// Deviations: tangents and differences of nearly equal terms are rearranged so that they stay exact at
// grazing angles; the values are the same. Where the value passes through zero on its way to a negative
// one, float32 keeps an absolute accuracy of 1e-6 rho / pi, not a relative one.
//
// Metal, made by gonio from gonio/models/oren_nayar.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: OrenNayar params; params.rho = ...; ... oren_nayar_eval(params, wi, wo)

#include <metal_stdlib>
using namespace metal;

// A sampled direction and its density.
struct OrenNayarSample {
    float3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// oren_nayar: Rough diffuse from V-shaped grooves, single and double scattering. Reciprocal; loses energy.
struct OrenNayar {
    float3 rho;  // albedo of the facets, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
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

// 2 atan(v) / v for v in [-1, 1], the angle whose half has the tangent v; 2 at v = 0.
inline float oren_nayar_twice_atan_over(float v) {
    const float ATAN_0 = 2.0;  // 2 atan(v) / v in v^2 on [0, 1]; fitted, relative error below 2e-8.
    const float ATAN_1 = -0.66666144;
    const float ATAN_2 = 0.3998524;
    const float ATAN_3 = -0.28407288;
    const float ATAN_4 = 0.21281867;
    const float ATAN_5 = -0.15008585;
    const float ATAN_6 = 0.085383;
    const float ATAN_7 = -0.03213723;
    const float ATAN_8 = 0.005699773;
    float q = v * v;
    float p = ATAN_4 + q * (ATAN_5 + q * (ATAN_6 + q * (ATAN_7 + q * ATAN_8)));
    return ATAN_0 + q * (ATAN_1 + q * (ATAN_2 + q * (ATAN_3 + q * p)));
}

// Arc sine of x limited to [-1, 1]: twice the angle whose tangent is x / (1 + cos).
inline float oren_nayar_safe_asin(float x) {
    float c = sqrt(max((1.0 - x) * (1.0 + x), 0.0));
    float v = clamp(x / (1.0 + c), -1.0, 1.0);
    return v * oren_nayar_twice_atan_over(v);
}

// s = cos(phi_i - phi_o) sin(theta_i) sin(theta_o), the inner product of the tangential parts.
//
// It is divided by cosines that may be tiny, so its last bits count: the rounding error of one
// product is carried along (Kahan), which plain wi.x wo.x + wi.y wo.y or dot(wi, wo) - mu_i mu_o loses.
inline float oren_nayar_tangential_dot(float3 wi, float3 wo) {
    float q = wi.y * wo.y;
    float error = fma(wi.y, wo.y, -q);
    return fma(wi.x, wo.x, q) + error;
}

// sin(phi_o - phi_i) sin(theta_i) sin(theta_o), as exact as oren_nayar_tangential_dot.
inline float oren_nayar_tangential_cross(float3 wi, float3 wo) {
    float q = wi.y * wo.x;
    float error = fma(wi.y, wo.x, -q);
    return fma(wi.x, wo.y, -q) - error;
}

// Arc cosine of x limited to [-1, 1]: twice the angle whose tangent is sin / (1 + x).
inline float oren_nayar_safe_acos(float x) {
    const float pi = 3.1415927;
    float a = min(abs(x), 1.0);
    float v = sqrt(max((1.0 - a) * (1.0 + a), 0.0)) / (1.0 + a);
    float angle = v * oren_nayar_twice_atan_over(v);
    return x < 0.0 ? pi - angle : angle;
}

// Eq. 27 + 29: BRDF value in 1/sr, without the cosine.
inline float3 oren_nayar_eval(OrenNayar params, float3 wi, float3 wo) {
    const float pi = 3.1415927;
    const float inv_pi = 0.31830987;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    // Smallest product of squared sines that is divided by. Directions nearer to the normal have no azimuth
    // that matters, and the reciprocal's derivative still fits into a float32.
    const float SIN4_MIN = 1.0e-20;
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return float3(0.0);
    }
    float s2 = params.sigma * params.sigma;
    // alpha is the larger, beta the smaller of the two polar angles.
    float cos_alpha = min(wi.z, wo.z);
    float cos_beta = max(wi.z, wo.z);
    float sin2_i = wi.x * wi.x + wi.y * wi.y;
    float sin2_o = wo.x * wo.x + wo.y * wo.y;
    float sin_alpha = sqrt(max(max(sin2_i, sin2_o), mu_min));
    float sin_beta = sqrt(max(min(sin2_i, sin2_o), mu_min));
    float beta_complement = oren_nayar_safe_asin(cos_beta);
    float beta = pi / 2.0 - beta_complement;
    float tan_beta = sin_beta / cos_beta;

    // c = cos(phi_i - phi_o), and 1 - |c| from the sine of that angle, which keeps its digits
    float s = oren_nayar_tangential_dot(wi, wo);
    float cross = oren_nayar_tangential_cross(wi, wo);
    float q = sqrt(max(sin2_i * sin2_o, SIN4_MIN));
    float c = s / q;
    float one_minus_c = cross / q * (cross / (q + abs(s)));

    float C1 = 1.0 - 0.5 * s2 / (s2 + 0.33);
    // C2 c tan(beta) for c < 0 needs sin(alpha) - (2 beta / pi)^3, in which two ones cancel when both
    // directions graze. With 2 beta / pi = 1 - delta they are gone.
    float delta = 2.0 * inv_pi * beta_complement;
    float dip = delta * (3.0 - delta * (3.0 - delta)) - cos_alpha * cos_alpha / (1.0 + sin_alpha);
    float C2 = 0.45 * s2 / (s2 + 0.09) * (s >= 0.0 ? sin_alpha : dip);
    float four_alpha_beta = 4.0 * inv_pi * inv_pi * oren_nayar_safe_acos(cos_alpha) * beta;
    float C3 = 0.125 * s2 / (s2 + 0.09) * four_alpha_beta * four_alpha_beta;
    float tan_half = (sin_alpha + sin_beta) / (cos_alpha + cos_beta);
    float L1 = C1 + c * C2 * tan_beta + one_minus_c * C3 * tan_half;

    float two_beta = 2.0 * inv_pi * beta;
    float L2 = 0.17 * s2 / (s2 + 0.13) * (1.0 - c * two_beta * two_beta);
    return params.rho * (inv_pi * L1) + params.rho * params.rho * (inv_pi * L2);
}

// ---- sampling ------------------------------------------------------------------------------

// A and B of Eq. 3. sigma: angle in radians; offset: 0.33, or 0.57 for the footnote's variant.
inline OrenNayarQualitativeCoefficients oren_nayar_qualitative_coefficients(float sigma,
    float offset) {
    float s2 = sigma * sigma;
    float A = 1.0 - 0.5 * s2 / (s2 + offset);
    float B = 0.45 * s2 / (s2 + 0.09);
    return OrenNayarQualitativeCoefficients{A, B};
}

inline float oren_nayar_matched_roughness(float r) {
    // Up to this roughness oren_nayar_sample_cltc_matched is cosine sampling. A lobe sheared by d leaves a
    // wedge of height r above the horizon to the uniform lobe, which costs a variance of r^2 log(1 / r); that
    // of cosine sampling is of order r^2, and the smaller of the two below r = 3e-4.
    const float R_COSINE = 1.0e-4;
    return max(r - R_COSINE, 0.0);
}

// How many samples oren_nayar_sample_cltc_matched gives to the uniform lobe: 0 at r = 0, at most 0.13.
//
// Fitted to the shares of least variance over (mu, r), on condition that the variance stays 4 %
// below those of cosine sampling and of the paper's choice. On average it is 5 % above the least.
inline float oren_nayar_matched_share(float mu, float r) {
    float k = 1.0 - mu;
    float steep = 0.0169 + k * (0.2136 + k * (0.445 * k - 0.2345));
    return r * steep * (1.0 + r * (0.315 * r - 0.602 - 0.5736 * k));
}

// A direction with density 1 / (2 pi).
inline float3 oren_nayar_sample_uniform(float2 u) {
    const float two_pi = 6.2831855;
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    float z = 1.0 - u.x;
    float r = sqrt(max(u.x * (1.0 + z), 0.0));
    float phi = two_pi * u.y;
    return float3(r * cos(phi), r * sin(phi), z);
}

// 1 - w.z, with the digits that w.z has lost beside the normal, where d needs them.
inline float oren_nayar_one_minus_cos(float3 w) {
    return (w.x * w.x + w.y * w.y) / (1.0 + w.z);
}

// a, b, c, d of M = [[a, 0, b], [0, c, 0], [d, 0, 1]] (Eq. 25, Listing 2) at mu = wo.z, k = 1 - mu.
inline OrenNayarCoefficients oren_nayar_coefficients(float mu, float k, float r) {
    float a = 1.0 + r * (0.303392 + (-0.518982 + 0.111709 * mu) * mu
        + (-0.276266 + 0.335918 * mu) * r);
    float b = r * (-1.16407 + 1.15859 * mu + (0.150815 - 0.150105 * mu) * r)
        / (mu * mu * mu - 1.43545);
    float c = 1.0 + (0.20013 + (-0.506373 + 0.261777 * mu) * mu) * r;
    // Numerator and denominator of d nearly vanish at mu = 1: the paper's polynomials in mu,
    // 0.540852 - 1.01625 mu + 0.475392 mu^2 and -1.0743 + 0.0725628 mu + mu^2, are written in k = 1 - mu.
    float d = r * (-6.0e-6 + (0.065466 + 0.475392 * k) * k) / (-0.0017372 - (2.0725627 - k) * k);
    return OrenNayarCoefficients{a, b, c, d};
}

// Share of the unit disk that clipping keeps (Eq. 28): (1 + cos(theta_P)) / 2.
inline float oren_nayar_kept_area(float d) {
    return 0.5 + 0.5 / sqrt(1.0 + d * d);
}

// Cosine and sine of wo's azimuth; (1, 0) at normal incidence.
inline float2 oren_nayar_azimuth(float3 wo) {
    // Below this squared sine the azimuth of wo is taken as 0: any azimuth is right there, and the square of
    // its reciprocal still fits into a float32.
    const float SIN2_MIN = 1.0e-18;
    float sin2 = wo.x * wo.x + wo.y * wo.y;
    bool tilted = sin2 > SIN2_MIN;
    float inv = 1.0 / sqrt(max(sin2, SIN2_MIN));
    return float2(tilted ? wo.x * inv : 1.0, tilted ? wo.y * inv : 0.0);
}

// A direction given relative to an azimuth (cosine, sine), about the normal turned by it.
inline float3 oren_nayar_from_frame(float3 w, float2 axis) {
    return float3(axis.x * w.x - axis.y * w.y, axis.y * w.x + axis.x * w.y, w.z);
}

// M applied to the cosine lobe's direction above (x, y), turned to wo's azimuth, normalised.
inline float3 oren_nayar_transform(float x, float y, float3 wo, float r, float d) {
    OrenNayarCoefficients coefficients_result = oren_nayar_coefficients(wo.z,
        oren_nayar_one_minus_cos(wo), r);
    float a = coefficients_result.a;
    float b = coefficients_result.b;
    float c = coefficients_result.c;
    float z = sqrt(max(1.0 - x * x - y * y, 0.0));
    return normalize(oren_nayar_from_frame(float3(a * x + b * z, c * y, d * x + z),
        oren_nayar_azimuth(wo)));
}

// Clipped to the directions that M keeps above the horizon (Listing 3).
inline float3 oren_nayar_sample_cltc(float3 wo, float r, float2 u) {
    const float two_pi = 6.2831855;
    // A sample that rounding pushed below the horizon is lifted to this cosine, 1/16 of a float32 epsilon.
    const float Z_MIN = 7.450581e-9;
    OrenNayarCoefficients coefficients_result = oren_nayar_coefficients(wo.z,
        oren_nayar_one_minus_cos(wo), r);
    float d = coefficients_result.d;
    float R = sqrt(max(u.x, 0.0));
    float phi = two_pi * u.y;
    float y = R * sin(phi);
    // A half-disk and a half-ellipse (Heitz 2018); the plane cuts the side on which d x is negative.
    float x = mix(sqrt(max(1.0 - y * y, 0.0)), R * cos(phi), oren_nayar_kept_area(d));
    float3 wi = oren_nayar_transform(d < 0.0 ? -x : x, y, wo, r, d);
    return float3(wi.x, wi.y, max(wi.z, Z_MIN));
}

// CLTC mixed with as much of the uniform hemisphere as the roughness asks for.
inline float3 oren_nayar_sample_cltc_matched(float3 wo, float r, float2 u) {
    // Smallest probability that is divided by: no 0 / 0, and no infinite derivative, in samples that are
    // not taken.
    const float P_MIN = 1.0e-6;
    float q = oren_nayar_matched_roughness(r);
    float P_u = oren_nayar_matched_share(wo.z, q);
    bool uniform = u.x < P_u;
    float u1 = uniform ? u.x / max(P_u, P_MIN) : (u.x - P_u) / (1.0 - P_u);
    float3 w_u = oren_nayar_sample_uniform(float2(u1, u.y));
    float3 w_c = oren_nayar_sample_cltc(wo, q, float2(u1, u.y));
    return uniform ? w_u : w_c;
}

// A direction relative to an azimuth (cosine, sine): the inverse of oren_nayar_from_frame.
inline float3 oren_nayar_to_frame(float3 w, float2 axis) {
    return float3(axis.x * w.x + axis.y * w.y, axis.x * w.y - axis.y * w.x, w.z);
}

// Density of oren_nayar_transform for an unclipped cosine lobe (Eq. 23 and 24).
inline float oren_nayar_cltc_pdf(float3 wi, float3 wo, float r, float d) {
    const float inv_pi = 0.31830987;
    OrenNayarCoefficients coefficients_result = oren_nayar_coefficients(wo.z,
        oren_nayar_one_minus_cos(wo), r);
    float a = coefficients_result.a;
    float b = coefficients_result.b;
    float c = coefficients_result.c;
    float3 w = oren_nayar_to_frame(wi, oren_nayar_azimuth(wo));
    float det = c * (a - b * d);
    // det(M) times the inverse of M, applied to w
    float3 h = float3(c * (w.x - b * w.z), (a - b * d) * w.y, c * (a * w.z - d * w.x));
    float inv2 = 1.0 / dot(h, h);
    return inv_pi * det * det * inv2 * inv2 * max(h.z, 0.0);
}

// Density of oren_nayar_sample_cltc.
inline float oren_nayar_pdf_cltc(float3 wi, float3 wo, float r) {
    OrenNayarCoefficients coefficients_result = oren_nayar_coefficients(wo.z,
        oren_nayar_one_minus_cos(wo), r);
    float d = coefficients_result.d;
    return oren_nayar_cltc_pdf(wi, wo, r, d) / oren_nayar_kept_area(d);
}

// Density of oren_nayar_sample_cltc_matched.
inline float oren_nayar_pdf_cltc_matched(float3 wi, float3 wo, float r) {
    const float inv_two_pi = 0.15915494;
    float q = oren_nayar_matched_roughness(r);
    return mix(oren_nayar_pdf_cltc(wi, wo, q), inv_two_pi, oren_nayar_matched_share(wo.z, q));
}

// Density of oren_nayar_sample in 1/sr.
inline float oren_nayar_pdf(OrenNayar params, float3 wi, float3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    OrenNayarQualitativeCoefficients qualitative_coefficients_result =
        oren_nayar_qualitative_coefficients(params.sigma, 0.33);
    float A = qualitative_coefficients_result.A;
    float B = qualitative_coefficients_result.B;
    return oren_nayar_pdf_cltc_matched(wi, wo, B / A);
}

// EON's sampler, at the roughness that fits the qualitative model.
inline OrenNayarSample oren_nayar_sample(OrenNayar params, float3 wo, float2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return OrenNayarSample{float3(0.0, 0.0, 1.0), 0.0};
    }
    OrenNayarQualitativeCoefficients qualitative_coefficients_result =
        oren_nayar_qualitative_coefficients(params.sigma, 0.33);
    float A = qualitative_coefficients_result.A;
    float B = qualitative_coefficients_result.B;
    float3 wi = oren_nayar_sample_cltc_matched(wo, B / A, u);
    return OrenNayarSample{wi, oren_nayar_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline float3 oren_nayar_albedo(OrenNayar params, float3 wo) {
    // Steps of the rule in oren_nayar_albedo: a Fibonacci number, and the golden ratio.
    const float ALBEDO_SAMPLES = 987.0;
    const float GOLDEN = 0.618034;
    // Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
    const float HORIZON = 1.0e-6;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z < 0.0) {  // below the horizon
        return float3(0.0);
    }
    float3 w = float3(wo.x, wo.y, max(wo.z, HORIZON));
    float3 total = float3(0.0);
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        float2 u = float2((i + 0.5) / ALBEDO_SAMPLES, fract((i + 0.5) * GOLDEN));
        OrenNayarSample drawn = oren_nayar_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + oren_nayar_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
