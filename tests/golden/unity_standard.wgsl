// SPDX-License-Identifier: Apache-2.0
// Unity Standard: BRDF1, the full-quality shading of Unity's built-in render pipeline.
//
// Source: "PBR theory, part 1: foundations" (SZ's temple, 2019), section 5, which walks through
// UnityStandardBRDF.cginc of Unity 2018.2. Unity's own value is pi times f: its diffuse term is not divided
// by pi and its highlight is multiplied by it. The article misses a division by 4 mu_i mu_o, but Unity's V
// holds it already.
// Where it departs from physics: k_d is the constant 0.96 (1 - metallic) in place of 1 - F, so that the
// diffuse term takes no notice of the Fresnel reflection above it; V replaces sqrt(mu^2 + alpha^2 sin^2) of
// Smith by mu (1 - alpha) + alpha.
// Deviation: Unity adds 1e-5 to V's and 1e-7 to D's denominator, against division by zero; neither is here.
// The second dims its highlights: the peak by 4 % at roughness 0.2, 28 % at 0.15 and 91 % at 0.1.
//
// WGSL (WebGPU), made by gonio from gonio/models/unity_standard.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: var params: UnityStandard; params.base_color = ...; ... unity_standard_eval(params, wi, wo)

// A sampled direction and its density.
struct UnityStandardSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// unity_standard: Burley diffuse plus a GGX highlight with a cheaper Smith term. Reciprocal; gains energy.
struct UnityStandard {
    // diffuse colour, or F0 of metals, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    base_color: vec3f,
    metallic: f32,  // 0 for dielectrics, 1 for metals; 0 to 1, default 0
    roughness: f32,  // perceptual roughness, 1 - Unity's smoothness; 0 to 1, default 0.5
}

// Facets of GGX with the same width in all directions.
struct UnityStandardRoundGGX {
    alpha: f32,  // width of the slopes
}

// Which of two lobes a sample is taken from.
struct UnityStandardChoice {
    is_first: bool,  // Whether it is the first one
    u: vec2f,  // Fresh random numbers, made of those that chose
}

// Facets of GGX, also called Trowbridge-Reitz.
struct UnityStandardGGX {
    alpha_x: f32,  // width of the slopes along x
    alpha_y: f32,  // width of the slopes along y
}

// ---- evaluation ----------------------------------------------------------------------------

// (1 - cos_theta)^5 of Schlick's approximation.
fn unity_standard_schlick_weight(cos_theta: f32) -> f32 {
    let k = 1.0 - cos_theta;
    let k2 = k * k;
    return k2 * k2 * k;
}

