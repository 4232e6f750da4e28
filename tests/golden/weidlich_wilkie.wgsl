// SPDX-License-Identifier: Apache-2.0
// Weidlich-Wilkie: a rough clear coat over any base, which may be coated itself.
//
// Source: Elek, "Layered materials in real-time rendering", CESCG 2010, Eq. 2 to 4 and Algorithm 1, after
// Weidlich, Wilkie, "Arbitrarily layered micro-facet surfaces", GRAPHITE 2007. Symbols are Elek's.
// Deviations: refracted directions keep the azimuth of the ones they belong to (Algorithm 1 mirrors them at
// the normal, which would turn an anisotropic base by 180 degrees); F is exact by default, not
// Lazanyi's fit;
// D carries the 1 / pi that Elek's lacks; a coloured coat, which has an index and an extinction for each
// channel as in Algorithm 1, refracts by one index. What Eq. 2 leaves out can be switched on: Fresnel's
// reflection at both crossings, the compression of solid angles, and the light that bounces between
// base and
// surface.
//
// Lambert: ideal diffuse reflection.
//
// Source: Johann Heinrich Lambert, "Photometria", 1760.
//
// WGSL (WebGPU), made by gonio from gonio/models/weidlich_wilkie.py, gonio/models/lambert.py; free to use
// under Apache-2.0. wi points towards the light and wo towards the viewer: unit vectors in the local
// frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: var params: WeidlichWilkie; params.eta = ...; ... weidlich_wilkie_eval(params, wi, wo)

// A sampled direction and its density.
struct WeidlichWilkieSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// Parameters of lambert: Ideal diffuse: the same radiance in every direction. Reciprocal; the albedo
// is rho.
struct WeidlichWilkieBase {
    rho: vec3f,  // albedo, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
}

// weidlich_wilkie: A clear, tinted coat over any base; nest it for more layers. Reciprocal if the base is.
// Exported with interface='rough', distribution='beckmann', masking='cook_torrance', fresnel='exact',
// transmission='half_vector', solid_angle='none', bounces='none', roughness_clamp='on'.
struct WeidlichWilkie {
    eta: f32,  // index of the coat over that of the medium above it; 1 to 3, default 1.5
    alpha: f32,  // slope width of the coat's facets; unused when smooth; 0.0001 to 1, default 0.1
    sigma_a: vec3f,  // absorption of the coat per unit of thickness; 0 to 10, default (0, 0, 0)
    thickness: f32,  // thickness of the coat, in the unit of sigma_a; 0 to 1, default 1
    base: WeidlichWilkieBase,  // what lies below; its indices are relative to the coat
}

// What becomes of light at the surface of something denser.
struct WeidlichWilkieEntering {
    F: f32,  // Is reflected
    T: f32,  // Enters
}

// Beckmann's facets with the same width in all directions.
struct WeidlichWilkieRoundBeckmann {
    alpha: f32,  // width of the slopes
}

// Which of two lobes a sample is taken from.
struct WeidlichWilkieChoice {
    is_first: bool,  // Whether it is the first one
    u: vec2f,  // Fresh random numbers, made of those that chose
}

// Beckmann's facets: slopes with a normal distribution of variance alpha^2 / 2.
struct WeidlichWilkieBeckmann {
    alpha_x: f32,  // width of the slopes along x
    alpha_y: f32,  // width of the slopes along y
}

// ---- evaluation ----------------------------------------------------------------------------

// eta^2 - 1.
fn weidlich_wilkie_contrast(excess: f32) -> f32 {
    return excess * (2.0 + excess);
}

// eta^2 cos^2(theta_t) = mu^2 + eta^2 - 1.
fn weidlich_wilkie_eta2_cos2(mu: f32, excess: f32) -> f32 {
    // mu^2 with its rounding error: at grazing angles little else is left
    return fma(mu, mu, weidlich_wilkie_contrast(excess));
}

// The direction inside a layer with eta >= 1 that belongs to w outside.
fn weidlich_wilkie_refract(w: vec3f, excess: f32) -> vec3f {
    return vec3f(w.x, w.y, sqrt(weidlich_wilkie_eta2_cos2(w.z, excess))) * (1.0 / (1.0 + excess));
}

