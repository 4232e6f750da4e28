// SPDX-License-Identifier: Apache-2.0
// SGD: the shifted gamma distribution of facets, which was fitted to a hundred measured materials.
//
// Source: Bagher, Soler, Holzschuch, "Accurate fitting of measured reflectances using a shifted gamma
// micro-facet distribution", Computer Graphics Forum 31(4), 2012. Every number has three channels; K, the
// masking and F are free of each other, as in the published fits. Deviations: c (theta - theta_0)^k is
// ((theta - theta_0) / width)^k with width = c^(-1/k), as c of some fits is above 10^100; F and G are never
// below 0.
//
// WGSL (WebGPU), made by gonio from gonio/models/sgd.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: var params: Sgd; params.rho = ...; ... sgd_eval(params, wi, wo)

// A sampled direction and its density.
struct SgdSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// sgd: Paints, metals and plastics as they were measured; the default is a gold paint. Reciprocal.
struct Sgd {
    rho: vec3f,  // diffuse albedo, linear RGB; 0 to 1, default (0.147708, 0.0806975, 0.033172)
    // weight of the highlight, linear RGB; 0 to 10, default (0.160592, 0.217282, 0.236425)
    specular: vec3f,
    // shift, and width of the squared slopes; 1e-05 to 1, default (0.122506, 0.108069, 0.12187)
    alpha: vec3f,
    p: vec3f,  // power of the distribution's tail; 0 to 2, default (0.795078, 0.637578, 0.936117)
    f0: vec3f,  // F's constant; 0 to 10, default (0, 0, 0.0024589)
    // F's slope: f0 - f1 at normal incidence; -2 to 10, default (-0.596835, -0.331147, -0.140729)
    f1: vec3f,
    // K: 1 / (alpha Gamma(1 - p, alpha)) where D is normalized; 0 to 100000, default (5.98176,
    // 7.35539, 5.29722)
    normalization: vec3f,
    masking_strength: vec3f,  // Lambda; 0 to 1e+08, default (2.64832, 3.04253, 2.3013)
    // theta_0 in radians: G is 1 up to there; -1 to 1.5, default (-0.284195, -0.277297, -0.245352)
    masking_angle: vec3f,
    // c^(-1/k): radians from there on; 0.01 to 100, default (1.943735, 1.94587, 1.890624)
    masking_width: vec3f,
    // k: how suddenly masking begins; 1 to 1000, default (24.3593, 24.4037, 25.3623)
    masking_exponent: vec3f,
}

// Densities of one channel's facets for samples: s^-p up to s = 1, and exp(1 - s) beyond.
//
// s is alpha + tan^2 / alpha. The distribution itself, s^-p exp(-s), has no inverse; it is at most the one
// for samples, and at least a third of that before s = 1.
struct SgdShiftedGamma {
    alpha: f32,  // Shift, and width of the squared slopes
    p: f32,  // Power of the tail
}

