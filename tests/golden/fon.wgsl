// SPDX-License-Identifier: Apache-2.0
// FON: Fujii's simplified Oren-Nayar model.
//
// Source: Fujii, "A tiny improvement of Oren-Nayar reflectance model", 2013, in the form of Portsmouth,
// Kutz, Hill, "EON", arXiv:2410.18026, Eq. 10 to 15.
//
// WGSL (WebGPU), made by gonio from gonio/models/fon.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// Usage: var params: Fon; params.rho = ...; ... fon_eval(params, wi, wo)

// A sampled direction and its density.
struct FonSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// fon: Rough diffuse without a dark ring. Reciprocal; never gains energy, but loses up to 22 %.
struct Fon {
    rho: vec3f,  // single-scattering albedo, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    roughness: f32,  // unitless r; not the Oren-Nayar angle sigma; 0 to 1, default 0.5
}

// What fon_coefficients returns.
struct FonCoefficients {
    a: f32,
    b: f32,
    c: f32,
    d: f32,
}

// ---- evaluation ----------------------------------------------------------------------------

// s = cos(phi_i - phi_o) sin(theta_i) sin(theta_o), the inner product of the tangential parts.
//
// It is divided by cosines that may be tiny, so its last bits count: the rounding error of one
// product is carried along (Kahan), which plain wi.x wo.x + wi.y wo.y or dot(wi, wo) - mu_i mu_o loses.
fn fon_tangential_dot(wi: vec3f, wo: vec3f) -> f32 {
    let q = wi.y * wo.y;
    let error = fma(wi.y, wo.y, -q);
    return fma(wi.x, wo.x, q) + error;
}

// s / max(mu_i, mu_o).
fn fon_s_over_max(s: f32, wi: vec3f, wo: vec3f) -> f32 {
    return s / max(wi.z, wo.z);
}

// 1 + r s/t with Eq. 11: the angular shape of FON and of EON's single scattering.
fn fon_fujii_shape(wi: vec3f, wo: vec3f, r: f32) -> f32 {
    let s = fon_tangential_dot(wi, wo);
    // 1 + s = (|t_i + t_o|^2 + mu_i^2 + mu_o^2) / 2 with the tangential parts t: nothing cancels when wi is the
    // mirror direction of a grazing wo, where 1 + s goes to 0.
    let x = wi.x + wo.x;
    let y = wi.y + wo.y;
    let one_plus_s = 0.5 * (x * x + y * y + wi.z * wi.z + wo.z * wo.z);
    return 1.0 - r + r * select(one_plus_s, 1.0 + fon_s_over_max(s, wi, wo), s > 0.0);
}

// Eq. 10: BRDF value in 1/sr, without the cosine.
fn fon_eval(params: Fon, wi: vec3f, wo: vec3f) -> vec3f {
    const inv_pi = 0.31830987;
    const mu_min = 1.0e-18;  // cosine of the horizon
    const C1 = 0.2877934;  // A_F = 1 / (1 + C1 r)
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    let r = params.roughness;
    return params.rho * (inv_pi / (1.0 + C1 * r) * fon_fujii_shape(wi, wo, r));
}

// ---- sampling ------------------------------------------------------------------------------

fn fon_matched_roughness(r: f32) -> f32 {
    // Up to this roughness fon_sample_cltc_matched is cosine sampling. A lobe sheared by d leaves a wedge of
    // height r above the horizon to the uniform lobe, which costs a variance of r^2 log(1 / r); that of cosine
    // sampling is of order r^2, and the smaller of the two below r = 3e-4.
    const R_COSINE = 1.0e-4;
    return max(r - R_COSINE, 0.0);
}

// How many samples fon_sample_cltc_matched gives to the uniform lobe: 0 at r = 0, at most 0.13.
//
// Fitted to the shares of least variance over (mu, r), on condition that the variance stays 4 % below those
// of cosine sampling and of the paper's choice. On average it is 5 % above the least.
fn fon_matched_share(mu: f32, r: f32) -> f32 {
    let k = 1.0 - mu;
    let steep = 0.0169 + k * (0.2136 + k * (0.445 * k - 0.2345));
    return r * steep * (1.0 + r * (0.315 * r - 0.602 - 0.5736 * k));
}

// A direction with density 1 / (2 pi).
fn fon_sample_uniform(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    let z = 1.0 - u.x;
    let r = sqrt(max(u.x * (1.0 + z), 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), z);
}

