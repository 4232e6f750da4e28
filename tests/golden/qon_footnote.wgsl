// SPDX-License-Identifier: Apache-2.0
// QON with the coefficient of a footnote: 0.57 in place of 0.33, a little brighter.
//
// Source: Oren, Nayar, "Generalization of Lambert's reflectance model", SIGGRAPH 1994, Eq. 30 and its
// footnote; in the form of Portsmouth, Kutz, Hill, "EON", arXiv:2410.18026, Eq. 1 to 9.
//
// WGSL (WebGPU), made by gonio from gonio/models/qon_footnote.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose normal is
// +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// Usage: var params: QonFootnote; params.rho = ...; ... qon_footnote_eval(params, wi, wo)

// A sampled direction and its density.
struct QonFootnoteSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// qon_footnote: QON made brighter to stand in for interreflection. Reciprocal; gains energy at
// grazing angles.
struct QonFootnote {
    rho: vec3f,  // single-scattering albedo, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    sigma: f32,  // standard deviation of the facet angle, radians; 0 to 1.570796, default 0.5
}

// What qon_footnote_qualitative_coefficients returns.
struct QonFootnoteQualitativeCoefficients {
    A: f32,
    B: f32,
}

// What qon_footnote_coefficients returns.
struct QonFootnoteCoefficients {
    a: f32,
    b: f32,
    c: f32,
    d: f32,
}

// ---- evaluation ----------------------------------------------------------------------------

// A and B of Eq. 3. sigma: angle in radians; offset: 0.33, or 0.57 for the footnote's variant.
fn qon_footnote_qualitative_coefficients(sigma: f32,
    offset: f32) -> QonFootnoteQualitativeCoefficients {
    let s2 = sigma * sigma;
    let A = 1.0 - 0.5 * s2 / (s2 + offset);
    let B = 0.45 * s2 / (s2 + 0.09);
    return QonFootnoteQualitativeCoefficients(A, B);
}

// s = cos(phi_i - phi_o) sin(theta_i) sin(theta_o), the inner product of the tangential parts.
//
// It is divided by cosines that may be tiny, so its last bits count: the rounding error of one
// product is carried along (Kahan), which plain wi.x wo.x + wi.y wo.y or dot(wi, wo) - mu_i mu_o loses.
fn qon_footnote_tangential_dot(wi: vec3f, wo: vec3f) -> f32 {
    let q = wi.y * wo.y;
    let error = fma(wi.y, wo.y, -q);
    return fma(wi.x, wo.x, q) + error;
}

// s / max(mu_i, mu_o).
fn qon_footnote_s_over_max(s: f32, wi: vec3f, wo: vec3f) -> f32 {
    return s / max(wi.z, wo.z);
}

// s / t of Eq. 4: nothing for s <= 0.
fn qon_footnote_s_over_t_qualitative(s: f32, wi: vec3f, wo: vec3f) -> f32 {
    return select(0.0, qon_footnote_s_over_max(s, wi, wo), s > 0.0);
}

// Eq. 1: BRDF value in 1/sr, without the cosine.
fn qon_footnote_eval(params: QonFootnote, wi: vec3f, wo: vec3f) -> vec3f {
    const inv_pi = 0.31830987;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    let qualitative_coefficients_result = qon_footnote_qualitative_coefficients(params.sigma, 0.57);
    let A = qualitative_coefficients_result.A;
    let B = qualitative_coefficients_result.B;
    let s = qon_footnote_tangential_dot(wi, wo);
    return params.rho * (inv_pi * (A + B * qon_footnote_s_over_t_qualitative(s, wi, wo)));
}

// ---- sampling ------------------------------------------------------------------------------

fn qon_footnote_matched_roughness(r: f32) -> f32 {
    // Up to this roughness qon_footnote_sample_cltc_matched is cosine sampling. A lobe sheared by d leaves a
    // wedge of height r above the horizon to the uniform lobe, which costs a variance of r^2 log(1 / r); that
    // of cosine sampling is of order r^2, and the smaller of the two below r = 3e-4.
    const R_COSINE = 1.0e-4;
    return max(r - R_COSINE, 0.0);
}