// exp(-sigma_a d (1 / mu_i + 1 / mu_o)): what is left of light after its way in and out (Bouguer).
//
// wi, wo: refracted directions. sigma_a: absorption per unit of the thickness d.
fn weidlich_wilkie_attenuation(sigma_a: vec3f, thickness: f32, wi: vec3f, wo: vec3f) -> vec3f {
    return exp(-sigma_a * (thickness * ((wi.z + wo.z) / (wi.z * wo.z))));
}

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
fn weidlich_wilkie_length2(h: vec3f) -> f32 {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
fn weidlich_wilkie_cos_half(wi: vec3f, wo: vec3f) -> f32 {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(weidlich_wilkie_length2(wi + wo));
}

// eta^2 cos^2(theta_t) = mu^2 + eta^2 - 1; negative where light is reflected totally.
fn weidlich_wilkie_refracted_cos2(mu: f32, eta: f32) -> f32 {
    // The difference of two squares as a product, and mu^2 with its rounding error: at grazing angles, and at
    // the critical one, little else is left.
    return fma(mu, mu, (eta - 1.0) * (eta + 1.0));
}

// F and T = 1 - F of a smooth dielectric with eta >= 1 at a cosine mu outside, mu > 0.
fn weidlich_wilkie_split_entering(mu: f32, eta: f32) -> WeidlichWilkieEntering {
    // r_s = (1 - eta^2) / s^2 with s = c + g, and r_p = r_s (c g - sin2) / q with q = c g + sin2. So 1 - r_s^2
    // = 4 c g / s^2, and 1 - r_p^2 = 4 c g eta^2 / (s q)^2. One quotient serves all.
    let c = mu;
    let g = sqrt(weidlich_wilkie_refracted_cos2(c, eta));
    let s = c + g;
    let p = c * g;
    let sin2 = 1.0 - c * c;
    let q = p + sin2;
    let s2 = s * s;
    let q2 = q * q;
    let inv = 1.0 / (s2 * q2);
    let r_s = (eta - 1.0) * (eta + 1.0) * (q2 * inv);
    let F = r_s * r_s * ((p * p + sin2 * sin2) * (s2 * inv));
    return WeidlichWilkieEntering(F, p * inv * (2.0 * (q2 + eta * eta)));
}

// 1 - F of a smooth dielectric with eta >= 1 at a cosine mu outside; exact where it nearly vanishes.
fn weidlich_wilkie_transmittance_entering(mu: f32, eta: f32) -> f32 {
    return weidlich_wilkie_split_entering(mu, eta).T;
}

// 1 - G of V-grooves, 1 - 4 h.z min(mu_i, mu_o) / |h|^2 with h = wi + wo, exact where G is nearly 1.
//
// To within 1e-7 in float32. Shaders' compilers rearrange sums, and what was carried along would be 0.
fn weidlich_wilkie_lost_cook_torrance(wi: vec3f, wo: vec3f) -> f32 {
    let h = wi + wo;
    let low = min(wi.z, wo.z);
    let high = max(wi.z, wo.z);
    // h.z^2 - 4 h.z low = h.z (high - 3 low); in two steps, both are exact where G is nearly 1
    let rest = high - 2.0 * low - low;
    return max((h.x * h.x + h.y * h.y + h.z * rest) / weidlich_wilkie_length2(h), 0.0);
}

// T12 t of Eq. 2 and 4 with lost = 1 - G.
fn weidlich_wilkie_past_facets(T: f32, lost: f32) -> f32 {
    // 1 - G F would lose the digits of a small T
    return T * (T + lost * (1.0 - T));
}

// T12 t: what the surface lets in and out again.
fn weidlich_wilkie_transmitted(params: WeidlichWilkie, wi: vec3f, wo: vec3f) -> f32 {
    let T = weidlich_wilkie_transmittance_entering(weidlich_wilkie_cos_half(wi, wo), params.eta);
    // Eq. 4
    return weidlich_wilkie_past_facets(T, weidlich_wilkie_lost_cook_torrance(wi, wo));
}

// rho / pi.
fn weidlich_wilkie_base_eval_above(params: WeidlichWilkieBase) -> vec3f {
    const inv_pi = 0.31830987;
    return params.rho * inv_pi;
}

// Exact reflectance of a dielectric with eta >= 1, never total, at a cosine outside, mu > 0.
fn weidlich_wilkie_F_dielectric_entering(mu: f32, eta: f32) -> f32 {
    return weidlich_wilkie_split_entering(mu, eta).F;
}

fn weidlich_wilkie_facets(params: WeidlichWilkie) -> WeidlichWilkieRoundBeckmann {
    return WeidlichWilkieRoundBeckmann(params.alpha);
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
fn weidlich_wilkie_slopes(h: vec3f) -> vec2f {
    let inv = 1.0 / h.z;
    return vec2f(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
fn weidlich_wilkie_tangent2(h: vec3f) -> f32 {
    let t = weidlich_wilkie_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
fn weidlich_wilkie_round_beckmann_D_along(round_beckmann: WeidlichWilkieRoundBeckmann,
    h: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    let inv_a2 = 1.0 / (round_beckmann.alpha * round_beckmann.alpha);
    let tan2 = weidlich_wilkie_tangent2(h);
    // The root of D, as 1 / cos^4 leaves a float32 where the exponential is 0
    let root = (1.0 + tan2) * exp(-0.5 * tan2 * inv_a2);
    return inv_pi * inv_a2 * (root * root);
}

// G over 4 mu_i mu_o.
fn weidlich_wilkie_V_cook_torrance(wi: vec3f, wo: vec3f) -> f32 {
    // Largest V of the maskings that grow like 1 / mu^2 where both directions graze: times the largest D, 3e7,
    // it still is a float32. It is reached at cosines of 5e-16.
    const V_MAX = 1.0e30;
    let h = wi + wo;
    return min(min(h.z / weidlich_wilkie_length2(h) * min(wi.z, wo.z), 0.25) / (wi.z * wo.z),
        V_MAX);
}

// Eq. 2: BRDF value in 1/sr, without the cosine.
fn weidlich_wilkie_eval(params: WeidlichWilkie, wi: vec3f, wo: vec3f) -> vec3f {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    let wi_t = weidlich_wilkie_refract(wi, params.eta - 1.0);
    let wo_t = weidlich_wilkie_refract(wo, params.eta - 1.0);
    let kept = weidlich_wilkie_attenuation(params.sigma_a, params.thickness, wi_t, wo_t);
    let through = weidlich_wilkie_transmitted(params, wi, wo);
    let below = weidlich_wilkie_base_eval_above(params.base) * (kept * through);
    let F = weidlich_wilkie_F_dielectric_entering(weidlich_wilkie_cos_half(wi, wo), params.eta);
    let coat = F * weidlich_wilkie_round_beckmann_D_along(weidlich_wilkie_facets(params), wi + wo)
        * weidlich_wilkie_V_cook_torrance(wi, wo);
    return below + coat;
}

// ---- sampling ------------------------------------------------------------------------------

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
fn weidlich_wilkie_half_vector(wi: vec3f, wo: vec3f) -> vec3f {
    // wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
    // squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
    // much longer.
    const LENGTHENED = 1.0995116e12;
    let h = LENGTHENED * (wi + wo);
    return h / sqrt(weidlich_wilkie_length2(h));  // the root is the cosine's as well
}

// A cosine at which light from anywhere meets the facets that it enters by, to choose lobes with.
//
// Halfway between wo.z (the mirror direction) and 1 (wi = wo): at grazing angles tilted facets let in more
// than the mean surface, whose transmittance is nearly 0 there.
fn weidlich_wilkie_usual_cos_half(wo: vec3f) -> f32 {
    return 0.5 + 0.5 * wo.z;
}

// The most that weidlich_wilkie_attenuation leaves of light that goes out along wo: it came in along
// the normal.
fn weidlich_wilkie_attenuation_least(sigma_a: vec3f, thickness: f32, wo: vec3f) -> vec3f {
    return weidlich_wilkie_attenuation(sigma_a, thickness, vec3f(0.0, 0.0, 1.0), wo);
}

// Mean of the three channels, by which lobes are weighed against each other.
fn weidlich_wilkie_average(color: vec3f) -> f32 {
    return (color.x + color.y + color.z) / 3.0;
}

fn weidlich_wilkie_raised(probability: f32) -> f32 {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const SHARE_LEAST = 0.1;
    const ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
fn weidlich_wilkie_lobes_shares(first: f32, second: f32) -> vec2f {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const WEIGHT_MIN = 1.0e-37;
    let a = first + BLACK;
    let b = max(second, WEIGHT_MIN);
    let inv = 1.0 / (a + b);
    let P_first = weidlich_wilkie_raised(a * inv);
    let P_second = weidlich_wilkie_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    let smaller = a < b;
    return vec2f(select(1.0 - P_second, P_first, smaller),
        select(P_second, 1.0 - P_first, smaller));
}

// Probabilities of the coat and of the base: their parts of the light, if the base were white.
fn weidlich_wilkie_shares(params: WeidlichWilkie, wo: vec3f, wo_t: vec3f) -> vec2f {
    // The coat gets at least a tenth as many samples as the base: facets reflect more than the mean surface
    // where they are tilted, and this bounds their weight.
    const COAT_SHARE_MIN = 0.1;
    // Added to the weight of a lobe, so that the reciprocal of two black lobes' sum has a finite derivative.
    const LOBE_MIN = 1.0e-12;
    let mu = weidlich_wilkie_usual_cos_half(wo);
    let through = weidlich_wilkie_transmittance_entering(mu, params.eta)
        * weidlich_wilkie_average(weidlich_wilkie_attenuation_least(params.sigma_a,
            params.thickness, wo_t));
    let reflected = max(weidlich_wilkie_F_dielectric_entering(wo.z, params.eta),
        COAT_SHARE_MIN * through + LOBE_MIN);
    return weidlich_wilkie_lobes_shares(reflected, through);
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
fn weidlich_wilkie_choose(probability: f32, u: vec2f) -> WeidlichWilkieChoice {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const SHARE_MIN = 1.0e-12;
    const RANDOM_MAX = 0.99999994;  // The largest float32 below 1, up to which random numbers go.
    let first = u.x < probability;
    let below = u.x / max(probability, SHARE_MIN);
    let above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return WeidlichWilkieChoice(first,
        vec2f(clamp(select(above, below, first), 0.0, RANDOM_MAX), u.y));
}

// A direction with density cos(theta) / pi.
fn weidlich_wilkie_sample_cosine(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(u.x, 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// Density of weidlich_wilkie_sample_cosine in 1/sr, for w above the horizon.
fn weidlich_wilkie_pdf_cosine(w: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Cosine-weighted, which is exact here.
fn weidlich_wilkie_base_sample(wo: vec3f, u: vec2f) -> WeidlichWilkieSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return WeidlichWilkieSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let wi = weidlich_wilkie_sample_cosine(u);
    return WeidlichWilkieSample(wi, select(0.0, weidlich_wilkie_pdf_cosine(wi), wi.z > mu_min));
}

// Cosine inside the layer of the flattest direction that leaves it; 0 for eta <= 1.
fn weidlich_wilkie_critical_cosine(excess: f32) -> f32 {
    return sqrt(max(weidlich_wilkie_contrast(excess), 0.0)) / (1.0 + excess);
}

// The outer direction for a direction inside: refracted, or spread out if it cannot leave.
fn weidlich_wilkie_leave(w: vec3f, excess: f32) -> vec3f {
    const mu_min = 1.0e-18;  // cosine of the horizon
    // Below this squared sine the azimuth of wo is taken as 0: any azimuth is right there, and the square of
    // its reciprocal still fits into a float32.
    const SIN2_MIN = 1.0e-18;
    // Flattest direction that a sample leaves in: derivatives by the index fit in a float32 there.
    const LEAVE_MIN = 1.0e-12;
    let k = weidlich_wilkie_critical_cosine(excess);
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

// weidlich_wilkie_base_sample inside a kernel for a base under layers: the direction in which the light
// leaves them.
//
// wo: inside the lowest layer. excess: the product of the layers' indices, minus 1. Layers over layers
// override it: each calls the next once, whose light refracts as if there were one layer.
fn weidlich_wilkie_base_sample_leaving(wo: vec3f, u: vec2f, excess: f32) -> vec3f {
    return weidlich_wilkie_leave(weidlich_wilkie_base_sample(wo, u).wi, excess);
}

// A normal with density D m.z. Walter et al., Eq. 28 and 29.
fn weidlich_wilkie_beckmann_sample(beckmann: WeidlichWilkieBeckmann, u: vec2f) -> vec3f {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const RANDOM_MARGIN = 5.9604645e-8;
    const two_pi = 6.2831855;
    let r = sqrt(max(-log(max(1.0 - u.x, RANDOM_MARGIN)), 0.0));
    let phi = two_pi * u.y;
    return normalize(vec3f(beckmann.alpha_x * r * cos(phi), beckmann.alpha_y * r * sin(phi), 1.0));
}

// A normal with density D m.z.
fn weidlich_wilkie_round_beckmann_sample(round_beckmann: WeidlichWilkieRoundBeckmann,
    u: vec2f) -> vec3f {
    return weidlich_wilkie_beckmann_sample(WeidlichWilkieBeckmann(round_beckmann.alpha,
        round_beckmann.alpha), u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
fn weidlich_wilkie_mirror(wo: vec3f, m: vec3f) -> vec3f {
    return 2.0 * dot(wo, m) * m - wo;
}

// A direction that the coat mirrors.
//
// Visible normals need a G that is no larger than Smith's G1: with Cook-Torrance's the weights would grow
// like alpha / mu_o in the horizon. Those of all normals are at most 2.
fn weidlich_wilkie_sample_coat(params: WeidlichWilkie, wo: vec3f, u: vec2f) -> vec3f {
    return weidlich_wilkie_mirror(wo,
        weidlich_wilkie_round_beckmann_sample(weidlich_wilkie_facets(params), u));
}

// cos(theta_i) / pi.
fn weidlich_wilkie_base_pdf(wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return weidlich_wilkie_pdf_cosine(wi);
}

// The inner direction that weidlich_wilkie_leave spreads to w; z = 0 for eta <= 1, which has none.
fn weidlich_wilkie_gather(w: vec3f, excess: f32) -> vec3f {
    const SIN2_MIN = 1.0e-18;
    let k = weidlich_wilkie_critical_cosine(excess);
    let z = k * w.z;
    let sin2 = w.x * w.x + w.y * w.y;
    let scale = sqrt(max(1.0 - z * z, 0.0)) / sqrt(max(sin2, SIN2_MIN));
    let near = sin2 < SIN2_MIN;  // no azimuth: any is right
    let x = select(w.x * scale, sqrt(max(1.0 - z * z, 0.0)), near);
    return vec3f(x, select(w.y * scale, 0.0, near), z);
}

// Density of weidlich_wilkie_leave at w, from the inner density at w_t = refract(w) and at gather(w).
fn weidlich_wilkie_pdf_leave(pdf_refracted: f32, pdf_gathered: f32, w: vec3f, w_t: vec3f,
    excess: f32) -> f32 {
    // Solid angle over cosine-weighted one: 1 / mu. Refraction shrinks the latter by eta^2, gathering by k^2,
    // and the cosines are k mu and mu.
    let eta = 1.0 + excess;
    return pdf_refracted * w.z / (eta * eta * w_t.z)
        + pdf_gathered * weidlich_wilkie_critical_cosine(excess);
}

// Density of weidlich_wilkie_base_sample_leaving at wi, which is outside all layers, in 1/sr.
fn weidlich_wilkie_base_pdf_leaving(wi: vec3f, wo: vec3f, excess: f32) -> f32 {
    let wi_t = weidlich_wilkie_refract(wi, excess);
    return weidlich_wilkie_pdf_leave(weidlich_wilkie_base_pdf(wi_t, wo),
        weidlich_wilkie_base_pdf(weidlich_wilkie_gather(wi, excess), wo), wi, wi_t, excess);
}

// Density of facets, in 1/sr. Walter et al., Eq. 25.
fn weidlich_wilkie_round_beckmann_D(round_beckmann: WeidlichWilkieRoundBeckmann,
    m: vec3f) -> f32 {
    // Square of the cosine below which exp(-tan^2 / alpha^2) is 0 in any precision, for alpha up to 3.2.
    const COS2_MIN = 1.0e-6;
    const inv_pi = 0.31830987;
    let inv_cos2 = 1.0 / max(m.z * m.z, COS2_MIN);
    let inv_a2 = 1.0 / (round_beckmann.alpha * round_beckmann.alpha);
    let sin2 = m.x * m.x + m.y * m.y;
    return inv_pi * inv_a2 * inv_cos2 * inv_cos2 * exp(-sin2 * inv_cos2 * inv_a2);
}

// Density of weidlich_wilkie_round_beckmann_sample in 1/sr.
fn weidlich_wilkie_round_beckmann_density(round_beckmann: WeidlichWilkieRoundBeckmann,
    m: vec3f) -> f32 {
    return weidlich_wilkie_round_beckmann_D(round_beckmann, m) * m.z;
}

// |wi + wo| / 2, the same with all digits however short it is: for what is divided by it.
fn weidlich_wilkie_half_length(wi: vec3f, wo: vec3f) -> f32 {
    const LENGTHENED = 1.0995116e12;
    return 0.5 / LENGTHENED * sqrt(weidlich_wilkie_length2(LENGTHENED * (wi + wo)));
}

// Density of weidlich_wilkie_mirror in 1/sr, if m has the given density and cos_h = wo . m.
fn weidlich_wilkie_pdf_mirror(density: f32, cos_h: f32) -> f32 {
    // Walter et al., Eq. 14
    return 0.25 * density / cos_h;
}

fn weidlich_wilkie_pdf_coat(params: WeidlichWilkie, wi: vec3f, wo: vec3f) -> f32 {
    let density = weidlich_wilkie_round_beckmann_density(weidlich_wilkie_facets(params),
        weidlich_wilkie_half_vector(wi, wo));
    return weidlich_wilkie_pdf_mirror(density, weidlich_wilkie_half_length(wi, wo));
}

// Density of weidlich_wilkie_sample in 1/sr.
fn weidlich_wilkie_pdf(params: WeidlichWilkie, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    let wo_t = weidlich_wilkie_refract(wo, params.eta - 1.0);
    let below = weidlich_wilkie_base_pdf_leaving(wi, wo_t, params.eta - 1.0);
    let P = weidlich_wilkie_shares(params, wo, wo_t);
    return P.x * weidlich_wilkie_pdf_coat(params, wi, wo) + P.y * below;
}

// The coat by visible normals or the base below, chosen by what the coat reflects and absorbs.
fn weidlich_wilkie_sample(params: WeidlichWilkie, wo: vec3f, u: vec2f) -> WeidlichWilkieSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return WeidlichWilkieSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let wo_t = weidlich_wilkie_refract(wo, params.eta - 1.0);
    let choose_result = weidlich_wilkie_choose(weidlich_wilkie_shares(params, wo, wo_t).x, u);
    let on_coat = choose_result.is_first;
    let v = choose_result.u;
    let w_base = weidlich_wilkie_base_sample_leaving(wo_t, v, params.eta - 1.0);
    let wi = select(w_base, weidlich_wilkie_sample_coat(params, wo, v), on_coat);
    return WeidlichWilkieSample(wi, weidlich_wilkie_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
fn weidlich_wilkie_albedo(params: WeidlichWilkie, wo: vec3f) -> vec3f {
    // Steps of the rule in weidlich_wilkie_albedo: a Fibonacci number, and the golden ratio.
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
        let drawn = weidlich_wilkie_sample(params, w, u);
        let weight = select(0.0, drawn.wi.z / max(drawn.pdf, mu_min), drawn.pdf > 0.0);
        total = total + weidlich_wilkie_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