// 1 - w.z, with the digits that w.z has lost beside the normal, where d needs them.
fn fon_one_minus_cos(w: vec3f) -> f32 {
    return (w.x * w.x + w.y * w.y) / (1.0 + w.z);
}

// a, b, c, d of M = [[a, 0, b], [0, c, 0], [d, 0, 1]] (Eq. 25, Listing 2) at mu = wo.z, k = 1 - mu.
fn fon_coefficients(mu: f32, k: f32, r: f32) -> FonCoefficients {
    let a = 1.0 + r * (0.303392 + (-0.518982 + 0.111709 * mu) * mu
        + (-0.276266 + 0.335918 * mu) * r);
    let b = r * (-1.16407 + 1.15859 * mu + (0.150815 - 0.150105 * mu) * r)
        / (mu * mu * mu - 1.43545);
    let c = 1.0 + (0.20013 + (-0.506373 + 0.261777 * mu) * mu) * r;
    // Numerator and denominator of d nearly vanish at mu = 1: the paper's polynomials in mu,
    // 0.540852 - 1.01625 mu + 0.475392 mu^2 and -1.0743 + 0.0725628 mu + mu^2, are written in k = 1 - mu.
    let d = r * (-6.0e-6 + (0.065466 + 0.475392 * k) * k) / (-0.0017372 - (2.0725627 - k) * k);
    return FonCoefficients(a, b, c, d);
}

// Share of the unit disk that clipping keeps (Eq. 28): (1 + cos(theta_P)) / 2.
fn fon_kept_area(d: f32) -> f32 {
    return 0.5 + 0.5 / sqrt(1.0 + d * d);
}

// Cosine and sine of wo's azimuth; (1, 0) at normal incidence.
fn fon_azimuth(wo: vec3f) -> vec2f {
    // Below this squared sine the azimuth of wo is taken as 0: any azimuth is right there, and the square of
    // its reciprocal still fits into a float32.
    const SIN2_MIN = 1.0e-18;
    let sin2 = wo.x * wo.x + wo.y * wo.y;
    let tilted = sin2 > SIN2_MIN;
    let inv = 1.0 / sqrt(max(sin2, SIN2_MIN));
    return vec2f(select(1.0, wo.x * inv, tilted), select(0.0, wo.y * inv, tilted));
}

// A direction given relative to an azimuth (cosine, sine), about the normal turned by it.
fn fon_from_frame(w: vec3f, axis: vec2f) -> vec3f {
    return vec3f(axis.x * w.x - axis.y * w.y, axis.y * w.x + axis.x * w.y, w.z);
}

// M applied to the cosine lobe's direction above (x, y), turned to wo's azimuth, normalised.
fn fon_transform(x: f32, y: f32, wo: vec3f, r: f32, d: f32) -> vec3f {
    let coefficients_result = fon_coefficients(wo.z, fon_one_minus_cos(wo), r);
    let a = coefficients_result.a;
    let b = coefficients_result.b;
    let c = coefficients_result.c;
    let z = sqrt(max(1.0 - x * x - y * y, 0.0));
    return normalize(fon_from_frame(vec3f(a * x + b * z, c * y, d * x + z), fon_azimuth(wo)));
}

// Clipped to the directions that M keeps above the horizon (Listing 3).
fn fon_sample_cltc(wo: vec3f, r: f32, u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    // A sample that rounding pushed below the horizon is lifted to this cosine, 1/16 of a float32 epsilon.
    const Z_MIN = 7.450581e-9;
    let coefficients_result = fon_coefficients(wo.z, fon_one_minus_cos(wo), r);
    let d = coefficients_result.d;
    let R = sqrt(max(u.x, 0.0));
    let phi = two_pi * u.y;
    let y = R * sin(phi);
    // A half-disk and a half-ellipse (Heitz 2018); the plane cuts the side on which d x is negative.
    let x = mix(sqrt(max(1.0 - y * y, 0.0)), R * cos(phi), fon_kept_area(d));
    let wi = fon_transform(select(x, -x, d < 0.0), y, wo, r, d);
    return vec3f(wi.x, wi.y, max(wi.z, Z_MIN));
}

// CLTC mixed with as much of the uniform hemisphere as the roughness asks for.
fn fon_sample_cltc_matched(wo: vec3f, r: f32, u: vec2f) -> vec3f {
    // Smallest probability that is divided by: no 0 / 0, and no infinite derivative, in samples that are
    // not taken.
    const P_MIN = 1.0e-6;
    let q = fon_matched_roughness(r);
    let P_u = fon_matched_share(wo.z, q);
    let uniform = u.x < P_u;
    let u1 = select((u.x - P_u) / (1.0 - P_u), u.x / max(P_u, P_MIN), uniform);
    let w_u = fon_sample_uniform(vec2f(u1, u.y));
    let w_c = fon_sample_cltc(wo, q, vec2f(u1, u.y));
    return select(w_c, w_u, uniform);
}

