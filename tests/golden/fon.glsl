// SPDX-License-Identifier: Apache-2.0
// FON: Fujii's simplified Oren-Nayar model.
//
// Source: Fujii, "A tiny improvement of Oren-Nayar reflectance model", 2013, in the form of Portsmouth,
// Kutz, Hill, "EON", arXiv:2410.18026, Eq. 10 to 15.
//
// GLSL 4.5, made by gonio from gonio/models/fon.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// Usage: Fon params; params.rho = ...; ... fon_eval(params, wi, wo)

// A sampled direction and its density.
struct FonSample {
    vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// fon: Rough diffuse without a dark ring. Reciprocal; never gains energy, but loses up to 22 %.
struct Fon {
    vec3 rho;  // single-scattering albedo, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    float roughness;  // unitless r; not the Oren-Nayar angle sigma; 0 to 1, default 0.5
};

// What fon_coefficients returns.
struct FonCoefficients {
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
float fon_tangential_dot(vec3 wi, vec3 wo) {
    float q = wi.y * wo.y;
    float error = fma(wi.y, wo.y, -q);
    return fma(wi.x, wo.x, q) + error;
}

// s / max(mu_i, mu_o).
float fon_s_over_max(float s, vec3 wi, vec3 wo) {
    return s / max(wi.z, wo.z);
}

// 1 + r s/t with Eq. 11: the angular shape of FON and of EON's single scattering.
float fon_fujii_shape(vec3 wi, vec3 wo, float r) {
    float s = fon_tangential_dot(wi, wo);
    // 1 + s = (|t_i + t_o|^2 + mu_i^2 + mu_o^2) / 2 with the tangential parts t: nothing cancels when wi is the
    // mirror direction of a grazing wo, where 1 + s goes to 0.
    float x = wi.x + wo.x;
    float y = wi.y + wo.y;
    float one_plus_s = 0.5 * (x * x + y * y + wi.z * wi.z + wo.z * wo.z);
    return 1.0 - r + r * (s > 0.0 ? 1.0 + fon_s_over_max(s, wi, wo) : one_plus_s);
}

// Eq. 10: BRDF value in 1/sr, without the cosine.
vec3 fon_eval(Fon params, vec3 wi, vec3 wo) {
    const float inv_pi = 0.31830987;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    const float C1 = 0.2877934;  // A_F = 1 / (1 + C1 r)
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3(0.0);
    }
    float r = params.roughness;
    return params.rho * (inv_pi / (1.0 + C1 * r) * fon_fujii_shape(wi, wo, r));
}

// ---- sampling ------------------------------------------------------------------------------

float fon_matched_roughness(float r) {
    // Up to this roughness fon_sample_cltc_matched is cosine sampling. A lobe sheared by d leaves a wedge of
    // height r above the horizon to the uniform lobe, which costs a variance of r^2 log(1 / r); that of cosine
    // sampling is of order r^2, and the smaller of the two below r = 3e-4.
    const float R_COSINE = 1.0e-4;
    return max(r - R_COSINE, 0.0);
}

// How many samples fon_sample_cltc_matched gives to the uniform lobe: 0 at r = 0, at most 0.13.
//
// Fitted to the shares of least variance over (mu, r), on condition that the variance stays 4 % below those
// of cosine sampling and of the paper's choice. On average it is 5 % above the least.
float fon_matched_share(float mu, float r) {
    float k = 1.0 - mu;
    float steep = 0.0169 + k * (0.2136 + k * (0.445 * k - 0.2345));
    return r * steep * (1.0 + r * (0.315 * r - 0.602 - 0.5736 * k));
}

// A direction with density 1 / (2 pi).
vec3 fon_sample_uniform(vec2 u) {
    const float two_pi = 6.2831855;
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    float z = 1.0 - u.x;
    float r = sqrt(max(u.x * (1.0 + z), 0.0));
    float phi = two_pi * u.y;
    return vec3(r * cos(phi), r * sin(phi), z);
}

// 1 - w.z, with the digits that w.z has lost beside the normal, where d needs them.
float fon_one_minus_cos(vec3 w) {
    return (w.x * w.x + w.y * w.y) / (1.0 + w.z);
}

// a, b, c, d of M = [[a, 0, b], [0, c, 0], [d, 0, 1]] (Eq. 25, Listing 2) at mu = wo.z, k = 1 - mu.
FonCoefficients fon_coefficients(float mu, float k, float r) {
    float a = 1.0 + r * (0.303392 + (-0.518982 + 0.111709 * mu) * mu
        + (-0.276266 + 0.335918 * mu) * r);
    float b = r * (-1.16407 + 1.15859 * mu + (0.150815 - 0.150105 * mu) * r)
        / (mu * mu * mu - 1.43545);
    float c = 1.0 + (0.20013 + (-0.506373 + 0.261777 * mu) * mu) * r;
    // Numerator and denominator of d nearly vanish at mu = 1: the paper's polynomials in mu,
    // 0.540852 - 1.01625 mu + 0.475392 mu^2 and -1.0743 + 0.0725628 mu + mu^2, are written in k = 1 - mu.
    float d = r * (-6.0e-6 + (0.065466 + 0.475392 * k) * k) / (-0.0017372 - (2.0725627 - k) * k);
    return FonCoefficients(a, b, c, d);
}

// Share of the unit disk that clipping keeps (Eq. 28): (1 + cos(theta_P)) / 2.
float fon_kept_area(float d) {
    return 0.5 + 0.5 / sqrt(1.0 + d * d);
}

// Cosine and sine of wo's azimuth; (1, 0) at normal incidence.
vec2 fon_azimuth(vec3 wo) {
    // Below this squared sine the azimuth of wo is taken as 0: any azimuth is right there, and the square of
    // its reciprocal still fits into a float32.
    const float SIN2_MIN = 1.0e-18;
    float sin2 = wo.x * wo.x + wo.y * wo.y;
    bool tilted = sin2 > SIN2_MIN;
    float inv = 1.0 / sqrt(max(sin2, SIN2_MIN));
    return vec2(tilted ? wo.x * inv : 1.0, tilted ? wo.y * inv : 0.0);
}

// A direction given relative to an azimuth (cosine, sine), about the normal turned by it.
vec3 fon_from_frame(vec3 w, vec2 axis) {
    return vec3(axis.x * w.x - axis.y * w.y, axis.y * w.x + axis.x * w.y, w.z);
}

// M applied to the cosine lobe's direction above (x, y), turned to wo's azimuth, normalised.
vec3 fon_transform(float x, float y, vec3 wo, float r, float d) {
    FonCoefficients coefficients_result = fon_coefficients(wo.z, fon_one_minus_cos(wo), r);
    float a = coefficients_result.a;
    float b = coefficients_result.b;
    float c = coefficients_result.c;
    float z = sqrt(max(1.0 - x * x - y * y, 0.0));
    return normalize(fon_from_frame(vec3(a * x + b * z, c * y, d * x + z), fon_azimuth(wo)));
}

// Clipped to the directions that M keeps above the horizon (Listing 3).
vec3 fon_sample_cltc(vec3 wo, float r, vec2 u) {
    const float two_pi = 6.2831855;
    // A sample that rounding pushed below the horizon is lifted to this cosine, 1/16 of a float32 epsilon.
    const float Z_MIN = 7.450581e-9;
    FonCoefficients coefficients_result = fon_coefficients(wo.z, fon_one_minus_cos(wo), r);
    float d = coefficients_result.d;
    float R = sqrt(max(u.x, 0.0));
    float phi = two_pi * u.y;
    float y = R * sin(phi);
    // A half-disk and a half-ellipse (Heitz 2018); the plane cuts the side on which d x is negative.
    float x = mix(sqrt(max(1.0 - y * y, 0.0)), R * cos(phi), fon_kept_area(d));
    vec3 wi = fon_transform(d < 0.0 ? -x : x, y, wo, r, d);
    return vec3(wi.x, wi.y, max(wi.z, Z_MIN));
}

// CLTC mixed with as much of the uniform hemisphere as the roughness asks for.
vec3 fon_sample_cltc_matched(vec3 wo, float r, vec2 u) {
    // Smallest probability that is divided by: no 0 / 0, and no infinite derivative, in samples that are
    // not taken.
    const float P_MIN = 1.0e-6;
    float q = fon_matched_roughness(r);
    float P_u = fon_matched_share(wo.z, q);
    bool uniform_ = u.x < P_u;
    float u1 = uniform_ ? u.x / max(P_u, P_MIN) : (u.x - P_u) / (1.0 - P_u);
    vec3 w_u = fon_sample_uniform(vec2(u1, u.y));
    vec3 w_c = fon_sample_cltc(wo, q, vec2(u1, u.y));
    return uniform_ ? w_u : w_c;
}

// A direction relative to an azimuth (cosine, sine): the inverse of fon_from_frame.
vec3 fon_to_frame(vec3 w, vec2 axis) {
    return vec3(axis.x * w.x + axis.y * w.y, axis.x * w.y - axis.y * w.x, w.z);
}

// Density of fon_transform for an unclipped cosine lobe (Eq. 23 and 24).
float fon_cltc_pdf(vec3 wi, vec3 wo, float r, float d) {
    const float inv_pi = 0.31830987;
    FonCoefficients coefficients_result = fon_coefficients(wo.z, fon_one_minus_cos(wo), r);
    float a = coefficients_result.a;
    float b = coefficients_result.b;
    float c = coefficients_result.c;
    vec3 w = fon_to_frame(wi, fon_azimuth(wo));
    float det = c * (a - b * d);
    // det(M) times the inverse of M, applied to w
    vec3 h = vec3(c * (w.x - b * w.z), (a - b * d) * w.y, c * (a * w.z - d * w.x));
    float inv2 = 1.0 / dot(h, h);
    return inv_pi * det * det * inv2 * inv2 * max(h.z, 0.0);
}

// Density of fon_sample_cltc.
float fon_pdf_cltc(vec3 wi, vec3 wo, float r) {
    FonCoefficients coefficients_result = fon_coefficients(wo.z, fon_one_minus_cos(wo), r);
    float d = coefficients_result.d;
    return fon_cltc_pdf(wi, wo, r, d) / fon_kept_area(d);
}

// Density of fon_sample_cltc_matched.
float fon_pdf_cltc_matched(vec3 wi, vec3 wo, float r) {
    const float inv_two_pi = 0.15915494;
    float q = fon_matched_roughness(r);
    return mix(fon_pdf_cltc(wi, wo, q), inv_two_pi, fon_matched_share(wo.z, q));
}

// Density of fon_sample in 1/sr.
float fon_pdf(Fon params, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return fon_pdf_cltc_matched(wi, wo, params.roughness);
}

// EON's sampler, made for the same shape.
FonSample fon_sample(Fon params, vec3 wo, vec2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return FonSample(vec3(0.0, 0.0, 1.0), 0.0);
    }
    vec3 wi = fon_sample_cltc_matched(wo, params.roughness, u);
    return FonSample(wi, fon_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// 2 atan(v) / v for v in [-1, 1], the angle whose half has the tangent v; 2 at v = 0.
float fon_twice_atan_over(float v) {
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

// Arc cosine of x limited to [-1, 1]: twice the angle whose tangent is sin / (1 + x).
float fon_safe_acos(float x) {
    const float pi = 3.1415927;
    float a = min(abs(x), 1.0);
    float v = sqrt(max((1.0 - a) * (1.0 + a), 0.0)) / (1.0 + a);
    float angle = v * fon_twice_atan_over(v);
    return x < 0.0 ? pi - angle : angle;
}

// Eq. 8: the integral of s/t (Eq. 4) times the cosine, at a cosine mu in [0, 1]; pi/2 at mu = 0.
float fon_G_qualitative(float mu) {
    float s = sqrt(max((1.0 - mu) * (1.0 + mu), 0.0));
    // The paper has tan(theta) (1 - s^3); with 1 - s = mu^2 / (1 + s) the division by mu cancels.
    return s * (fon_safe_acos(mu) - s * mu) + 2.0 / 3.0 * s * mu * (1.0 + s + s * s) / (1.0 + s);
}

// Eq. 13: the same for s/t of Eq. 11.
float fon_G_fujii(float mu) {
    return fon_G_qualitative(mu) - 2.0 / 3.0 * sqrt(max((1.0 - mu) * (1.0 + mu), 0.0));
}

// Eq. 12.
vec3 fon_albedo(Fon params, vec3 wo) {
    const float inv_pi = 0.31830987;
    const float C1 = 0.2877934;  // A_F = 1 / (1 + C1 r)
    if (wo.z < 0.0) {  // below the horizon
        return vec3(0.0);
    }
    float r = params.roughness;
    return params.rho * ((1.0 + r * inv_pi * fon_G_fujii(wo.z)) / (1.0 + C1 * r));
}
