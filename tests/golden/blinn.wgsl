// SPDX-License-Identifier: Apache-2.0
// Blinn: a diffuse term and a highlight around the half vector, as early hardware shaded it.
//
// Source: Blinn, "Models of light reflection for computer synthesized pictures", SIGGRAPH 1977: Phong's
// formula with the angle between the normal and the half vector in place of that to the mirror direction.
// The formula gives the radiance f cos(theta_i), which is divided by the cosine here.
//
// WGSL (WebGPU), made by gonio from gonio/models/blinn.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: var params: Blinn; params.rho = ...; ... blinn_eval(params, wi, wo)

// A sampled direction and its density.
struct BlinnSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// blinn: The classic Blinn-Phong: diffuse, specular and gloss, without Fresnel or normalisation.
struct Blinn {
    rho: vec3f,  // albedo of the diffuse term, linear RGB; 0 to 1, default (0.5, 0.5, 0.5)
    specular: vec3f,  // weight of the highlight, linear RGB; 0 to 1, default (0.3, 0.3, 0.3)
    shininess: f32,  // exponent n of the highlight, its gloss; 0 to 100000, default 50
}

// Which of two lobes a sample is taken from.
struct BlinnChoice {
    is_first: bool,  // Whether it is the first one
    u: vec2f,  // Fresh random numbers, made of those that chose
}

// Facets of GGX with the same width in all directions.
struct BlinnRoundGGX {
    alpha: f32,  // width of the slopes
}

// Facets of GGX, also called Trowbridge-Reitz.
struct BlinnGGX {
    alpha_x: f32,  // width of the slopes along x
    alpha_y: f32,  // width of the slopes along y
}

// ---- evaluation ----------------------------------------------------------------------------

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
fn blinn_slopes(h: vec3f) -> vec2f {
    let inv = 1.0 / h.z;
    return vec2f(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
fn blinn_tangent2(h: vec3f) -> f32 {
    let t = blinn_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
fn blinn_atanh_over(y: f32) -> f32 {
    let y2 = y * y;
    return 1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0 + y2 * (1.0 / 9.0))));
}

// log(cos) of the angle between the normal and h, which need not be unit.
fn blinn_log_cos_along(h: vec3f) -> f32 {
    // Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
    const LOG1P_SMALL = 0.25;
    // log(cos) = -log(1 + tan^2) / 2 = -atanh(y)
    let tan2 = blinn_tangent2(h);
    let y = tan2 / (2.0 + tan2);
    return select(-0.5 * log(1.0 + tan2), -y * blinn_atanh_over(y), tan2 < LOG1P_SMALL);
}

// (N.m)^exponent of the normal m along h, exact for sharp lobes.
fn blinn_cos_power(h: vec3f, exponent: f32) -> f32 {
    return exp(exponent * blinn_log_cos_along(h));
}

// The highlight without its weight.
fn blinn_highlight(params: Blinn, wi: vec3f, wo: vec3f) -> f32 {
    return blinn_cos_power(wi + wo, params.shininess) / wi.z;
}

