// SPDX-License-Identifier: Apache-2.0
// UE4: the shading model of Unreal Engine 4 as it was published.
//
// Source: Karis, "Real shading in Unreal Engine 4", SIGGRAPH 2013 course "Physically based shading in
// theory and practice": Lambert, GGX with alpha = roughness^2, Schlick's masking with
// k = (roughness + 1)^2 / 8 for punctual lights and k = alpha / 2 for image-based light, F0 = 0.08 specular
// for dielectrics.
// Deviations: the Fresnel term is Schlick's power, which the engine replaces by
// 2^((-5.55473 (wo.H) - 6.98316) (wo.H)), at most 0.0038 from it; alpha is at least ALPHA_MIN.
//
// WGSL (WebGPU), made by gonio from gonio/models/ue4.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: var params: Ue4; params.base_color = ...; ... ue4_eval(params, wi, wo)

// A sampled direction and its density.
struct Ue4Sample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// ue4: Lambert plus a GGX highlight, simply added. Reciprocal; white dielectrics gain energy. Exported
// with light='punctual'.
struct Ue4 {
    // diffuse colour, or F0 of metals, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    base_color: vec3f,
    metallic: f32,  // 0 for dielectrics, 1 for metals; 0 to 1, default 0
    specular: f32,  // F0 of dielectrics in units of 0.08; 0 to 1, default 0.5
    roughness: f32,  // perceptual roughness, alpha = roughness^2; 0 to 1, default 0.5
}

// Facets of GGX with the same width in all directions.
struct Ue4RoundGGX {
    alpha: f32,  // width of the slopes
}

// Which of two lobes a sample is taken from.
struct Ue4Choice {
    is_first: bool,  // Whether it is the first one
    u: vec2f,  // Fresh random numbers, made of those that chose
}

// Facets of GGX, also called Trowbridge-Reitz.
struct Ue4GGX {
    alpha_x: f32,  // width of the slopes along x
    alpha_y: f32,  // width of the slopes along y
}

// ---- evaluation ----------------------------------------------------------------------------

