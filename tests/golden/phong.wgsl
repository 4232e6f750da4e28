// SPDX-License-Identifier: Apache-2.0
// Phong: a diffuse term and a highlight around the mirror direction.
//
// Sources: Phong, "Illumination for computer generated pictures", Communications of the ACM 18(6), 1975;
// Lafortune, Willems, "Using the modified Phong reflectance model for physically based rendering", 1994,
// for the normalised form. alpha is the angle between wi and the mirror direction of wo.
// Phong's formula gives the radiance f cos(theta_i); "classical" is that formula divided by the cosine.
//
// WGSL (WebGPU), made by gonio from gonio/models/phong.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: var params: Phong; params.rho = ...; ... phong_eval(params, wi, wo)

// A sampled direction and its density.
struct PhongSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// phong: Diffuse with a round highlight around the mirror direction, the classic of computer graphics.
// Exported with form='normalized'.
struct Phong {
    rho: vec3f,  // albedo of the diffuse term, linear RGB; 0 to 1, default (0.5, 0.5, 0.5)
    specular: vec3f,  // weight of the highlight, linear RGB; 0 to 1, default (0.3, 0.3, 0.3)
    shininess: f32,  // exponent n of the highlight; 0 to 100000, default 20
}

// Which of two lobes a sample is taken from.
struct PhongChoice {
    is_first: bool,  // Whether it is the first one
    u: vec2f,  // Fresh random numbers, made of those that chose
}

// ---- evaluation ----------------------------------------------------------------------------

// Cosine between wi and the mirror direction of wo: mu_i mu_o - wi.x wo.x - wi.y wo.y.
//
// Near 0 the three products cancel. The rounding errors of the last two and of their sum are carried along
// (Kahan's and Knuth's ways to find them), so that a broad lobe fades out with all its digits; the first
// product comes in with a single rounding, which is small beside what is left.
fn phong_cos_alpha(wi: vec3f, wo: vec3f) -> f32 {
    let x = wi.x * wo.x;
    let y = wi.y * wo.y;
    let s = x + y;
    let back_y = s - x;
    let error_s = x - (s - back_y) + (y - back_y);
    let error = fma(wi.x, wo.x, -x) + fma(wi.y, wo.y, -y) + error_s;
    return fma(wi.z, wo.z, -s) - error;
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
fn phong_atanh_over(y: f32) -> f32 {
    let y2 = y * y;
    return 1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0 + y2 * (1.0 / 9.0))));
}

// log(1 + x) for x from -LOG1P_SMALL to LOG1P_SMALL.
fn phong_log1p_small(x: f32) -> f32 {
    let y = x / (2.0 + x);
    return 2.0 * y * phong_atanh_over(y);
}

// max(0, cos(alpha))^exponent; half of all directions have 0 for exponent 0 as well.
fn phong_lobe(wi: vec3f, wo: vec3f, exponent: f32) -> f32 {
    // Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
    const LOG1P_SMALL = 0.25;
    // Smallest cosine whose logarithm is taken: its reciprocal, the derivative, still is a float32.
    const COS_MIN = 1.0e-37;
    // Inside, the digits of a sharp lobe are in 1 - cos(alpha): half the squared distance to the
    // mirror direction.
    let apart = vec3f(wi.x + wo.x, wi.y + wo.y, wi.z - wo.z);
    let q = 0.5 * dot(apart, apart);
    let c = phong_cos_alpha(wi, wo);
    let near = phong_log1p_small(-min(q, LOG1P_SMALL));
    let log_cos = select(log(clamp(c, COS_MIN, 1.0)), near, q < LOG1P_SMALL);
    return select(0.0, exp(exponent * log_cos), c > 0.0);
}

// The highlight without its weight.
fn phong_highlight(params: Phong, wi: vec3f, wo: vec3f) -> f32 {
    const inv_two_pi = 0.15915494;
    let n = params.shininess;
    return inv_two_pi * (n + 2.0) * phong_lobe(wi, wo, n);
}

