// SPDX-License-Identifier: Apache-2.0
// Lambert: ideal diffuse reflection.
//
// Source: Johann Heinrich Lambert, "Photometria", 1760.
//
// WGSL (WebGPU), made by gonio from gonio/models/lambert.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose normal is
// +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// Usage: var params: Lambert; params.rho = ...; ... lambert_eval(params, wi, wo)

// A sampled direction and its density.
struct LambertSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// lambert: Ideal diffuse: the same radiance in every direction. Reciprocal; the albedo is rho.
struct Lambert {
    rho: vec3f,  // albedo, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
}

// ---- evaluation ----------------------------------------------------------------------------

// rho / pi.
fn lambert_eval(params: Lambert, wi: vec3f, wo: vec3f) -> vec3f {
    const inv_pi = 0.31830987;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    return params.rho * inv_pi;
}

// ---- sampling ------------------------------------------------------------------------------

// A direction with density cos(theta) / pi.
fn lambert_sample_cosine(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(u.x, 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// Density of lambert_sample_cosine in 1/sr, for w above the horizon.
fn lambert_pdf_cosine(w: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Cosine-weighted, which is exact here.
fn lambert_sample(params: Lambert, wo: vec3f, u: vec2f) -> LambertSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return LambertSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let wi = lambert_sample_cosine(u);
    return LambertSample(wi, select(0.0, lambert_pdf_cosine(wi), wi.z > mu_min));
}

// cos(theta_i) / pi.
fn lambert_pdf(params: Lambert, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return lambert_pdf_cosine(wi);
}

// ---- albedo --------------------------------------------------------------------------------

// rho.
fn lambert_albedo(params: Lambert, wo: vec3f) -> vec3f {
    if (wo.z < 0.0) {  // below the horizon
        return vec3f(0.0);
    }
    return params.rho;
}
