// SPDX-License-Identifier: Apache-2.0
// Student-t: facets whose slopes have tails of any length, between Beckmann's and longer than GGX's.
//
// Source: Ribardiere, Bringier, Meneveaux, Simonot, "STD: Student's t-distribution of slopes for microfacet
// based BSDFs", Computer Graphics Forum 36(2), 2017: D and its samples. gamma = 2 is GGX, and large gammas
// come near Beckmann. Burley's GTR, "Physically-based shading at Disney", 2012, has the same family of
// tails. Deviation: G is Cook and Torrance's, which is exact for V-cavities of any facets and needs no fit.
//
// WGSL (WebGPU), made by gonio from gonio/models/student_t.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: var params: StudentT; params.f0 = ...; ... student_t_eval(params, wi, wo)

// A sampled direction and its density.
struct StudentTSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// student_t: Metals and plastics whose highlights have the tail that was measured. Reciprocal.
struct StudentT {
    f0: vec3f,  // reflectance at normal incidence, linear RGB; 0 to 1, default (0.9, 0.9, 0.9)
    alpha: f32,  // slope width: GGX's alpha at gamma = 2; 0.001 to 1, default 0.3
    // tail: 2 is GGX's, smaller is longer, 40 is nearly Beckmann's; 1.55 to 40, default 2
    gamma: f32,
}

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
fn student_t_length2(h: vec3f) -> f32 {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
fn student_t_cos_half(wi: vec3f, wo: vec3f) -> f32 {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(student_t_length2(wi + wo));
}

// 1 - student_t_cos_half^2, the squared sine at which light meets the facet: of half the length of wi - wo.
fn student_t_sin2_half(wi: vec3f, wo: vec3f) -> f32 {
    let apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
fn student_t_weight(cos_h: f32, sin2_h: f32) -> f32 {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    let k = sin2_h / (1.0 + cos_h);
    let k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
fn student_t_schlick_weight_half(wi: vec3f, wo: vec3f) -> f32 {
    return student_t_weight(student_t_cos_half(wi, wo), student_t_sin2_half(wi, wo));
}

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
fn student_t_half_vector(wi: vec3f, wo: vec3f) -> vec3f {
    // wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
    // squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
    // much longer.
    const LENGTHENED = 1.0995116e12;
    let h = LENGTHENED * (wi + wo);
    return h / sqrt(student_t_length2(h));  // the root is the cosine's as well
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
fn student_t_atanh_over(y: f32) -> f32 {
    let y2 = y * y;
    return 1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0 + y2 * (1.0 / 9.0))));
}

// log(1 + x) / x for x > -1; 1 at x = 0.
fn student_t_log1p_over(x: f32) -> f32 {
    // Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
    const LOG1P_SMALL = 0.25;
    let near = max(min(x, LOG1P_SMALL), -LOG1P_SMALL);
    let small = x > -LOG1P_SMALL && x < LOG1P_SMALL;
    let far = select(x, 1.0, small);
    let series = student_t_atanh_over(near / (2.0 + near));
    return select(log(1.0 + far) / far, 2.0 / (2.0 + near) * series, small);
}

// log(1 + x) for x > -1, exact where x is small.
fn student_t_log1p(x: f32) -> f32 {
    return x * student_t_log1p_over(x);
}

// 1 / (pi a^2 z^4 (1 + x)^g) with x = tan^2 / ((g - 1) a^2).
fn student_t_D(params: StudentT, m: vec3f) -> f32 {
    // Largest squared slope in units of the widths: more leaves a float32, and D is 0 long before.
    const RATIO_MAX = 1.0e37;
    const inv_pi = 0.31830987;
    let a2 = params.alpha * params.alpha;
    let z2 = m.z * m.z;
    let slope2 = (m.x * m.x + m.y * m.y) / ((params.gamma - 1.0) * a2);
    // z^-4 (1 + x)^-g = (z^2 + slope2)^-2 (1 + x)^(2 - g), finite in the horizon; log1p keeps the digits that a
    // large g multiplies
    let x = min(slope2 / z2, RATIO_MAX);
    let whole = z2 + slope2;
    return inv_pi / a2 / (whole * whole) * exp((2.0 - params.gamma) * student_t_log1p(x));
}

// G over 4 mu_i mu_o.
fn student_t_V_cook_torrance(wi: vec3f, wo: vec3f) -> f32 {
    // Largest V of the maskings that grow like 1 / mu^2 where both directions graze: times the largest D, 3e7,
    // it still is a float32. It is reached at cosines of 5e-16.
    const V_MAX = 1.0e30;
    let h = wi + wo;
    return min(min(h.z / student_t_length2(h) * min(wi.z, wo.z), 0.25) / (wi.z * wo.z), V_MAX);
}

// D G / (4 mu_i mu_o): the highlight without F.
fn student_t_highlight(params: StudentT, wi: vec3f, wo: vec3f) -> f32 {
    let m = student_t_half_vector(wi, wo);
    return student_t_D(params, m) * student_t_V_cook_torrance(wi, wo);
}

// F D G / (4 mu_i mu_o): BRDF value in 1/sr, without the cosine.
fn student_t_eval(params: StudentT, wi: vec3f, wo: vec3f) -> vec3f {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    return mix(params.f0, vec3f(1.0), vec3f(student_t_schlick_weight_half(wi, wo)))
        * student_t_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// exp(x) - 1, exact where x is small.
fn student_t_expm1(x: f32) -> f32 {
    // Below this the series needs few terms; above, the plain difference is exact to 2e-7 in float32.
    const EXPM1_SMALL = 0.3;
    let near = max(min(x, EXPM1_SMALL), -EXPM1_SMALL);
    // Taylor's series
    let over = 1.0 + near
        * (0.5 + near * (0.16666667
            + near * (0.041666668
                + near * (0.008333334 + near * (0.0013888889 + near * 0.0001984127)))));
    return select(exp(x) - 1.0, near * over, x > -EXPM1_SMALL && x < EXPM1_SMALL);
}

// tan^2 = (g - 1) a^2 ((1 - u)^(1 / (1 - g)) - 1).
fn student_t_normal(params: StudentT, u: vec2f) -> vec3f {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const RANDOM_MARGIN = 5.9604645e-8;
    const two_pi = 6.2831855;
    let spread = student_t_expm1(log(max(1.0 - u.x, RANDOM_MARGIN)) / (1.0 - params.gamma));
    let tangent = params.alpha * sqrt(max((params.gamma - 1.0) * spread, 0.0));
    let phi = two_pi * u.y;
    return normalize(vec3f(tangent * cos(phi), tangent * sin(phi), 1.0));
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
fn student_t_mirror(wo: vec3f, m: vec3f) -> vec3f {
    return 2.0 * dot(wo, m) * m - wo;
}

// |wi + wo| / 2, the same with all digits however short it is: for what is divided by it.
fn student_t_half_length(wi: vec3f, wo: vec3f) -> f32 {
    const LENGTHENED = 1.0995116e12;
    return 0.5 / LENGTHENED * sqrt(student_t_length2(LENGTHENED * (wi + wo)));
}

// Density of student_t_mirror in 1/sr, if m has the given density and cos_h = wo . m.
fn student_t_pdf_mirror(density: f32, cos_h: f32) -> f32 {
    // Walter et al., Eq. 14
    return 0.25 * density / cos_h;
}

// Density of student_t_sample in 1/sr.
fn student_t_pdf(params: StudentT, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    let m = student_t_half_vector(wi, wo);
    return student_t_pdf_mirror(student_t_D(params, m) * m.z, student_t_half_length(wi, wo));
}

// wo mirrored at a normal by its density.
fn student_t_sample(params: StudentT, wo: vec3f, u: vec2f) -> StudentTSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return StudentTSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let wi = student_t_mirror(wo, student_t_normal(params, u));
    return StudentTSample(wi, student_t_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
fn student_t_albedo(params: StudentT, wo: vec3f) -> vec3f {
    // Steps of the rule in student_t_albedo: a Fibonacci number, and the golden ratio.
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
        let drawn = student_t_sample(params, w, u);
        let weight = select(0.0, drawn.wi.z / max(drawn.pdf, mu_min), drawn.pdf > 0.0);
        total = total + student_t_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
