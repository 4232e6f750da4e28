// SPDX-License-Identifier: Apache-2.0
// tri-Ace Blinn-Phong: a normalised Blinn-Phong highlight with Fresnel, cheap enough for a console.
//
// Source: Gotanda, "Beyond a simple physically based Blinn-Phong model in real-time", SIGGRAPH 2012
// course "Practical physically based shading in film and game production", Eq. 1; Eq. 25 for the rough
// diffuse part of its Figures 6, 11 and 14, which shares the highlight's exponent.
// The course's shaders return pi f cos(theta_i); this is f. Its linear factor 0.0397436 n + 0.0856832 is a
// fit of (n + 2) / (4 pi (2 - 2^(-n / 2))): within 0.6 % for n >= 10, 32 % too small at n = 1.
//
// WGSL (WebGPU), made by gonio from gonio/models/triace_blinn_phong.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: var params: TriaceBlinnPhong; params.rho = ...; ... triace_blinn_phong_eval(params, wi, wo)

// A sampled direction and its density.
struct TriaceBlinnPhongSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// triace_blinn_phong: Lambert under a Blinn-Phong highlight with Schlick's Fresnel. Reciprocal. Exported
// with diffuse='lambert'.
struct TriaceBlinnPhong {
    rho: vec3f,  // diffuse albedo R_d, linear RGB; 0 to 1, default (0.5, 0.5, 0.5)
    f0: vec3f,  // reflectance at normal incidence, linear RGB; 0 to 1, default (0.04, 0.04, 0.04)
    shininess: f32,  // Blinn-Phong exponent n; 0 to 100000, default 50
}

// Which of two lobes a sample is taken from.
struct TriaceBlinnPhongChoice {
    is_first: bool,  // Whether it is the first one
    u: vec2f,  // Fresh random numbers, made of those that chose
}

// Facets of GGX with the same width in all directions.
struct TriaceBlinnPhongRoundGGX {
    alpha: f32,  // width of the slopes
}

