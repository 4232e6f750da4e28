// SPDX-License-Identifier: Apache-2.0
// Patina: copper that turns green, from bare metal to a closed layer.
//
// Source: Elek, "Layered materials in real-time rendering", CESCG 2010, section 4.2: the layered model of
// `weidlich_wilkie` with a coat of cuprite that also scatters, faded in by a map, which
// `gonio.mitsuba.textures.growth_map` makes. Spatial variation is the host's business: growth is a number
// here, and a texture gives each point its own.
// Deviations: by default light that leaves the coat spreads by 1 / eta^2, without which the metal below is
// eta^2 = 9.5 times too bright; facets are GGX's with Smith's masking instead of Beckmann's with
// V-cavities, and F is exact instead of Lazanyi's fit. Options restore each of these. The index that Elek
// mixes with the patina's as that grows is the one of the environment's reflection alone: the metal below
// stays copper.
//
// WGSL (WebGPU), made by gonio from gonio/models/patina.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: var params: Patina; params.growth = ...; ... patina_eval(params, wi, wo)

// A sampled direction and its density.
struct PatinaSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// patina: Copper under a growing green layer of cuprite. Reciprocal.
// Exported with solid_angle='compressed', distribution='ggx', masking='smith_correlated', fresnel='exact'.
struct Patina {
    growth: f32,  // the map: where it is dark, the patina grows first; 0 to 1, default 0.5
    extent: f32,  // from -transition (bare) to 1 + transition (closed); -1 to 2, default 0.45
    transition: f32,  // softness of the patina's edges; 0.001 to 1, default 0.65
    thickness: f32,  // thickness of the patina, in the unit of sigma_a; 0 to 5, default 1
    sigma_a: vec3f,  // absorption; 1 - sigma_a is the colour; 0 to 1, default (0.66, 0.3, 0.42)
    alpha: f32,  // slope width of the patina's facets; 0.0001 to 1, default 0.5
    bare_alpha: f32,  // slope width of the metal's facets where bare; 0.0001 to 1, default 0.15
    grown_alpha: f32,  // slope width of the metal's facets below patina; 0.0001 to 1, default 0.5
    // the metal's index; the default is copper; 0.01 to 20, default (0.201005, 0.923749, 1.10221)
    metal_eta: vec3f,
    metal_k: vec3f,  // the metal's extinction; 0 to 20, default (3.91326, 2.45304, 2.14209)
    // the patina's index; the default is cuprite; 1 to 5, default (2.947821, 3.110926, 3.026471)
    coat_eta: vec3f,
    // the patina's extinction, at its surface only; 0 to 3, default (0.09478703, 0.2044823, 0.6666183)
    coat_k: vec3f,
    tarnish: f32,  // how much the metal has darkened; a texture can drive it; 0 to 1, default 0.5
    tarnish_tint: vec3f,  // colour of the metal at tarnish 1; 0 to 1, default (0.45, 0.2, 0.08)
}

// Facets of GGX with the same width in all directions.
struct PatinaRoundGGX {
    alpha: f32,  // width of the slopes
}

// What becomes of light at a surface.
struct PatinaSplit {
    F: vec3f,  // Is reflected
    T: vec3f,  // Enters
}

// What patina_shares returns.
struct PatinaShares {
    P_bare: vec2f,
    P_coat: vec2f,
    P_diffuse: vec2f,
}

// Which of two lobes a sample is taken from.
struct PatinaChoice {
    is_first: bool,  // Whether it is the first one
    u: vec2f,  // Fresh random numbers, made of those that chose
}

