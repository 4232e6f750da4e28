// EON with the fitted albedo and cosine sampling, written by hand for the tests of gonio.export.prove.
// Source: Portsmouth, Kutz, Hill, arXiv:2410.18026, Eq. 14, 16, 19.

struct Eon {
    float3 rho;         // 0 to 1: single-scattering albedo, linear RGB
    float roughness;  // 0 to 1: unitless r
};

struct EonSample {
    float3 wi;
    float pdf;
};

static const float EON_PI = 3.14159265358979;
static const float EON_C1 = 0.28779340921081;  // 1/2 - 2 / (3 pi)
static const float EON_C2 = 0.07248821245692;  // 2/3 - 28 / (15 pi)

// Arc sine of x in [0, 1], as gonio.export.library has it.
float eon_asin(float x) {
    bool near = x < 0.5;
    float a = near ? x : sqrt(max(0.5 - 0.5 * x, 0.0));
    float q = a * a;
    float p = 0.1666675393 + q * (0.07495241804 + q * (0.04547709131 + q * (0.02414764736 + q * 0.04221847907)));
    float angle = a + a * q * p;
    return near ? angle : 0.5 * EON_PI - 2.0 * angle;
}

// C1 - G_F / pi from Eq. 14, multiplied out in mu.
float eon_loss(float mu) {
    float k = 1.0 - mu;
    float g = k * (0.0571085289 + k * (0.491881867 + k * (-0.332181442 + k * 0.0714429953)));
    return EON_C1 - g;
}

float3 eon_rho_multiple(float3 rho, float r) {
    float mean_E = (1.0 + EON_C2 * r) / (1.0 + EON_C1 * r);
    return rho * rho * mean_E / (float3(1.0, 1.0, 1.0) - rho * (1.0 - mean_E));
}

float3 eon_eval(Eon params, float3 wi, float3 wo) {
    if (wi.z <= 0.0 || wo.z <= 0.0) {
        return float3(0.0, 0.0, 0.0);
    }
    float r = params.roughness;
    float s = wi.x * wo.x + wi.y * wo.y;
    // 1 + s without cancellation, for wi near the mirror direction of a grazing wo
    float x = wi.x + wo.x;
    float y = wi.y + wo.y;
    float one_plus_s = 0.5 * (x * x + y * y + wi.z * wi.z + wo.z * wo.z);
    float above = 1.0 + r * s / max(wi.z, wo.z);
    float below = (1.0 - r) + r * one_plus_s;
    float shape = s > 0.0 ? above : below;
    float A_F = 1.0 / (1.0 + EON_C1 * r);
    float single = A_F * shape;
    float multiple = A_F * r / (EON_C1 - EON_C2) * eon_loss(wi.z) * eon_loss(wo.z);
    return (params.rho * single + eon_rho_multiple(params.rho, r) * multiple) / EON_PI;
}

float eon_pdf(Eon params, float3 wi, float3 wo) {
    return wi.z > 0.0 && wo.z > 0.0 ? wi.z / EON_PI : 0.0;
}

EonSample eon_sample(Eon params, float3 wo, float2 u) {
    EonSample result;
    float radius = sqrt(u.x);
    float phi = 2.0 * EON_PI * u.y;
    result.wi = float3(radius * cos(phi), radius * sin(phi), sqrt(1.0 - u.x));
    result.pdf = eon_pdf(params, result.wi, wo);
    return result;
}

float3 eon_albedo(Eon params, float3 wo) {
    if (wo.z < 0.0) {
        return float3(0.0, 0.0, 0.0);
    }
    float r = params.roughness;
    float A_F = 1.0 / (1.0 + EON_C1 * r);
    float mu = wo.z;
    float s = sqrt(max((1.0 - mu) * (1.0 + mu), 0.0));
    float lost = mu * mu / (1.0 + s) * (0.5 * EON_PI - 2.0 / 3.0 - s * mu * (s + 2.0) / (3.0 * (1.0 + s)));
    float single = 1.0 - r * A_F * (lost + s * eon_asin(mu)) / EON_PI;
    float mean_fitted = 0.0571085289 / 3.0 + 0.491881867 / 6.0 - 0.332181442 / 10.0 + 0.0714429953 / 15.0;
    float ratio = (EON_C1 - mean_fitted) / (EON_C1 - EON_C2);
    float multiple = r * A_F * eon_loss(mu) * ratio;
    return params.rho * single + eon_rho_multiple(params.rho, r) * multiple;
}