// Facets of GGX, also called Trowbridge-Reitz.
struct TriaceBlinnPhongGGX {
    alpha_x: f32,  // width of the slopes along x
    alpha_y: f32,  // width of the slopes along y
}

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
fn triace_blinn_phong_length2(h: vec3f) -> f32 {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
fn triace_blinn_phong_cos_half(wi: vec3f, wo: vec3f) -> f32 {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(triace_blinn_phong_length2(wi + wo));
}

// 1 - triace_blinn_phong_cos_half^2, the squared sine at which light meets the facet: of half the length of
// wi - wo.
fn triace_blinn_phong_sin2_half(wi: vec3f, wo: vec3f) -> f32 {
    let apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
fn triace_blinn_phong_weight(cos_h: f32, sin2_h: f32) -> f32 {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    let k = sin2_h / (1.0 + cos_h);
    let k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
fn triace_blinn_phong_schlick_weight_half(wi: vec3f, wo: vec3f) -> f32 {
    return triace_blinn_phong_weight(triace_blinn_phong_cos_half(wi, wo),
        triace_blinn_phong_sin2_half(wi, wo));
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
fn triace_blinn_phong_slopes(h: vec3f) -> vec2f {
    let inv = 1.0 / h.z;
    return vec2f(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
fn triace_blinn_phong_tangent2(h: vec3f) -> f32 {
    let t = triace_blinn_phong_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
fn triace_blinn_phong_atanh_over(y: f32) -> f32 {
    let y2 = y * y;
    return 1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0 + y2 * (1.0 / 9.0))));
}

// log(cos) of the angle between the normal and h, which need not be unit.
fn triace_blinn_phong_log_cos_along(h: vec3f) -> f32 {
    // Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
    const LOG1P_SMALL = 0.25;
    // log(cos) = -log(1 + tan^2) / 2 = -atanh(y)
    let tan2 = triace_blinn_phong_tangent2(h);
    let y = tan2 / (2.0 + tan2);
    return select(-0.5 * log(1.0 + tan2), -y * triace_blinn_phong_atanh_over(y),
        tan2 < LOG1P_SMALL);
}

// (N.m)^exponent of the normal m along h, exact for sharp lobes.
fn triace_blinn_phong_cos_power(h: vec3f, exponent: f32) -> f32 {
    return exp(exponent * triace_blinn_phong_log_cos_along(h));
}

// (0.0397436 n + 0.0856832) (N.H)^n / max(mu_i, mu_o): Eq. 1's highlight without Fresnel.
fn triace_blinn_phong_blinn_phong_highlight(wi: vec3f, wo: vec3f, shininess: f32) -> f32 {
    const NORM_SLOPE = 0.0397436;  // Eq. 1: the normalisation as a linear function of n.
    const NORM_OFFSET = 0.0856832;
    let power = triace_blinn_phong_cos_power(wi + wo, shininess);
    return (NORM_SLOPE * shininess + NORM_OFFSET) * power / max(wi.z, wo.z);
}

// Eq. 1 without the cosine and the factor pi: BRDF value in 1/sr.
fn triace_blinn_phong_eval(params: TriaceBlinnPhong, wi: vec3f, wo: vec3f) -> vec3f {
    const inv_pi = 0.31830987;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    let F = mix(params.f0, vec3f(1.0), vec3f(triace_blinn_phong_schlick_weight_half(wi, wo)));
    let diffuse = params.rho * (1.0 - params.f0) * inv_pi;
    return diffuse + F * triace_blinn_phong_blinn_phong_highlight(wi, wo, params.shininess);
}

// ---- sampling ------------------------------------------------------------------------------

// The width that matches an exponent n: sqrt(2 / (n + 2)).
fn triace_blinn_phong_blinn_phong_alpha(exponent: f32) -> f32 {
    return sqrt(2.0 / (exponent + 2.0));
}

// (1 - cos_theta)^5 of Schlick's approximation.
fn triace_blinn_phong_schlick_weight(cos_theta: f32) -> f32 {
    let k = 1.0 - cos_theta;
    let k2 = k * k;
    return k2 * k2 * k;
}

// Mean of the three channels, by which lobes are weighed against each other.
fn triace_blinn_phong_average(color: vec3f) -> f32 {
    return (color.x + color.y + color.z) / 3.0;
}

fn triace_blinn_phong_raised(probability: f32) -> f32 {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const SHARE_LEAST = 0.1;
    const ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
fn triace_blinn_phong_lobes_shares(first: f32, second: f32) -> vec2f {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const WEIGHT_MIN = 1.0e-37;
    let a = first + BLACK;
    let b = max(second, WEIGHT_MIN);
    let inv = 1.0 / (a + b);
    let P_first = triace_blinn_phong_raised(a * inv);
    let P_second = triace_blinn_phong_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    let smaller = a < b;
    return vec2f(select(1.0 - P_second, P_first, smaller),
        select(P_second, 1.0 - P_first, smaller));
}

// Probabilities of the diffuse lobe and of the highlight.
fn triace_blinn_phong_shares(params: TriaceBlinnPhong, wo: vec3f) -> vec2f {
    let F = mix(params.f0, vec3f(1.0), vec3f(triace_blinn_phong_schlick_weight(wo.z)));
    return triace_blinn_phong_lobes_shares(triace_blinn_phong_average(params.rho
        * (1.0 - params.f0)), triace_blinn_phong_average(F));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
fn triace_blinn_phong_choose(probability: f32, u: vec2f) -> TriaceBlinnPhongChoice {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const SHARE_MIN = 1.0e-12;
    const RANDOM_MAX = 0.99999994;  // The largest float32 below 1, up to which random numbers go.
    let first = u.x < probability;
    let below = u.x / max(probability, SHARE_MIN);
    let above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return TriaceBlinnPhongChoice(first,
        vec2f(clamp(select(above, below, first), 0.0, RANDOM_MAX), u.y));
}

// A direction with density cos(theta) / pi.
fn triace_blinn_phong_sample_cosine(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(u.x, 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// w where all facets are those of a unit sphere.
fn triace_blinn_phong_ggx_unstretched(ggx: TriaceBlinnPhongGGX, w: vec3f) -> vec3f {
    return normalize(vec3f(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
fn triace_blinn_phong_ggx_half_way(ggx: TriaceBlinnPhongGGX, w: vec3f, drop: f32, z: f32,
    v: f32) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(drop * (2.0 - drop), 0.0));
    let phi = two_pi * v;
    let h = vec3f(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(vec3f(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
fn triace_blinn_phong_ggx_sample_visible(ggx: TriaceBlinnPhongGGX, wo: vec3f,
    u: vec2f) -> vec3f {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const RANDOM_MARGIN = 5.9604645e-8;
    let w = triace_blinn_phong_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    let u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    let height = 1.0 + w.z;
    return triace_blinn_phong_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see triace_blinn_phong_ggx_sample_visible.
fn triace_blinn_phong_round_ggx_sample_visible(round_ggx: TriaceBlinnPhongRoundGGX, wo: vec3f,
    u: vec2f) -> vec3f {
    return triace_blinn_phong_ggx_sample_visible(TriaceBlinnPhongGGX(round_ggx.alpha,
        round_ggx.alpha), wo, u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
fn triace_blinn_phong_mirror(wo: vec3f, m: vec3f) -> vec3f {
    return 2.0 * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
fn triace_blinn_phong_sample_ggx_lobe(facets: TriaceBlinnPhongRoundGGX, wo: vec3f,
    u: vec2f) -> vec3f {
    let w = triace_blinn_phong_mirror(wo,
        triace_blinn_phong_round_ggx_sample_visible(facets, wo, u));
    return vec3f(w.x, w.y, abs(w.z));
}

// A direction of one of the two lobes; shares: the probabilities of the matte one and of the other.
fn triace_blinn_phong_sample_matte_gloss(wo: vec3f, alpha: f32, shares: vec2f,
    u: vec2f) -> vec3f {
    let choose_result = triace_blinn_phong_choose(shares.x, u);
    let matte = choose_result.is_first;
    let v = choose_result.u;
    return select(triace_blinn_phong_sample_ggx_lobe(TriaceBlinnPhongRoundGGX(alpha), wo, v),
        triace_blinn_phong_sample_cosine(v), matte);
}

// Density of triace_blinn_phong_sample_cosine in 1/sr, for w above the horizon.
fn triace_blinn_phong_pdf_cosine(w: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
fn triace_blinn_phong_round_ggx_area(round_ggx: TriaceBlinnPhongRoundGGX, w: vec3f) -> f32 {
    let a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrt(a2 + (1.0 - a2) * (w.z * w.z));
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
fn triace_blinn_phong_round_ggx_D_along(round_ggx: TriaceBlinnPhongRoundGGX, h: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    let a2 = round_ggx.alpha * round_ggx.alpha;
    let tan2 = triace_blinn_phong_tangent2(h);
    let r = (1.0 + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// Density of triace_blinn_phong_sample_ggx_lobe in 1/sr.
fn triace_blinn_phong_pdf_ggx_lobe(facets: TriaceBlinnPhongRoundGGX, wi: vec3f,
    wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    // Smith's G1 over 4 mu_o
    let seen = 0.5 / (wo.z + triace_blinn_phong_round_ggx_area(facets, wo));
    let straight = triace_blinn_phong_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    let exists = wo.z > wi.z;
    let across = vec3f(wi.x, wi.y, select(wi.z, wo.z - wi.z, exists));
    let folded = triace_blinn_phong_round_ggx_D_along(facets, across
        + vec3f(wo.x, wo.y, select(wo.z, mu_min, exists)));
    return (straight + select(0.0, folded, exists)) * seen;
}

// Density of triace_blinn_phong_sample_matte_gloss in 1/sr.
fn triace_blinn_phong_pdf_matte_gloss(wi: vec3f, wo: vec3f, alpha: f32, shares: vec2f) -> f32 {
    return shares.x * triace_blinn_phong_pdf_cosine(wi)
        + shares.y * triace_blinn_phong_pdf_ggx_lobe(TriaceBlinnPhongRoundGGX(alpha), wi, wo);
}

// Density of triace_blinn_phong_sample in 1/sr.
fn triace_blinn_phong_pdf(params: TriaceBlinnPhong, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    let alpha = triace_blinn_phong_blinn_phong_alpha(params.shininess);
    let P = triace_blinn_phong_shares(params, wo);
    return triace_blinn_phong_pdf_matte_gloss(wi, wo, alpha, P);
}

// Cosine-weighted, or the GGX lobe of the same width, whose longer tail bounds the weights.
fn triace_blinn_phong_sample(params: TriaceBlinnPhong, wo: vec3f,
    u: vec2f) -> TriaceBlinnPhongSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return TriaceBlinnPhongSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let alpha = triace_blinn_phong_blinn_phong_alpha(params.shininess);
    let wi = triace_blinn_phong_sample_matte_gloss(wo, alpha, triace_blinn_phong_shares(params, wo),
        u);
    return TriaceBlinnPhongSample(wi, triace_blinn_phong_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
fn triace_blinn_phong_albedo(params: TriaceBlinnPhong, wo: vec3f) -> vec3f {
    // Steps of the rule in triace_blinn_phong_albedo: a Fibonacci number, and the golden ratio.
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
        let drawn = triace_blinn_phong_sample(params, w, u);
        let weight = select(0.0, drawn.wi.z / max(drawn.pdf, mu_min), drawn.pdf > 0.0);
        total = total + triace_blinn_phong_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