fn ue4_f0(params: Ue4) -> vec3f {
    // F0 of a dielectric with specular = 1; the default of 0.5 gives 0.04.
    const F0_SPECULAR = 0.08;
    return mix(vec3f(F0_SPECULAR * params.specular), params.base_color, vec3f(params.metallic));
}

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
fn ue4_length2(h: vec3f) -> f32 {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
fn ue4_cos_half(wi: vec3f, wo: vec3f) -> f32 {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(ue4_length2(wi + wo));
}

// 1 - ue4_cos_half^2, the squared sine at which light meets the facet: of half the length of wi - wo.
fn ue4_sin2_half(wi: vec3f, wo: vec3f) -> f32 {
    let apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
fn ue4_weight(cos_h: f32, sin2_h: f32) -> f32 {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    let k = sin2_h / (1.0 + cos_h);
    let k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
fn ue4_schlick_weight_half(wi: vec3f, wo: vec3f) -> f32 {
    return ue4_weight(ue4_cos_half(wi, wo), ue4_sin2_half(wi, wo));
}

fn ue4_alpha(params: Ue4) -> f32 {
    // Sharpest facets: a float32 direction is good to 6e-8, a thousandth of this width, so the shape of the
    // highlight is still resolved. The peak of D, 3e7, and its derivatives fit into a float32.
    const ALPHA_MIN = 1.0e-4;
    return max(params.roughness * params.roughness, ALPHA_MIN);
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
fn ue4_slopes(h: vec3f) -> vec2f {
    let inv = 1.0 / h.z;
    return vec2f(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
fn ue4_tangent2(h: vec3f) -> f32 {
    let t = ue4_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
fn ue4_round_ggx_D_along(round_ggx: Ue4RoundGGX, h: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    let a2 = round_ggx.alpha * round_ggx.alpha;
    let tan2 = ue4_tangent2(h);
    let r = (1.0 + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// k = (r + 1)^2 / 8 of Unreal Engine 4's punctual lights; r is the perceptual roughness.
fn ue4_schlick_k_ue4(roughness: f32) -> f32 {
    let r = roughness + 1.0;
    return r * r / 8.0;
}

// G = G1_schlick(mu_i) G1_schlick(mu_o).
fn ue4_V_schlick(wi: vec3f, wo: vec3f, k: f32) -> f32 {
    return 0.25 / ((wi.z * (1.0 - k) + k) * (wo.z * (1.0 - k) + k));
}

// D G / (4 mu_i mu_o): the highlight without F.
fn ue4_highlight(params: Ue4, wi: vec3f, wo: vec3f) -> f32 {
    let D = ue4_round_ggx_D_along(Ue4RoundGGX(ue4_alpha(params)), wi + wo);
    return D * ue4_V_schlick(wi, wo, ue4_schlick_k_ue4(params.roughness));
}

// BRDF value in 1/sr, without the cosine.
fn ue4_eval(params: Ue4, wi: vec3f, wo: vec3f) -> vec3f {
    const inv_pi = 0.31830987;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    let F = mix(ue4_f0(params), vec3f(1.0), vec3f(ue4_schlick_weight_half(wi, wo)));
    let diffuse = inv_pi * (1.0 - params.metallic) * params.base_color;
    return diffuse + F * ue4_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// (1 - cos_theta)^5 of Schlick's approximation.
fn ue4_schlick_weight(cos_theta: f32) -> f32 {
    let k = 1.0 - cos_theta;
    let k2 = k * k;
    return k2 * k2 * k;
}

// Mean of the three channels, by which lobes are weighed against each other.
fn ue4_average(color: vec3f) -> f32 {
    return (color.x + color.y + color.z) / 3.0;
}

fn ue4_raised(probability: f32) -> f32 {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const SHARE_LEAST = 0.1;
    const ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
fn ue4_lobes_shares(first: f32, second: f32) -> vec2f {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const WEIGHT_MIN = 1.0e-37;
    let a = first + BLACK;
    let b = max(second, WEIGHT_MIN);
    let inv = 1.0 / (a + b);
    let P_first = ue4_raised(a * inv);
    let P_second = ue4_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    let smaller = a < b;
    return vec2f(select(1.0 - P_second, P_first, smaller),
        select(P_second, 1.0 - P_first, smaller));
}

// Probabilities of the diffuse lobe and of the highlight.
fn ue4_shares(params: Ue4, wo: vec3f) -> vec2f {
    let F = mix(ue4_f0(params), vec3f(1.0), vec3f(ue4_schlick_weight(wo.z)));
    return ue4_lobes_shares(ue4_average((1.0 - params.metallic) * params.base_color),
        ue4_average(F));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
fn ue4_choose(probability: f32, u: vec2f) -> Ue4Choice {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const SHARE_MIN = 1.0e-12;
    const RANDOM_MAX = 0.99999994;  // The largest float32 below 1, up to which random numbers go.
    let first = u.x < probability;
    let below = u.x / max(probability, SHARE_MIN);
    let above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return Ue4Choice(first, vec2f(clamp(select(above, below, first), 0.0, RANDOM_MAX), u.y));
}

// A direction with density cos(theta) / pi.
fn ue4_sample_cosine(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(u.x, 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// w where all facets are those of a unit sphere.
fn ue4_ggx_unstretched(ggx: Ue4GGX, w: vec3f) -> vec3f {
    return normalize(vec3f(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
fn ue4_ggx_half_way(ggx: Ue4GGX, w: vec3f, drop: f32, z: f32, v: f32) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(drop * (2.0 - drop), 0.0));
    let phi = two_pi * v;
    let h = vec3f(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(vec3f(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
fn ue4_ggx_sample_visible(ggx: Ue4GGX, wo: vec3f, u: vec2f) -> vec3f {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const RANDOM_MARGIN = 5.9604645e-8;
    let w = ue4_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    let u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    let height = 1.0 + w.z;
    return ue4_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see ue4_ggx_sample_visible.
fn ue4_round_ggx_sample_visible(round_ggx: Ue4RoundGGX, wo: vec3f, u: vec2f) -> vec3f {
    return ue4_ggx_sample_visible(Ue4GGX(round_ggx.alpha, round_ggx.alpha), wo, u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
fn ue4_mirror(wo: vec3f, m: vec3f) -> vec3f {
    return 2.0 * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
fn ue4_sample_ggx_lobe(facets: Ue4RoundGGX, wo: vec3f, u: vec2f) -> vec3f {
    let w = ue4_mirror(wo, ue4_round_ggx_sample_visible(facets, wo, u));
    return vec3f(w.x, w.y, abs(w.z));
}

// A direction of one of the two lobes; shares: the probabilities of the matte one and of the other.
fn ue4_sample_matte_gloss(wo: vec3f, alpha: f32, shares: vec2f, u: vec2f) -> vec3f {
    let choose_result = ue4_choose(shares.x, u);
    let matte = choose_result.is_first;
    let v = choose_result.u;
    return select(ue4_sample_ggx_lobe(Ue4RoundGGX(alpha), wo, v), ue4_sample_cosine(v), matte);
}

// Density of ue4_sample_cosine in 1/sr, for w above the horizon.
fn ue4_pdf_cosine(w: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
fn ue4_round_ggx_area(round_ggx: Ue4RoundGGX, w: vec3f) -> f32 {
    let a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrt(a2 + (1.0 - a2) * (w.z * w.z));
}

// Density of ue4_sample_ggx_lobe in 1/sr.
fn ue4_pdf_ggx_lobe(facets: Ue4RoundGGX, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    let seen = 0.5 / (wo.z + ue4_round_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    let straight = ue4_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    let exists = wo.z > wi.z;
    let across = vec3f(wi.x, wi.y, select(wi.z, wo.z - wi.z, exists));
    let folded = ue4_round_ggx_D_along(facets, across
        + vec3f(wo.x, wo.y, select(wo.z, mu_min, exists)));
    return (straight + select(0.0, folded, exists)) * seen;
}

// Density of ue4_sample_matte_gloss in 1/sr.
fn ue4_pdf_matte_gloss(wi: vec3f, wo: vec3f, alpha: f32, shares: vec2f) -> f32 {
    return shares.x * ue4_pdf_cosine(wi) + shares.y * ue4_pdf_ggx_lobe(Ue4RoundGGX(alpha), wi, wo);
}

// Density of ue4_sample in 1/sr.
fn ue4_pdf(params: Ue4, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return ue4_pdf_matte_gloss(wi, wo, ue4_alpha(params), ue4_shares(params, wo));
}

// Cosine-weighted or a visible GGX normal, by the estimated albedos.
fn ue4_sample(params: Ue4, wo: vec3f, u: vec2f) -> Ue4Sample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return Ue4Sample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let wi = ue4_sample_matte_gloss(wo, ue4_alpha(params), ue4_shares(params, wo), u);
    return Ue4Sample(wi, ue4_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
fn ue4_albedo(params: Ue4, wo: vec3f) -> vec3f {
    // Steps of the rule in ue4_albedo: a Fibonacci number, and the golden ratio.
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
        let drawn = ue4_sample(params, w, u);
        let weight = select(0.0, drawn.wi.z / max(drawn.pdf, mu_min), drawn.pdf > 0.0);
        total = total + ue4_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