// Facets of GGX, also called Trowbridge-Reitz.
struct PatinaGGX {
    alpha_x: f32,  // width of the slopes along x
    alpha_y: f32,  // width of the slopes along y
}

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
fn patina_length2(h: vec3f) -> f32 {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
fn patina_half_vector(wi: vec3f, wo: vec3f) -> vec3f {
    // wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
    // squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
    // much longer.
    const LENGTHENED = 1.0995116e12;
    let h = LENGTHENED * (wi + wo);
    return h / sqrt(patina_length2(h));  // the root is the cosine's as well
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
fn patina_cos_half(wi: vec3f, wo: vec3f) -> f32 {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(patina_length2(wi + wo));
}

// 1 - patina_cos_half^2, the squared sine at which light meets the facet: of half the length of wi - wo.
fn patina_sin2_half(wi: vec3f, wo: vec3f) -> f32 {
    let apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// |re + i im| for im of at least 2 ABSORPTION_MIN.
fn patina_size(re: vec3f, im: vec3f) -> vec3f {
    return sqrt(re * re + im * im);
}

// |re + i im|^2 / s2^2 p / q.
fn patina_reflected(re: vec3f, im: vec3f, s2: vec3f, p: vec3f, q: vec3f) -> vec3f {
    // In two quotients, as the square of s2 is 1e-34 for a matched index in the horizon
    return (re * re + im * im) / s2 * (p / (s2 * q));
}

// Exact reflectance of a conductor, eta + i k, from cosine and squared sine at a facet.
fn patina_F_conductor_half(cos_h: f32, sin2_h: f32, eta: vec3f, k: vec3f) -> vec3f {
    // A trace of absorption, which keeps a conductor's roots from 0, and their squares from where GPUs
    // take them for 0. By itself it reflects where the index is matched in the horizon, (ABSORPTION_MIN /
    // (2 mu^2))^2.
    const ABSORPTION_MIN = 1.0e-17;
    // Cosine from which on the square of the sine is the smaller of the two, and keeps the digits.
    const NEAR_NORMAL = 0.75;
    // As for a dielectric, in complex numbers: contrast = (eta + i k)^2 - 1, g^2 = w = contrast + c^2
    let c = cos_h;
    let contrast_re = (eta - 1.0) * (eta + 1.0) - k * k;
    let half_im = eta * k + ABSORPTION_MIN;
    let c2 = c * c;
    // The same as eta^2 - k^2 - sin^2, of which a small index leaves little else near the normal
    let w_re = select(contrast_re + c2, eta * eta - k * k - sin2_h, cos_h > NEAR_NORMAL);
    let im = 2.0 * half_im;
    let w_abs = patina_size(w_re, im);
    // Of the two parts of the root, the larger has no cancellation; the smaller follows from it.
    let g2 = 0.5 * (w_abs + abs(w_re));
    let g_re = select(half_im, g2, w_re > vec3f(0.0)) * (1.0 / sqrt(g2));
    // |c + g|^2 = c^2 + |w| + cross, and |c g -+ sin2_h|^2 = p -+ cross sin2_h
    let cross = 2.0 * c * g_re;
    let s_abs2 = c2 + w_abs + cross;
    let p = c2 * w_abs + sin2_h * sin2_h;
    return patina_reflected(contrast_re, im, s_abs2, p, p + cross * sin2_h);
}

// The metal's reflectance, as far as it has tarnished.
fn patina_metal_F(params: Patina, cos_h: f32, sin2_h: f32) -> vec3f {
    let tint = mix(vec3f(1.0), params.tarnish_tint, vec3f(params.tarnish));
    return patina_F_conductor_half(cos_h, sin2_h, params.metal_eta, params.metal_k) * tint;
}

// a + b + c with the rounding error of a + b carried along (Knuth), for a c that cancels it.
fn patina_sum3(a: f32, b: f32, c: f32) -> f32 {
    let ab = a + b;
    let back = ab - a;
    let error = a - (ab - back) + (b - back);
    return ab + c + error;
}

// 1 - extentFactor, with all its digits: a sharp highlight counts however little of it is left.
fn patina_bare(params: Patina) -> f32 {
    let rise = patina_sum3(params.growth, -params.extent, params.transition)
        / (2.0 * params.transition);
    let t = clamp(rise, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// extentFactor: 1 - smoothstep(extent - transition, extent + transition, growth).
fn patina_grown(params: Patina) -> f32 {
    let rest = patina_sum3(params.extent, -params.growth, params.transition)
        / (2.0 * params.transition);
    let t = clamp(rest, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

fn patina_metal_alpha(params: Patina) -> f32 {
    return patina_bare(params) * params.bare_alpha + patina_grown(params) * params.grown_alpha;
}

fn patina_bare_facets(params: Patina) -> PatinaRoundGGX {
    return PatinaRoundGGX(patina_metal_alpha(params));
}

// Density of facets, in 1/sr. Walter et al., Eq. 33.
fn patina_round_ggx_D(round_ggx: PatinaRoundGGX, m: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    let a2 = round_ggx.alpha * round_ggx.alpha;
    let s = a2 + (1.0 - a2) * (m.x * m.x + m.y * m.y);
    return inv_pi * a2 / (s * s);
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
fn patina_round_ggx_area(round_ggx: PatinaRoundGGX, w: vec3f) -> f32 {
    let a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrt(a2 + (1.0 - a2) * (w.z * w.z));
}

// G = 1 / (1 + Lambda_i + Lambda_o): correlated by the facet's height. Heitz 2014, Eq. 99.
fn patina_V_smith_correlated(facets: PatinaRoundGGX, wi: vec3f, wo: vec3f) -> f32 {
    return 0.5 / (wo.z * patina_round_ggx_area(facets, wi)
        + wi.z * patina_round_ggx_area(facets, wo));
}

// D G / (4 mu_i mu_o); F is missing.
fn patina_reflected_by(facets: PatinaRoundGGX, wi: vec3f, wo: vec3f, m: vec3f) -> f32 {
    return patina_round_ggx_D(facets, m) * patina_V_smith_correlated(facets, wi, wo);
}

// Mean of the three channels, by which lobes are weighed against each other.
fn patina_average(color: vec3f) -> f32 {
    return (color.x + color.y + color.z) / 3.0;
}

// The patina's index for refraction, the mean of its channels, minus 1.
fn patina_excess(params: Patina) -> f32 {
    return patina_average(params.coat_eta - 1.0);
}

fn patina_sin2(cos_theta: f32) -> f32 {
    return (1.0 - cos_theta) * (1.0 + cos_theta);
}

// F of a conductor denser than the medium above, and 1 - F, exact where it nearly vanishes.
fn patina_split_conductor(cos_theta: f32, eta: vec3f, k: vec3f) -> PatinaSplit {
    const ABSORPTION_MIN = 1.0e-17;
    // With eps = (eta + i k)^2 and g^2 = eps - 1 + c^2: 1 - R_s = 4 c Re(g) / |c + g|^2, and 1 - R_p is 4 c
    // Re(conj(g) eps) / |eps c + g|^2. The roots are those of F.
    let c = cos_theta;
    let contrast_re = (eta - 1.0) * (eta + 1.0) - k * k;
    let half_im = eta * k + ABSORPTION_MIN;
    let eps_re = (eta - k) * (eta + k);
    let eps_im = 2.0 * half_im;
    let c2 = c * c;
    let sin2 = patina_sin2(c);
    let w_re = contrast_re + c2;
    let w_abs = patina_size(w_re, eps_im);
    let g2 = 0.5 * (w_abs + abs(w_re));
    let inv = 1.0 / sqrt(g2);
    let large = g2 * inv;
    let small = half_im * inv;
    let g_re = select(small, large, w_re > vec3f(0.0));
    let g_im = select(large, small, w_re > vec3f(0.0));
    let cross = 2.0 * c * g_re;
    let s_abs2 = c2 + w_abs + cross;
    let p = c2 * w_abs + sin2 * sin2;
    let p_re = eps_re * c + g_re;
    let p_im = eps_im * c + g_im;
    let T_p = (eps_re * g_re + eps_im * g_im) / (p_re * p_re + p_im * p_im);
    let F = patina_reflected(contrast_re, eps_im, s_abs2, p, p + cross * sin2);
    return PatinaSplit(F, 2.0 * c * (g_re / s_abs2 + T_p));
}

fn patina_facets(params: Patina) -> PatinaRoundGGX {
    return PatinaRoundGGX(params.alpha);
}

// 2 mu Lambda, patina_round_ggx_area without mu, exact where it is little.
fn patina_round_ggx_hidden(round_ggx: PatinaRoundGGX, w: vec3f) -> f32 {
    // The difference would have few digits, which count beside a coat that transmits as little
    let rest = round_ggx.alpha * round_ggx.alpha * ((1.0 - w.z) * (1.0 + w.z));
    return rest / (patina_round_ggx_area(round_ggx, w) + w.z);
}

// 1 - G of patina_V_smith_correlated, exact where G is nearly 1.
fn patina_lost_smith_correlated(facets: PatinaRoundGGX, wi: vec3f, wo: vec3f) -> f32 {
    let rest = wo.z * patina_round_ggx_hidden(facets, wi)
        + wi.z * patina_round_ggx_hidden(facets, wo);
    return 2.0 * rest * patina_V_smith_correlated(facets, wi, wo);
}

// T12 t of Eq. 2 and 4 with lost = 1 - G.
fn patina_past_facets(T: vec3f, lost: f32) -> vec3f {
    // 1 - G F would lose the digits of a small T
    return T * (T + lost * (1.0 - T));
}

// T12 t of Eq. 2 and 4 with t = (1 - G) + T21 G, T21 = T12 = T at the half vector.
fn patina_through_facets(facets: PatinaRoundGGX, wi: vec3f, wo: vec3f, T: vec3f) -> vec3f {
    return patina_past_facets(T, patina_lost_smith_correlated(facets, wi, wo));
}

// eta^2 - 1.
fn patina_contrast(excess: f32) -> f32 {
    return excess * (2.0 + excess);
}

// eta^2 cos^2(theta_t) = mu^2 + eta^2 - 1.
fn patina_eta2_cos2(mu: f32, excess: f32) -> f32 {
    // mu^2 with its rounding error: at grazing angles little else is left
    return fma(mu, mu, patina_contrast(excess));
}

// The direction inside a layer with eta >= 1 that belongs to w outside.
fn patina_refract(w: vec3f, excess: f32) -> vec3f {
    return vec3f(w.x, w.y, sqrt(patina_eta2_cos2(w.z, excess))) * (1.0 / (1.0 + excess));
}

// exp(-sigma_a d (1 / mu_i + 1 / mu_o)): what is left of light after its way in and out (Bouguer).
//
// wi, wo: refracted directions. sigma_a: absorption per unit of the thickness d.
fn patina_attenuation(sigma_a: vec3f, thickness: f32, wi: vec3f, wo: vec3f) -> vec3f {
    return exp(-sigma_a * (thickness * ((wi.z + wo.z) / (wi.z * wo.z))));
}

// eta times the sum of both refracted directions, which has their half vector's direction.
//
// Where the two are nearly mirrored the tangential parts cancel: they are summed before they are rounded by
// refraction, so that a sharp highlight below keeps its place.
fn patina_refracted_sum(wi: vec3f, wo: vec3f, excess: f32) -> vec3f {
    let z_i = patina_eta2_cos2(wi.z, excess);
    let z_o = patina_eta2_cos2(wo.z, excess);
    return vec3f(wi.x + wo.x, wi.y + wo.y, sqrt(z_i) + sqrt(z_o));
}

// Squared sine at which refracted light meets a facet, from a difference before it is rounded.
fn patina_refracted_sin2_half(wi: vec3f, wo: vec3f, excess: f32) -> f32 {
    let z_i = patina_eta2_cos2(wi.z, excess);
    let z_o = patina_eta2_cos2(wo.z, excess);
    // A difference of two roots is that of their squares over their sum
    let z = (wi.z - wo.z) * (wi.z + wo.z) / (sqrt(z_i) + sqrt(z_o));
    let apart = vec3f(wi.x - wo.x, wi.y - wo.y, z) / (1.0 + excess);
    return 0.25 * dot(apart, apart);
}

// The metal's under the patina, at least as wide as those of the patina itself (Figure 2).
fn patina_facets_below(params: Patina) -> PatinaRoundGGX {
    return PatinaRoundGGX(max(patina_metal_alpha(params), params.alpha));
}

// Eq. 2 with a coat that scatters.
fn patina_coated(params: Patina, wi: vec3f, wo: vec3f) -> vec3f {
    const inv_pi = 0.31830987;
    let m = patina_half_vector(wi, wo);
    let cos_h = patina_cos_half(wi, wo);
    let excess = patina_excess(params);
    let index = 1.0 + excess;
    let surface = patina_split_conductor(cos_h, params.coat_eta, params.coat_k);
    let facets = patina_facets(params);
    let glossy = patina_reflected_by(facets, wi, wo, m);
    let coat = surface.F * glossy + (1.0 - params.sigma_a) * surface.T * inv_pi;

    var through = patina_through_facets(facets, wi, wo, surface.T);
    through = through / (index * index);
    let wi_t = patina_refract(wi, excess);
    let wo_t = patina_refract(wo, excess);
    let kept = patina_attenuation(params.sigma_a, params.thickness, wi_t, wo_t);
    let both = patina_refracted_sum(wi, wo, excess);
    let cos_t = 0.5 * length(both) / index;
    let F = patina_metal_F(params, cos_t, patina_refracted_sin2_half(wi, wo, excess));
    let below = patina_facets_below(params);
    let metal = F * patina_reflected_by(below, wi_t, wo_t, normalize(both));
    return coat + metal * through * kept;
}

// The bare and the coated metal, mixed: BRDF value in 1/sr, without the cosine.
fn patina_eval(params: Patina, wi: vec3f, wo: vec3f) -> vec3f {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    let m = patina_half_vector(wi, wo);
    let cos_h = patina_cos_half(wi, wo);
    let F = patina_metal_F(params, cos_h, patina_sin2_half(wi, wo));
    let bare = F * patina_reflected_by(patina_bare_facets(params), wi, wo, m);
    return patina_bare(params) * bare + patina_grown(params) * patina_coated(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// A cosine at which light from anywhere meets the facets that it enters by, to choose lobes with.
//
// Halfway between wo.z (the mirror direction) and 1 (wi = wo): at grazing angles tilted facets let in more
// than the mean surface, whose transmittance is nearly 0 there.
fn patina_usual_cos_half(wo: vec3f) -> f32 {
    return 0.5 + 0.5 * wo.z;
}

// The most that patina_attenuation leaves of light that goes out along wo: it came in along the normal.
fn patina_attenuation_least(sigma_a: vec3f, thickness: f32, wo: vec3f) -> vec3f {
    return patina_attenuation(sigma_a, thickness, vec3f(0.0, 0.0, 1.0), wo);
}

fn patina_raised(probability: f32) -> f32 {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const SHARE_LEAST = 0.1;
    const ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
fn patina_lobes_shares(first: f32, second: f32) -> vec2f {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const WEIGHT_MIN = 1.0e-37;
    let a = first + BLACK;
    let b = max(second, WEIGHT_MIN);
    let inv = 1.0 / (a + b);
    let P_first = patina_raised(a * inv);
    let P_second = patina_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    let smaller = a < b;
    return vec2f(select(1.0 - P_second, P_first, smaller),
        select(P_second, 1.0 - P_first, smaller));
}

// Probabilities: bare metal or patina; of that, surface or not; of the rest, diffuse or below.
fn patina_shares(params: Patina, wo: vec3f) -> PatinaShares {
    // Added to the weight of a lobe, so that the reciprocal of two black lobes' sum has a finite derivative.
    const LOBE_MIN = 1.0e-12;
    let grown = patina_grown(params);
    let wo_t = patina_refract(wo, patina_excess(params));
    let mu = wo.z;
    let sin2 = (1.0 - wo.z) * (1.0 + wo.z);
    let F = patina_split_conductor(mu, params.coat_eta, params.coat_k).F;
    let T = patina_split_conductor(patina_usual_cos_half(wo), params.coat_eta, params.coat_k).T;
    let F_metal = patina_metal_F(params, mu, sin2);
    let bare = patina_bare(params) * patina_average(F_metal);
    let coat = grown * patina_average(F);
    let diffuse = grown * patina_average((1.0 - params.sigma_a) * T);
    let kept = patina_attenuation_least(params.sigma_a, params.thickness, wo_t);
    let below = grown * patina_average(T * kept * F_metal) + LOBE_MIN;
    let inside = diffuse + below;
    let P_bare = patina_lobes_shares(bare, coat + inside);
    let P_coat = patina_lobes_shares(coat, inside);
    let P_diffuse = patina_lobes_shares(diffuse, below);
    return PatinaShares(P_bare, P_coat, P_diffuse);
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
fn patina_choose(probability: f32, u: vec2f) -> PatinaChoice {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const SHARE_MIN = 1.0e-12;
    const RANDOM_MAX = 0.99999994;  // The largest float32 below 1, up to which random numbers go.
    let first = u.x < probability;
    let below = u.x / max(probability, SHARE_MIN);
    let above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return PatinaChoice(first, vec2f(clamp(select(above, below, first), 0.0, RANDOM_MAX), u.y));
}

// w where all facets are those of a unit sphere.
fn patina_ggx_unstretched(ggx: PatinaGGX, w: vec3f) -> vec3f {
    return normalize(vec3f(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
fn patina_ggx_half_way(ggx: PatinaGGX, w: vec3f, drop: f32, z: f32, v: f32) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(drop * (2.0 - drop), 0.0));
    let phi = two_pi * v;
    let h = vec3f(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(vec3f(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
fn patina_ggx_sample_visible(ggx: PatinaGGX, wo: vec3f, u: vec2f) -> vec3f {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const RANDOM_MARGIN = 5.9604645e-8;
    let w = patina_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    let u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    let height = 1.0 + w.z;
    return patina_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see patina_ggx_sample_visible.
fn patina_round_ggx_sample_visible(round_ggx: PatinaRoundGGX, wo: vec3f, u: vec2f) -> vec3f {
    return patina_ggx_sample_visible(PatinaGGX(round_ggx.alpha, round_ggx.alpha), wo, u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
fn patina_mirror(wo: vec3f, m: vec3f) -> vec3f {
    return 2.0 * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
fn patina_sample_ggx_lobe(facets: PatinaRoundGGX, wo: vec3f, u: vec2f) -> vec3f {
    let w = patina_mirror(wo, patina_round_ggx_sample_visible(facets, wo, u));
    return vec3f(w.x, w.y, abs(w.z));
}

// How far down the cap of visible normals goes that mirror wo above the horizon; 1: all the way.
//
// Eto and Tokuyoshi, Eq. 5 and 6; least: the smaller width, at most 1. No normal is left out that would
// mirror wo above the horizon. Of facets of one width 5 % at most of the others are left.
fn patina_ggx_bound(least: f32, wo: vec3f) -> f32 {
    let s = 1.0 + sqrt(max(wo.x * wo.x + wo.y * wo.y, 0.0));
    let a2 = least * least;
    let s2 = s * s;
    return (1.0 - a2) * s2 / (s2 + a2 * wo.z * wo.z);
}

// A normal that wo sees, without those that mirror wo below the horizon, or most of them.
//
// Eto and Tokuyoshi, "Bounded VNDF sampling for Smith-GGX reflections", 2023; bound: see patina_ggx_bound.
fn patina_ggx_sample_bounded(ggx: PatinaGGX, wo: vec3f, u: vec2f, bound: f32) -> vec3f {
    const RANDOM_MARGIN = 5.9604645e-8;
    let w = patina_ggx_unstretched(ggx, wo);
    let u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -bound w.z: z = 1 - u (1 + bound w.z), and z + w.z as a sum of positive terms
    let height = 1.0 + bound * w.z;
    return patina_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height + (1.0 - bound) * w.z, u.y);
}

// A normal that wo sees, without most that mirror wo downwards; see patina_ggx_sample_bounded.
fn patina_round_ggx_sample_bounded(round_ggx: PatinaRoundGGX, wo: vec3f, u: vec2f,
    bound: f32) -> vec3f {
    return patina_ggx_sample_bounded(PatinaGGX(round_ggx.alpha, round_ggx.alpha), wo, u, bound);
}

// A facet's normal.
fn patina_sample_facet(facets: PatinaRoundGGX, wo: vec3f, u: vec2f) -> vec3f {
    return patina_round_ggx_sample_bounded(facets, wo, u, patina_ggx_bound(facets.alpha, wo));
}

// Cosine inside the layer of the flattest direction that leaves it; 0 for eta <= 1.
fn patina_critical_cosine(excess: f32) -> f32 {
    return sqrt(max(patina_contrast(excess), 0.0)) / (1.0 + excess);
}

// The outer direction for a direction inside: refracted, or spread out if it cannot leave.
fn patina_leave(w: vec3f, excess: f32) -> vec3f {
    const mu_min = 1.0e-18;  // cosine of the horizon
    // Below this squared sine the azimuth of wo is taken as 0: any azimuth is right there, and the square of
    // its reciprocal still fits into a float32.
    const SIN2_MIN = 1.0e-18;
    // Flattest direction that a sample leaves in: derivatives by the index fit in a float32 there.
    const LEAVE_MIN = 1.0e-12;
    let k = patina_critical_cosine(excess);
    let eta = 1.0 + excess;
    let refracted = w.z > k;
    let spread = min(w.z / max(k, mu_min), 1.0);
    // The sine from x and y: under many layers 1 - z^2 has few digits
    let sin2 = w.x * w.x + w.y * w.y;
    var z = select(spread, sqrt(max(1.0 - eta * eta * sin2, 0.0)), refracted);
    // Refracted sines are eta times as large, of which 1 - z^2 would leave no digits near the normal
    let spread_out = sqrt(max(1.0 - spread * spread, 0.0)) / sqrt(max(sin2, SIN2_MIN));
    let scale = select(spread_out, eta, refracted);
    // A sample above the horizon stays there, however flat.
    z = select(-1.0, max(z, LEAVE_MIN), w.z > 0.0);
    return normalize(vec3f(w.x * scale, w.y * scale, z));
}

// A direction with density cos(theta) / pi.
fn patina_sample_cosine(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(u.x, 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// Density of wo mirrored at a visible normal m that a bound leaves, in 1/sr.
fn patina_pdf_bounded(facets: PatinaRoundGGX, wo: vec3f, m: vec3f, bound: f32) -> f32 {
    return 0.5 * patina_round_ggx_D(facets, m) / (bound * wo.z + patina_round_ggx_area(facets, wo));
}

// Density of wo mirrored at patina_sample_facet, in 1/sr.
fn patina_pdf_facet(facets: PatinaRoundGGX, wo: vec3f, m: vec3f) -> f32 {
    return patina_pdf_bounded(facets, wo, m, patina_ggx_bound(facets.alpha, wo));
}

// Density of what the metal below mirrors, inside the patina.
fn patina_pdf_below(params: Patina, wo_t: vec3f, m: vec3f) -> f32 {
    return patina_pdf_facet(patina_facets_below(params), wo_t, m);
}

// The inner direction that patina_leave spreads to w; z = 0 for eta <= 1, which has none.
fn patina_gather(w: vec3f, excess: f32) -> vec3f {
    const SIN2_MIN = 1.0e-18;
    let k = patina_critical_cosine(excess);
    let z = k * w.z;
    let sin2 = w.x * w.x + w.y * w.y;
    let scale = sqrt(max(1.0 - z * z, 0.0)) / sqrt(max(sin2, SIN2_MIN));
    let near = sin2 < SIN2_MIN;  // no azimuth: any is right
    let x = select(w.x * scale, sqrt(max(1.0 - z * z, 0.0)), near);
    return vec3f(x, select(w.y * scale, 0.0, near), z);
}

// Density of patina_leave at w, from the inner density at w_t = refract(w) and at gather(w).
fn patina_pdf_leave(pdf_refracted: f32, pdf_gathered: f32, w: vec3f, w_t: vec3f,
    excess: f32) -> f32 {
    // Solid angle over cosine-weighted one: 1 / mu. Refraction shrinks the latter by eta^2, gathering by k^2,
    // and the cosines are k mu and mu.
    let eta = 1.0 + excess;
    return pdf_refracted * w.z / (eta * eta * w_t.z)
        + pdf_gathered * patina_critical_cosine(excess);
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
fn patina_slopes(h: vec3f) -> vec2f {
    let inv = 1.0 / h.z;
    return vec2f(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
fn patina_tangent2(h: vec3f) -> f32 {
    let t = patina_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
fn patina_round_ggx_D_along(round_ggx: PatinaRoundGGX, h: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    let a2 = round_ggx.alpha * round_ggx.alpha;
    let tan2 = patina_tangent2(h);
    let r = (1.0 + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// Density of patina_sample_ggx_lobe in 1/sr.
fn patina_pdf_ggx_lobe(facets: PatinaRoundGGX, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    let seen = 0.5 / (wo.z + patina_round_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    let straight = patina_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    let exists = wo.z > wi.z;
    let across = vec3f(wi.x, wi.y, select(wi.z, wo.z - wi.z, exists));
    let folded = patina_round_ggx_D_along(facets, across
        + vec3f(wo.x, wo.y, select(wo.z, mu_min, exists)));
    return (straight + select(0.0, folded, exists)) * seen;
}

// Density of patina_sample_cosine in 1/sr, for w above the horizon.
fn patina_pdf_cosine(w: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Density of patina_sample in 1/sr.
fn patina_pdf(params: Patina, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    let shares_result = patina_shares(params, wo);
    let P_bare = shares_result.P_bare;
    let P_coat = shares_result.P_coat;
    let P_diffuse = shares_result.P_diffuse;
    let excess = patina_excess(params);
    let wi_t = patina_refract(wi, excess);
    let wo_t = patina_refract(wo, excess);
    let refracted = patina_pdf_below(params, wo_t, normalize(patina_refracted_sum(wi, wo, excess)));
    let w = patina_gather(wi, excess);
    let gathered = patina_pdf_below(params, wo_t, patina_half_vector(w, wo_t));
    let below = patina_pdf_leave(refracted, gathered, wi, wi_t, excess);
    let coat = patina_pdf_ggx_lobe(patina_facets(params), wi, wo);
    let bare = patina_pdf_ggx_lobe(patina_bare_facets(params), wi, wo);
    let inside = P_diffuse.x * patina_pdf_cosine(wi) + P_diffuse.y * below;
    return P_bare.x * bare + P_bare.y * (P_coat.x * coat + P_coat.y * inside);
}

// One of the bare metal, the patina's surface, its diffuse part, and the metal below.
fn patina_sample(params: Patina, wo: vec3f, u: vec2f) -> PatinaSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return PatinaSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let shares_result = patina_shares(params, wo);
    let P_bare = shares_result.P_bare;
    let P_coat = shares_result.P_coat;
    let P_diffuse = shares_result.P_diffuse;
    let excess = patina_excess(params);
    let choose_result = patina_choose(P_bare.x, u);
    let on_bare = choose_result.is_first;
    let v = choose_result.u;
    let choose_result_2 = patina_choose(P_coat.x, v);
    let on_coat = choose_result_2.is_first;
    let s = choose_result_2.u;
    let choose_result_3 = patina_choose(P_diffuse.x, s);
    let on_diffuse = choose_result_3.is_first;
    let t = choose_result_3.u;
    let w_bare = patina_sample_ggx_lobe(patina_bare_facets(params), wo, v);
    let w_coat = patina_sample_ggx_lobe(patina_facets(params), wo, s);
    let wo_t = patina_refract(wo, excess);
    let m = patina_sample_facet(patina_facets_below(params), wo_t, t);
    let w_below = patina_leave(patina_mirror(wo_t, m), excess);
    let w_patina = select(select(w_below, patina_sample_cosine(t), on_diffuse), w_coat, on_coat);
    let wi = select(w_patina, w_bare, on_bare);
    return PatinaSample(wi, patina_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
fn patina_albedo(params: Patina, wo: vec3f) -> vec3f {
    // Steps of the rule in patina_albedo: a Fibonacci number, and the golden ratio.
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
        let drawn = patina_sample(params, w, u);
        let weight = select(0.0, drawn.wi.z / max(drawn.pdf, mu_min), drawn.pdf > 0.0);
        total = total + patina_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
