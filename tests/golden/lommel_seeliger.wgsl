// SPDX-License-Identifier: Apache-2.0
// Lommel-Seeliger: single scattering in a half space of dark dust, such as the Moon's.
//
// Source: Seeliger, "Zur Photometrie des Saturnringes", Astronomische Nachrichten 109, 1884, in the form
// of Hapke, "Bidirectional reflectance spectroscopy, 1: theory", Journal of Geophysical Research 86, 1981,
// Eq. 15 without its other orders, for grains that scatter evenly in all directions. The albedos are
// integrated here.
//
// WGSL (WebGPU), made by gonio from gonio/models/lommel_seeliger.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// Usage: var params: LommelSeeliger; params.rho = ...; ... lommel_seeliger_eval(params, wi, wo)

// A sampled direction and its density.
struct LommelSeeligerSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// lommel_seeliger: Dark dust that scatters light once; a full moon without dark limbs. Reciprocal.
struct LommelSeeliger {
    // single-scattering albedo w of a grain, linear RGB; 0 to 1, default (0.3, 0.3, 0.3)
    rho: vec3f,
}

// ---- evaluation ----------------------------------------------------------------------------

// w / (4 pi (mu_i + mu_o)): BRDF value in 1/sr, without the cosine.
fn lommel_seeliger_eval(params: LommelSeeliger, wi: vec3f, wo: vec3f) -> vec3f {
    const mu_min = 1.0e-18;  // cosine of the horizon
    const INV_FOUR_PI = 0.07957747;
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    return params.rho * (INV_FOUR_PI / (wi.z + wo.z));
}

// ---- sampling ------------------------------------------------------------------------------

// A direction with density 1 / (2 pi).
fn lommel_seeliger_sample_uniform(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    let z = 1.0 - u.x;
    let r = sqrt(max(u.x * (1.0 + z), 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), z);
}

// Density of lommel_seeliger_sample in 1/sr.
fn lommel_seeliger_pdf(params: LommelSeeliger, wi: vec3f, wo: vec3f) -> f32 {
    const inv_two_pi = 0.15915494;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return inv_two_pi;
}

// Uniform: the weight, w / 2 mu_i / (mu_i + mu_o), has a bound.
fn lommel_seeliger_sample(params: LommelSeeliger, wo: vec3f, u: vec2f) -> LommelSeeligerSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return LommelSeeligerSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let wi = lommel_seeliger_sample_uniform(u);
    return LommelSeeligerSample(wi, lommel_seeliger_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
fn lommel_seeliger_atanh_over(y: f32) -> f32 {
    let y2 = y * y;
    return 1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0 + y2 * (1.0 / 9.0))));
}

// log(1 + x) / x for x > -1; 1 at x = 0.
fn lommel_seeliger_log1p_over(x: f32) -> f32 {
    // Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
    const LOG1P_SMALL = 0.25;
    let near = max(min(x, LOG1P_SMALL), -LOG1P_SMALL);
    let small = x > -LOG1P_SMALL && x < LOG1P_SMALL;
    let far = select(x, 1.0, small);
    let series = lommel_seeliger_atanh_over(near / (2.0 + near));
    return select(log(1.0 + far) / far, 2.0 / (2.0 + near) * series, small);
}

// log(1 + x) for x > -1, exact where x is small.
fn lommel_seeliger_log1p(x: f32) -> f32 {
    return x * lommel_seeliger_log1p_over(x);
}

// w / 2 (1 - mu_o log((1 + mu_o) / mu_o)).
fn lommel_seeliger_albedo(params: LommelSeeliger, wo: vec3f) -> vec3f {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z < 0.0) {  // below the horizon
        return vec3f(0.0);
    }
    let mu = wo.z;
    return params.rho * (0.5 - 0.5 * mu * (lommel_seeliger_log1p(mu) - log(max(mu, mu_min))));
}
