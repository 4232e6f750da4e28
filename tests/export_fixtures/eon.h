// EON with the fitted albedo and cosine sampling, written by hand for the tests of gonio.export.prove.
// Source: Portsmouth, Kutz, Hill, arXiv:2410.18026, Eq. 14, 16, 19.

#pragma once
#include <algorithm>
#include <cmath>

namespace gonio_eon {

struct Vec2 {
    float x, y;
};

struct Vec3 {
    float x, y, z;
};

inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline Vec3 operator/(Vec3 a, Vec3 b) { return {a.x / b.x, a.y / b.y, a.z / b.z}; }
inline Vec3 operator*(Vec3 a, float b) { return {a.x * b, a.y * b, a.z * b}; }
inline Vec3 operator/(Vec3 a, float b) { return {a.x / b, a.y / b, a.z / b}; }
inline float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

struct Eon {
    Vec3 rho;         // 0 to 1: single-scattering albedo, linear RGB
    float roughness;  // 0 to 1: unitless r
};

struct EonSample {
    Vec3 wi;
    float pdf;
};

constexpr float EON_PI = 3.14159265358979f;
constexpr float EON_C1 = 0.28779340921081f;  // 1/2 - 2 / (3 pi)
constexpr float EON_C2 = 0.07248821245692f;  // 2/3 - 28 / (15 pi)

// Arc sine of x in [0, 1], as gonio.export.library has it.
inline float eon_asin(float x) {
    bool near = x < 0.5f;
    float a = near ? x : std::sqrt(std::max(0.5f - 0.5f * x, 0.0f));
    float q = a * a;
    float p = 0.1666675393f + q * (0.07495241804f + q * (0.04547709131f + q * (0.02414764736f + q * 0.04221847907f)));
    float angle = a + a * q * p;
    return near ? angle : 0.5f * EON_PI - 2.0f * angle;
}

// C1 - G_F / pi from Eq. 14, multiplied out in mu.
inline float eon_loss(float mu) {
    float k = 1.0f - mu;
    float g = k * (0.0571085289f + k * (0.491881867f + k * (-0.332181442f + k * 0.0714429953f)));
    return EON_C1 - g;
}

inline Vec3 eon_rho_multiple(Vec3 rho, float r) {
    float mean_E = (1.0f + EON_C2 * r) / (1.0f + EON_C1 * r);
    return rho * rho * mean_E / (Vec3{1.0f, 1.0f, 1.0f} - rho * (1.0f - mean_E));
}

inline Vec3 eon_eval(const Eon& params, Vec3 wi, Vec3 wo) {
    if (wi.z <= 0.0f || wo.z <= 0.0f) {
        return Vec3{0.0f, 0.0f, 0.0f};
    }
    float r = params.roughness;
    float s = wi.x * wo.x + wi.y * wo.y;
    // 1 + s without cancellation, for wi near the mirror direction of a grazing wo
    float x = wi.x + wo.x;
    float y = wi.y + wo.y;
    float one_plus_s = 0.5f * (x * x + y * y + wi.z * wi.z + wo.z * wo.z);
    float above = 1.0f + r * s / std::max(wi.z, wo.z);
    float below = (1.0f - r) + r * one_plus_s;
    float shape = s > 0.0f ? above : below;
    float A_F = 1.0f / (1.0f + EON_C1 * r);
    float single = A_F * shape;
    float multiple = A_F * r / (EON_C1 - EON_C2) * eon_loss(wi.z) * eon_loss(wo.z);
    return (params.rho * single + eon_rho_multiple(params.rho, r) * multiple) / EON_PI;
}

inline float eon_pdf(const Eon& params, Vec3 wi, Vec3 wo) {
    return wi.z > 0.0f && wo.z > 0.0f ? wi.z / EON_PI : 0.0f;
}

inline EonSample eon_sample(const Eon& params, Vec3 wo, Vec2 u) {
    EonSample result;
    float radius = std::sqrt(u.x);
    float phi = 2.0f * EON_PI * u.y;
    result.wi = Vec3{radius * std::cos(phi), radius * std::sin(phi), std::sqrt(1.0f - u.x)};
    result.pdf = eon_pdf(params, result.wi, wo);
    return result;
}

inline Vec3 eon_albedo(const Eon& params, Vec3 wo) {
    if (wo.z < 0.0f) {
        return Vec3{0.0f, 0.0f, 0.0f};
    }
    float r = params.roughness;
    float A_F = 1.0f / (1.0f + EON_C1 * r);
    float mu = wo.z;
    float s = std::sqrt(std::max((1.0f - mu) * (1.0f + mu), 0.0f));
    float lost = mu * mu / (1.0f + s) * (0.5f * EON_PI - 2.0f / 3.0f - s * mu * (s + 2.0f) / (3.0f * (1.0f + s)));
    float single = 1.0f - r * A_F * (lost + s * eon_asin(mu)) / EON_PI;
    float mean_fitted = 0.0571085289f / 3.0f + 0.491881867f / 6.0f - 0.332181442f / 10.0f + 0.0714429953f / 15.0f;
    float ratio = (EON_C1 - mean_fitted) / (EON_C1 - EON_C2);
    float multiple = r * A_F * eon_loss(mu) * ratio;
    return params.rho * single + eon_rho_multiple(params.rho, r) * multiple;
}

}  // namespace gonio_eon