// Which of two lobes a sample is taken from.
struct SgdChoice {
    is_first: bool,  // Whether it is the first one
    u: vec2f,  // Fresh random numbers, made of those that chose
}

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
fn sgd_length2(h: vec3f) -> f32 {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
fn sgd_half_vector(wi: vec3f, wo: vec3f) -> vec3f {
    // wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
    // squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
    // much longer.
    const LENGTHENED = 1.0995116e12;
    let h = LENGTHENED * (wi + wo);
    return h / sqrt(sgd_length2(h));  // the root is the cosine's as well
}

// 2 atan(v) / v for v in [-1, 1], the angle whose half has the tangent v; 2 at v = 0.
fn sgd_twice_atan_over(v: f32) -> f32 {
    const ATAN_0 = 2.0;  // 2 atan(v) / v in v^2 on [0, 1]; fitted, relative error below 2e-8.
    const ATAN_1 = -0.66666144;
    const ATAN_2 = 0.3998524;
    const ATAN_3 = -0.28407288;
    const ATAN_4 = 0.21281867;
    const ATAN_5 = -0.15008585;
    const ATAN_6 = 0.085383;
    const ATAN_7 = -0.03213723;
    const ATAN_8 = 0.005699773;
    let q = v * v;
    let p = ATAN_4 + q * (ATAN_5 + q * (ATAN_6 + q * (ATAN_7 + q * ATAN_8)));
    return ATAN_0 + q * (ATAN_1 + q * (ATAN_2 + q * (ATAN_3 + q * p)));
}

// exp(x) - 1, exact where x is small.
fn sgd_expm1(x: f32) -> f32 {
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

// 1 + Lambda (1 - exp(((theta - theta_0) / width)^k)).
fn sgd_G(params: Sgd, w: vec3f) -> vec3f {
    // Largest x of exp(x) in the masking, where G of all fits is 0 before; and the smallest, where 1.8e-35 of
    // Lambda changes no G and still is a normal float32.
    const LOG_MAX = 3.0;
    const LOG_MIN = -80.0;
    // Angles and squared cosines below which a logarithm or quotient leaves a float32.
    const ANGLE_MIN = 1.0e-12;
    let v = sqrt(w.x * w.x + w.y * w.y) / (1.0 + w.z);
    let beyond = v * sgd_twice_atan_over(v) - params.masking_angle;
    let x = log(max(beyond, vec3f(ANGLE_MIN))) - log(params.masking_width);
    let t = max(min(params.masking_exponent * x, vec3f(LOG_MAX)), vec3f(LOG_MIN));
    // expm1 of each channel
    let lost = exp(t);
    let masked = params.masking_strength
        * vec3f(sgd_expm1(lost.x), sgd_expm1(lost.y), sgd_expm1(lost.z));
    return select(vec3f(1.0), clamp(1.0 - masked, vec3f(0.0), vec3f(1.0)), beyond > vec3f(0.0));
}

// K s^-p exp(-s) / cos^4 with s = alpha + tan^2 / alpha.
fn sgd_D(params: Sgd, m: vec3f) -> vec3f {
    // Largest squared slope over alpha, where D is 0 in every precision.
    const SLOPE_MAX = 10000.0;
    const COS2_MIN = 1.0e-30;
    let z2 = max(m.z * m.z, COS2_MIN);
    let s = params.alpha + min((m.x * m.x + m.y * m.y) / z2 / params.alpha, vec3f(SLOPE_MAX));
    return params.normalization * exp(-params.p * log(s) - s - 2.0 * log(z2));
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
fn sgd_cos_half(wi: vec3f, wo: vec3f) -> f32 {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(sgd_length2(wi + wo));
}

// Schlick's with a slope.
fn sgd_F(params: Sgd, cos_h: f32) -> vec3f {
    let c = 1.0 - min(cos_h, 1.0);
    let c5 = c * c * (c * c) * c;
    return max(params.f0 - params.f1 * cos_h + (1.0 - params.f0) * c5, vec3f(0.0));
}

// rho / pi + specular / pi F D G / (mu_i mu_o): BRDF value in 1/sr, without the cosine.
fn sgd_eval(params: Sgd, wi: vec3f, wo: vec3f) -> vec3f {
    const inv_pi = 0.31830987;
    const mu_min = 1.0e-18;  // cosine of the horizon
    // Largest 1 / (mu_i mu_o), at cosines of 1e-4: times D and its derivatives it still is a float32.
    const V_SGD = 1.0e8;
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    let m = sgd_half_vector(wi, wo);
    let G = sgd_G(params, wi) * sgd_G(params, wo);
    let D = sgd_D(params, m) * min(1.0 / wi.z / wo.z, V_SGD);
    return inv_pi * (params.rho + params.specular * sgd_F(params, sgd_cos_half(wi, wo)) * (G * D));
}

// ---- sampling ------------------------------------------------------------------------------

// The facets of a channel.
fn sgd_red(params: Sgd) -> SgdShiftedGamma {
    return SgdShiftedGamma(params.alpha.x, params.p.x);
}

// 1 - p, not quite 0.
fn sgd_shifted_gamma_one_less(shifted_gamma: SgdShiftedGamma) -> f32 {
    // Nearer to 1 than this, 1 - p is taken as this: what is divided by it differs by as little.
    const POWER_MIN = 1.0e-4;
    let q = 1.0 - shifted_gamma.p;
    return select(max(q, POWER_MIN), min(q, -POWER_MIN), q < 0.0);
}

// The integral of s^-p from alpha to 1; that of the rest is 1.
fn sgd_shifted_gamma_near(shifted_gamma: SgdShiftedGamma) -> f32 {
    let q = sgd_shifted_gamma_one_less(shifted_gamma);
    return -sgd_expm1(q * log(shifted_gamma.alpha)) / q;
}

// The facets of a channel.
fn sgd_green(params: Sgd) -> SgdShiftedGamma {
    return SgdShiftedGamma(params.alpha.y, params.p.y);
}

// The facets of a channel.
fn sgd_blue(params: Sgd) -> SgdShiftedGamma {
    return SgdShiftedGamma(params.alpha.z, params.p.z);
}

// Mean of the three channels, by which lobes are weighed against each other.
fn sgd_average(color: vec3f) -> f32 {
    return (color.x + color.y + color.z) / 3.0;
}

fn sgd_raised(probability: f32) -> f32 {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const SHARE_LEAST = 0.1;
    const ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
fn sgd_lobes_shares(first: f32, second: f32) -> vec2f {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const WEIGHT_MIN = 1.0e-37;
    let a = first + BLACK;
    let b = max(second, WEIGHT_MIN);
    let inv = 1.0 / (a + b);
    let P_first = sgd_raised(a * inv);
    let P_second = sgd_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    let smaller = a < b;
    return vec2f(select(1.0 - P_second, P_first, smaller),
        select(P_second, 1.0 - P_first, smaller));
}

// Probabilities of the diffuse part and of the highlight, as if it was a mirror.
fn sgd_shares(params: Sgd, wo: vec3f) -> vec2f {
    let near = vec3f(sgd_shifted_gamma_near(sgd_red(params)),
        sgd_shifted_gamma_near(sgd_green(params)), sgd_shifted_gamma_near(sgd_blue(params)));
    let mass = params.normalization * params.alpha * (near + 1.0);
    return sgd_lobes_shares(sgd_average(params.rho),
        4.0 * sgd_average(params.specular * sgd_F(params, wo.z) * mass));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
fn sgd_choose(probability: f32, u: vec2f) -> SgdChoice {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const SHARE_MIN = 1.0e-12;
    const RANDOM_MAX = 0.99999994;  // The largest float32 below 1, up to which random numbers go.
    let first = u.x < probability;
    let below = u.x / max(probability, SHARE_MIN);
    let above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return SgdChoice(first, vec2f(clamp(select(above, below, first), 0.0, RANDOM_MAX), u.y));
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
fn sgd_atanh_over(y: f32) -> f32 {
    let y2 = y * y;
    return 1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0 + y2 * (1.0 / 9.0))));
}

// log(1 + x) / x for x > -1; 1 at x = 0.
fn sgd_log1p_over(x: f32) -> f32 {
    // Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
    const LOG1P_SMALL = 0.25;
    let near = max(min(x, LOG1P_SMALL), -LOG1P_SMALL);
    let small = x > -LOG1P_SMALL && x < LOG1P_SMALL;
    let far = select(x, 1.0, small);
    let series = sgd_atanh_over(near / (2.0 + near));
    return select(log(1.0 + far) / far, 2.0 / (2.0 + near) * series, small);
}

// log(1 + x) for x > -1, exact where x is small.
fn sgd_log1p(x: f32) -> f32 {
    return x * sgd_log1p_over(x);
}

// A normal.
fn sgd_shifted_gamma_sample(shifted_gamma: SgdShiftedGamma, u: vec2f) -> vec3f {
    const ANGLE_MIN = 1.0e-12;
    const two_pi = 6.2831855;
    let near = sgd_shifted_gamma_near(shifted_gamma);
    let q = sgd_shifted_gamma_one_less(shifted_gamma);
    let v = u.x * (near + 1.0);
    let inside = v < near;
    // s = alpha (1 + q v alpha^-q)^(1/q), less alpha
    let grown = sgd_log1p(q * min(v, near) * exp(-q * log(shifted_gamma.alpha))) / q;
    let x = shifted_gamma.alpha * sgd_expm1(grown);
    let far = 1.0 - shifted_gamma.alpha - log(max(1.0 + near - v, ANGLE_MIN));
    let tangent = sqrt(shifted_gamma.alpha * max(select(far, x, inside), 0.0));
    let phi = two_pi * u.y;
    return normalize(vec3f(tangent * cos(phi), tangent * sin(phi), 1.0));
}

// A direction with density cos(theta) / pi.
fn sgd_sample_cosine(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(u.x, 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
fn sgd_mirror(wo: vec3f, m: vec3f) -> vec3f {
    return 2.0 * dot(wo, m) * m - wo;
}

// Of normals in 1/sr.
fn sgd_shifted_gamma_density(shifted_gamma: SgdShiftedGamma, m: vec3f) -> f32 {
    // Largest squared slope over alpha, where D is 0 in every precision.
    const SLOPE_MAX = 10000.0;
    const COS2_MIN = 1.0e-30;
    const inv_pi = 0.31830987;
    let z2 = max(m.z * m.z, COS2_MIN);
    let x = min((m.x * m.x + m.y * m.y) / z2 / shifted_gamma.alpha, SLOPE_MAX);
    let s = shifted_gamma.alpha + x;
    let tail = select(exp(min(1.0 - s, 0.0)), exp(-shifted_gamma.p * log(min(s, 1.0))), s < 1.0);
    return inv_pi * tail / ((sgd_shifted_gamma_near(shifted_gamma) + 1.0) * shifted_gamma.alpha)
        / z2 * (m.z / z2);
}

// Density of sgd_sample_cosine in 1/sr, for w above the horizon.
fn sgd_pdf_cosine(w: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// |wi + wo| / 2, the same with all digits however short it is: for what is divided by it.
fn sgd_half_length(wi: vec3f, wo: vec3f) -> f32 {
    const LENGTHENED = 1.0995116e12;
    return 0.5 / LENGTHENED * sqrt(sgd_length2(LENGTHENED * (wi + wo)));
}

// Density of sgd_mirror in 1/sr, if m has the given density and cos_h = wo . m.
fn sgd_pdf_mirror(density: f32, cos_h: f32) -> f32 {
    // Walter et al., Eq. 14
    return 0.25 * density / cos_h;
}

// Density of sgd_sample in 1/sr.
fn sgd_pdf(params: Sgd, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    let P = sgd_shares(params, wo);
    let m = sgd_half_vector(wi, wo);
    var facets = sgd_shifted_gamma_density(sgd_red(params), m)
        + sgd_shifted_gamma_density(sgd_green(params), m);
    facets = (facets + sgd_shifted_gamma_density(sgd_blue(params), m)) / 3.0;
    return P.x * sgd_pdf_cosine(wi) + P.y * sgd_pdf_mirror(facets, sgd_half_length(wi, wo));
}

// Cosine-weighted, or wo mirrored at a normal of one of the channels.
fn sgd_sample(params: Sgd, wo: vec3f, u: vec2f) -> SgdSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return SgdSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let choose_result = sgd_choose(sgd_shares(params, wo).x, u);
    let matte = choose_result.is_first;
    let v = choose_result.u;
    let thirds = 3.0 * v.x;
    let w = vec2f(fract(thirds), v.y);
    var m = sgd_shifted_gamma_sample(sgd_red(params), w);
    m = select(sgd_shifted_gamma_sample(sgd_green(params), w), m, thirds < 1.0);
    m = select(sgd_shifted_gamma_sample(sgd_blue(params), w), m, thirds < 2.0);
    let wi = select(sgd_mirror(wo, m), sgd_sample_cosine(v), matte);
    return SgdSample(wi, sgd_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
fn sgd_albedo(params: Sgd, wo: vec3f) -> vec3f {
    // Steps of the rule in sgd_albedo: a Fibonacci number, and the golden ratio.
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
        let drawn = sgd_sample(params, w, u);
        let weight = select(0.0, drawn.wi.z / max(drawn.pdf, mu_min), drawn.pdf > 0.0);
        total = total + sgd_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