fn unity_standard_f0(params: UnityStandard) -> vec3f {
    const F0_DIELECTRIC = 0.04;  // reflectance of dielectrics (linear colour space)
    return mix(vec3f(F0_DIELECTRIC), params.base_color, vec3f(params.metallic));
}

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
fn unity_standard_length2(h: vec3f) -> f32 {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
fn unity_standard_cos_half(wi: vec3f, wo: vec3f) -> f32 {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(unity_standard_length2(wi + wo));
}

// 1 - unity_standard_cos_half^2, the squared sine at which light meets the facet: of half the length of wi
// - wo.
fn unity_standard_sin2_half(wi: vec3f, wo: vec3f) -> f32 {
    let apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
fn unity_standard_weight(cos_h: f32, sin2_h: f32) -> f32 {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    let k = sin2_h / (1.0 + cos_h);
    let k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
fn unity_standard_schlick_weight_half(wi: vec3f, wo: vec3f) -> f32 {
    return unity_standard_weight(unity_standard_cos_half(wi, wo), unity_standard_sin2_half(wi, wo));
}

fn unity_standard_diffuse(params: UnityStandard) -> vec3f {
    const F0_DIELECTRIC = 0.04;  // reflectance of dielectrics (linear colour space)
    return (1.0 - F0_DIELECTRIC) * (1.0 - params.metallic) * params.base_color;
}

fn unity_standard_alpha(params: UnityStandard) -> f32 {
    const ALPHA_UNITY = 0.002;  // lower limit of alpha
    return max(params.roughness * params.roughness, ALPHA_UNITY);
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
fn unity_standard_slopes(h: vec3f) -> vec2f {
    let inv = 1.0 / h.z;
    return vec2f(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
fn unity_standard_tangent2(h: vec3f) -> f32 {
    let t = unity_standard_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
fn unity_standard_round_ggx_D_along(round_ggx: UnityStandardRoundGGX, h: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    let a2 = round_ggx.alpha * round_ggx.alpha;
    let tan2 = unity_standard_tangent2(h);
    let r = (1.0 + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// D V: the highlight without F.
fn unity_standard_highlight(params: UnityStandard, wi: vec3f, wo: vec3f) -> f32 {
    let alpha = unity_standard_alpha(params);
    let lambda_v = wi.z * mix(alpha, 1.0, wo.z);
    let lambda_l = wo.z * mix(alpha, 1.0, wi.z);
    let D = unity_standard_round_ggx_D_along(UnityStandardRoundGGX(alpha), wi + wo);
    return D * (0.5 / (lambda_v + lambda_l));
}

// BRDF value in 1/sr, without the cosine.
fn unity_standard_eval(params: UnityStandard, wi: vec3f, wo: vec3f) -> vec3f {
    const inv_pi = 0.31830987;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    let r = params.roughness;
    // F90 = 0.5 + 2 roughness cos^2(theta_d), and 2 cos^2(theta_d) = 1 + dot(wi, wo)
    let rise = r * (1.0 + dot(wi, wo)) - 0.5;
    let burley = (1.0 + rise * unity_standard_schlick_weight(wi.z))
        * (1.0 + rise * unity_standard_schlick_weight(wo.z));
    let F = mix(unity_standard_f0(params), vec3f(1.0),
        vec3f(unity_standard_schlick_weight_half(wi, wo)));
    return inv_pi * burley * unity_standard_diffuse(params)
        + F * unity_standard_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// Mean of the three channels, by which lobes are weighed against each other.
fn unity_standard_average(color: vec3f) -> f32 {
    return (color.x + color.y + color.z) / 3.0;
}

fn unity_standard_raised(probability: f32) -> f32 {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const SHARE_LEAST = 0.1;
    const ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
fn unity_standard_lobes_shares(first: f32, second: f32) -> vec2f {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const WEIGHT_MIN = 1.0e-37;
    let a = first + BLACK;
    let b = max(second, WEIGHT_MIN);
    let inv = 1.0 / (a + b);
    let P_first = unity_standard_raised(a * inv);
    let P_second = unity_standard_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    let smaller = a < b;
    return vec2f(select(1.0 - P_second, P_first, smaller),
        select(P_second, 1.0 - P_first, smaller));
}

// Probabilities of the diffuse lobe and of the highlight.
fn unity_standard_shares(params: UnityStandard, wo: vec3f) -> vec2f {
    let F = mix(unity_standard_f0(params), vec3f(1.0), vec3f(unity_standard_schlick_weight(wo.z)));
    return unity_standard_lobes_shares(unity_standard_average(unity_standard_diffuse(params)),
        unity_standard_average(F));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
fn unity_standard_choose(probability: f32, u: vec2f) -> UnityStandardChoice {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const SHARE_MIN = 1.0e-12;
    const RANDOM_MAX = 0.99999994;  // The largest float32 below 1, up to which random numbers go.
    let first = u.x < probability;
    let below = u.x / max(probability, SHARE_MIN);
    let above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return UnityStandardChoice(first,
        vec2f(clamp(select(above, below, first), 0.0, RANDOM_MAX), u.y));
}

// A direction with density cos(theta) / pi.
fn unity_standard_sample_cosine(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(u.x, 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// w where all facets are those of a unit sphere.
fn unity_standard_ggx_unstretched(ggx: UnityStandardGGX, w: vec3f) -> vec3f {
    return normalize(vec3f(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
fn unity_standard_ggx_half_way(ggx: UnityStandardGGX, w: vec3f, drop: f32, z: f32,
    v: f32) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(drop * (2.0 - drop), 0.0));
    let phi = two_pi * v;
    let h = vec3f(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(vec3f(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
fn unity_standard_ggx_sample_visible(ggx: UnityStandardGGX, wo: vec3f, u: vec2f) -> vec3f {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const RANDOM_MARGIN = 5.9604645e-8;
    let w = unity_standard_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    let u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    let height = 1.0 + w.z;
    return unity_standard_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see unity_standard_ggx_sample_visible.
fn unity_standard_round_ggx_sample_visible(round_ggx: UnityStandardRoundGGX, wo: vec3f,
    u: vec2f) -> vec3f {
    return unity_standard_ggx_sample_visible(UnityStandardGGX(round_ggx.alpha, round_ggx.alpha), wo,
        u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
fn unity_standard_mirror(wo: vec3f, m: vec3f) -> vec3f {
    return 2.0 * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
fn unity_standard_sample_ggx_lobe(facets: UnityStandardRoundGGX, wo: vec3f, u: vec2f) -> vec3f {
    let w = unity_standard_mirror(wo, unity_standard_round_ggx_sample_visible(facets, wo, u));
    return vec3f(w.x, w.y, abs(w.z));
}

// A direction of one of the two lobes; shares: the probabilities of the matte one and of the other.
fn unity_standard_sample_matte_gloss(wo: vec3f, alpha: f32, shares: vec2f, u: vec2f) -> vec3f {
    let choose_result = unity_standard_choose(shares.x, u);
    let matte = choose_result.is_first;
    let v = choose_result.u;
    return select(unity_standard_sample_ggx_lobe(UnityStandardRoundGGX(alpha), wo, v),
        unity_standard_sample_cosine(v), matte);
}

// Density of unity_standard_sample_cosine in 1/sr, for w above the horizon.
fn unity_standard_pdf_cosine(w: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
fn unity_standard_round_ggx_area(round_ggx: UnityStandardRoundGGX, w: vec3f) -> f32 {
    let a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrt(a2 + (1.0 - a2) * (w.z * w.z));
}

// Density of unity_standard_sample_ggx_lobe in 1/sr.
fn unity_standard_pdf_ggx_lobe(facets: UnityStandardRoundGGX, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    let seen = 0.5 / (wo.z + unity_standard_round_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    let straight = unity_standard_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    let exists = wo.z > wi.z;
    let across = vec3f(wi.x, wi.y, select(wi.z, wo.z - wi.z, exists));
    let folded = unity_standard_round_ggx_D_along(facets, across
        + vec3f(wo.x, wo.y, select(wo.z, mu_min, exists)));
    return (straight + select(0.0, folded, exists)) * seen;
}

// Density of unity_standard_sample_matte_gloss in 1/sr.
fn unity_standard_pdf_matte_gloss(wi: vec3f, wo: vec3f, alpha: f32, shares: vec2f) -> f32 {
    return shares.x * unity_standard_pdf_cosine(wi)
        + shares.y * unity_standard_pdf_ggx_lobe(UnityStandardRoundGGX(alpha), wi, wo);
}

// Density of unity_standard_sample in 1/sr.
fn unity_standard_pdf(params: UnityStandard, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return unity_standard_pdf_matte_gloss(wi, wo, unity_standard_alpha(params),
        unity_standard_shares(params, wo));
}

// Cosine-weighted or a visible GGX normal, by the estimated albedos.
fn unity_standard_sample(params: UnityStandard, wo: vec3f, u: vec2f) -> UnityStandardSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return UnityStandardSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let wi = unity_standard_sample_matte_gloss(wo, unity_standard_alpha(params),
        unity_standard_shares(params, wo), u);
    return UnityStandardSample(wi, unity_standard_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
fn unity_standard_albedo(params: UnityStandard, wo: vec3f) -> vec3f {
    // Steps of the rule in unity_standard_albedo: a Fibonacci number, and the golden ratio.
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
        let drawn = unity_standard_sample(params, w, u);
        let weight = select(0.0, drawn.wi.z / max(drawn.pdf, mu_min), drawn.pdf > 0.0);
        total = total + unity_standard_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
