// SPDX-License-Identifier: Apache-2.0
// Charlie: sheen of cloth, fibres that stand up.
//
// Source: Estevez, Kulla, "Production friendly microfacet sheen BRDF", SIGGRAPH 2017 course, Eq. 2 for the
// distribution; its masking grows without bound in the horizon, and real-time renderers took that of
// Neubelt, Pettineo, "Crafting a next-gen material pipeline for The Order: 1886", SIGGRAPH 2013 course,
// which is here.
//
// WGSL (WebGPU), made by gonio from gonio/models/charlie.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: var params: Charlie; params.rho = ...; ... charlie_eval(params, wi, wo)

// A sampled direction and its density.
struct CharlieSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// charlie: Velvet and felt: bright at the edges, to be laid over a base. Reciprocal.
struct Charlie {
    rho: vec3f,  // colour of the sheen, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    // roughness of the fibres; 1 / alpha is the sine's exponent; 0.05 to 1, default 0.4
    alpha: f32,
}

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
fn charlie_length2(h: vec3f) -> f32 {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
fn charlie_half_vector(wi: vec3f, wo: vec3f) -> vec3f {
    // wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
    // squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
    // much longer.
    const LENGTHENED = 1.0995116e12;
    let h = LENGTHENED * (wi + wo);
    return h / sqrt(charlie_length2(h));  // the root is the cosine's as well
}

// D / (4 (mu_i + mu_o - mu_i mu_o)): BRDF value in 1/sr, without the cosine.
fn charlie_eval(params: Charlie, wi: vec3f, wo: vec3f) -> vec3f {
    const inv_two_pi = 0.15915494;
    const mu_min = 1.0e-18;  // cosine of the horizon
    // Smallest squared sine of a half vector: below it grazing directions have no digits left for it.
    const SIN2_LEAST = 1.0e-12;
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    let m = charlie_half_vector(wi, wo);
    let inv = 1.0 / params.alpha;
    let sin2 = max(m.x * m.x + m.y * m.y, SIN2_LEAST);
    let D = inv_two_pi * (2.0 + inv) * exp(0.5 * inv * log(sin2));
    return params.rho * (0.25 * D / (wi.z + wo.z * (1.0 - wi.z)));
}

// ---- sampling ------------------------------------------------------------------------------

// A direction with density 1 / (2 pi).
fn charlie_sample_uniform(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    let z = 1.0 - u.x;
    let r = sqrt(max(u.x * (1.0 + z), 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), z);
}

// Density of charlie_sample in 1/sr.
fn charlie_pdf(params: Charlie, wi: vec3f, wo: vec3f) -> f32 {
    const inv_two_pi = 0.15915494;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return inv_two_pi;
}

// Uniform: mu_i / (mu_i + mu_o) has a bound.
fn charlie_sample(params: Charlie, wo: vec3f, u: vec2f) -> CharlieSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return CharlieSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let wi = charlie_sample_uniform(u);
    return CharlieSample(wi, charlie_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
fn charlie_albedo(params: Charlie, wo: vec3f) -> vec3f {
    // Steps of the rule in charlie_albedo: a Fibonacci number, and the golden ratio.
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
        let drawn = charlie_sample(params, w, u);
        let weight = select(0.0, drawn.wi.z / max(drawn.pdf, mu_min), drawn.pdf > 0.0);
        total = total + charlie_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