// A direction relative to an azimuth (cosine, sine): the inverse of fon_from_frame.
fn fon_to_frame(w: vec3f, axis: vec2f) -> vec3f {
    return vec3f(axis.x * w.x + axis.y * w.y, axis.x * w.y - axis.y * w.x, w.z);
}

// Density of fon_transform for an unclipped cosine lobe (Eq. 23 and 24).
fn fon_cltc_pdf(wi: vec3f, wo: vec3f, r: f32, d: f32) -> f32 {
    const inv_pi = 0.31830987;
    let coefficients_result = fon_coefficients(wo.z, fon_one_minus_cos(wo), r);
    let a = coefficients_result.a;
    let b = coefficients_result.b;
    let c = coefficients_result.c;
    let w = fon_to_frame(wi, fon_azimuth(wo));
    let det = c * (a - b * d);
    // det(M) times the inverse of M, applied to w
    let h = vec3f(c * (w.x - b * w.z), (a - b * d) * w.y, c * (a * w.z - d * w.x));
    let inv2 = 1.0 / dot(h, h);
    return inv_pi * det * det * inv2 * inv2 * max(h.z, 0.0);
}

// Density of fon_sample_cltc.
fn fon_pdf_cltc(wi: vec3f, wo: vec3f, r: f32) -> f32 {
    let coefficients_result = fon_coefficients(wo.z, fon_one_minus_cos(wo), r);
    let d = coefficients_result.d;
    return fon_cltc_pdf(wi, wo, r, d) / fon_kept_area(d);
}

// Density of fon_sample_cltc_matched.
fn fon_pdf_cltc_matched(wi: vec3f, wo: vec3f, r: f32) -> f32 {
    const inv_two_pi = 0.15915494;
    let q = fon_matched_roughness(r);
    return mix(fon_pdf_cltc(wi, wo, q), inv_two_pi, fon_matched_share(wo.z, q));
}

// Density of fon_sample in 1/sr.
fn fon_pdf(params: Fon, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return fon_pdf_cltc_matched(wi, wo, params.roughness);
}

// EON's sampler, made for the same shape.
fn fon_sample(params: Fon, wo: vec3f, u: vec2f) -> FonSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return FonSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let wi = fon_sample_cltc_matched(wo, params.roughness, u);
    return FonSample(wi, fon_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// 2 atan(v) / v for v in [-1, 1], the angle whose half has the tangent v; 2 at v = 0.
fn fon_twice_atan_over(v: f32) -> f32 {
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
fn fon_safe_acos(x: f32) -> f32 {
    const pi = 3.1415927;
    let a = min(abs(x), 1.0);
    let v = sqrt(max((1.0 - a) * (1.0 + a), 0.0)) / (1.0 + a);
    let angle = v * fon_twice_atan_over(v);
    return select(angle, pi - angle, x < 0.0);
}

// Eq. 8: the integral of s/t (Eq. 4) times the cosine, at a cosine mu in [0, 1]; pi/2 at mu = 0.
fn fon_G_qualitative(mu: f32) -> f32 {
    let s = sqrt(max((1.0 - mu) * (1.0 + mu), 0.0));
    // The paper has tan(theta) (1 - s^3); with 1 - s = mu^2 / (1 + s) the division by mu cancels.
    return s * (fon_safe_acos(mu) - s * mu) + 2.0 / 3.0 * s * mu * (1.0 + s + s * s) / (1.0 + s);
}

// Eq. 13: the same for s/t of Eq. 11.
fn fon_G_fujii(mu: f32) -> f32 {
    return fon_G_qualitative(mu) - 2.0 / 3.0 * sqrt(max((1.0 - mu) * (1.0 + mu), 0.0));
}

// Eq. 12.
fn fon_albedo(params: Fon, wo: vec3f) -> vec3f {
    const inv_pi = 0.31830987;
    const C1 = 0.2877934;  // A_F = 1 / (1 + C1 r)
    if (wo.z < 0.0) {  // below the horizon
        return vec3f(0.0);
    }
    let r = params.roughness;
    return params.rho * ((1.0 + r * inv_pi * fon_G_fujii(wo.z)) / (1.0 + C1 * r));
}
