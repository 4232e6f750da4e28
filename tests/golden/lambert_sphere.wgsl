// SPDX-License-Identifier: Apache-2.0
// Lambert sphere: light in a half space of white or coloured balls, each of them Lambertian.
//
// Source: d'Eon, "An analytic BRDF for materials with spherical Lambertian scatterers", Computer Graphics
// Forum 40(4), 2021: the phase function of a Lambertian ball once, and even scattering after that, with the
// function H of Hapke, "Bidirectional reflectance spectroscopy, 1: theory", Journal of Geophysical
// Research, 1981, which d'Eon compares his own fit with.
//
// WGSL (WebGPU), made by gonio from gonio/models/lambert_sphere.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: var params: LambertSphere; params.rho = ...; ... lambert_sphere_eval(params, wi, wo)

// A sampled direction and its density.
struct LambertSphereSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// lambert_sphere: Chalk and other powders: flatter than Lambert, brighter back to the light. Reciprocal.
struct LambertSphere {
    rho: vec3f,  // albedo of a single ball, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
}

// ---- evaluation ----------------------------------------------------------------------------

// H - 1 of H = (1 + 2 mu) / (1 + 2 mu gamma) with gamma = sqrt(1 - w).
fn lambert_sphere_H_minus_1(params: LambertSphere, mu: f32) -> vec3f {
    let gamma = sqrt(1.0 - params.rho);
    return 2.0 * mu * params.rho / ((1.0 + gamma) * (1.0 + 2.0 * mu * gamma));
}

// 2 atan(v) / v for v in [-1, 1], the angle whose half has the tangent v; 2 at v = 0.
fn lambert_sphere_twice_atan_over(v: f32) -> f32 {
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

// 2 (sin y - y cos y) / (3 pi^2) at the angle y that light is turned from its way.
fn lambert_sphere_phase(wi: vec3f, wo: vec3f) -> f32 {
    const pi = 3.1415927;
    // 2 / (3 pi^2) makes the mean of the phase function over all directions 1 / (4 pi).
    const PHASE = 0.067547455;
    // Below this angle to the straight direction sin y - y cos y is taken by its series: it would cancel.
    const SMALL = 0.4;
    // Twice the sine and cosine of half the angle between wi and wo; the smaller has all its digits
    let across = sqrt(dot(wi - wo, wi - wo));
    let along = length(wi + wo);
    let t = min(across, along) / max(across, along);
    let small = t * lambert_sphere_twice_atan_over(t);
    let y = select(small, pi - small, across < along);
    let y2 = y * y;
    let series = y * y2 / 3.0 * (1.0 - y2 / 10.0 * (1.0 - y2 / 28.0 * (1.0 - y2 / 54.0)));
    let exact = 0.5 * across * along + y * dot(wi, wo);
    return PHASE * select(exact, series, y < SMALL);
}

// BRDF value in 1/sr, without the cosine.
fn lambert_sphere_eval(params: LambertSphere, wi: vec3f, wo: vec3f) -> vec3f {
    const mu_min = 1.0e-18;  // cosine of the horizon
    const INV_FOUR_PI = 0.07957747;
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    let h_i = lambert_sphere_H_minus_1(params, wi.z);
    let h_o = lambert_sphere_H_minus_1(params, wo.z);
    let often = INV_FOUR_PI * (h_i + h_o + h_i * h_o);
    return params.rho * (lambert_sphere_phase(wi, wo) + often) / (wi.z + wo.z);
}

// ---- sampling ------------------------------------------------------------------------------

// A direction with density 1 / (2 pi).
fn lambert_sphere_sample_uniform(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    let z = 1.0 - u.x;
    let r = sqrt(max(u.x * (1.0 + z), 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), z);
}

// Density of lambert_sphere_sample in 1/sr.
fn lambert_sphere_pdf(params: LambertSphere, wi: vec3f, wo: vec3f) -> f32 {
    const inv_two_pi = 0.15915494;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return inv_two_pi;
}

// Uniform: mu_i / (mu_i + mu_o) has a bound.
fn lambert_sphere_sample(params: LambertSphere, wo: vec3f, u: vec2f) -> LambertSphereSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return LambertSphereSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let wi = lambert_sphere_sample_uniform(u);
    return LambertSphereSample(wi, lambert_sphere_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
fn lambert_sphere_albedo(params: LambertSphere, wo: vec3f) -> vec3f {
    // Steps of the rule in lambert_sphere_albedo: a Fibonacci number, and the golden ratio.
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
        let drawn = lambert_sphere_sample(params, w, u);
        let weight = select(0.0, drawn.wi.z / max(drawn.pdf, mu_min), drawn.pdf > 0.0);
        total = total + lambert_sphere_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
