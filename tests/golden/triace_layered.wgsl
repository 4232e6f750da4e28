// SPDX-License-Identifier: Apache-2.0
// tri-Ace layered: two Blinn-Phong layers with an absorbing one between, made for game consoles.
//
// Source: Gotanda, "Beyond a simple physically based Blinn-Phong model in real-time", SIGGRAPH 2012 course
// "Practical physically based shading in film and game production", section 2. Symbols are the course's;
// the alpha' of Eq. 3 is sigma_a times thickness here, as in Eq. 2.
// Choices where the course is silent: the fraction of Eq. 1 and the transmittance of Eq. 5 have Schlick's
// F, and Eq. 4 the exact one, all at wo.H; the lower layer uses directions that are not refracted, except
// in the exact absorption; F_trans takes its part from the lower layer's diffuse reflection as well, which
// an option turns off.
//
// WGSL (WebGPU), made by gonio from gonio/models/triace_layered.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: var params: TriaceLayered; params.top_eta = ...; ... triace_layered_eval(params, wi, wo)

// A sampled direction and its density.
struct TriaceLayeredSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// triace_layered: A glossy layer over a glossy and matte one, with absorption between. Reciprocal. Exported
// with absorption='exact', bottom_fresnel='exact', top_transmission='on', diffuse='lambert'.
struct TriaceLayered {
    top_eta: f32,  // index n1 of the upper layer; 1 to 3, default 1.33333
    top_shininess: f32,  // Blinn-Phong exponent of the upper layer; 0 to 100000, default 200
    bottom_eta: f32,  // index n2 of the lower layer, as it would be in air; 1 to 3, default 1.5
    bottom_shininess: f32,  // Blinn-Phong exponent of the lower layer; 0 to 100000, default 20
    // diffuse albedo R_d of the lower layer, linear RGB; 0 to 1, default (0.5, 0.5, 0.5)
    rho: vec3f,
    // absorption of the upper layer per unit of thickness; 0 to 10, default (0, 0, 0)
    sigma_a: vec3f,
    thickness: f32,  // thickness of the upper layer, in the unit of sigma_a; 0 to 1, default 1
}

// What becomes of light at the surface of something denser.
struct TriaceLayeredEntering {
    F: f32,  // Is reflected
    T: f32,  // Enters
}

// What Fresnel leaves of the lower layer's reflection, both crossings of the upper surface included.
struct TriaceLayeredBottomFresnel {
    glossy: f32,  // Factor of the glossy reflection (Eq. 4 or 5)
    matte: f32,  // Factor of the matte reflection (Eq. 9)
}

// What triace_layered_shares returns.
struct TriaceLayeredShares {
    P_top: vec2f,
    P_bottom: vec2f,
}

// Which of two lobes a sample is taken from.
struct TriaceLayeredChoice {
    is_first: bool,  // Whether it is the first one
    u: vec2f,  // Fresh random numbers, made of those that chose
}

// Facets of GGX with the same width in all directions.
struct TriaceLayeredRoundGGX {
    alpha: f32,  // width of the slopes
}