// How many samples qon_footnote_sample_cltc_matched gives to the uniform lobe: 0 at r = 0, at most 0.13.
//
// Fitted to the shares of least variance over (mu, r), on condition that the variance stays 4 %
// below those of cosine sampling and of the paper's choice. On average it is 5 % above the least.
fn qon_footnote_matched_share(mu: f32, r: f32) -> f32 {
    let k = 1.0 - mu;
    let steep = 0.0169 + k * (0.2136 + k * (0.445 * k - 0.2345));
    return r * steep * (1.0 + r * (0.315 * r - 0.602 - 0.5736 * k));
}

// A direction with density 1 / (2 pi).
fn qon_footnote_sample_uniform(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    let z = 1.0 - u.x;
    let r = sqrt(max(u.x * (1.0 + z), 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), z);
}

// 1 - w.z, with the digits that w.z has lost beside the normal, where d needs them.
fn qon_footnote_one_minus_cos(w: vec3f) -> f32 {
    return (w.x * w.x + w.y * w.y) / (1.0 + w.z);
}

// a, b, c, d of M = [[a, 0, b], [0, c, 0], [d, 0, 1]] (Eq. 25, Listing 2) at mu = wo.z, k = 1 - mu.
fn qon_footnote_coefficients(mu: f32, k: f32, r: f32) -> QonFootnoteCoefficients {
    let a = 1.0 + r * (0.303392 + (-0.518982 + 0.111709 * mu) * mu
        + (-0.276266 + 0.335918 * mu) * r);
    let b = r * (-1.16407 + 1.15859 * mu + (0.150815 - 0.150105 * mu) * r)
        / (mu * mu * mu - 1.43545);
    let c = 1.0 + (0.20013 + (-0.506373 + 0.261777 * mu) * mu) * r;
    // Numerator and denominator of d nearly vanish at mu = 1: the paper's polynomials in mu,
    // 0.540852 - 1.01625 mu + 0.475392 mu^2 and -1.0743 + 0.0725628 mu + mu^2, are written in k = 1 - mu.
    let d = r * (-6.0e-6 + (0.065466 + 0.475392 * k) * k) / (-0.0017372 - (2.0725627 - k) * k);
    return QonFootnoteCoefficients(a, b, c, d);
}

// Share of the unit disk that clipping keeps (Eq. 28): (1 + cos(theta_P)) / 2.
fn qon_footnote_kept_area(d: f32) -> f32 {
    return 0.5 + 0.5 / sqrt(1.0 + d * d);
}

// Cosine and sine of wo's azimuth; (1, 0) at normal incidence.
fn qon_footnote_azimuth(wo: vec3f) -> vec2f {
    // Below this squared sine the azimuth of wo is taken as 0: any azimuth is right there, and the square of
    // its reciprocal still fits into a float32.
    const SIN2_MIN = 1.0e-18;
    let sin2 = wo.x * wo.x + wo.y * wo.y;
    let tilted = sin2 > SIN2_MIN;
    let inv = 1.0 / sqrt(max(sin2, SIN2_MIN));
    return vec2f(select(1.0, wo.x * inv, tilted), select(0.0, wo.y * inv, tilted));
}

// A direction given relative to an azimuth (cosine, sine), about the normal turned by it.
fn qon_footnote_from_frame(w: vec3f, axis: vec2f) -> vec3f {
    return vec3f(axis.x * w.x - axis.y * w.y, axis.y * w.x + axis.x * w.y, w.z);
}

