// SPDX-License-Identifier: Apache-2.0
// Unity BRDF2: the cheaper shading that Unity's built-in render pipeline takes on mobile devices.
//
// Source: UnityStandardBRDF.cginc of Unity 2018.2, which "PBR theory, part 1: foundations" (SZ's temple,
// 2019), section 5, names beside BRDF1; the highlight is the one of "Optimizing PBR for mobile", SIGGRAPH
// 2015 course: masking and Fresnel together are 1 / ((wo.H)^2 (alpha + 0.5)). Unity's own value is pi times
// f. Where it departs from physics: the highlight has the colour F0 at every angle, and nothing masks
// grazing directions. Unity's constants are kept: at roughness 0 there is no highlight at all.
// BRDF3, the lowest of the three, is absent: it reads its highlight from a table that is not public.
//
// WGSL (WebGPU), made by gonio from gonio/models/unity_brdf2.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: var params: UnityBrdf2; params.base_color = ...; ... unity_brdf2_eval(params, wi, wo)

// A sampled direction and its density.
struct UnityBrdf2Sample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// unity_brdf2: Lambert plus a highlight without masking and Fresnel. Reciprocal; gains energy.
struct UnityBrdf2 {
    // diffuse colour, or F0 of metals, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    base_color: vec3f,
    metallic: f32,  // 0 for dielectrics, 1 for metals; 0 to 1, default 0
    roughness: f32,  // perceptual roughness, 1 - Unity's smoothness; 0 to 1, default 0.5
}

// Which of two lobes a sample is taken from.
struct UnityBrdf2Choice {
    is_first: bool,  // Whether it is the first one
    u: vec2f,  // Fresh random numbers, made of those that chose
}

// Facets of GGX with the same width in all directions.
struct UnityBrdf2RoundGGX {
    alpha: f32,  // width of the slopes
}

// Facets of GGX, also called Trowbridge-Reitz.
struct UnityBrdf2GGX {
    alpha_x: f32,  // width of the slopes along x
    alpha_y: f32,  // width of the slopes along y
}

// ---- evaluation ----------------------------------------------------------------------------

fn unity_brdf2_diffuse(params: UnityBrdf2) -> vec3f {
    const F0_DIELECTRIC = 0.04;  // Unity's dielectric reflectance (linear colour space).
    return (1.0 - F0_DIELECTRIC) * (1.0 - params.metallic) * params.base_color;
}