// BRDF value in 1/sr, without the cosine.
fn phong_eval(params: Phong, wi: vec3f, wo: vec3f) -> vec3f {
    const inv_pi = 0.31830987;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    return params.rho * inv_pi + params.specular * phong_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// Mean of the three channels, by which lobes are weighed against each other.
fn phong_average(color: vec3f) -> f32 {
    return (color.x + color.y + color.z) / 3.0;
}

fn phong_raised(probability: f32) -> f32 {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const SHARE_LEAST = 0.1;
    const ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
fn phong_lobes_shares(first: f32, second: f32) -> vec2f {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const WEIGHT_MIN = 1.0e-37;
    let a = first + BLACK;
    let b = max(second, WEIGHT_MIN);
    let inv = 1.0 / (a + b);
    let P_first = phong_raised(a * inv);
    let P_second = phong_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    let smaller = a < b;
    return vec2f(select(1.0 - P_second, P_first, smaller),
        select(P_second, 1.0 - P_first, smaller));
}

// Probabilities of the diffuse lobe and of the highlight.
fn phong_shares(params: Phong, wo: vec3f) -> vec2f {
    const pi = 3.1415927;
    let n = params.shininess;
    // 1 at the normal; in the horizon about 1 / sqrt(2 pi n), and 1/2 for n = 0
    let highlight = mix(0.5 / sqrt(1.0 + 0.5 * pi * n), 1.0, wo.z);
    return phong_lobes_shares(phong_average(params.rho),
        phong_average(params.specular) * highlight);
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
fn phong_choose(probability: f32, u: vec2f) -> PhongChoice {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const SHARE_MIN = 1.0e-12;
    const RANDOM_MAX = 0.99999994;  // The largest float32 below 1, up to which random numbers go.
    let first = u.x < probability;
    let below = u.x / max(probability, SHARE_MIN);
    let above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return PhongChoice(first, vec2f(clamp(select(above, below, first), 0.0, RANDOM_MAX), u.y));
}

// A direction with density cos(theta) / pi.
fn phong_sample_cosine(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(u.x, 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// exp(x) - 1, exact where x is small.
fn phong_expm1(x: f32) -> f32 {
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

// Cosine and sine of wo's azimuth; (1, 0) at normal incidence.
fn phong_azimuth(wo: vec3f) -> vec2f {
    // Below this squared sine the azimuth of wo is taken as 0: any azimuth is right there, and the square of
    // its reciprocal still fits into a float32.
    const SIN2_MIN = 1.0e-18;
    let sin2 = wo.x * wo.x + wo.y * wo.y;
    let tilted = sin2 > SIN2_MIN;
    let inv = 1.0 / sqrt(max(sin2, SIN2_MIN));
    return vec2f(select(1.0, wo.x * inv, tilted), select(0.0, wo.y * inv, tilted));
}

// A direction around wo's mirror image with density (n + 1) / (2 pi) cos(alpha)^n.
//
// What falls below the horizon is mirrored up again, so that no sample is wasted.
fn phong_sample_lobe(wo: vec3f, exponent: f32, u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    // cos(alpha) = (1 - u)^(1 / (n + 1)), and sin^2 = 1 - cos^2 without cancellation
    let t = log(1.0 - u.x) / (exponent + 1.0);
    let c = exp(t);
    let s = sqrt(max(-phong_expm1(2.0 * t), 0.0));
    let phi = two_pi * u.y;
    // A frame around the mirror direction: towards the normal, and level.
    let axis = phong_azimuth(wo);
    let sin_o = sqrt(max(wo.x * wo.x + wo.y * wo.y, 0.0));
    let x = s * cos(phi);
    let y = s * sin(phi);
    let outward = c * sin_o - x * wo.z;
    let up = c * wo.z + x * sin_o;
    let w = vec3f(-axis.x * outward + axis.y * y, -axis.y * outward - axis.x * y, up);
    return normalize(vec3f(w.x, w.y, abs(w.z)));
}

// Density of phong_sample_cosine in 1/sr, for w above the horizon.
fn phong_pdf_cosine(w: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Density of phong_sample_lobe in 1/sr.
fn phong_pdf_lobe(wi: vec3f, wo: vec3f, exponent: f32) -> f32 {
    const inv_two_pi = 0.15915494;
    let both = phong_lobe(wi, wo, exponent) + phong_lobe(vec3f(wi.x, wi.y, -wi.z), wo, exponent);
    return inv_two_pi * (exponent + 1.0) * both;
}

// Density of phong_sample in 1/sr.
fn phong_pdf(params: Phong, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    let P = phong_shares(params, wo);
    return P.x * phong_pdf_cosine(wi) + P.y * phong_pdf_lobe(wi, wo, params.shininess);
}

// Cosine-weighted, or around the mirror direction, by the estimated albedos.
fn phong_sample(params: Phong, wo: vec3f, u: vec2f) -> PhongSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return PhongSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let choose_result = phong_choose(phong_shares(params, wo).x, u);
    let first = choose_result.is_first;
    let v = choose_result.u;
    let wi = select(phong_sample_lobe(wo, params.shininess, v), phong_sample_cosine(v), first);
    return PhongSample(wi, phong_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
fn phong_albedo(params: Phong, wo: vec3f) -> vec3f {
    // Steps of the rule in phong_albedo: a Fibonacci number, and the golden ratio.
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
        let drawn = phong_sample(params, w, u);
        let weight = select(0.0, drawn.wi.z / max(drawn.pdf, mu_min), drawn.pdf > 0.0);
        total = total + phong_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
