// EON with the fitted albedo and cosine sampling, written by hand for the tests of gonio.export.prove.
// Source: Portsmouth, Kutz, Hill, arXiv:2410.18026, Eq. 14, 16, 19.

struct Eon {
    rho: vec3f,       // 0 to 1: single-scattering albedo, linear RGB
    roughness: f32,   // 0 to 1: unitless r
}

struct EonSample {
    wi: vec3f,
    pdf: f32,
}

const EON_PI: f32 = 3.14159265358979;
const EON_C1: f32 = 0.28779340921081;  // 1/2 - 2 / (3 pi)
const EON_C2: f32 = 0.07248821245692;  // 2/3 - 28 / (15 pi)

// Arc sine of x in [0, 1], as gonio.export.library has it.
fn eon_asin(x: f32) -> f32 {
    let near = x < 0.5;
    let a = select(sqrt(max(0.5 - 0.5 * x, 0.0)), x, near);
    let q = a * a;
    let p = 0.1666675393 + q * (0.07495241804 + q * (0.04547709131 + q * (0.02414764736 + q * 0.04221847907)));
    let angle = a + a * q * p;
    return select(0.5 * EON_PI - 2.0 * angle, angle, near);
}

// C1 - G_F / pi from Eq. 14, multiplied out in mu.
fn eon_loss(mu: f32) -> f32 {
    let k = 1.0 - mu;
    let g = k * (0.0571085289 + k * (0.491881867 + k * (-0.332181442 + k * 0.0714429953)));
    return EON_C1 - g;
}

fn eon_rho_multiple(rho: vec3f, r: f32) -> vec3f {
    let mean_E = (1.0 + EON_C2 * r) / (1.0 + EON_C1 * r);
    return rho * rho * mean_E / (vec3f(1.0, 1.0, 1.0) - rho * (1.0 - mean_E));
}

fn eon_eval(params: Eon, wi: vec3f, wo: vec3f) -> vec3f {
    if (wi.z <= 0.0 || wo.z <= 0.0) {
        return vec3f(0.0, 0.0, 0.0);
    }
    let r = params.roughness;
    let s = wi.x * wo.x + wi.y * wo.y;
    // 1 + s without cancellation, for wi near the mirror direction of a grazing wo
    let x = wi.x + wo.x;
    let y = wi.y + wo.y;
    let one_plus_s = 0.5 * (x * x + y * y + wi.z * wi.z + wo.z * wo.z);
    let above = 1.0 + r * s / max(wi.z, wo.z);
    let below = (1.0 - r) + r * one_plus_s;
    let shape = select(below, above, s > 0.0);
    let A_F = 1.0 / (1.0 + EON_C1 * r);
    let single = A_F * shape;
    let multiple = A_F * r / (EON_C1 - EON_C2) * eon_loss(wi.z) * eon_loss(wo.z);
    return (params.rho * single + eon_rho_multiple(params.rho, r) * multiple) / EON_PI;
}

fn eon_pdf(params: Eon, wi: vec3f, wo: vec3f) -> f32 {
    return select(0.0, wi.z / EON_PI, wi.z > 0.0 && wo.z > 0.0);
}

fn eon_sample(params: Eon, wo: vec3f, u: vec2f) -> EonSample {
    var result: EonSample;
    let radius = sqrt(u.x);
    let phi = 2.0 * EON_PI * u.y;
    result.wi = vec3f(radius * cos(phi), radius * sin(phi), sqrt(1.0 - u.x));
    result.pdf = eon_pdf(params, result.wi, wo);
    return result;
}

fn eon_albedo(params: Eon, wo: vec3f) -> vec3f {
    if (wo.z < 0.0) {
        return vec3f(0.0, 0.0, 0.0);
    }
    let r = params.roughness;
    let A_F = 1.0 / (1.0 + EON_C1 * r);
    let mu = wo.z;
    let s = sqrt(max((1.0 - mu) * (1.0 + mu), 0.0));
    let lost = mu * mu / (1.0 + s) * (0.5 * EON_PI - 2.0 / 3.0 - s * mu * (s + 2.0) / (3.0 * (1.0 + s)));
    let single = 1.0 - r * A_F * (lost + s * eon_asin(mu)) / EON_PI;
    let mean_fitted = 0.0571085289 / 3.0 + 0.491881867 / 6.0 - 0.332181442 / 10.0 + 0.0714429953 / 15.0;
    let ratio = (EON_C1 - mean_fitted) / (EON_C1 - EON_C2);
    let multiple = r * A_F * eon_loss(mu) * ratio;
    return params.rho * single + eon_rho_multiple(params.rho, r) * multiple;
}