// BRDF value in 1/sr, without the cosine.
fn blinn_eval(params: Blinn, wi: vec3f, wo: vec3f) -> vec3f {
    const inv_pi = 0.31830987;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    return params.rho * inv_pi + params.specular * blinn_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// The width that matches an exponent n: sqrt(2 / (n + 2)).
fn blinn_blinn_phong_alpha(exponent: f32) -> f32 {
    return sqrt(2.0 / (exponent + 2.0));
}

// Mean of the three channels, by which lobes are weighed against each other.
fn blinn_average(color: vec3f) -> f32 {
    return (color.x + color.y + color.z) / 3.0;
}

fn blinn_raised(probability: f32) -> f32 {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const SHARE_LEAST = 0.1;
    const ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
fn blinn_lobes_shares(first: f32, second: f32) -> vec2f {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const WEIGHT_MIN = 1.0e-37;
    let a = first + BLACK;
    let b = max(second, WEIGHT_MIN);
    let inv = 1.0 / (a + b);
    let P_first = blinn_raised(a * inv);
    let P_second = blinn_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    let smaller = a < b;
    return vec2f(select(1.0 - P_second, P_first, smaller),
        select(P_second, 1.0 - P_first, smaller));
}

// Probabilities of the diffuse lobe and of the highlight.
fn blinn_shares(params: Blinn, wo: vec3f) -> vec2f {
    const pi = 3.1415927;
    // 4 mu_h dw_h of a narrow lobe; half of it lies below the horizon at grazing angles
    let highlight = 4.0 * pi / (params.shininess + 2.0) * (1.0 + wo.z);
    return blinn_lobes_shares(blinn_average(params.rho),
        blinn_average(params.specular) * highlight);
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
fn blinn_choose(probability: f32, u: vec2f) -> BlinnChoice {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const SHARE_MIN = 1.0e-12;
    const RANDOM_MAX = 0.99999994;  // The largest float32 below 1, up to which random numbers go.
    let first = u.x < probability;
    let below = u.x / max(probability, SHARE_MIN);
    let above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return BlinnChoice(first, vec2f(clamp(select(above, below, first), 0.0, RANDOM_MAX), u.y));
}

// A direction with density cos(theta) / pi.
fn blinn_sample_cosine(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(u.x, 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// w where all facets are those of a unit sphere.
fn blinn_ggx_unstretched(ggx: BlinnGGX, w: vec3f) -> vec3f {
    return normalize(vec3f(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
fn blinn_ggx_half_way(ggx: BlinnGGX, w: vec3f, drop: f32, z: f32, v: f32) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(drop * (2.0 - drop), 0.0));
    let phi = two_pi * v;
    let h = vec3f(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(vec3f(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
fn blinn_ggx_sample_visible(ggx: BlinnGGX, wo: vec3f, u: vec2f) -> vec3f {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const RANDOM_MARGIN = 5.9604645e-8;
    let w = blinn_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    let u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    let height = 1.0 + w.z;
    return blinn_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see blinn_ggx_sample_visible.
fn blinn_round_ggx_sample_visible(round_ggx: BlinnRoundGGX, wo: vec3f, u: vec2f) -> vec3f {
    return blinn_ggx_sample_visible(BlinnGGX(round_ggx.alpha, round_ggx.alpha), wo, u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
fn blinn_mirror(wo: vec3f, m: vec3f) -> vec3f {
    return 2.0 * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
fn blinn_sample_ggx_lobe(facets: BlinnRoundGGX, wo: vec3f, u: vec2f) -> vec3f {
    let w = blinn_mirror(wo, blinn_round_ggx_sample_visible(facets, wo, u));
    return vec3f(w.x, w.y, abs(w.z));
}

// A direction of one of the two lobes; shares: the probabilities of the matte one and of the other.
fn blinn_sample_matte_gloss(wo: vec3f, alpha: f32, shares: vec2f, u: vec2f) -> vec3f {
    let choose_result = blinn_choose(shares.x, u);
    let matte = choose_result.is_first;
    let v = choose_result.u;
    return select(blinn_sample_ggx_lobe(BlinnRoundGGX(alpha), wo, v), blinn_sample_cosine(v),
        matte);
}

// Density of blinn_sample_cosine in 1/sr, for w above the horizon.
fn blinn_pdf_cosine(w: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
fn blinn_round_ggx_area(round_ggx: BlinnRoundGGX, w: vec3f) -> f32 {
    let a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrt(a2 + (1.0 - a2) * (w.z * w.z));
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
fn blinn_round_ggx_D_along(round_ggx: BlinnRoundGGX, h: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    let a2 = round_ggx.alpha * round_ggx.alpha;
    let tan2 = blinn_tangent2(h);
    let r = (1.0 + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// Density of blinn_sample_ggx_lobe in 1/sr.
fn blinn_pdf_ggx_lobe(facets: BlinnRoundGGX, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    let seen = 0.5 / (wo.z + blinn_round_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    let straight = blinn_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    let exists = wo.z > wi.z;
    let across = vec3f(wi.x, wi.y, select(wi.z, wo.z - wi.z, exists));
    let folded = blinn_round_ggx_D_along(facets, across
        + vec3f(wo.x, wo.y, select(wo.z, mu_min, exists)));
    return (straight + select(0.0, folded, exists)) * seen;
}

// Density of blinn_sample_matte_gloss in 1/sr.
fn blinn_pdf_matte_gloss(wi: vec3f, wo: vec3f, alpha: f32, shares: vec2f) -> f32 {
    return shares.x * blinn_pdf_cosine(wi)
        + shares.y * blinn_pdf_ggx_lobe(BlinnRoundGGX(alpha), wi, wo);
}

// Density of blinn_sample in 1/sr.
fn blinn_pdf(params: Blinn, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return blinn_pdf_matte_gloss(wi, wo, blinn_blinn_phong_alpha(params.shininess),
        blinn_shares(params, wo));
}

// Cosine-weighted, or the GGX lobe of the same width, whose longer tail bounds the weights.
fn blinn_sample(params: Blinn, wo: vec3f, u: vec2f) -> BlinnSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return BlinnSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let wi = blinn_sample_matte_gloss(wo, blinn_blinn_phong_alpha(params.shininess),
        blinn_shares(params, wo), u);
    return BlinnSample(wi, blinn_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
fn blinn_albedo(params: Blinn, wo: vec3f) -> vec3f {
    // Steps of the rule in blinn_albedo: a Fibonacci number, and the golden ratio.
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
        let drawn = blinn_sample(params, w, u);
        let weight = select(0.0, drawn.wi.z / max(drawn.pdf, mu_min), drawn.pdf > 0.0);
        total = total + blinn_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