// Facets of GGX, also called Trowbridge-Reitz.
struct TriaceLayeredGGX {
    alpha_x: f32,  // width of the slopes along x
    alpha_y: f32,  // width of the slopes along y
}

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
fn triace_layered_length2(h: vec3f) -> f32 {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
fn triace_layered_cos_half(wi: vec3f, wo: vec3f) -> f32 {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(triace_layered_length2(wi + wo));
}

// Reflectance of a dielectric at normal incidence, ((eta - 1) / (eta + 1))^2.
fn triace_layered_f0_from_eta(eta: f32) -> f32 {
    let r = (eta - 1.0) / (eta + 1.0);
    return r * r;
}

// 1 - triace_layered_cos_half^2, the squared sine at which light meets the facet: of half the length of wi
// - wo.
fn triace_layered_sin2_half(wi: vec3f, wo: vec3f) -> f32 {
    let apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
fn triace_layered_weight(cos_h: f32, sin2_h: f32) -> f32 {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    let k = sin2_h / (1.0 + cos_h);
    let k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
fn triace_layered_schlick_weight_half(wi: vec3f, wo: vec3f) -> f32 {
    return triace_layered_weight(triace_layered_cos_half(wi, wo), triace_layered_sin2_half(wi, wo));
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
fn triace_layered_slopes(h: vec3f) -> vec2f {
    let inv = 1.0 / h.z;
    return vec2f(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
fn triace_layered_tangent2(h: vec3f) -> f32 {
    let t = triace_layered_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
fn triace_layered_atanh_over(y: f32) -> f32 {
    let y2 = y * y;
    return 1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0 + y2 * (1.0 / 9.0))));
}

// log(cos) of the angle between the normal and h, which need not be unit.
fn triace_layered_log_cos_along(h: vec3f) -> f32 {
    // Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
    const LOG1P_SMALL = 0.25;
    // log(cos) = -log(1 + tan^2) / 2 = -atanh(y)
    let tan2 = triace_layered_tangent2(h);
    let y = tan2 / (2.0 + tan2);
    return select(-0.5 * log(1.0 + tan2), -y * triace_layered_atanh_over(y), tan2 < LOG1P_SMALL);
}

// (N.m)^exponent of the normal m along h, exact for sharp lobes.
fn triace_layered_cos_power(h: vec3f, exponent: f32) -> f32 {
    return exp(exponent * triace_layered_log_cos_along(h));
}

// (0.0397436 n + 0.0856832) (N.H)^n / max(mu_i, mu_o): Eq. 1's highlight without Fresnel.
fn triace_layered_blinn_phong_highlight(wi: vec3f, wo: vec3f, shininess: f32) -> f32 {
    const NORM_SLOPE = 0.0397436;  // Eq. 1: the normalisation as a linear function of n.
    const NORM_OFFSET = 0.0856832;
    let power = triace_layered_cos_power(wi + wo, shininess);
    return (NORM_SLOPE * shininess + NORM_OFFSET) * power / max(wi.z, wo.z);
}

// eta^2 cos^2(theta_t) = mu^2 + eta^2 - 1; negative where light is reflected totally.
fn triace_layered_refracted_cos2(mu: f32, eta: f32) -> f32 {
    // The difference of two squares as a product, and mu^2 with its rounding error: at grazing angles, and at
    // the critical one, little else is left.
    return fma(mu, mu, (eta - 1.0) * (eta + 1.0));
}

// F and T = 1 - F of a smooth dielectric with eta >= 1 at a cosine mu outside, mu > 0.
fn triace_layered_split_entering(mu: f32, eta: f32) -> TriaceLayeredEntering {
    // r_s = (1 - eta^2) / s^2 with s = c + g, and r_p = r_s (c g - sin2) / q with q = c g + sin2. So 1 - r_s^2
    // = 4 c g / s^2, and 1 - r_p^2 = 4 c g eta^2 / (s q)^2. One quotient serves all.
    let c = mu;
    let g = sqrt(triace_layered_refracted_cos2(c, eta));
    let s = c + g;
    let p = c * g;
    let sin2 = 1.0 - c * c;
    let q = p + sin2;
    let s2 = s * s;
    let q2 = q * q;
    let inv = 1.0 / (s2 * q2);
    let r_s = (eta - 1.0) * (eta + 1.0) * (q2 * inv);
    let F = r_s * r_s * ((p * p + sin2 * sin2) * (s2 * inv));
    return TriaceLayeredEntering(F, p * inv * (2.0 * (q2 + eta * eta)));
}

// Exact reflectance of a dielectric with eta >= 1, never total, at a cosine outside, mu > 0.
fn triace_layered_F_dielectric_entering(mu: f32, eta: f32) -> f32 {
    return triace_layered_split_entering(mu, eta).F;
}

// 1 - F of a smooth dielectric with eta >= 1 at a cosine mu outside; exact where it nearly vanishes.
fn triace_layered_transmittance_entering(mu: f32, eta: f32) -> f32 {
    return triace_layered_split_entering(mu, eta).T;
}

// n times the cosine inside a layer of index n.
fn triace_layered_below(cos_theta: f32, n: f32) -> f32 {
    return sqrt(triace_layered_refracted_cos2(cos_theta, n));
}

fn triace_layered_sin2(cos_theta: f32) -> f32 {
    return (1.0 - cos_theta) * (1.0 + cos_theta);
}

// Exact reflectance of the lower surface, between layers of n1 and n2, at a cosine above the upper one.
//
// Both indices are at least 1, relative to where the cosine is: nothing is reflected totally.
fn triace_layered_F_below(cos_theta: f32, n1: f32, n2: f32) -> f32 {
    // With g = n cos(theta) on both sides: r_s = (g1 - g2) / (g1 + g2), r_p = (n2^2 g1 - n1^2 g2) / p. Both
    // differences leave n1^2 - n2^2 as a factor, and g from the cosine above has no cancellation.
    let g1 = triace_layered_below(cos_theta, n1);
    let g2 = triace_layered_below(cos_theta, n2);
    let a = n1 * n1;
    let b = n2 * n2;
    let sin2 = triace_layered_sin2(cos_theta);
    let contrast = (n1 - n2) * (n1 + n2);
    let s = g1 + g2;
    let p = b * g1 + a * g2;
    let r_s = contrast / (s * s);
    let r_p = contrast * (a * b - sin2 * (a + b)) / (p * p);
    return 0.5 * (r_s * r_s + r_p * r_p);
}

// 1 - triace_layered_F_below; exact where it nearly vanishes.
fn triace_layered_transmittance_below(cos_theta: f32, n1: f32, n2: f32) -> f32 {
    let g1 = triace_layered_below(cos_theta, n1);
    let g2 = triace_layered_below(cos_theta, n2);
    let a = n1 * n1;
    let b = n2 * n2;
    let s = g1 + g2;
    let p = b * g1 + a * g2;
    return 2.0 * (g1 / s * (g2 / s) + a * b * (g1 / p) * (g2 / p));
}

// Factors of the lower layer's glossy and matte reflection (Eq. 4 or 5, and Eq. 9).
fn triace_layered_bottom_fresnel(params: TriaceLayered,
    cos_h: f32) -> TriaceLayeredBottomFresnel {
    let n1 = params.top_eta;
    let n2 = params.bottom_eta;
    // Both crossings of the upper surface have the same F at angles that belong together.
    let F = triace_layered_F_dielectric_entering(cos_h, n1);
    let T = triace_layered_transmittance_entering(cos_h, n1);
    let glossy = T * T * triace_layered_F_below(cos_h, n1, n2);
    let lost = T * triace_layered_transmittance_below(cos_h, n1, n2);
    // 1 - T triace_layered_F_below and 1 - T T triace_layered_F_below without their cancellation
    return TriaceLayeredBottomFresnel(glossy, T * (F + lost));
}

// eta^2 - 1.
fn triace_layered_contrast(excess: f32) -> f32 {
    return excess * (2.0 + excess);
}

// eta^2 cos^2(theta_t) = mu^2 + eta^2 - 1.
fn triace_layered_eta2_cos2(mu: f32, excess: f32) -> f32 {
    // mu^2 with its rounding error: at grazing angles little else is left
    return fma(mu, mu, triace_layered_contrast(excess));
}

// The direction inside a layer with eta >= 1 that belongs to w outside.
fn triace_layered_refract(w: vec3f, excess: f32) -> vec3f {
    return vec3f(w.x, w.y, sqrt(triace_layered_eta2_cos2(w.z, excess))) * (1.0 / (1.0 + excess));
}

// exp(-sigma_a d (1 / mu_i + 1 / mu_o)): what is left of light after its way in and out (Bouguer).
//
// wi, wo: refracted directions. sigma_a: absorption per unit of the thickness d.
fn triace_layered_attenuation(sigma_a: vec3f, thickness: f32, wi: vec3f, wo: vec3f) -> vec3f {
    return exp(-sigma_a * (thickness * ((wi.z + wo.z) / (wi.z * wo.z))));
}

// Eq. 2 or 3.
fn triace_layered_absorption(params: TriaceLayered, wi: vec3f, wo: vec3f) -> vec3f {
    return triace_layered_attenuation(params.sigma_a, params.thickness,
        triace_layered_refract(wi, params.top_eta - 1.0),
            triace_layered_refract(wo, params.top_eta - 1.0));
}

// Eq. 1 twice, with Eq. 2 to 5 between: BRDF value in 1/sr, without the cosine.
fn triace_layered_eval(params: TriaceLayered, wi: vec3f, wo: vec3f) -> vec3f {
    const inv_pi = 0.31830987;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    let cos_h = triace_layered_cos_half(wi, wo);
    let F_top = mix(triace_layered_f0_from_eta(params.top_eta), 1.0,
        triace_layered_schlick_weight_half(wi, wo));
    let top = F_top * triace_layered_blinn_phong_highlight(wi, wo, params.top_shininess);
    let bottom_fresnel_result = triace_layered_bottom_fresnel(params, cos_h);
    let glossy = bottom_fresnel_result.glossy;
    let matte = bottom_fresnel_result.matte;
    let bottom = glossy * triace_layered_blinn_phong_highlight(wi, wo, params.bottom_shininess);
    let below = bottom + matte * params.rho * inv_pi;
    return top + below * triace_layered_absorption(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// A cosine at which light from anywhere meets the facets that it enters by, to choose lobes with.
//
// Halfway between wo.z (the mirror direction) and 1 (wi = wo): at grazing angles tilted facets let in more
// than the mean surface, whose transmittance is nearly 0 there.
fn triace_layered_usual_cos_half(wo: vec3f) -> f32 {
    return 0.5 + 0.5 * wo.z;
}

// (1 - cos_theta)^5 of Schlick's approximation.
fn triace_layered_schlick_weight(cos_theta: f32) -> f32 {
    let k = 1.0 - cos_theta;
    let k2 = k * k;
    return k2 * k2 * k;
}

// Mean of the three channels, by which lobes are weighed against each other.
fn triace_layered_average(color: vec3f) -> f32 {
    return (color.x + color.y + color.z) / 3.0;
}

fn triace_layered_raised(probability: f32) -> f32 {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const SHARE_LEAST = 0.1;
    const ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
fn triace_layered_lobes_shares(first: f32, second: f32) -> vec2f {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const WEIGHT_MIN = 1.0e-37;
    let a = first + BLACK;
    let b = max(second, WEIGHT_MIN);
    let inv = 1.0 / (a + b);
    let P_first = triace_layered_raised(a * inv);
    let P_second = triace_layered_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    let smaller = a < b;
    return vec2f(select(1.0 - P_second, P_first, smaller),
        select(P_second, 1.0 - P_first, smaller));
}

// Probabilities: upper highlight or lower layer; of that, its highlight or its diffuse part.
fn triace_layered_shares(params: TriaceLayered, wo: vec3f) -> TriaceLayeredShares {
    // Added to the weight of a lobe, so that the reciprocal of two black lobes' sum has a finite derivative.
    const LOBE_MIN = 1.0e-12;
    // Smallest share of the samples that a highlight gets: it bounds their weights.
    const LOBE_SHARE_MIN = 0.1;
    let bottom_fresnel_result = triace_layered_bottom_fresnel(params,
        triace_layered_usual_cos_half(wo));
    let glossy = bottom_fresnel_result.glossy;
    let matte = bottom_fresnel_result.matte;
    // The shortest way in, the light's, bounds what the absorption can leave.
    let kept = triace_layered_absorption(params, vec3f(0.0, 0.0, 1.0), wo);
    let top = mix(triace_layered_f0_from_eta(params.top_eta), 1.0,
        triace_layered_schlick_weight(wo.z));
    let bottom = glossy * triace_layered_average(kept);
    let diffuse = matte * triace_layered_average(kept * params.rho) + LOBE_MIN;
    let lower = bottom + diffuse;
    // Half vectors away from the normal reflect more than this estimate, which is made for the normal.
    let P_top = triace_layered_lobes_shares(max(top, LOBE_SHARE_MIN * lower), lower);
    let P_bottom = triace_layered_lobes_shares(max(bottom, LOBE_SHARE_MIN * diffuse), diffuse);
    return TriaceLayeredShares(P_top, P_bottom);
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
fn triace_layered_choose(probability: f32, u: vec2f) -> TriaceLayeredChoice {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const SHARE_MIN = 1.0e-12;
    const RANDOM_MAX = 0.99999994;  // The largest float32 below 1, up to which random numbers go.
    let first = u.x < probability;
    let below = u.x / max(probability, SHARE_MIN);
    let above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return TriaceLayeredChoice(first,
        vec2f(clamp(select(above, below, first), 0.0, RANDOM_MAX), u.y));
}

// The width that matches an exponent n: sqrt(2 / (n + 2)).
fn triace_layered_blinn_phong_alpha(exponent: f32) -> f32 {
    return sqrt(2.0 / (exponent + 2.0));
}

// Facets that the upper highlight is sampled by: as wide, with a longer tail.
fn triace_layered_top(params: TriaceLayered) -> TriaceLayeredRoundGGX {
    return TriaceLayeredRoundGGX(triace_layered_blinn_phong_alpha(params.top_shininess));
}

// w where all facets are those of a unit sphere.
fn triace_layered_ggx_unstretched(ggx: TriaceLayeredGGX, w: vec3f) -> vec3f {
    return normalize(vec3f(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
fn triace_layered_ggx_half_way(ggx: TriaceLayeredGGX, w: vec3f, drop: f32, z: f32,
    v: f32) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(drop * (2.0 - drop), 0.0));
    let phi = two_pi * v;
    let h = vec3f(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(vec3f(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
fn triace_layered_ggx_sample_visible(ggx: TriaceLayeredGGX, wo: vec3f, u: vec2f) -> vec3f {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const RANDOM_MARGIN = 5.9604645e-8;
    let w = triace_layered_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    let u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    let height = 1.0 + w.z;
    return triace_layered_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see triace_layered_ggx_sample_visible.
fn triace_layered_round_ggx_sample_visible(round_ggx: TriaceLayeredRoundGGX, wo: vec3f,
    u: vec2f) -> vec3f {
    return triace_layered_ggx_sample_visible(TriaceLayeredGGX(round_ggx.alpha, round_ggx.alpha), wo,
        u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
fn triace_layered_mirror(wo: vec3f, m: vec3f) -> vec3f {
    return 2.0 * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
fn triace_layered_sample_ggx_lobe(facets: TriaceLayeredRoundGGX, wo: vec3f, u: vec2f) -> vec3f {
    let w = triace_layered_mirror(wo, triace_layered_round_ggx_sample_visible(facets, wo, u));
    return vec3f(w.x, w.y, abs(w.z));
}

// Facets that the lower highlight is sampled by: as wide, with a longer tail.
fn triace_layered_bottom(params: TriaceLayered) -> TriaceLayeredRoundGGX {
    return TriaceLayeredRoundGGX(triace_layered_blinn_phong_alpha(params.bottom_shininess));
}

// A direction with density cos(theta) / pi.
fn triace_layered_sample_cosine(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(u.x, 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
fn triace_layered_round_ggx_area(round_ggx: TriaceLayeredRoundGGX, w: vec3f) -> f32 {
    let a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrt(a2 + (1.0 - a2) * (w.z * w.z));
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
fn triace_layered_round_ggx_D_along(round_ggx: TriaceLayeredRoundGGX, h: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    let a2 = round_ggx.alpha * round_ggx.alpha;
    let tan2 = triace_layered_tangent2(h);
    let r = (1.0 + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// Density of triace_layered_sample_ggx_lobe in 1/sr.
fn triace_layered_pdf_ggx_lobe(facets: TriaceLayeredRoundGGX, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    let seen = 0.5 / (wo.z + triace_layered_round_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    let straight = triace_layered_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    let exists = wo.z > wi.z;
    let across = vec3f(wi.x, wi.y, select(wi.z, wo.z - wi.z, exists));
    let folded = triace_layered_round_ggx_D_along(facets, across
        + vec3f(wo.x, wo.y, select(wo.z, mu_min, exists)));
    return (straight + select(0.0, folded, exists)) * seen;
}

// Density of triace_layered_sample_cosine in 1/sr, for w above the horizon.
fn triace_layered_pdf_cosine(w: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Density of triace_layered_sample in 1/sr.
fn triace_layered_pdf(params: TriaceLayered, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    let shares_result = triace_layered_shares(params, wo);
    let P_top = shares_result.P_top;
    let P_bottom = shares_result.P_bottom;
    let top = triace_layered_pdf_ggx_lobe(triace_layered_top(params), wi, wo);
    let bottom = triace_layered_pdf_ggx_lobe(triace_layered_bottom(params), wi, wo);
    let matte = triace_layered_pdf_cosine(wi);
    return P_top.x * top + P_top.y * (P_bottom.x * bottom + P_bottom.y * matte);
}

// Diffuse, or the GGX lobe as wide as one of the highlights, chosen by what they reflect.
fn triace_layered_sample(params: TriaceLayered, wo: vec3f, u: vec2f) -> TriaceLayeredSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return TriaceLayeredSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let shares_result = triace_layered_shares(params, wo);
    let P_top = shares_result.P_top;
    let P_bottom = shares_result.P_bottom;
    let choose_result = triace_layered_choose(P_top.x, u);
    let on_top = choose_result.is_first;
    let v = choose_result.u;
    let choose_result_2 = triace_layered_choose(P_bottom.x, v);
    let on_bottom = choose_result_2.is_first;
    let t = choose_result_2.u;
    let w_top = triace_layered_sample_ggx_lobe(triace_layered_top(params), wo, v);
    let w_bottom = triace_layered_sample_ggx_lobe(triace_layered_bottom(params), wo, t);
    let w_matte = triace_layered_sample_cosine(t);
    let wi = select(select(w_matte, w_bottom, on_bottom), w_top, on_top);
    return TriaceLayeredSample(wi, triace_layered_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
fn triace_layered_albedo(params: TriaceLayered, wo: vec3f) -> vec3f {
    // Steps of the rule in triace_layered_albedo: a Fibonacci number, and the golden ratio.
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
        let drawn = triace_layered_sample(params, w, u);
        let weight = select(0.0, drawn.wi.z / max(drawn.pdf, mu_min), drawn.pdf > 0.0);
        total = total + triace_layered_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