fn unity_brdf2_specular(params: UnityBrdf2) -> vec3f {
    const F0_DIELECTRIC = 0.04;  // Unity's dielectric reflectance (linear colour space).
    return mix(vec3f(F0_DIELECTRIC), params.base_color, vec3f(params.metallic));
}

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
fn unity_brdf2_length2(h: vec3f) -> f32 {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
fn unity_brdf2_half_vector(wi: vec3f, wo: vec3f) -> vec3f {
    // wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
    // squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
    // much longer.
    const LENGTHENED = 1.0995116e12;
    let h = LENGTHENED * (wi + wo);
    return h / sqrt(unity_brdf2_length2(h));  // the root is the cosine's as well
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
fn unity_brdf2_cos_half(wi: vec3f, wo: vec3f) -> f32 {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(unity_brdf2_length2(wi + wo));
}

// The highlight without its colour.
fn unity_brdf2_highlight(params: UnityBrdf2, wi: vec3f, wo: vec3f) -> f32 {
    // Unity's limits: of (wo.H)^2, and what its 1.00001 adds to the denominator of D.
    const COS2_UNITY = 0.1;
    const D_UNITY = 1.0e-5;
    const inv_pi = 0.31830987;
    let a = params.roughness * params.roughness;
    let m = unity_brdf2_half_vector(wi, wo);
    let c = unity_brdf2_cos_half(wi, wo);
    // (N.H)^2 (a^2 - 1) + 1.00001, without its cancellation
    let d = m.x * m.x + m.y * m.y + a * a * m.z * m.z + D_UNITY;
    return inv_pi * (a * a / (4.0 * max(c * c, COS2_UNITY) * (a + 0.5) * d * d));
}

// BRDF value in 1/sr, without the cosine.
fn unity_brdf2_eval(params: UnityBrdf2, wi: vec3f, wo: vec3f) -> vec3f {
    const inv_pi = 0.31830987;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    return inv_pi * unity_brdf2_diffuse(params)
        + unity_brdf2_specular(params) * unity_brdf2_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// Width of the GGX that d is the denominator of: D_UNITY never lets it vanish.
fn unity_brdf2_alpha(params: UnityBrdf2) -> f32 {
    const D_UNITY = 1.0e-5;
    let a2 = params.roughness * params.roughness * params.roughness * params.roughness;
    return sqrt((a2 + D_UNITY) / (1.0 + D_UNITY));
}

// Mean of the three channels, by which lobes are weighed against each other.
fn unity_brdf2_average(color: vec3f) -> f32 {
    return (color.x + color.y + color.z) / 3.0;
}

fn unity_brdf2_raised(probability: f32) -> f32 {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const SHARE_LEAST = 0.1;
    const ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
fn unity_brdf2_lobes_shares(first: f32, second: f32) -> vec2f {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const WEIGHT_MIN = 1.0e-37;
    let a = first + BLACK;
    let b = max(second, WEIGHT_MIN);
    let inv = 1.0 / (a + b);
    let P_first = unity_brdf2_raised(a * inv);
    let P_second = unity_brdf2_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    let smaller = a < b;
    return vec2f(select(1.0 - P_second, P_first, smaller),
        select(P_second, 1.0 - P_first, smaller));
}

// Probabilities of the diffuse lobe and of the highlight.
fn unity_brdf2_shares(params: UnityBrdf2) -> vec2f {
    const D_UNITY = 1.0e-5;
    // The highlight's albedo at the normal is near 1 / (a + 0.5), times the part that D_UNITY leaves.
    let a = params.roughness * params.roughness;
    // In two quotients, as alpha^2 may be less than a float32 holds.
    let reflected = a / (a * a + D_UNITY) * (a / (a + 0.5));
    return unity_brdf2_lobes_shares(unity_brdf2_average(unity_brdf2_diffuse(params)),
        unity_brdf2_average(unity_brdf2_specular(params)) * reflected);
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
fn unity_brdf2_choose(probability: f32, u: vec2f) -> UnityBrdf2Choice {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const SHARE_MIN = 1.0e-12;
    const RANDOM_MAX = 0.99999994;  // The largest float32 below 1, up to which random numbers go.
    let first = u.x < probability;
    let below = u.x / max(probability, SHARE_MIN);
    let above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return UnityBrdf2Choice(first, vec2f(clamp(select(above, below, first), 0.0, RANDOM_MAX), u.y));
}

// A direction with density cos(theta) / pi.
fn unity_brdf2_sample_cosine(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(u.x, 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// w where all facets are those of a unit sphere.
fn unity_brdf2_ggx_unstretched(ggx: UnityBrdf2GGX, w: vec3f) -> vec3f {
    return normalize(vec3f(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
fn unity_brdf2_ggx_half_way(ggx: UnityBrdf2GGX, w: vec3f, drop: f32, z: f32, v: f32) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(drop * (2.0 - drop), 0.0));
    let phi = two_pi * v;
    let h = vec3f(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(vec3f(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
fn unity_brdf2_ggx_sample_visible(ggx: UnityBrdf2GGX, wo: vec3f, u: vec2f) -> vec3f {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const RANDOM_MARGIN = 5.9604645e-8;
    let w = unity_brdf2_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    let u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    let height = 1.0 + w.z;
    return unity_brdf2_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see unity_brdf2_ggx_sample_visible.
fn unity_brdf2_round_ggx_sample_visible(round_ggx: UnityBrdf2RoundGGX, wo: vec3f,
    u: vec2f) -> vec3f {
    return unity_brdf2_ggx_sample_visible(UnityBrdf2GGX(round_ggx.alpha, round_ggx.alpha), wo, u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
fn unity_brdf2_mirror(wo: vec3f, m: vec3f) -> vec3f {
    return 2.0 * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
fn unity_brdf2_sample_ggx_lobe(facets: UnityBrdf2RoundGGX, wo: vec3f, u: vec2f) -> vec3f {
    let w = unity_brdf2_mirror(wo, unity_brdf2_round_ggx_sample_visible(facets, wo, u));
    return vec3f(w.x, w.y, abs(w.z));
}

// A direction of one of the two lobes; shares: the probabilities of the matte one and of the other.
fn unity_brdf2_sample_matte_gloss(wo: vec3f, alpha: f32, shares: vec2f, u: vec2f) -> vec3f {
    let choose_result = unity_brdf2_choose(shares.x, u);
    let matte = choose_result.is_first;
    let v = choose_result.u;
    return select(unity_brdf2_sample_ggx_lobe(UnityBrdf2RoundGGX(alpha), wo, v),
        unity_brdf2_sample_cosine(v), matte);
}

// Density of unity_brdf2_sample_cosine in 1/sr, for w above the horizon.
fn unity_brdf2_pdf_cosine(w: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
fn unity_brdf2_round_ggx_area(round_ggx: UnityBrdf2RoundGGX, w: vec3f) -> f32 {
    let a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrt(a2 + (1.0 - a2) * (w.z * w.z));
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
fn unity_brdf2_slopes(h: vec3f) -> vec2f {
    let inv = 1.0 / h.z;
    return vec2f(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
fn unity_brdf2_tangent2(h: vec3f) -> f32 {
    let t = unity_brdf2_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
fn unity_brdf2_round_ggx_D_along(round_ggx: UnityBrdf2RoundGGX, h: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    let a2 = round_ggx.alpha * round_ggx.alpha;
    let tan2 = unity_brdf2_tangent2(h);
    let r = (1.0 + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// Density of unity_brdf2_sample_ggx_lobe in 1/sr.
fn unity_brdf2_pdf_ggx_lobe(facets: UnityBrdf2RoundGGX, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    let seen = 0.5 / (wo.z + unity_brdf2_round_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    let straight = unity_brdf2_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    let exists = wo.z > wi.z;
    let across = vec3f(wi.x, wi.y, select(wi.z, wo.z - wi.z, exists));
    let folded = unity_brdf2_round_ggx_D_along(facets, across
        + vec3f(wo.x, wo.y, select(wo.z, mu_min, exists)));
    return (straight + select(0.0, folded, exists)) * seen;
}

// Density of unity_brdf2_sample_matte_gloss in 1/sr.
fn unity_brdf2_pdf_matte_gloss(wi: vec3f, wo: vec3f, alpha: f32, shares: vec2f) -> f32 {
    return shares.x * unity_brdf2_pdf_cosine(wi)
        + shares.y * unity_brdf2_pdf_ggx_lobe(UnityBrdf2RoundGGX(alpha), wi, wo);
}

// Density of unity_brdf2_sample in 1/sr.
fn unity_brdf2_pdf(params: UnityBrdf2, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return unity_brdf2_pdf_matte_gloss(wi, wo, unity_brdf2_alpha(params),
        unity_brdf2_shares(params));
}

// Cosine-weighted or a visible GGX normal, by the estimated albedos.
fn unity_brdf2_sample(params: UnityBrdf2, wo: vec3f, u: vec2f) -> UnityBrdf2Sample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return UnityBrdf2Sample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let wi = unity_brdf2_sample_matte_gloss(wo, unity_brdf2_alpha(params),
        unity_brdf2_shares(params), u);
    return UnityBrdf2Sample(wi, unity_brdf2_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
fn unity_brdf2_albedo(params: UnityBrdf2, wo: vec3f) -> vec3f {
    // Steps of the rule in unity_brdf2_albedo: a Fibonacci number, and the golden ratio.
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
        let drawn = unity_brdf2_sample(params, w, u);
        let weight = select(0.0, drawn.wi.z / max(drawn.pdf, mu_min), drawn.pdf > 0.0);
        total = total + unity_brdf2_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
