// SPDX-License-Identifier: Apache-2.0
// Retroreflective: any model with its light turned by half a turn, so that highlights go back to the light.
//
// Source: Belcour, Pacanowski, Delahaie, Laville-Geay, Eupherte, "Bidirectional reflectance distribution
// function measurements and analysis of retroreflective materials", Journal of the Optical Society
// of America
// A 31(12), 2014: the back vector, which lies between wo and wi mirrored at the normal, takes the place
// of the
// half vector.
//
// Torrance-Sparrow: mirrors of microscopic size, with every published choice of D, G and F.
//
// f = F D G / (4 mu_i mu_o). Also called Cook-Torrance, whose own paper prints 1 / pi in place of 1 / 4.
//
// Sources:
// Torrance, Sparrow, "Theory for off-specular reflection from roughened surfaces", JOSA 57, 1967;
// Cook, Torrance, "A reflectance model for computer graphics", 1982;
// Walter et al., "Microfacet models for refraction through rough surfaces", EGSR 2007;
// Kulla, Conty, "Revisiting physically based shading at Imageworks", SIGGRAPH 2017 course;
// Turquin, "Practical multiple scattering compensation for microfacet models", 2019;
// Elek, "Layered materials in real-time rendering", CESCG 2010, Algorithm 1: a matte part below.
// Those of D, G and F are named in gonio.parts.distribution, masking and fresnel.
//
// C++, made by gonio from gonio/models/retroreflective.py, gonio/models/torrance_sparrow.py; free to use
// under Apache-2.0. wi points towards the light and wo towards the viewer: unit vectors in the local
// frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// Usage: gonio_retroreflective::Retroreflective params; params.base.alpha = ...; ... gonio_retroreflective::retroreflective_eval(params, wi, wo)

#pragma once
#include <math.h>

