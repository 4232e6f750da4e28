// SPDX-License-Identifier: Apache-2.0
// Metallic-roughness: one colour, a metalness and a roughness, the way games describe materials.
//
// Source: "PBR theory, part 1: foundations" (SZ's temple, 2019), section 4, after Burley 2012: Lambert with
// k_d = 1 - F and c_d = base_color (1 - metallic), Cook-Torrance with GGX, Smith and Schlick, F0 between
// 0.04 and the base colour. The text leaves Smith's form open: both are here.
// Deviation: alpha = roughness^2 is at least ALPHA_MIN, where the highlight still is a function.
//
// WGSL (WebGPU), made by gonio from gonio/models/metallic_roughness.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: var params: MetallicRoughness; params.base_color = ...; ... metallic_roughness_eval(params, wi, wo)

// A sampled direction and its density.
struct MetallicRoughnessSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// metallic_roughness: Diffuse below a GGX highlight, which takes its share of the light facet by facet.
// Reciprocal. Exported with masking='smith_correlated'.
struct MetallicRoughness {
    // diffuse colour, or F0 of metals, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    base_color: vec3f,
    metallic: f32,  // 0 for dielectrics, 1 for metals; 0 to 1, default 0
    roughness: f32,  // perceptual roughness, alpha = roughness^2; 0 to 1, default 0.5
}

// Facets of GGX with the same width in all directions.
struct MetallicRoughnessRoundGGX {
    alpha: f32,  // width of the slopes
}

// Which of two lobes a sample is taken from.
struct MetallicRoughnessChoice {
    is_first: bool,  // Whether it is the first one
    u: vec2f,  // Fresh random numbers, made of those that chose
}

// Facets of GGX, also called Trowbridge-Reitz.
struct MetallicRoughnessGGX {
    alpha_x: f32,  // width of the slopes along x
    alpha_y: f32,  // width of the slopes along y
}

// ---- evaluation ----------------------------------------------------------------------------

