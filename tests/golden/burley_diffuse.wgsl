// SPDX-License-Identifier: Apache-2.0
// Burley diffuse: the diffuse lobe of Disney's principled model.
//
// Source: Burley, "Physically-based shading at Disney", SIGGRAPH 2012 course notes, section 5.3.
// The albedo's closed form is ours: the BRDF is a polynomial in cosines once 2 cos^2(theta_d) is written as
// 1 + dot(wi, wo), so it can be integrated term by term.
//
// WGSL (WebGPU), made by gonio from gonio/models/burley_diffuse.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// Usage: var params: BurleyDiffuse; params.rho = ...; ... burley_diffuse_eval(params, wi, wo)

// A sampled direction and its density.
struct BurleyDiffuseSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// burley_diffuse: Diffuse with darker edges when smooth and a bright rim when rough. Reciprocal.
struct BurleyDiffuse {
    rho: vec3f,  // base colour, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    roughness: f32,  // perceptual roughness, not alpha; 0 to 1, default 0.5
}

// ---- evaluation ----------------------------------------------------------------------------

// (1 - cos_theta)^5 of Schlick's approximation.
fn burley_diffuse_schlick_weight(cos_theta: f32) -> f32 {
    let k = 1.0 - cos_theta;
    let k2 = k * k;
    return k2 * k2 * k;
}

// BRDF value in 1/sr, without the cosine.
fn burley_diffuse_eval(params: BurleyDiffuse, wi: vec3f, wo: vec3f) -> vec3f {
    const inv_pi = 0.31830987;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    // F90 = 0.5 + 2 roughness cos^2(theta_d), and 2 cos^2(theta_d) = 1 + dot(wi, wo)
    let rise = params.roughness * (1.0 + dot(wi, wo)) - 0.5;
    let fresnel_i = 1.0 + rise * burley_diffuse_schlick_weight(wi.z);
    let fresnel_o = 1.0 + rise * burley_diffuse_schlick_weight(wo.z);
    return params.rho * (inv_pi * fresnel_i * fresnel_o);
}

// ---- sampling ------------------------------------------------------------------------------

// A direction with density cos(theta) / pi.
fn burley_diffuse_sample_cosine(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(u.x, 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// Density of burley_diffuse_sample_cosine in 1/sr, for w above the horizon.
fn burley_diffuse_pdf_cosine(w: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Cosine-weighted: the weight is the product of two Fresnel factors of at most 2.5.
fn burley_diffuse_sample(params: BurleyDiffuse, wo: vec3f, u: vec2f) -> BurleyDiffuseSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return BurleyDiffuseSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let wi = burley_diffuse_sample_cosine(u);
    return BurleyDiffuseSample(wi, select(0.0, burley_diffuse_pdf_cosine(wi), wi.z > mu_min));
}

// Density of burley_diffuse_sample in 1/sr.
fn burley_diffuse_pdf(params: BurleyDiffuse, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return burley_diffuse_pdf_cosine(wi);
}

// ---- albedo --------------------------------------------------------------------------------

// Integral of burley_diffuse_eval times the cosine.
fn burley_diffuse_albedo(params: BurleyDiffuse, wo: vec3f) -> vec3f {
    const I1 = 0.023809524;  // Integrals of (1 - mu)^5 mu^k over mu in [0, 1], k = 1, 2, 3.
    const I2 = 0.005952381;
    const I3 = 0.001984127;
    if (wo.z < 0.0) {  // below the horizon
        return vec3f(0.0);
    }
    let r = params.roughness;
    let a = r - 0.5;
    let mu = wo.z;
    let w = burley_diffuse_schlick_weight(wo.z);
    let both = a * a * I1 + 2.0 * a * r * mu * I2
        + r * r * (mu * mu * I3 + (1.0 - mu * mu) * (I1 - I3) / 2.0);
    return params.rho * (1.0 + 2.0 * (a * I1 + r * mu * I2) + w * (a + 2.0 / 3.0 * r * mu)
        + 2.0 * w * both);
}