// M applied to the cosine lobe's direction above (x, y), turned to wo's azimuth, normalised.
fn qon_footnote_transform(x: f32, y: f32, wo: vec3f, r: f32, d: f32) -> vec3f {
    let coefficients_result = qon_footnote_coefficients(wo.z, qon_footnote_one_minus_cos(wo), r);
    let a = coefficients_result.a;
    let b = coefficients_result.b;
    let c = coefficients_result.c;
    let z = sqrt(max(1.0 - x * x - y * y, 0.0));
    return normalize(qon_footnote_from_frame(vec3f(a * x + b * z, c * y, d * x + z),
        qon_footnote_azimuth(wo)));
}

// Clipped to the directions that M keeps above the horizon (Listing 3).
fn qon_footnote_sample_cltc(wo: vec3f, r: f32, u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    // A sample that rounding pushed below the horizon is lifted to this cosine, 1/16 of a float32 epsilon.
    const Z_MIN = 7.450581e-9;
    let coefficients_result = qon_footnote_coefficients(wo.z, qon_footnote_one_minus_cos(wo), r);
    let d = coefficients_result.d;
    let R = sqrt(max(u.x, 0.0));
    let phi = two_pi * u.y;
    let y = R * sin(phi);
    // A half-disk and a half-ellipse (Heitz 2018); the plane cuts the side on which d x is negative.
    let x = mix(sqrt(max(1.0 - y * y, 0.0)), R * cos(phi), qon_footnote_kept_area(d));
    let wi = qon_footnote_transform(select(x, -x, d < 0.0), y, wo, r, d);
    return vec3f(wi.x, wi.y, max(wi.z, Z_MIN));
}

// CLTC mixed with as much of the uniform hemisphere as the roughness asks for.
fn qon_footnote_sample_cltc_matched(wo: vec3f, r: f32, u: vec2f) -> vec3f {
    // Smallest probability that is divided by: no 0 / 0, and no infinite derivative, in samples that are
    // not taken.
    const P_MIN = 1.0e-6;
    let q = qon_footnote_matched_roughness(r);
    let P_u = qon_footnote_matched_share(wo.z, q);
    let uniform = u.x < P_u;
    let u1 = select((u.x - P_u) / (1.0 - P_u), u.x / max(P_u, P_MIN), uniform);
    let w_u = qon_footnote_sample_uniform(vec2f(u1, u.y));
    let w_c = qon_footnote_sample_cltc(wo, q, vec2f(u1, u.y));
    return select(w_c, w_u, uniform);
}

// A direction relative to an azimuth (cosine, sine): the inverse of qon_footnote_from_frame.
fn qon_footnote_to_frame(w: vec3f, axis: vec2f) -> vec3f {
    return vec3f(axis.x * w.x + axis.y * w.y, axis.x * w.y - axis.y * w.x, w.z);
}

// Density of qon_footnote_transform for an unclipped cosine lobe (Eq. 23 and 24).
fn qon_footnote_cltc_pdf(wi: vec3f, wo: vec3f, r: f32, d: f32) -> f32 {
    const inv_pi = 0.31830987;
    let coefficients_result = qon_footnote_coefficients(wo.z, qon_footnote_one_minus_cos(wo), r);
    let a = coefficients_result.a;
    let b = coefficients_result.b;
    let c = coefficients_result.c;
    let w = qon_footnote_to_frame(wi, qon_footnote_azimuth(wo));
    let det = c * (a - b * d);
    // det(M) times the inverse of M, applied to w
    let h = vec3f(c * (w.x - b * w.z), (a - b * d) * w.y, c * (a * w.z - d * w.x));
    let inv2 = 1.0 / dot(h, h);
    return inv_pi * det * det * inv2 * inv2 * max(h.z, 0.0);
}

// Density of qon_footnote_sample_cltc.
fn qon_footnote_pdf_cltc(wi: vec3f, wo: vec3f, r: f32) -> f32 {
    let coefficients_result = qon_footnote_coefficients(wo.z, qon_footnote_one_minus_cos(wo), r);
    let d = coefficients_result.d;
    return qon_footnote_cltc_pdf(wi, wo, r, d) / qon_footnote_kept_area(d);
}

