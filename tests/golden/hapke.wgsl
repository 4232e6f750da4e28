// SPDX-License-Identifier: Apache-2.0
// Hapke: light in a half space of grains, as planetary science reads the Moon and asteroids.
//
// Source: Hapke, "Bidirectional reflectance spectroscopy, 1: theory", Journal of Geophysical Research,
// 1981: Eq. 16 with the function H of its two-stream solution; the opposition effect in the form of
// "Bidirectional reflectance spectroscopy, 4: the extinction coefficient and the opposition effect", Icarus
// 67, 1986. Grains scatter by the function of Henyey, Greenstein, "Diffuse radiation in the galaxy",
// Astrophysical Journal 93,
// 1941. Macroscopic roughness is not there.
//
// WGSL (WebGPU), made by gonio from gonio/models/hapke.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: var params: Hapke; params.rho = ...; ... hapke_eval(params, wi, wo)

// A sampled direction and its density.
struct HapkeSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// hapke: Regolith: dust that scatters once by its phase function, and often. Reciprocal.
struct Hapke {
    // single-scattering albedo w of a grain, linear RGB; 0 to 1, default (0.3, 0.3, 0.3)
    rho: vec3f,
    // b of Henyey and Greenstein: below 0 back to the light, above 0 onwards; -0.8 to 0.8, default -0.2
    asymmetry: f32,
    opposition: f32,  // strength B0 of the brighter spot around the light; 0 to 1, default 0.8
    opposition_width: f32,  // width h of that spot; radians, about; 0.02 to 1, default 0.06
}

// ---- evaluation ----------------------------------------------------------------------------

// B0 / (1 + tan(g / 2) / h), with the tangent from the lengths of difference and sum.
fn hapke_opposition(params: Hapke, wi: vec3f, wo: vec3f) -> f32 {
    let scaled = params.opposition_width * length(wi + wo);
    return params.opposition * scaled / (scaled + sqrt(dot(wi - wo, wi - wo)));
}

// Henyey and Greenstein's function at the phase angle between light and viewer, mean 1.
fn hapke_phase(params: Hapke, wi: vec3f, wo: vec3f) -> f32 {
    let b = params.asymmetry;
    // 1 + 2 b cos(g) + b^2 as a sum of squares
    let v = wi + b * wo;
    let q = dot(v, v);
    return (1.0 - b) * (1.0 + b) / (q * sqrt(q));
}

// H - 1 of H = (1 + 2 mu) / (1 + 2 mu gamma) with gamma = sqrt(1 - w).
fn hapke_H_minus_1(params: Hapke, mu: f32) -> vec3f {
    let gamma = sqrt(1.0 - params.rho);
    return 2.0 * mu * params.rho / ((1.0 + gamma) * (1.0 + 2.0 * mu * gamma));
}

// Eq. 16 over mu_i: BRDF value in 1/sr, without the cosine.
fn hapke_eval(params: Hapke, wi: vec3f, wo: vec3f) -> vec3f {
    const mu_min = 1.0e-18;  // cosine of the horizon
    const INV_FOUR_PI = 0.07957747;
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    let once = (1.0 + hapke_opposition(params, wi, wo)) * hapke_phase(params, wi, wo);
    // H_i H_o - 1 without its cancellation
    let h_i = hapke_H_minus_1(params, wi.z);
    let h_o = hapke_H_minus_1(params, wo.z);
    let often = h_i + h_o + h_i * h_o;
    return params.rho * (once + often) * (INV_FOUR_PI / (wi.z + wo.z));
}

// ---- sampling ------------------------------------------------------------------------------

// A direction with density 1 / (2 pi).
fn hapke_sample_uniform(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    let z = 1.0 - u.x;
    let r = sqrt(max(u.x * (1.0 + z), 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), z);
}

// Density of hapke_sample in 1/sr.
fn hapke_pdf(params: Hapke, wi: vec3f, wo: vec3f) -> f32 {
    const inv_two_pi = 0.15915494;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return inv_two_pi;
}

// Uniform: mu_i / (mu_i + mu_o) has a bound.
fn hapke_sample(params: Hapke, wo: vec3f, u: vec2f) -> HapkeSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return HapkeSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let wi = hapke_sample_uniform(u);
    return HapkeSample(wi, hapke_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
fn hapke_albedo(params: Hapke, wo: vec3f) -> vec3f {
    // Steps of the rule in hapke_albedo: a Fibonacci number, and the golden ratio.
    const ALBEDO_SAMPLES = 987.0;
    const GOLDEN = 0.618034;
    // Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
    const HORIZON = 1.0e-6;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z < 0.0) {  // below the horizon
        return vec3f(0.0);
    }
    let w = vec3f(wo.x, wo.y, max(wo.z, HORIZON));
    var total = vec3f(0.0);
    for (var i_step = 0; i_step < i32(ALBEDO_SAMPLES); i_step++) {
        let i = f32(i_step);
        let u = vec2f((i + 0.5) / ALBEDO_SAMPLES, fract((i + 0.5) * GOLDEN));
        let drawn = hapke_sample(params, w, u);
        let weight = select(0.0, drawn.wi.z / max(drawn.pdf, mu_min), drawn.pdf > 0.0);
        total = total + hapke_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
