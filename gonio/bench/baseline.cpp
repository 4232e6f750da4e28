// The C++ that `gonio bench` compares gonio with: every model typed from its paper, float32, one scalar function
// per model, called once per direction pair in a straight loop. Compiled and driven by native.py.
//
// It is meant to be neither slowed down nor tuned: no intrinsics, no -ffast-math, no table, nothing computed twice.
// Two loops run the same functions:
//   calls     through a function pointer, one call per pair, as a renderer calls its BSDF; this is the baseline;
//   inlined   the function is a template argument, so the compiler may inline it, move constants out of the loop
//             and vectorise: the best that plain C++ of this kind can do.
//
// Directions are unit vectors in the local frame (N = +z), above the horizon; no function checks that. wo is known,
// wi is sampled. Values are BRDFs in 1/sr without the cosine.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <memory>
#include <thread>
#include <type_traits>
#include <vector>

namespace {

const float PI = 3.14159265f;

struct Vec3 {
    float x, y, z;
};

Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec3 operator*(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
Vec3 operator/(Vec3 a, Vec3 b) { return {a.x / b.x, a.y / b.y, a.z / b.z}; }
Vec3 operator*(Vec3 a, float b) { return {a.x * b, a.y * b, a.z * b}; }
Vec3 operator/(Vec3 a, float b) { return a * (1.0f / b); }
Vec3 white() { return {1.0f, 1.0f, 1.0f}; }
float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
float length(Vec3 a) { return std::sqrt(dot(a, a)); }
Vec3 normalize(Vec3 a) { return a / length(a); }
float mix(float a, float b, float t) { return a + t * (b - a); }

// Parameters: as many floats as the model has numbers, in the order in which it declares them.
struct Flat {
    Vec3 rho;
};

struct Params {
    Vec3 rho;
    float roughness;  // sigma in radians, r or the shininess n: whatever the model takes
};

// ---- Values ----------------------------------------------------------------------------------------------------

Vec3 lambert(const Flat& p, Vec3, Vec3) { return p.rho / PI; }

// Oren and Nayar 1994, Eq. 27-29, with interreflection.
Vec3 oren_nayar(const Params& p, Vec3 wi, Vec3 wo) {
    float sigma2 = p.roughness * p.roughness;
    float theta_i = std::acos(wi.z), theta_o = std::acos(wo.z);
    float alpha = std::max(theta_i, theta_o), beta = std::min(theta_i, theta_o);
    float sines = std::sqrt((1.0f - wi.z * wi.z) * (1.0f - wo.z * wo.z));
    float c = sines > 0.0f ? (wi.x * wo.x + wi.y * wo.y) / sines : 0.0f;  // cos(phi_i - phi_o)

    float b = 2.0f * beta / PI;
    float C1 = 1.0f - 0.5f * sigma2 / (sigma2 + 0.33f);
    float C2 = 0.45f * sigma2 / (sigma2 + 0.09f) * (c >= 0.0f ? std::sin(alpha) : std::sin(alpha) - b * b * b);
    float a = 4.0f * alpha * beta / (PI * PI);
    float C3 = 0.125f * sigma2 / (sigma2 + 0.09f) * a * a;
    float single = C1 + c * C2 * std::tan(beta) + (1.0f - std::abs(c)) * C3 * std::tan(0.5f * (alpha + beta));
    float twice = 0.17f * sigma2 / (sigma2 + 0.13f) * (1.0f - c * b * b);
    return p.rho / PI * single + p.rho * p.rho / PI * twice;
}

// s / t of the qualitative model (Oren and Nayar 1994, Eq. 30) and of Fujii's, which keeps the negative s.
float s_over_t_qon(Vec3 wi, Vec3 wo) {
    float s = dot(wi, wo) - wi.z * wo.z;
    return s > 0.0f ? s / std::max(wi.z, wo.z) : 0.0f;
}

float s_over_t_fujii(Vec3 wi, Vec3 wo) {
    float s = dot(wi, wo) - wi.z * wo.z;
    return s > 0.0f ? s / std::max(wi.z, wo.z) : s;
}

Vec3 qon(const Params& p, Vec3 wi, Vec3 wo) {
    float sigma2 = p.roughness * p.roughness;
    float A = 1.0f - 0.5f * sigma2 / (sigma2 + 0.33f);
    float B = 0.45f * sigma2 / (sigma2 + 0.09f);
    return p.rho / PI * (A + B * s_over_t_qon(wi, wo));
}

Vec3 qon_footnote(const Params& p, Vec3 wi, Vec3 wo) {
    float sigma2 = p.roughness * p.roughness;
    float A = 1.0f - 0.5f * sigma2 / (sigma2 + 0.57f);
    float B = 0.45f * sigma2 / (sigma2 + 0.09f);
    return p.rho / PI * (A + B * s_over_t_qon(wi, wo));
}

Vec3 qon_fujii(const Params& p, Vec3 wi, Vec3 wo) {
    float sigma2 = p.roughness * p.roughness;
    Vec3 A = white() * (1.0f - 0.5f * sigma2 / (sigma2 + 0.33f)) + p.rho * (0.17f * sigma2 / (sigma2 + 0.13f));
    float B = 0.45f * sigma2 / (sigma2 + 0.09f);
    return p.rho / PI * (A + white() * (B * s_over_t_fujii(wi, wo)));
}

// EON, arXiv:2410.18026, Listing 1.
const float constant1_FON = 0.5f - 2.0f / (3.0f * PI);
const float constant2_FON = 2.0f / 3.0f - 28.0f / (15.0f * PI);

Vec3 fon(const Params& p, Vec3 wi, Vec3 wo) {
    float AF = 1.0f / (1.0f + constant1_FON * p.roughness);
    return p.rho / PI * AF * (1.0f + p.roughness * s_over_t_fujii(wi, wo));
}

float E_FON_exact(float mu, float r) {
    float AF = 1.0f / (1.0f + constant1_FON * r);
    float BF = r * AF;
    float Si = std::sqrt(1.0f - mu * mu);
    float G = Si * (std::acos(mu) - Si * mu) + (2.0f / 3.0f) * ((Si / mu) * (1.0f - (Si * Si * Si)) - Si);
    return AF + (BF / PI) * G;
}

float E_FON_approx(float mu, float r) {
    float mucomp = 1.0f - mu;
    float mucomp2 = mucomp * mucomp;
    // The listing's dot(mat2 * vec2(mucomp, mucomp2), vec2(1, mucomp2)), written out.
    float GoverPi = 0.0571085289f * mucomp + 0.491881867f * mucomp2 +
                    (-0.332181442f * mucomp + 0.0714429953f * mucomp2) * mucomp2;
    return (1.0f + r * GoverPi) / (1.0f + constant1_FON * r);
}

template <bool exact>
Vec3 eon(const Params& p, Vec3 wi, Vec3 wo) {
    float r = p.roughness;
    float AF = 1.0f / (1.0f + constant1_FON * r);
    Vec3 f_ss = p.rho / PI * AF * (1.0f + r * s_over_t_fujii(wi, wo));
    float EFo = exact ? E_FON_exact(wo.z, r) : E_FON_approx(wo.z, r);
    float EFi = exact ? E_FON_exact(wi.z, r) : E_FON_approx(wi.z, r);
    float avgEF = AF * (1.0f + constant2_FON * r);
    Vec3 rho_ms = p.rho * p.rho * avgEF / (white() - p.rho * (1.0f - avgEF));
    const float eps = 1.0e-7f;
    Vec3 f_ms = rho_ms / PI * std::max(eps, 1.0f - EFo) * std::max(eps, 1.0f - EFi) / std::max(eps, 1.0f - avgEF);
    return f_ss + f_ms;
}

// Gotanda 2012, Eq. 25; n is the shininess.
Vec3 triace_oren_nayar(const Params& p, Vec3 wi, Vec3 wo) {
    float n = p.roughness;
    float A = 1.0f - 1.0f / (2.0f + 0.65f * n);
    float B = 1.0f / (2.22222f + 0.1f * n);
    return p.rho / PI * (A + B * s_over_t_fujii(wi, wo));
}

float pow5(float x) {
    float x2 = x * x;
    return x2 * x2 * x;
}

Vec3 burley_diffuse(const Params& p, Vec3 wi, Vec3 wo) {
    float cos_d = dot(wi, normalize(wi + wo));
    float F90 = 0.5f + 2.0f * cos_d * cos_d * p.roughness;
    return p.rho / PI * (1.0f + (F90 - 1.0f) * pow5(1.0f - wi.z)) * (1.0f + (F90 - 1.0f) * pow5(1.0f - wo.z));
}

// ---- Samples ---------------------------------------------------------------------------------------------------

struct Sample {
    Vec3 wi;
    float pdf;
};

Sample cosine_sample(const Flat&, Vec3, float u1, float u2) {
    float R = std::sqrt(u1), phi = 2.0f * PI * u2;
    float z = std::sqrt(1.0f - u1);
    return {{R * std::cos(phi), R * std::sin(phi), z}, z / PI};
}

// EON, Listings 2-4.
struct Ltc {
    float a, b, c, d;
};

Ltc ltc_coeffs(float mu, float r) {
    float a = 1.0f + r * (0.303392f + (-0.518982f + 0.111709f * mu) * mu + (-0.276266f + 0.335918f * mu) * r);
    float b = r * (-1.16407f + 1.15859f * mu + (0.150815f - 0.150105f * mu) * r) / (mu * mu * mu - 1.43545f);
    float c = 1.0f + (0.20013f + (-0.506373f + 0.261777f * mu) * mu) * r;
    float d = r * (0.540852f + (-1.01625f + 0.475392f * mu) * mu) / (-1.0743f + mu * (0.0725628f + mu));
    return {a, b, c, d};
}

// First axis of the frame whose x points along the azimuth of w; the second is (-y, x).
Vec3 ltc_x_axis(Vec3 w) {
    float lenSqr = w.x * w.x + w.y * w.y;
    return lenSqr > 0.0f ? Vec3{w.x, w.y, 0.0f} * (1.0f / std::sqrt(lenSqr)) : Vec3{1.0f, 0.0f, 0.0f};
}

Sample cltc_sample(Vec3 wo, float r, float u1, float u2) {
    Ltc m = ltc_coeffs(wo.z, r);
    float R = std::sqrt(u1), phi = 2.0f * PI * u2;
    float x = R * std::cos(phi), y = R * std::sin(phi);
    float vz = 1.0f / std::sqrt(m.d * m.d + 1.0f);
    float s = 0.5f * (1.0f + vz);
    x = mix(std::sqrt(1.0f - y * y), x, s);
    x = m.d < 0.0f ? -x : x;  // the listing has -x always; d turns positive above mu = 0.99986
    Vec3 wh = {x, y, std::sqrt(std::max(1.0f - (x * x + y * y), 0.0f))};
    float pdf_wh = wh.z / (PI * s);
    Vec3 wi = {m.a * wh.x + m.b * wh.z, m.c * wh.y, m.d * wh.x + wh.z};
    float len = length(wi);
    float detM = m.c * (m.a - m.b * m.d);
    float pdf_wi = pdf_wh * len * len * len / detM;
    Vec3 X = ltc_x_axis(wo);
    return {normalize({X.x * wi.x - X.y * wi.y, X.y * wi.x + X.x * wi.y, wi.z}), pdf_wi};
}

float cltc_pdf(Vec3 wo, Vec3 wi, float r) {
    Vec3 X = ltc_x_axis(wo);
    wi = {X.x * wi.x + X.y * wi.y, X.x * wi.y - X.y * wi.x, wi.z};
    Ltc m = ltc_coeffs(wo.z, r);
    float detM = m.c * (m.a - m.b * m.d);
    Vec3 wh = {m.c * (wi.x - m.b * wi.z), (m.a - m.b * m.d) * wi.y, -m.c * (m.d * wi.x - m.a * wi.z)};
    float lenSqr = dot(wh, wh);
    float vz = 1.0f / std::sqrt(m.d * m.d + 1.0f);
    float s = 0.5f * (1.0f + vz);
    return detM * detM / (lenSqr * lenSqr) * std::max(wh.z, 0.0f) / (PI * s);
}

Sample eon_sample(const Params& p, Vec3 wo, float u1, float u2) {
    // The share of uniform samples is that of gonio's default sampler; the listing's takes a power of r.
    float r = std::max(p.roughness - 1e-4f, 0.0f), k = 1.0f - wo.z;
    float P_u = r * (0.0169f + k * (0.2136f + k * (-0.2345f + 0.445f * k))) * (1.0f + r * (-0.602f - 0.5736f * k + 0.315f * r));
    float P_c = 1.0f - P_u;
    Sample s;
    if (u1 < P_u) {  // the listing's <= makes 0 / 0 of u1 = 0 at P_u = 0
        u1 = u1 / P_u;
        float sinTheta = std::sqrt(1.0f - u1 * u1), phi = 2.0f * PI * u2;
        s.wi = {sinTheta * std::cos(phi), sinTheta * std::sin(phi), u1};
        s.pdf = cltc_pdf(wo, s.wi, r);
    } else {
        s = cltc_sample(wo, r, (u1 - P_u) / P_c, u2);
    }
    s.pdf = P_u / (2.0f * PI) + P_c * s.pdf;
    return s;
}

// ---- Facets ----------------------------------------------------------------------------------------------------

float square(float x) { return x * x; }

const Sample WASTED = {{0.0f, 0.0f, -1.0f}, 0.0f};

struct Half {
    Vec3 m;       // (wi + wo) / |wi + wo|
    float cos_h;  // wo . m, half the length of wi + wo
};

Half half_vector(Vec3 wi, Vec3 wo) {
    Vec3 sum = wi + wo;
    float len = length(sum);
    return {sum / len, std::min(0.5f * len, 1.0f)};
}

Vec3 mirror(Vec3 wo, Vec3 m) { return m * (2.0f * dot(wo, m)) - wo; }

// Walter et al. 2007, Eq. 33, with a width along x and one along y (Burley 2012, Eq. 13).
float D_ggx(Vec3 m, float ax, float ay) {
    return 1.0f / (PI * ax * ay * square(square(m.x / ax) + square(m.y / ay) + m.z * m.z));
}

// Smith's Lambda for GGX. Heitz 2014, Eq. 72 and 86.
float Lambda_ggx(Vec3 w, float ax, float ay) {
    float alpha2_tan2 = (square(ax * w.x) + square(ay * w.y)) / (w.z * w.z);
    return 0.5f * (std::sqrt(1.0f + alpha2_tan2) - 1.0f);
}

// Heitz, "Sampling the GGX distribution of visible normals", JCGT 2018, Listing 1.
Vec3 visible_ggx_normal(Vec3 wo, float ax, float ay, float u1, float u2) {
    Vec3 Vh = normalize({ax * wo.x, ay * wo.y, wo.z});
    float lensq = Vh.x * Vh.x + Vh.y * Vh.y;
    Vec3 T1 = lensq > 0.0f ? Vec3{-Vh.y, Vh.x, 0.0f} * (1.0f / std::sqrt(lensq)) : Vec3{1.0f, 0.0f, 0.0f};
    Vec3 T2 = {-Vh.z * T1.y, Vh.z * T1.x, Vh.x * T1.y - Vh.y * T1.x};
    float r = std::sqrt(u1), phi = 2.0f * PI * u2;
    float t1 = r * std::cos(phi), t2 = r * std::sin(phi);
    float s = 0.5f * (1.0f + Vh.z);
    t2 = (1.0f - s) * std::sqrt(1.0f - t1 * t1) + s * t2;
    Vec3 Nh = T1 * t1 + T2 * t2 + Vh * std::sqrt(std::max(0.0f, 1.0f - t1 * t1 - t2 * t2));
    return normalize({ax * Nh.x, ay * Nh.y, std::max(1e-6f, Nh.z)});
}

// G1(wo) D / (4 mu_o), the density of wo mirrored at a visible normal m.
float visible_ggx_pdf(Vec3 wo, Vec3 m, float ax, float ay) {
    return D_ggx(m, ax, ay) / ((1.0f + Lambda_ggx(wo, ax, ay)) * 4.0f * wo.z);
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again, as gonio does:
// densities can only be compared with the same samples.
Vec3 folded_ggx_sample(Vec3 wo, float ax, float ay, float u1, float u2) {
    Vec3 wi = mirror(wo, visible_ggx_normal(wo, ax, ay, u1, u2));
    wi.z = std::abs(wi.z);
    return wi;
}

// The density of both ways to wi; a normal mirrors wo below the horizon, to wi's image, if wo is the higher.
float folded_ggx_pdf(Vec3 wi, Vec3 wo, float ax, float ay) {
    float pdf = visible_ggx_pdf(wo, half_vector(wi, wo).m, ax, ay);
    if (wo.z > wi.z) pdf += visible_ggx_pdf(wo, half_vector({wi.x, wi.y, -wi.z}, wo).m, ax, ay);
    return pdf;
}

// Exact reflectance of a conductor for one channel (Born and Wolf; as renderers have it).
float F_conductor(float cos_theta, float eta, float k) {
    float cos2 = cos_theta * cos_theta, sin2 = 1.0f - cos2, sin4 = sin2 * sin2;
    float t0 = eta * eta - k * k - sin2;
    float a2_plus_b2 = std::sqrt(t0 * t0 + 4.0f * eta * eta * k * k);
    float a = std::sqrt(std::max(0.5f * (a2_plus_b2 + t0), 0.0f));
    float t1 = a2_plus_b2 + cos2, t2 = 2.0f * a * cos_theta;
    float Rs = (t1 - t2) / (t1 + t2);
    float t3 = a2_plus_b2 * cos2 + sin4, t4 = t2 * sin2;
    float Rp = Rs * (t3 - t4) / (t3 + t4);
    return 0.5f * (Rs + Rp);
}

// Exact reflectance of a dielectric, by Snell and Fresnel; eta >= 1.
float F_dielectric(float cos_i, float eta) {
    float cos_t = std::sqrt(1.0f - (1.0f - cos_i * cos_i) / (eta * eta));
    float rs = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    float rp = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    return 0.5f * (rs * rs + rp * rp);
}

// ---- Choice of lobes -------------------------------------------------------------------------------------------

// The first lobe's probability of two with the albedos a and b: in proportion, but at least a tenth for a lobe,
// unless fifty times its part is less. gonio chooses so; densities can only be compared with the same choice.
float first_share(float a, float b) {
    float p = a / (a + b), q = b / (a + b);
    return p < q ? std::max(p, std::min(0.1f, 50.0f * p)) : 1.0f - std::max(q, std::min(0.1f, 50.0f * q));
}

// Whether u chooses the first lobe; u is stretched to [0, 1) again.
bool choose(float probability, float& u) {
    bool first = u < probability;
    u = first ? u / probability : (u - probability) / (1.0f - probability);
    u = std::min(u, 0.99999994f);
    return first;
}

float average(Vec3 c) { return (c.x + c.y + c.z) / 3.0f; }

// ---- Torrance-Sparrow: GGX, height-correlated Smith, exact conductor ---------------------------------------------

struct TorranceSparrow {
    float alpha, anisotropy;
    Vec3 eta, k;
};

struct Widths {
    float x, y;
};

Widths widths(const TorranceSparrow& p) {
    float aspect = std::sqrt(1.0f - 0.9f * p.anisotropy);
    return {p.alpha / aspect, p.alpha * aspect};
}

Vec3 torrance_sparrow(const TorranceSparrow& p, Vec3 wi, Vec3 wo) {
    Widths a = widths(p);
    Half h = half_vector(wi, wo);
    float D = D_ggx(h.m, a.x, a.y);
    float G = 1.0f / (1.0f + Lambda_ggx(wi, a.x, a.y) + Lambda_ggx(wo, a.x, a.y));
    Vec3 F = {F_conductor(h.cos_h, p.eta.x, p.k.x), F_conductor(h.cos_h, p.eta.y, p.k.y),
              F_conductor(h.cos_h, p.eta.z, p.k.z)};
    return F * (D * G / (4.0f * wi.z * wo.z));
}

Sample torrance_sparrow_sample(const TorranceSparrow& p, Vec3 wo, float u1, float u2) {
    Widths a = widths(p);
    Vec3 wi = folded_ggx_sample(wo, a.x, a.y, u1, u2);
    if (wi.z <= 0.0f) return WASTED;
    return {wi, folded_ggx_pdf(wi, wo, a.x, a.y)};
}

// ---- Disney 2012: Burley's disney.brdf, with the masking of the course notes ---------------------------------------

struct Disney {
    Vec3 baseColor;
    float subsurface, metallic, specular, specularTint, roughness, anisotropic, sheen, sheenTint, clearcoat,
        clearcoatGloss;
};

float SchlickFresnel(float u) { return pow5(std::clamp(1.0f - u, 0.0f, 1.0f)); }

float GTR1(float NdotH, float a) {
    float a2 = a * a;
    float t = 1.0f + (a2 - 1.0f) * NdotH * NdotH;
    return (a2 - 1.0f) / (PI * std::log(a2) * t);
}

float smithG_GGX(float NdotV, float alphaG) {
    float a = alphaG * alphaG, b = NdotV * NdotV;
    return 1.0f / (NdotV + std::sqrt(a + b - a * b));
}

Vec3 mix(Vec3 a, Vec3 b, float t) { return a + (b - a) * t; }

Vec3 tint(const Disney& p) {
    float luminance = 0.3f * p.baseColor.x + 0.6f * p.baseColor.y + 0.1f * p.baseColor.z;
    return luminance > 0.0f ? p.baseColor / luminance : white();
}

Vec3 specular_colour(const Disney& p) {
    return mix(mix(white(), tint(p), p.specularTint) * (p.specular * 0.08f), p.baseColor, p.metallic);
}

Widths widths(const Disney& p) {
    float aspect = std::sqrt(1.0f - p.anisotropic * 0.9f);
    return {std::max(0.001f, square(p.roughness) / aspect), std::max(0.001f, square(p.roughness) * aspect)};
}

Vec3 disney(const Disney& p, Vec3 L, Vec3 V) {
    float NdotL = L.z, NdotV = V.z;
    Half h = half_vector(L, V);
    float NdotH = h.m.z, LdotH = h.cos_h;

    // Diffuse, from 1 at the normal to 0.5 or more at grazing angles
    float FL = SchlickFresnel(NdotL), FV = SchlickFresnel(NdotV);
    float Fd90 = 0.5f + 2.0f * LdotH * LdotH * p.roughness;
    float Fd = mix(1.0f, Fd90, FL) * mix(1.0f, Fd90, FV);

    // Hanrahan and Krueger's, for subsurface
    float Fss90 = LdotH * LdotH * p.roughness;
    float Fss = mix(1.0f, Fss90, FL) * mix(1.0f, Fss90, FV);
    float ss = 1.25f * (Fss * (1.0f / (NdotL + NdotV) - 0.5f) + 0.5f);

    Widths a = widths(p);
    float Ds = D_ggx(h.m, a.x, a.y);
    float FH = SchlickFresnel(LdotH);
    Vec3 Fs = mix(specular_colour(p), white(), FH);
    float roughg = square(p.roughness * 0.5f + 0.5f);
    float Gs = smithG_GGX(NdotL, roughg) * smithG_GGX(NdotV, roughg);

    Vec3 Fsheen = mix(white(), tint(p), p.sheenTint) * (FH * p.sheen);

    float Dr = GTR1(NdotH, mix(0.1f, 0.001f, p.clearcoatGloss));
    float Fr = mix(0.04f, 1.0f, FH);
    float Gr = smithG_GGX(NdotL, 0.25f) * smithG_GGX(NdotV, 0.25f);

    return (p.baseColor * (mix(Fd, ss, p.subsurface) / PI) + Fsheen) * (1.0f - p.metallic) + Fs * (Gs * Ds) +
           white() * (0.25f * p.clearcoat * Gr * Fr * Dr);
}

// Lobes by the estimated albedos: cosine-weighted (some of it uniform, for the subsurface term), a visible GGX normal
// whose mirrored direction is folded up at the horizon, or a clearcoat normal.
Sample disney_sample(const Disney& p, Vec3 wo, float u1, float u2) {
    Widths a = widths(p);
    float FV = SchlickFresnel(wo.z);
    float diffuse =
        average((p.baseColor + mix(white(), tint(p), p.sheenTint) * (0.06f * p.sheen)) * (1.0f - p.metallic));
    float highlight = average(mix(specular_colour(p), white(), FV));
    float clearcoat = 0.25f * p.clearcoat * mix(0.04f, 1.0f, FV);
    float P_diffuse = first_share(diffuse, highlight + clearcoat), P_highlight = first_share(highlight, clearcoat);
    float P_uniform = 0.5f * p.subsurface;
    float coat_alpha = mix(0.1f, 0.001f, p.clearcoatGloss);

    Vec3 wi;
    if (choose(P_diffuse, u1)) {
        bool uniform = choose(P_uniform, u1);
        float z = uniform ? u1 : std::sqrt(1.0f - u1);
        float sine = std::sqrt(1.0f - z * z), phi = 2.0f * PI * u2;
        wi = {sine * std::cos(phi), sine * std::sin(phi), z};
    } else if (choose(P_highlight, u1)) {
        wi = folded_ggx_sample(wo, a.x, a.y, u1, u2);
    } else {
        float a2 = coat_alpha * coat_alpha;  // Burley, Eq. 5
        float cos2 = (1.0f - std::pow(a2, 1.0f - u1)) / (1.0f - a2);
        float sine = std::sqrt(std::max(1.0f - cos2, 0.0f)), phi = 2.0f * PI * u2;
        wi = mirror(wo, {sine * std::cos(phi), sine * std::sin(phi), std::sqrt(cos2)});
    }
    if (wi.z <= 0.0f) return WASTED;

    Half h = half_vector(wi, wo);
    float specular = P_highlight * folded_ggx_pdf(wi, wo, a.x, a.y) +
                     (1.0f - P_highlight) * GTR1(h.m.z, coat_alpha) * h.m.z / (4.0f * h.cos_h);
    float matte = mix(wi.z / PI, 1.0f / (2.0f * PI), P_uniform);
    return {wi, P_diffuse * matte + (1.0f - P_diffuse) * specular};
}

// ---- Weidlich-Wilkie: Elek 2010, Eq. 2 to 4, with a base of any kind ------------------------------------------------

template <class Base>
struct Coat {
    float eta, alpha;
    Vec3 sigma_a;
    float thickness;
    Base base;
};

// The base is at least as rough as what lies above it.
Flat at_least_as_rough(Flat base, float) { return base; }
template <class Base>
Coat<Base> at_least_as_rough(Coat<Base> base, float alpha) {
    base.alpha = std::max(base.alpha, alpha);
    return base;
}

Vec3 refract(Vec3 w, float eta) {
    float x = w.x / eta, y = w.y / eta;
    return {x, y, std::sqrt(1.0f - (x * x + y * y))};
}

Vec3 exp(Vec3 a) { return {std::exp(a.x), std::exp(a.y), std::exp(a.z)}; }

// exp(-sigma d (1 / mu_i' + 1 / mu_o')).
template <class Base>
Vec3 absorbed(const Coat<Base>& p, float mu_i, float mu_o) {
    return exp(p.sigma_a * (-p.thickness * (1.0f / mu_i + 1.0f / mu_o)));
}

float D_beckmann(float cos_m, float alpha) {
    float cos2 = cos_m * cos_m, alpha2 = alpha * alpha;
    return std::exp((cos2 - 1.0f) / (cos2 * alpha2)) / (PI * alpha2 * cos2 * cos2);
}

Vec3 value(const Flat& p, Vec3 wi, Vec3 wo) { return lambert(p, wi, wo); }
template <class Base>
Vec3 value(const Coat<Base>& p, Vec3 wi, Vec3 wo) {
    Half h = half_vector(wi, wo);
    float F = F_dielectric(h.cos_h, p.eta);
    float G = std::min(1.0f, 2.0f * h.m.z * std::min(wi.z, wo.z) / h.cos_h);
    float coat = F * D_beckmann(h.m.z, p.alpha) * G / (4.0f * wi.z * wo.z);
    float T12 = 1.0f - F;
    float t = (1.0f - G) + T12 * G;
    Vec3 wi_t = refract(wi, p.eta), wo_t = refract(wo, p.eta);
    Vec3 below = value(at_least_as_rough(p.base, p.alpha), wi_t, wo_t);
    return white() * coat + below * absorbed(p, wi_t.z, wo_t.z) * (T12 * t);
}

template <class Base>
Vec3 coated(const Coat<Base>& p, Vec3 wi, Vec3 wo) {
    return value(p, wi, wo);
}

// The coat's probability, by what it reflects of wo and what reaches the base and leaves again along wo.
template <class Base>
float coat_share(const Coat<Base>& p, Vec3 wo, Vec3 wo_t) {
    float T = 1.0f - F_dielectric(0.5f + 0.5f * wo.z, p.eta);
    float through = T * average(absorbed(p, 1.0f, wo_t.z));
    return first_share(std::max(F_dielectric(wo.z, p.eta), 0.1f * through), through);
}

// Directions inside that are reflected totally, flatter than the cosine k, are spread over the hemisphere outside.
float critical_cosine(float eta) { return std::sqrt(1.0f - 1.0f / (eta * eta)); }

// The direction with the azimuth of w and the cosine z.
Vec3 with_cosine(Vec3 w, float z) {
    float sin2 = w.x * w.x + w.y * w.y, sine = std::sqrt(std::max(1.0f - z * z, 0.0f));
    if (sin2 <= 0.0f) return {sine, 0.0f, z};
    float scale = sine / std::sqrt(sin2);
    return {w.x * scale, w.y * scale, z};
}

float density(const Flat&, Vec3 wi, Vec3) { return wi.z / PI; }
template <class Base>
float density(const Coat<Base>& p, Vec3 wi, Vec3 wo) {
    Vec3 wi_t = refract(wi, p.eta), wo_t = refract(wo, p.eta);
    Base base = at_least_as_rough(p.base, p.alpha);
    float k = critical_cosine(p.eta);
    float below = density(base, wi_t, wo_t) * wi.z / (p.eta * p.eta * wi_t.z) +
                  density(base, with_cosine(wi, k * wi.z), wo_t) * k;
    Half h = half_vector(wi, wo);
    float P = coat_share(p, wo, wo_t);
    return P * D_beckmann(h.m.z, p.alpha) * h.m.z / (4.0f * h.cos_h) + (1.0f - P) * below;
}

Vec3 direction(const Flat&, Vec3, float u1, float u2) {
    float R = std::sqrt(u1), phi = 2.0f * PI * u2;
    return {R * std::cos(phi), R * std::sin(phi), std::sqrt(1.0f - u1)};
}
template <class Base>
Vec3 direction(const Coat<Base>& p, Vec3 wo, float u1, float u2) {
    Vec3 wo_t = refract(wo, p.eta);
    if (choose(coat_share(p, wo, wo_t), u1)) {
        float tangent = p.alpha * std::sqrt(-std::log(1.0f - u1)), phi = 2.0f * PI * u2;  // Walter et al., Eq. 28
        float cos_m = 1.0f / std::sqrt(1.0f + tangent * tangent), sin_m = tangent * cos_m;
        return mirror(wo, {sin_m * std::cos(phi), sin_m * std::sin(phi), cos_m});
    }
    Vec3 w = direction(at_least_as_rough(p.base, p.alpha), wo_t, u1, u2);
    if (w.z <= 0.0f) return WASTED.wi;
    float k = critical_cosine(p.eta);
    float refracted2 = 1.0f - p.eta * p.eta * (1.0f - w.z * w.z);
    return with_cosine(w, w.z > k ? std::sqrt(std::max(refracted2, 0.0f)) : w.z / k);
}

template <class Base>
Sample coated_sample(const Coat<Base>& p, Vec3 wo, float u1, float u2) {
    Vec3 wi = direction(p, wo, u1, u2);
    if (wi.z <= 0.0f) return WASTED;
    return {wi, density(p, wi, wo)};
}

// ---- Loops -----------------------------------------------------------------------------------------------------

template <class P>
using EvalFunction = Vec3(const P&, Vec3 wi, Vec3 wo);
template <class P>
using SampleFunction = Sample(const P&, Vec3 wo, float u1, float u2);

// One array per component: wi.xyz, wo.xyz -> value.rgb for eval; wo.xyz, u1, u2 -> wi.xyz, pdf, value.rgb for sample.
using Inputs = const float* const*;
using Outputs = float* const*;

// Always inlined into its callers below, which differ only in whether f is known to the compiler.
template <class P>
[[gnu::always_inline]] inline void eval_loop(EvalFunction<P>* f, P p, Inputs in, Outputs out, size_t begin,
                                             size_t end) {
    const float *wi_x = in[0], *wi_y = in[1], *wi_z = in[2];
    const float *wo_x = in[3], *wo_y = in[4], *wo_z = in[5];
    float *__restrict red = out[0], *__restrict green = out[1], *__restrict blue = out[2];
    for (size_t i = begin; i < end; i++) {
        Vec3 value = f(p, {wi_x[i], wi_y[i], wi_z[i]}, {wo_x[i], wo_y[i], wo_z[i]});
        red[i] = value.x;
        green[i] = value.y;
        blue[i] = value.z;
    }
}

// A sample with density 0 is wasted, and has no value.
template <class P>
[[gnu::always_inline]] inline void sample_loop(SampleFunction<P>* sample, EvalFunction<P>* f, P p, Inputs in,
                                               Outputs out, size_t begin, size_t end) {
    const float *wo_x = in[0], *wo_y = in[1], *wo_z = in[2], *u1 = in[3], *u2 = in[4];
    float *__restrict wi_x = out[0], *__restrict wi_y = out[1], *__restrict wi_z = out[2], *__restrict pdf = out[3];
    float *__restrict red = out[4], *__restrict green = out[5], *__restrict blue = out[6];
    for (size_t i = begin; i < end; i++) {
        Vec3 wo = {wo_x[i], wo_y[i], wo_z[i]};
        Sample s = sample(p, wo, u1[i], u2[i]);
        Vec3 value = s.pdf > 0.0f ? f(p, s.wi, wo) : Vec3{0.0f, 0.0f, 0.0f};
        wi_x[i] = s.wi.x;
        wi_y[i] = s.wi.y;
        wi_z[i] = s.wi.z;
        pdf[i] = s.pdf;
        red[i] = value.x;
        green[i] = value.y;
        blue[i] = value.z;
    }
}

template <class P>
P read(const float* parameters) {
    static_assert(std::is_trivially_copyable_v<P> && sizeof(P) % sizeof(float) == 0);
    P p;
    std::memcpy(&p, parameters, sizeof(P));
    return p;
}

using Loop = void(const float* parameters, Inputs in, Outputs out, size_t begin, size_t end);

// The functions' addresses are volatile here: the compiler does not know what it calls.
template <class P, EvalFunction<P>* f>
void called_eval(const float* parameters, Inputs in, Outputs out, size_t begin, size_t end) {
    EvalFunction<P>* volatile hidden = f;
    eval_loop<P>(hidden, read<P>(parameters), in, out, begin, end);
}

template <class P, SampleFunction<P>* sample, EvalFunction<P>* f>
void called_sample(const float* parameters, Inputs in, Outputs out, size_t begin, size_t end) {
    SampleFunction<P>* volatile hidden_sample = sample;
    EvalFunction<P>* volatile hidden = f;
    sample_loop<P>(hidden_sample, hidden, read<P>(parameters), in, out, begin, end);
}

template <class P, EvalFunction<P>* f>
void inlined_eval(const float* parameters, Inputs in, Outputs out, size_t begin, size_t end) {
    eval_loop<P>(f, read<P>(parameters), in, out, begin, end);
}

template <class P, SampleFunction<P>* sample, EvalFunction<P>* f>
void inlined_sample(const float* parameters, Inputs in, Outputs out, size_t begin, size_t end) {
    sample_loop<P>(sample, f, read<P>(parameters), in, out, begin, end);
}

struct Row {
    const char* name;
    bool samples;    // whether the row times sample + pdf + eval, or eval alone
    int parameters;  // how many floats
    Loop* called;
    Loop* inlined;
};

template <class P, EvalFunction<P>* f>
constexpr Row row(const char* name) {
    return {name, false, sizeof(P) / sizeof(float), called_eval<P, f>, inlined_eval<P, f>};
}

template <class P, SampleFunction<P>* sample, EvalFunction<P>* f>
constexpr Row row(const char* name) {
    return {name, true, sizeof(P) / sizeof(float), called_sample<P, sample, f>, inlined_sample<P, sample, f>};
}

using TwoCoats = Coat<Coat<Flat>>;

const Row ROWS[] = {
    row<Flat, lambert>("lambert"),
    row<Params, oren_nayar>("oren_nayar"),
    row<Params, qon>("qon"),
    row<Params, qon_footnote>("qon_footnote"),
    row<Params, qon_fujii>("qon_fujii"),
    row<Params, fon>("fon"),
    row<Params, eon<true>>("eon_exact"),
    row<Params, eon<false>>("eon_fitted"),
    row<Params, triace_oren_nayar>("triace_oren_nayar"),
    row<Params, burley_diffuse>("burley_diffuse"),
    row<TorranceSparrow, torrance_sparrow>("torrance_sparrow"),
    row<Disney, disney>("disney"),
    row<Coat<Flat>, coated<Flat>>("weidlich_wilkie"),
    row<TwoCoats, coated<Coat<Flat>>>("weidlich_wilkie_two_coats"),
    row<Flat, cosine_sample, lambert>("lambert"),
    row<Params, eon_sample, eon<true>>("eon_exact"),
    row<Params, eon_sample, eon<false>>("eon_fitted"),
    row<TorranceSparrow, torrance_sparrow_sample, torrance_sparrow>("torrance_sparrow"),
    row<Disney, disney_sample, disney>("disney"),
    row<Coat<Flat>, coated_sample<Flat>, coated<Flat>>("weidlich_wilkie"),
    row<TwoCoats, coated_sample<Coat<Flat>>, coated<Coat<Flat>>>("weidlich_wilkie_two_coats"),
};

// Calls body(begin, end) on `threads` contiguous chunks of 0..n, the last one in this thread, and returns the
// seconds that took. Starting a thread costs some 20 microseconds, against milliseconds for the arrays timed here.
template <class Body>
double timed_parallel(size_t n, int threads, Body body) {
    auto start = std::chrono::steady_clock::now();
    std::vector<std::thread> others;
    for (int t = 0; t + 1 < threads; t++) others.emplace_back(body, n * t / threads, n * (t + 1) / threads);
    body(n * (threads - 1) / threads, n);
    for (std::thread& other : others) other.join();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

extern "C" {

// Name of row i, or null past the last one.
const char* baseline_name(int i) { return i < int(std::size(ROWS)) ? ROWS[i].name : nullptr; }

// Whether row i is sample + pdf + eval (1) or eval (0).
int baseline_samples(int i) { return ROWS[i].samples; }

// How many floats row i takes as parameters.
int baseline_parameters(int i) { return ROWS[i].parameters; }

// Runs row i once over n pairs and returns the seconds.
double baseline_run(int i, int inlined, const float* parameters, const float* const* in, float* const* out, size_t n,
                    int threads) {
    Loop* loop = inlined ? ROWS[i].inlined : ROWS[i].called;
    return timed_parallel(n, threads, [&](size_t begin, size_t end) { loop(parameters, in, out, begin, end); });
}

// STREAM's triad a = b + x c over n floats per array: bytes read and written per second, best of `repeat`.
// As in STREAM, the line that a store first fetches is not counted.
double baseline_bandwidth(size_t n, int threads, int repeat) {
    // Not std::vector: pages should be touched first by the thread that uses them.
    std::unique_ptr<float[]> a(new float[n]), b(new float[n]), c(new float[n]);
    timed_parallel(n, threads, [&](size_t begin, size_t end) {
        std::fill(&a[begin], &a[end], 0.0f);
        std::fill(&b[begin], &b[end], 1.0f);
        std::fill(&c[begin], &c[end], 2.0f);
    });
    double best = INFINITY;
    for (int i = 0; i < repeat; i++) {
        float x = 0.5f * i;
        double seconds = timed_parallel(n, threads, [&](size_t begin, size_t end) {
            float* __restrict to = a.get();
            const float *from = b.get(), *scaled = c.get();
            for (size_t j = begin; j < end; j++) to[j] = from[j] + x * scaled[j];
        });
        best = std::min(best, seconds);
    }
    return 3.0 * sizeof(float) * n / best;
}

}  // extern "C"