// Density of qon_footnote_sample_cltc_matched.
fn qon_footnote_pdf_cltc_matched(wi: vec3f, wo: vec3f, r: f32) -> f32 {
    const inv_two_pi = 0.15915494;
    let q = qon_footnote_matched_roughness(r);
    return mix(qon_footnote_pdf_cltc(wi, wo, q), inv_two_pi, qon_footnote_matched_share(wo.z, q));
}

// Density of qon_footnote_sample in 1/sr.
fn qon_footnote_pdf(params: QonFootnote, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    let qualitative_coefficients_result = qon_footnote_qualitative_coefficients(params.sigma, 0.57);
    let A = qualitative_coefficients_result.A;
    let B = qualitative_coefficients_result.B;
    return qon_footnote_pdf_cltc_matched(wi, wo, B / A);
}

// EON's sampler, at the roughness with the same weight of s/t.
fn qon_footnote_sample(params: QonFootnote, wo: vec3f, u: vec2f) -> QonFootnoteSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return QonFootnoteSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let qualitative_coefficients_result = qon_footnote_qualitative_coefficients(params.sigma, 0.57);
    let A = qualitative_coefficients_result.A;
    let B = qualitative_coefficients_result.B;
    let wi = qon_footnote_sample_cltc_matched(wo, B / A, u);
    return QonFootnoteSample(wi, qon_footnote_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// 2 atan(v) / v for v in [-1, 1], the angle whose half has the tangent v; 2 at v = 0.
fn qon_footnote_twice_atan_over(v: f32) -> f32 {
    const ATAN_0 = 2.0;  // 2 atan(v) / v in v^2 on [0, 1]; fitted, relative error below 2e-8.
    const ATAN_1 = -0.66666144;
    const ATAN_2 = 0.3998524;
    const ATAN_3 = -0.28407288;
    const ATAN_4 = 0.21281867;
    const ATAN_5 = -0.15008585;
    const ATAN_6 = 0.085383;
    const ATAN_7 = -0.03213723;
    const ATAN_8 = 0.005699773;
    let q = v * v;
    let p = ATAN_4 + q * (ATAN_5 + q * (ATAN_6 + q * (ATAN_7 + q * ATAN_8)));
    return ATAN_0 + q * (ATAN_1 + q * (ATAN_2 + q * (ATAN_3 + q * p)));
}

// Arc cosine of x limited to [-1, 1]: twice the angle whose tangent is sin / (1 + x).
fn qon_footnote_safe_acos(x: f32) -> f32 {
    const pi = 3.1415927;
    let a = min(abs(x), 1.0);
    let v = sqrt(max((1.0 - a) * (1.0 + a), 0.0)) / (1.0 + a);
    let angle = v * qon_footnote_twice_atan_over(v);
    return select(angle, pi - angle, x < 0.0);
}

// Eq. 8: the integral of s/t (Eq. 4) times the cosine, at a cosine mu in [0, 1]; pi/2 at mu = 0.
fn qon_footnote_G_qualitative(mu: f32) -> f32 {
    let s = sqrt(max((1.0 - mu) * (1.0 + mu), 0.0));
    // The paper has tan(theta) (1 - s^3); with 1 - s = mu^2 / (1 + s) the division by mu cancels.
    return s * (qon_footnote_safe_acos(mu) - s * mu)
        + 2.0 / 3.0 * s * mu * (1.0 + s + s * s) / (1.0 + s);
}

// Eq. 5.
fn qon_footnote_albedo(params: QonFootnote, wo: vec3f) -> vec3f {
    const inv_pi = 0.31830987;
    if (wo.z < 0.0) {  // below the horizon
        return vec3f(0.0);
    }
    let qualitative_coefficients_result = qon_footnote_qualitative_coefficients(params.sigma, 0.57);
    let A = qualitative_coefficients_result.A;
    let B = qualitative_coefficients_result.B;
    return params.rho * (A + B * inv_pi * qon_footnote_G_qualitative(wo.z));
}