fn metallic_roughness_f0(params: MetallicRoughness) -> vec3f {
    const F0_DIELECTRIC = 0.04;  // Reflectance of every dielectric at normal incidence.
    return mix(vec3f(F0_DIELECTRIC), params.base_color, vec3f(params.metallic));
}

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
fn metallic_roughness_length2(h: vec3f) -> f32 {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
fn metallic_roughness_cos_half(wi: vec3f, wo: vec3f) -> f32 {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(metallic_roughness_length2(wi + wo));
}

// 1 - metallic_roughness_cos_half^2, the squared sine at which light meets the facet: of half the length of
// wi - wo.
fn metallic_roughness_sin2_half(wi: vec3f, wo: vec3f) -> f32 {
    let apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
fn metallic_roughness_weight(cos_h: f32, sin2_h: f32) -> f32 {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    let k = sin2_h / (1.0 + cos_h);
    let k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
fn metallic_roughness_schlick_weight_half(wi: vec3f, wo: vec3f) -> f32 {
    return metallic_roughness_weight(metallic_roughness_cos_half(wi, wo),
        metallic_roughness_sin2_half(wi, wo));
}

// 1 - (1 - c)^5, with the factor c taken out so that it keeps its digits as c goes to 0.
fn metallic_roughness_schlick_complement(c: f32) -> f32 {
    let k = 1.0 - c;
    let k2 = k * k;
    return c * ((1.0 + k) * (1.0 + k2) + k2 * k2);
}

fn metallic_roughness_alpha(params: MetallicRoughness) -> f32 {
    // Sharpest facets: a float32 direction is good to 6e-8, a thousandth of this width, so the shape of the
    // highlight is still resolved. The peak of D, 3e7, and its derivatives fit into a float32.
    const ALPHA_MIN = 1.0e-4;
    return max(params.roughness * params.roughness, ALPHA_MIN);
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
fn metallic_roughness_slopes(h: vec3f) -> vec2f {
    let inv = 1.0 / h.z;
    return vec2f(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
fn metallic_roughness_tangent2(h: vec3f) -> f32 {
    let t = metallic_roughness_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
fn metallic_roughness_round_ggx_D_along(round_ggx: MetallicRoughnessRoundGGX, h: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    let a2 = round_ggx.alpha * round_ggx.alpha;
    let tan2 = metallic_roughness_tangent2(h);
    let r = (1.0 + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
fn metallic_roughness_round_ggx_area(round_ggx: MetallicRoughnessRoundGGX, w: vec3f) -> f32 {
    let a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrt(a2 + (1.0 - a2) * (w.z * w.z));
}

// G = 1 / (1 + Lambda_i + Lambda_o): correlated by the facet's height. Heitz 2014, Eq. 99.
fn metallic_roughness_V_smith_correlated(facets: MetallicRoughnessRoundGGX, wi: vec3f,
    wo: vec3f) -> f32 {
    return 0.5 / (wo.z * metallic_roughness_round_ggx_area(facets, wi)
        + wi.z * metallic_roughness_round_ggx_area(facets, wo));
}

// D G / (4 mu_i mu_o): the highlight without F.
fn metallic_roughness_highlight(params: MetallicRoughness, wi: vec3f, wo: vec3f) -> f32 {
    let facets = MetallicRoughnessRoundGGX(metallic_roughness_alpha(params));
    let D = metallic_roughness_round_ggx_D_along(facets, wi + wo);
    return D * metallic_roughness_V_smith_correlated(facets, wi, wo);
}

// BRDF value in 1/sr, without the cosine.
fn metallic_roughness_eval(params: MetallicRoughness, wi: vec3f, wo: vec3f) -> vec3f {
    const inv_pi = 0.31830987;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    let f0 = metallic_roughness_f0(params);
    let F = mix(f0, vec3f(1.0), vec3f(metallic_roughness_schlick_weight_half(wi, wo)));
    // 1 - F without its cancellation
    let k_d = (1.0 - f0) * metallic_roughness_schlick_complement(metallic_roughness_cos_half(wi,
        wo));
    let diffuse = inv_pi * (1.0 - params.metallic) * params.base_color * k_d;
    return diffuse + F * metallic_roughness_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// Mean of the three channels, by which lobes are weighed against each other.
fn metallic_roughness_average(color: vec3f) -> f32 {
    return (color.x + color.y + color.z) / 3.0;
}

// (1 - cos_theta)^5 of Schlick's approximation.
fn metallic_roughness_schlick_weight(cos_theta: f32) -> f32 {
    let k = 1.0 - cos_theta;
    let k2 = k * k;
    return k2 * k2 * k;
}

fn metallic_roughness_raised(probability: f32) -> f32 {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const SHARE_LEAST = 0.1;
    const ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
fn metallic_roughness_lobes_shares(first: f32, second: f32) -> vec2f {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const WEIGHT_MIN = 1.0e-37;
    let a = first + BLACK;
    let b = max(second, WEIGHT_MIN);
    let inv = 1.0 / (a + b);
    let P_first = metallic_roughness_raised(a * inv);
    let P_second = metallic_roughness_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    let smaller = a < b;
    return vec2f(select(1.0 - P_second, P_first, smaller),
        select(P_second, 1.0 - P_first, smaller));
}

// Probabilities of the diffuse lobe and of the highlight.
fn metallic_roughness_shares(params: MetallicRoughness, wo: vec3f) -> vec2f {
    let f0 = metallic_roughness_f0(params);
    let diffuse = (1.0 - params.metallic) * params.base_color * (1.0 - f0);
    return metallic_roughness_lobes_shares(metallic_roughness_average(diffuse),
        metallic_roughness_average(mix(f0, vec3f(1.0),
            vec3f(metallic_roughness_schlick_weight(wo.z)))));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
fn metallic_roughness_choose(probability: f32, u: vec2f) -> MetallicRoughnessChoice {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const SHARE_MIN = 1.0e-12;
    const RANDOM_MAX = 0.99999994;  // The largest float32 below 1, up to which random numbers go.
    let first = u.x < probability;
    let below = u.x / max(probability, SHARE_MIN);
    let above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return MetallicRoughnessChoice(first,
        vec2f(clamp(select(above, below, first), 0.0, RANDOM_MAX), u.y));
}

// A direction with density cos(theta) / pi.
fn metallic_roughness_sample_cosine(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(u.x, 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// w where all facets are those of a unit sphere.
fn metallic_roughness_ggx_unstretched(ggx: MetallicRoughnessGGX, w: vec3f) -> vec3f {
    return normalize(vec3f(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
fn metallic_roughness_ggx_half_way(ggx: MetallicRoughnessGGX, w: vec3f, drop: f32, z: f32,
    v: f32) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(drop * (2.0 - drop), 0.0));
    let phi = two_pi * v;
    let h = vec3f(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(vec3f(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
fn metallic_roughness_ggx_sample_visible(ggx: MetallicRoughnessGGX, wo: vec3f,
    u: vec2f) -> vec3f {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const RANDOM_MARGIN = 5.9604645e-8;
    let w = metallic_roughness_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    let u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    let height = 1.0 + w.z;
    return metallic_roughness_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see metallic_roughness_ggx_sample_visible.
fn metallic_roughness_round_ggx_sample_visible(round_ggx: MetallicRoughnessRoundGGX, wo: vec3f,
    u: vec2f) -> vec3f {
    return metallic_roughness_ggx_sample_visible(MetallicRoughnessGGX(round_ggx.alpha,
        round_ggx.alpha), wo, u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
fn metallic_roughness_mirror(wo: vec3f, m: vec3f) -> vec3f {
    return 2.0 * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
fn metallic_roughness_sample_ggx_lobe(facets: MetallicRoughnessRoundGGX, wo: vec3f,
    u: vec2f) -> vec3f {
    let w = metallic_roughness_mirror(wo,
        metallic_roughness_round_ggx_sample_visible(facets, wo, u));
    return vec3f(w.x, w.y, abs(w.z));
}

// A direction of one of the two lobes; shares: the probabilities of the matte one and of the other.
fn metallic_roughness_sample_matte_gloss(wo: vec3f, alpha: f32, shares: vec2f,
    u: vec2f) -> vec3f {
    let choose_result = metallic_roughness_choose(shares.x, u);
    let matte = choose_result.is_first;
    let v = choose_result.u;
    return select(metallic_roughness_sample_ggx_lobe(MetallicRoughnessRoundGGX(alpha), wo, v),
        metallic_roughness_sample_cosine(v), matte);
}

// Density of metallic_roughness_sample_cosine in 1/sr, for w above the horizon.
fn metallic_roughness_pdf_cosine(w: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Density of metallic_roughness_sample_ggx_lobe in 1/sr.
fn metallic_roughness_pdf_ggx_lobe(facets: MetallicRoughnessRoundGGX, wi: vec3f,
    wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    // Smith's G1 over 4 mu_o
    let seen = 0.5 / (wo.z + metallic_roughness_round_ggx_area(facets, wo));
    let straight = metallic_roughness_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    let exists = wo.z > wi.z;
    let across = vec3f(wi.x, wi.y, select(wi.z, wo.z - wi.z, exists));
    let folded = metallic_roughness_round_ggx_D_along(facets, across
        + vec3f(wo.x, wo.y, select(wo.z, mu_min, exists)));
    return (straight + select(0.0, folded, exists)) * seen;
}

// Density of metallic_roughness_sample_matte_gloss in 1/sr.
fn metallic_roughness_pdf_matte_gloss(wi: vec3f, wo: vec3f, alpha: f32, shares: vec2f) -> f32 {
    return shares.x * metallic_roughness_pdf_cosine(wi)
        + shares.y * metallic_roughness_pdf_ggx_lobe(MetallicRoughnessRoundGGX(alpha), wi, wo);
}

// Density of metallic_roughness_sample in 1/sr.
fn metallic_roughness_pdf(params: MetallicRoughness, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return metallic_roughness_pdf_matte_gloss(wi, wo, metallic_roughness_alpha(params),
        metallic_roughness_shares(params, wo));
}

// Cosine-weighted or a visible GGX normal, by the estimated albedos.
fn metallic_roughness_sample(params: MetallicRoughness, wo: vec3f,
    u: vec2f) -> MetallicRoughnessSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return MetallicRoughnessSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let wi = metallic_roughness_sample_matte_gloss(wo, metallic_roughness_alpha(params),
        metallic_roughness_shares(params, wo), u);
    return MetallicRoughnessSample(wi, metallic_roughness_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
fn metallic_roughness_albedo(params: MetallicRoughness, wo: vec3f) -> vec3f {
    // Steps of the rule in metallic_roughness_albedo: a Fibonacci number, and the golden ratio.
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
        let drawn = metallic_roughness_sample(params, w, u);
        let weight = select(0.0, drawn.wi.z / max(drawn.pdf, mu_min), drawn.pdf > 0.0);
        total = total + metallic_roughness_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
