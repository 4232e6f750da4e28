// SPDX-License-Identifier: Apache-2.0
// Sum: the light of two models on one surface, each with a weight; nested, of any number of them.
//
// f = w1 f1 + w2 f2. Measured materials are often fitted with such sums: Lambert and one or more lobes.
// Sources: Ngan, Durand, Matusik, "Experimental analysis of BRDF models", EGSR 2005, section 3; Lafortune,
// Foo, Torrance, Greenberg, "Non-linear approximation of reflectance functions", SIGGRAPH 1997, Eq. 8.
//
// Lambert: ideal diffuse reflection.
//
// Source: Johann Heinrich Lambert, "Photometria", 1760.
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
// Metal, made by gonio from gonio/models/sum.py, gonio/models/lambert.py, gonio/models/torrance_sparrow.py;
// free to use under Apache-2.0. wi points towards the light and wo towards the viewer: unit vectors in the
// local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// Usage: Sum params; params.first.rho = ...; ... sum_eval(params, wi, wo)

#include <metal_stdlib>
using namespace metal;

// A sampled direction and its density.
struct SumSample {
    float3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// Parameters of lambert: Ideal diffuse: the same radiance in every direction. Reciprocal; the albedo
// is rho.
struct SumFirst {
    float3 rho;  // albedo, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
};

// Parameters of torrance_sparrow: Rough metal, or the reflection of a rough dielectric. Reciprocal; loses
// energy when rough. Exported with distribution='ggx', masking='smith_correlated', fresnel='conductor',
// compensation='none', diffuse='none'.
struct SumSecond {
    // width of the facets' slopes: GGX's alpha, Beckmann's m; 0.0001 to 1, default 0.3
    float alpha;
    // 0 round, 1 smoothest along y; only ggx and beckmann have it; 0 to 1, default 0
    float anisotropy;
    // index of refraction; the default is gold's; 0.01 to 20, default (0.143037, 0.375306, 1.44204)
    float3 eta;
    // extinction, the imaginary part of the index; not for dielectric; 0 to 20, default (3.98299,
    // 2.38556, 1.60336)
    float3 k;
};

// sum: Two models added, such as a diffuse one and a highlight. Reciprocal if both are.
struct Sum {
    SumFirst first;  // one of the two, such as what is diffuse
    SumSecond second;  // the other one, such as a highlight, or another sum
    float3 first_weight;  // what the first one is multiplied by; 0 to 1, default (0.5, 0.5, 0.5)
    float3 second_weight;  // what the second one is multiplied by; 0 to 1, default (0.5, 0.5, 0.5)
};

// Facets of GGX, also called Trowbridge-Reitz.
struct SumGGX {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// Which of two lobes a sample is taken from.
struct SumChoice {
    bool is_first;  // Whether it is the first one
    float2 u;  // Fresh random numbers, made of those that chose
};

// ---- evaluation ----------------------------------------------------------------------------

// rho / pi.
inline float3 sum_first_eval_above(SumFirst params) {
    const float inv_pi = 0.31830987;
    return params.rho * inv_pi;
}

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
inline float sum_length2(float3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
inline float sum_cos_half(float3 wi, float3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(sum_length2(wi + wo));
}

// 1 - sum_cos_half^2, the squared sine at which light meets the facet: of half the length of wi - wo.
inline float sum_sin2_half(float3 wi, float3 wo) {
    float3 apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// |re + i im| for im of at least 2 ABSORPTION_MIN.
inline float3 sum_size(float3 re, float3 im) {
    return sqrt(re * re + im * im);
}

// |re + i im|^2 / s2^2 p / q.
inline float3 sum_reflected(float3 re, float3 im, float3 s2, float3 p, float3 q) {
    // In two quotients, as the square of s2 is 1e-34 for a matched index in the horizon
    return (re * re + im * im) / s2 * (p / (s2 * q));
}

// Exact reflectance of a conductor, eta + i k, from cosine and squared sine at a facet.
inline float3 sum_F_conductor_half(float cos_h, float sin2_h, float3 eta, float3 k) {
    // A trace of absorption, which keeps a conductor's roots from 0, and their squares from where GPUs
    // take them for 0. By itself it reflects where the index is matched in the horizon, (ABSORPTION_MIN /
    // (2 mu^2))^2.
    const float ABSORPTION_MIN = 1.0e-17;
    // Cosine from which on the square of the sine is the smaller of the two, and keeps the digits.
    const float NEAR_NORMAL = 0.75;
    // As for a dielectric, in complex numbers: contrast = (eta + i k)^2 - 1, g^2 = w = contrast + c^2
    float c = cos_h;
    float3 contrast_re = (eta - 1.0) * (eta + 1.0) - k * k;
    float3 half_im = eta * k + ABSORPTION_MIN;
    float c2 = c * c;
    // The same as eta^2 - k^2 - sin^2, of which a small index leaves little else near the normal
    float3 w_re = cos_h > NEAR_NORMAL ? eta * eta - k * k - sin2_h : contrast_re + c2;
    float3 im = 2.0 * half_im;
    float3 w_abs = sum_size(w_re, im);
    // Of the two parts of the root, the larger has no cancellation; the smaller follows from it.
    float3 g2 = 0.5 * (w_abs + abs(w_re));
    float3 g_re = select(half_im, g2, w_re > float3(0.0)) * (1.0 / sqrt(g2));
    // |c + g|^2 = c^2 + |w| + cross, and |c g -+ sin2_h|^2 = p -+ cross sin2_h
    float3 cross = 2.0 * c * g_re;
    float3 s_abs2 = c2 + w_abs + cross;
    float3 p = c2 * w_abs + sin2_h * sin2_h;
    return sum_reflected(contrast_re, im, s_abs2, p, p + cross * sin2_h);
}

// Widths along x and y: aspect sqrt(1 - 0.9 anisotropy), their product remains alpha^2.
//
// Burley, appendix B, without its lower limit.
inline float2 sum_anisotropic_alpha(float alpha, float anisotropy) {
    float aspect2 = 1.0 - 0.9 * anisotropy;
    float stretch = 1.0 / sqrt(aspect2);
    return float2(alpha * stretch, alpha * (aspect2 * stretch));
}

// D and its widths.
inline SumGGX sum_second_facets(SumSecond params) {
    float2 a = sum_anisotropic_alpha(params.alpha, params.anisotropy);
    return SumGGX{a.x, a.y};
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
inline float2 sum_slopes(float3 h) {
    float inv = 1.0 / h.z;
    return float2(h.x * inv, h.y * inv);
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
inline float sum_ggx_D_along(SumGGX ggx, float3 h) {
    const float inv_pi = 0.31830987;
    float2 t = sum_slopes(h);
    // By slopes, s is (1 + (x / alpha_x)^2 + (y / alpha_y)^2) / (1 + x^2 + y^2). Times the squares of both
    // widths no width is a divisor, and the steepest slopes, 1e18, have squares.
    float x = ggx.alpha_y * t.x;
    float y = ggx.alpha_x * t.y;
    float a2 = ggx.alpha_x * ggx.alpha_y;
    float r = a2 * (1.0 + (t.x * t.x + t.y * t.y)) / (a2 * a2 + x * x + y * y);
    return inv_pi * a2 * (r * r);
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
inline float sum_ggx_area(SumGGX ggx, float3 w) {
    return length(float3(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// G = 1 / (1 + Lambda_i + Lambda_o): correlated by the facet's height. Heitz 2014, Eq. 99.
inline float sum_V_smith_correlated(SumGGX facets, float3 wi, float3 wo) {
    return 0.5 / (wo.z * sum_ggx_area(facets, wi) + wi.z * sum_ggx_area(facets, wo));
}

// G / (4 mu_i mu_o).
inline float sum_second_V(SumSecond params, float3 wi, float3 wo) {
    return sum_V_smith_correlated(sum_second_facets(params), wi, wo);
}

// D G / (4 mu_i mu_o): what facets reflect once, without F.
inline float sum_second_highlight(SumSecond params, float3 wi, float3 wo) {
    return sum_ggx_D_along(sum_second_facets(params), wi + wo) * sum_second_V(params, wi, wo);
}

// BRDF value in 1/sr, without the cosine.
inline float3 sum_second_eval_above(SumSecond params, float3 wi, float3 wo) {
    float cos_h = sum_cos_half(wi, wo);
    float3 single = sum_F_conductor_half(cos_h, sum_sin2_half(wi, wo), params.eta, params.k)
        * sum_second_highlight(params, wi, wo);
    return single;
}

// BRDF value in 1/sr, without the cosine.
inline float3 sum_eval(Sum params, float3 wi, float3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return float3(0.0);
    }
    float3 first = params.first_weight * sum_first_eval_above(params.first);
    return first + params.second_weight * sum_second_eval_above(params.second, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// Mean of the three channels, by which lobes are weighed against each other.
inline float sum_average(float3 color) {
    return (color.x + color.y + color.z) / 3.0;
}

inline float sum_raised(float probability) {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const float SHARE_LEAST = 0.1;
    const float ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
inline float2 sum_lobes_shares(float first, float second) {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const float BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const float WEIGHT_MIN = 1.0e-37;
    float a = first + BLACK;
    float b = max(second, WEIGHT_MIN);
    float inv = 1.0 / (a + b);
    float P_first = sum_raised(a * inv);
    float P_second = sum_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return float2(smaller ? P_first : 1.0 - P_second, smaller ? 1.0 - P_first : P_second);
}

// Probabilities of the two.
inline float2 sum_shares(Sum params) {
    return sum_lobes_shares(sum_average(params.first_weight), sum_average(params.second_weight));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
inline SumChoice sum_choose(float probability, float2 u) {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const float SHARE_MIN = 1.0e-12;
    // The largest float32 below 1, up to which random numbers go.
    const float RANDOM_MAX = 0.99999994;
    bool first = u.x < probability;
    float below = u.x / max(probability, SHARE_MIN);
    float above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return SumChoice{first, float2(clamp(first ? below : above, 0.0, RANDOM_MAX), u.y)};
}

// A direction with density cos(theta) / pi.
inline float3 sum_sample_cosine(float2 u) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(u.x, 0.0));
    float phi = two_pi * u.y;
    return float3(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// Density of sum_sample_cosine in 1/sr, for w above the horizon.
inline float sum_pdf_cosine(float3 w) {
    const float inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Cosine-weighted, which is exact here.
inline SumSample sum_first_sample(float3 wo, float2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return SumSample{float3(0.0, 0.0, 1.0), 0.0};
    }
    float3 wi = sum_sample_cosine(u);
    return SumSample{wi, wi.z > mu_min ? sum_pdf_cosine(wi) : 0.0};
}

// w where all facets are those of a unit sphere.
inline float3 sum_ggx_unstretched(SumGGX ggx, float3 w) {
    return normalize(float3(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
inline float3 sum_ggx_half_way(SumGGX ggx, float3 w, float drop, float z, float v) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(drop * (2.0 - drop), 0.0));
    float phi = two_pi * v;
    float3 h = float3(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(float3(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
inline float3 sum_ggx_sample_visible(SumGGX ggx, float3 wo, float2 u) {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const float RANDOM_MARGIN = 5.9604645e-8;
    float3 w = sum_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    float u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    float height = 1.0 + w.z;
    return sum_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
inline float3 sum_mirror(float3 wo, float3 m) {
    return 2.0 * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
inline float3 sum_sample_ggx_lobe(SumGGX facets, float3 wo, float2 u) {
    float3 w = sum_mirror(wo, sum_ggx_sample_visible(facets, wo, u));
    return float3(w.x, w.y, abs(w.z));
}

// wo mirrored at a visible normal, or at any.
//
// Visible normals need Smith's G1, and a G that is no larger than it. With the G of grooves their weights
// grow like alpha / mu_o in the horizon, but those of all normals are at most 2.
inline float3 sum_second_sample_facets(SumSecond params, float3 wo, float2 u) {
    return sum_sample_ggx_lobe(sum_second_facets(params), wo, u);
}

// Density of sum_sample_ggx_lobe in 1/sr.
inline float sum_pdf_ggx_lobe(SumGGX facets, float3 wi, float3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    float seen = 0.5 / (wo.z + sum_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    float straight = sum_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    bool exists = wo.z > wi.z;
    float3 across = float3(wi.x, wi.y, exists ? wo.z - wi.z : wi.z);
    float folded = sum_ggx_D_along(facets, across + float3(wo.x, wo.y, exists ? mu_min : wo.z));
    return (straight + (exists ? folded : 0.0)) * seen;
}

// Density of sum_second_sample_facets.
inline float sum_second_pdf_facets(SumSecond params, float3 wi, float3 wo) {
    return sum_pdf_ggx_lobe(sum_second_facets(params), wi, wo);
}

// Density of sum_second_sample in 1/sr.
inline float sum_second_pdf(SumSecond params, float3 wi, float3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    float specular = sum_second_pdf_facets(params, wi, wo);
    return specular;
}

// Visible normals where the masking has them, else normals; with lobes for what is added.
inline SumSample sum_second_sample(SumSecond params, float3 wo, float2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return SumSample{float3(0.0, 0.0, 1.0), 0.0};
    }
    float3 wi = sum_second_sample_facets(params, wo, u);
    return SumSample{wi, sum_second_pdf(params, wi, wo)};
}

// cos(theta_i) / pi.
inline float sum_first_pdf(float3 wi, float3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return sum_pdf_cosine(wi);
}

// Density of sum_sample in 1/sr.
inline float sum_pdf(Sum params, float3 wi, float3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    float2 P = sum_shares(params);
    return P.x * sum_first_pdf(wi, wo) + P.y * sum_second_pdf(params.second, wi, wo);
}

// One of the two, in proportion to their weights.
inline SumSample sum_sample(Sum params, float3 wo, float2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return SumSample{float3(0.0, 0.0, 1.0), 0.0};
    }
    SumChoice choose_result = sum_choose(sum_shares(params).x, u);
    bool on_first = choose_result.is_first;
    float2 v = choose_result.u;
    float3 w_first = sum_first_sample(wo, v).wi;
    float3 w_second = sum_second_sample(params.second, wo, v).wi;
    float3 wi = on_first ? w_first : w_second;
    return SumSample{wi, sum_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// rho.
inline float3 sum_first_albedo(SumFirst params, float3 wo) {
    if (wo.z < 0.0) {  // below the horizon
        return float3(0.0);
    }
    return params.rho;
}

// BRDF value in 1/sr, without the cosine.
inline float3 sum_second_eval(SumSecond params, float3 wi, float3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return float3(0.0);
    }
    float cos_h = sum_cos_half(wi, wo);
    float3 single = sum_F_conductor_half(cos_h, sum_sin2_half(wi, wo), params.eta, params.k)
        * sum_second_highlight(params, wi, wo);
    return single;
}

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline float3 sum_second_albedo(SumSecond params, float3 wo) {
    // Steps of the rule in sum_second_albedo: a Fibonacci number, and the golden ratio.
    const float ALBEDO_SAMPLES = 987.0;
    const float GOLDEN = 0.618034;
    // Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
    const float HORIZON = 1.0e-6;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z < 0.0) {  // below the horizon
        return float3(0.0);
    }
    float3 w = float3(wo.x, wo.y, max(wo.z, HORIZON));
    float3 total = float3(0.0);
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        float2 u = float2((i + 0.5) / ALBEDO_SAMPLES, fract((i + 0.5) * GOLDEN));
        SumSample drawn = sum_second_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + sum_second_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}

// Directional albedo: that of each, with its weight.
inline float3 sum_albedo(Sum params, float3 wo) {
    if (wo.z < 0.0) {  // below the horizon
        return float3(0.0);
    }
    return params.first_weight * sum_first_albedo(params.first, wo)
        + params.second_weight * sum_second_albedo(params.second, wo);
}