namespace gonio_retroreflective {

struct Vec2 {
    float x, y;
};

struct Vec3 {
    float x, y, z;
};

struct Bool3 {
    bool x, y, z;
};

inline Vec3 splat(float a) {
    return Vec3{a, a, a};
}

inline float fract(float a) {
    return a - floorf(a);
}

inline float dot(Vec3 a, Vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

inline float length(Vec3 a) {
    return sqrtf(a.x * a.x + a.y * a.y + a.z * a.z);
}

inline Vec3 normalize(Vec3 a) {
    float inv = 1.0f / sqrtf(a.x * a.x + a.y * a.y + a.z * a.z);
    return Vec3{a.x * inv, a.y * inv, a.z * inv};
}

inline Vec3 select(Bool3 c, Vec3 yes, Vec3 no) {
    return Vec3{c.x ? yes.x : no.x, c.y ? yes.y : no.y, c.z ? yes.z : no.z};
}

inline Vec3 operator+(Vec3 a, Vec3 b) {
    return Vec3{a.x + b.x, a.y + b.y, a.z + b.z};
}

inline Vec3 operator+(Vec3 a, float b) {
    return Vec3{a.x + b, a.y + b, a.z + b};
}

inline Vec3 operator+(float a, Vec3 b) {
    return Vec3{a + b.x, a + b.y, a + b.z};
}

inline Vec3 operator-(Vec3 a, Vec3 b) {
    return Vec3{a.x - b.x, a.y - b.y, a.z - b.z};
}

inline Vec3 operator-(Vec3 a, float b) {
    return Vec3{a.x - b, a.y - b, a.z - b};
}

inline Vec3 operator*(Vec3 a, Vec3 b) {
    return Vec3{a.x * b.x, a.y * b.y, a.z * b.z};
}

inline Vec3 operator*(Vec3 a, float b) {
    return Vec3{a.x * b, a.y * b, a.z * b};
}

inline Vec3 operator*(float a, Vec3 b) {
    return Vec3{a * b.x, a * b.y, a * b.z};
}

inline Vec3 operator/(Vec3 a, Vec3 b) {
    return Vec3{a.x / b.x, a.y / b.y, a.z / b.z};
}

inline Vec3 operator/(Vec3 a, float b) {
    return Vec3{a.x / b, a.y / b, a.z / b};
}

inline Vec3 operator/(float a, Vec3 b) {
    return Vec3{a / b.x, a / b.y, a / b.z};
}

inline Bool3 operator>(Vec3 a, Vec3 b) {
    return Bool3{a.x > b.x, a.y > b.y, a.z > b.z};
}

inline Vec3 absolute(Vec3 a) {
    return Vec3{fabsf(a.x), fabsf(a.y), fabsf(a.z)};
}

inline Vec3 sqrt(Vec3 a) {
    return Vec3{sqrtf(a.x), sqrtf(a.y), sqrtf(a.z)};
}

// A trace of absorption, which keeps a conductor's roots from 0, and their squares from where GPUs
// take them for 0. By itself it reflects where the index is matched in the horizon, (ABSORPTION_MIN /
// (2 mu^2))^2.
constexpr float ABSORPTION_MIN = 1.0e-17f;
// Cosine from which on the square of the sine is the smaller of the two, and keeps the digits.
constexpr float NEAR_NORMAL = 0.75f;
constexpr float two_pi = 6.2831855f;
constexpr float inv_pi = 0.31830987f;
constexpr float mu_min = 1.0e-18f;  // cosine of the horizon
// Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
constexpr float RANDOM_MARGIN = 5.9604645e-8f;
// Steps of the rule in retroreflective_base_albedo: a Fibonacci number, and the golden ratio.
constexpr float ALBEDO_SAMPLES = 987.0f;
constexpr float GOLDEN = 0.618034f;
// Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
constexpr float HORIZON = 1.0e-6f;

// A sampled direction and its density.
struct RetroreflectiveSample {
    Vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// Parameters of torrance_sparrow: Rough metal, or the reflection of a rough dielectric. Reciprocal; loses
// energy when rough. Exported with distribution='ggx', masking='smith_correlated', fresnel='conductor',
// compensation='none', diffuse='none'.
struct RetroreflectiveBase {
    // width of the facets' slopes: GGX's alpha, Beckmann's m; 0.0001 to 1, default 0.3
    float alpha;
    // 0 round, 1 smoothest along y; only ggx and beckmann have it; 0 to 1, default 0
    float anisotropy;
    // index of refraction; the default is gold's; 0.01 to 20, default (0.143037, 0.375306, 1.44204)
    Vec3 eta;
    // extinction, the imaginary part of the index; not for dielectric; 0 to 20, default (3.98299,
    // 2.38556, 1.60336)
    Vec3 k;
};

// retroreflective: Road signs and safety tape: bright where the light comes from. Reciprocal if the
// base is.
struct Retroreflective {
    RetroreflectiveBase base;  // whose mirror direction becomes that of the light
};

// Facets of GGX, also called Trowbridge-Reitz.
struct RetroreflectiveGGX {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// ---- evaluation ----------------------------------------------------------------------------

// By half a turn about the normal.
inline Vec3 retroreflective_turned(Vec3 w) {
    return Vec3{-w.x, -w.y, w.z};
}

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
inline float retroreflective_length2(Vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
inline float retroreflective_cos_half(Vec3 wi, Vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5f * sqrtf(retroreflective_length2(wi + wo));
}

// 1 - retroreflective_cos_half^2, the squared sine at which light meets the facet: of half the length of wi
// - wo.
inline float retroreflective_sin2_half(Vec3 wi, Vec3 wo) {
    Vec3 apart = wi - wo;
    return 0.25f * dot(apart, apart);
}

// |re + i im| for im of at least 2 ABSORPTION_MIN.
inline Vec3 retroreflective_size(Vec3 re, Vec3 im) {
    return sqrt(re * re + im * im);
}

// |re + i im|^2 / s2^2 p / q.
inline Vec3 retroreflective_reflected(Vec3 re, Vec3 im, Vec3 s2, Vec3 p, Vec3 q) {
    // In two quotients, as the square of s2 is 1e-34 for a matched index in the horizon
    return (re * re + im * im) / s2 * (p / (s2 * q));
}

// Exact reflectance of a conductor, eta + i k, from cosine and squared sine at a facet.
inline Vec3 retroreflective_F_conductor_half(float cos_h, float sin2_h, Vec3 eta, Vec3 k) {
    // As for a dielectric, in complex numbers: contrast = (eta + i k)^2 - 1, g^2 = w = contrast + c^2
    float c = cos_h;
    Vec3 contrast_re = (eta - 1.0f) * (eta + 1.0f) - k * k;
    Vec3 half_im = eta * k + ABSORPTION_MIN;
    float c2 = c * c;
    // The same as eta^2 - k^2 - sin^2, of which a small index leaves little else near the normal
    Vec3 w_re = cos_h > NEAR_NORMAL ? eta * eta - k * k - sin2_h : contrast_re + c2;
    Vec3 im = 2.0f * half_im;
    Vec3 w_abs = retroreflective_size(w_re, im);
    // Of the two parts of the root, the larger has no cancellation; the smaller follows from it.
    Vec3 g2 = 0.5f * (w_abs + absolute(w_re));
    Vec3 g_re = select(w_re > splat(0.0f), g2, half_im) * (1.0f / sqrt(g2));
    // |c + g|^2 = c^2 + |w| + cross, and |c g -+ sin2_h|^2 = p -+ cross sin2_h
    Vec3 cross = 2.0f * c * g_re;
    Vec3 s_abs2 = c2 + w_abs + cross;
    Vec3 p = c2 * w_abs + sin2_h * sin2_h;
    return retroreflective_reflected(contrast_re, im, s_abs2, p, p + cross * sin2_h);
}

// Widths along x and y: aspect sqrt(1 - 0.9 anisotropy), their product remains alpha^2.
//
// Burley, appendix B, without its lower limit.
inline Vec2 retroreflective_anisotropic_alpha(float alpha, float anisotropy) {
    float aspect2 = 1.0f - 0.9f * anisotropy;
    float stretch = 1.0f / sqrtf(aspect2);
    return Vec2{alpha * stretch, alpha * (aspect2 * stretch)};
}

// D and its widths.
inline RetroreflectiveGGX retroreflective_base_facets(const RetroreflectiveBase& params) {
    Vec2 a = retroreflective_anisotropic_alpha(params.alpha, params.anisotropy);
    return RetroreflectiveGGX{a.x, a.y};
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
inline Vec2 retroreflective_slopes(Vec3 h) {
    float inv = 1.0f / h.z;
    return Vec2{h.x * inv, h.y * inv};
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
inline float retroreflective_ggx_D_along(RetroreflectiveGGX ggx, Vec3 h) {
    Vec2 t = retroreflective_slopes(h);
    // By slopes, s is (1 + (x / alpha_x)^2 + (y / alpha_y)^2) / (1 + x^2 + y^2). Times the squares of both
    // widths no width is a divisor, and the steepest slopes, 1e18, have squares.
    float x = ggx.alpha_y * t.x;
    float y = ggx.alpha_x * t.y;
    float a2 = ggx.alpha_x * ggx.alpha_y;
    float r = a2 * (1.0f + (t.x * t.x + t.y * t.y)) / (a2 * a2 + x * x + y * y);
    return inv_pi * a2 * (r * r);
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
inline float retroreflective_ggx_area(RetroreflectiveGGX ggx, Vec3 w) {
    return length(Vec3{ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z});
}

// G = 1 / (1 + Lambda_i + Lambda_o): correlated by the facet's height. Heitz 2014, Eq. 99.
inline float retroreflective_V_smith_correlated(RetroreflectiveGGX facets, Vec3 wi, Vec3 wo) {
    return 0.5f / (wo.z * retroreflective_ggx_area(facets, wi)
        + wi.z * retroreflective_ggx_area(facets, wo));
}

// G / (4 mu_i mu_o).
inline float retroreflective_base_V(const RetroreflectiveBase& params, Vec3 wi, Vec3 wo) {
    return retroreflective_V_smith_correlated(retroreflective_base_facets(params), wi, wo);
}

// D G / (4 mu_i mu_o): what facets reflect once, without F.
inline float retroreflective_base_highlight(const RetroreflectiveBase& params, Vec3 wi,
    Vec3 wo) {
    return retroreflective_ggx_D_along(retroreflective_base_facets(params), wi + wo)
        * retroreflective_base_V(params, wi, wo);
}

// BRDF value in 1/sr, without the cosine.
inline Vec3 retroreflective_base_eval_above(const RetroreflectiveBase& params, Vec3 wi,
    Vec3 wo) {
    float cos_h = retroreflective_cos_half(wi, wo);
    Vec3 single = retroreflective_F_conductor_half(cos_h, retroreflective_sin2_half(wi, wo),
        params.eta, params.k) * retroreflective_base_highlight(params, wi, wo);
    return single;
}

// The base's value for light from the other side.
inline Vec3 retroreflective_eval(const Retroreflective& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    return retroreflective_base_eval_above(params.base, retroreflective_turned(wi), wo);
}

// ---- sampling ------------------------------------------------------------------------------

// w where all facets are those of a unit sphere.
inline Vec3 retroreflective_ggx_unstretched(RetroreflectiveGGX ggx, Vec3 w) {
    return normalize(Vec3{ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z});
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
inline Vec3 retroreflective_ggx_half_way(RetroreflectiveGGX ggx, Vec3 w, float drop, float z,
    float v) {
    float r = sqrtf(fmaxf(drop * (2.0f - drop), 0.0f));
    float phi = two_pi * v;
    Vec3 h = Vec3{r * cosf(phi) + w.x, r * sinf(phi) + w.y, z};
    return normalize(Vec3{ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z});
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
inline Vec3 retroreflective_ggx_sample_visible(RetroreflectiveGGX ggx, Vec3 wo, Vec2 u) {
    Vec3 w = retroreflective_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    float u1 = fminf(u.x, 1.0f - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    float height = 1.0f + w.z;
    return retroreflective_ggx_half_way(ggx, w, u1 * height, (1.0f - u1) * height, u.y);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
inline Vec3 retroreflective_mirror(Vec3 wo, Vec3 m) {
    return 2.0f * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
inline Vec3 retroreflective_sample_ggx_lobe(RetroreflectiveGGX facets, Vec3 wo, Vec2 u) {
    Vec3 w = retroreflective_mirror(wo, retroreflective_ggx_sample_visible(facets, wo, u));
    return Vec3{w.x, w.y, fabsf(w.z)};
}

// wo mirrored at a visible normal, or at any.
//
// Visible normals need Smith's G1, and a G that is no larger than it. With the G of grooves their weights
// grow like alpha / mu_o in the horizon, but those of all normals are at most 2.
inline Vec3 retroreflective_base_sample_facets(const RetroreflectiveBase& params, Vec3 wo,
    Vec2 u) {
    return retroreflective_sample_ggx_lobe(retroreflective_base_facets(params), wo, u);
}

// Density of retroreflective_sample_ggx_lobe in 1/sr.
inline float retroreflective_pdf_ggx_lobe(RetroreflectiveGGX facets, Vec3 wi, Vec3 wo) {
    float seen = 0.5f / (wo.z + retroreflective_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    float straight = retroreflective_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    bool exists = wo.z > wi.z;
    Vec3 across = Vec3{wi.x, wi.y, exists ? wo.z - wi.z : wi.z};
    float folded = retroreflective_ggx_D_along(facets, across
        + Vec3{wo.x, wo.y, exists ? mu_min : wo.z});
    return (straight + (exists ? folded : 0.0f)) * seen;
}

// Density of retroreflective_base_sample_facets.
inline float retroreflective_base_pdf_facets(const RetroreflectiveBase& params, Vec3 wi,
    Vec3 wo) {
    return retroreflective_pdf_ggx_lobe(retroreflective_base_facets(params), wi, wo);
}

// Density of retroreflective_base_sample in 1/sr.
inline float retroreflective_base_pdf(const RetroreflectiveBase& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    float specular = retroreflective_base_pdf_facets(params, wi, wo);
    return specular;
}

// Visible normals where the masking has them, else normals; with lobes for what is added.
inline RetroreflectiveSample retroreflective_base_sample(const RetroreflectiveBase& params,
    Vec3 wo, Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return RetroreflectiveSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    Vec3 wi = retroreflective_base_sample_facets(params, wo, u);
    return RetroreflectiveSample{wi, retroreflective_base_pdf(params, wi, wo)};
}

// Density of retroreflective_sample in 1/sr.
inline float retroreflective_pdf(const Retroreflective& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0f;
    }
    return retroreflective_base_pdf(params.base, retroreflective_turned(wi), wo);
}

// As the base, turned.
inline RetroreflectiveSample retroreflective_sample(const Retroreflective& params, Vec3 wo,
    Vec2 u) {
    if (wo.z <= mu_min) {  // in the horizon or below
        return RetroreflectiveSample{Vec3{0.0f, 0.0f, 1.0f}, 0.0f};
    }
    Vec3 wi = retroreflective_turned(retroreflective_base_sample(params.base, wo, u).wi);
    return RetroreflectiveSample{wi, retroreflective_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// BRDF value in 1/sr, without the cosine.
inline Vec3 retroreflective_base_eval(const RetroreflectiveBase& params, Vec3 wi, Vec3 wo) {
    if (fminf(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return splat(0.0f);
    }
    float cos_h = retroreflective_cos_half(wi, wo);
    Vec3 single = retroreflective_F_conductor_half(cos_h, retroreflective_sin2_half(wi, wo),
        params.eta, params.k) * retroreflective_base_highlight(params, wi, wo);
    return single;
}

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline Vec3 retroreflective_base_albedo(const RetroreflectiveBase& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    Vec3 w = Vec3{wo.x, wo.y, fmaxf(wo.z, HORIZON)};
    Vec3 total = Vec3{0.0f, 0.0f, 0.0f};
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        Vec2 u = Vec2{(i + 0.5f) / ALBEDO_SAMPLES, fract((i + 0.5f) * GOLDEN)};
        RetroreflectiveSample drawn = retroreflective_base_sample(params, w, u);
        float weight = drawn.pdf > 0.0f ? drawn.wi.z / fmaxf(drawn.pdf, mu_min) : 0.0f;
        total = total + retroreflective_base_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}

// That of the base: a turn about the normal changes no cosine.
inline Vec3 retroreflective_albedo(const Retroreflective& params, Vec3 wo) {
    if (wo.z < 0.0f) {  // below the horizon
        return splat(0.0f);
    }
    return retroreflective_base_albedo(params.base, wo);
}

}  // namespace gonio_retroreflective
