// SPDX-License-Identifier: Apache-2.0
// tri-Ace layered: two Blinn-Phong layers with an absorbing one between, made for game consoles.
//
// Source: Gotanda, "Beyond a simple physically based Blinn-Phong model in real-time", SIGGRAPH 2012 course
// "Practical physically based shading in film and game production", section 2. Symbols are the course's;
// the alpha' of Eq. 3 is sigma_a times thickness here, as in Eq. 2.
// Choices where the course is silent: the fraction of Eq. 1 and the transmittance of Eq. 5 have Schlick's
// F, and Eq. 4 the exact one, all at wo.H; the lower layer uses directions that are not refracted, except
// in the exact absorption; F_trans takes its part from the lower layer's diffuse reflection as well, which
// an option turns off.
//
// Metal, made by gonio from gonio/models/triace_layered.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: TriaceLayered params; params.top_eta = ...; ... triace_layered_eval(params, wi, wo)

#include <metal_stdlib>
using namespace metal;

// A sampled direction and its density.
struct TriaceLayeredSample {
    float3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// triace_layered: A glossy layer over a glossy and matte one, with absorption between. Reciprocal. Exported
// with absorption='exact', bottom_fresnel='exact', top_transmission='on', diffuse='lambert'.
struct TriaceLayered {
    float top_eta;  // index n1 of the upper layer; 1 to 3, default 1.33333
    float top_shininess;  // Blinn-Phong exponent of the upper layer; 0 to 100000, default 200
    float bottom_eta;  // index n2 of the lower layer, as it would be in air; 1 to 3, default 1.5
    float bottom_shininess;  // Blinn-Phong exponent of the lower layer; 0 to 100000, default 20
    // diffuse albedo R_d of the lower layer, linear RGB; 0 to 1, default (0.5, 0.5, 0.5)
    float3 rho;
    // absorption of the upper layer per unit of thickness; 0 to 10, default (0, 0, 0)
    float3 sigma_a;
    float thickness;  // thickness of the upper layer, in the unit of sigma_a; 0 to 1, default 1
};

// What becomes of light at the surface of something denser.
struct TriaceLayeredEntering {
    float F;  // Is reflected
    float T;  // Enters
};

// What Fresnel leaves of the lower layer's reflection, both crossings of the upper surface included.
struct TriaceLayeredBottomFresnel {
    float glossy;  // Factor of the glossy reflection (Eq. 4 or 5)
    float matte;  // Factor of the matte reflection (Eq. 9)
};

// What triace_layered_shares returns.
struct TriaceLayeredShares {
    float2 P_top;
    float2 P_bottom;
};

// Which of two lobes a sample is taken from.
struct TriaceLayeredChoice {
    bool is_first;  // Whether it is the first one
    float2 u;  // Fresh random numbers, made of those that chose
};

// Facets of GGX with the same width in all directions.
struct TriaceLayeredRoundGGX {
    float alpha;  // width of the slopes
};

// Facets of GGX, also called Trowbridge-Reitz.
struct TriaceLayeredGGX {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
inline float triace_layered_length2(float3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
inline float triace_layered_cos_half(float3 wi, float3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(triace_layered_length2(wi + wo));
}

// Reflectance of a dielectric at normal incidence, ((eta - 1) / (eta + 1))^2.
inline float triace_layered_f0_from_eta(float eta) {
    float r = (eta - 1.0) / (eta + 1.0);
    return r * r;
}

// 1 - triace_layered_cos_half^2, the squared sine at which light meets the facet: of half the length of wi
// - wo.
inline float triace_layered_sin2_half(float3 wi, float3 wo) {
    float3 apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
inline float triace_layered_weight(float cos_h, float sin2_h) {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    float k = sin2_h / (1.0 + cos_h);
    float k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
inline float triace_layered_schlick_weight_half(float3 wi, float3 wo) {
    return triace_layered_weight(triace_layered_cos_half(wi, wo), triace_layered_sin2_half(wi, wo));
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
inline float2 triace_layered_slopes(float3 h) {
    float inv = 1.0 / h.z;
    return float2(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
inline float triace_layered_tangent2(float3 h) {
    float2 t = triace_layered_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
inline float triace_layered_atanh_over(float y) {
    float y2 = y * y;
    return 1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0 + y2 * (1.0 / 9.0))));
}

// log(cos) of the angle between the normal and h, which need not be unit.
inline float triace_layered_log_cos_along(float3 h) {
    // Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
    const float LOG1P_SMALL = 0.25;
    // log(cos) = -log(1 + tan^2) / 2 = -atanh(y)
    float tan2 = triace_layered_tangent2(h);
    float y = tan2 / (2.0 + tan2);
    return tan2 < LOG1P_SMALL ? -y * triace_layered_atanh_over(y) : -0.5 * log(1.0 + tan2);
}

// (N.m)^exponent of the normal m along h, exact for sharp lobes.
inline float triace_layered_cos_power(float3 h, float exponent) {
    return exp(exponent * triace_layered_log_cos_along(h));
}

// (0.0397436 n + 0.0856832) (N.H)^n / max(mu_i, mu_o): Eq. 1's highlight without Fresnel.
inline float triace_layered_blinn_phong_highlight(float3 wi, float3 wo, float shininess) {
    const float NORM_SLOPE = 0.0397436;  // Eq. 1: the normalisation as a linear function of n.
    const float NORM_OFFSET = 0.0856832;
    float power = triace_layered_cos_power(wi + wo, shininess);
    return (NORM_SLOPE * shininess + NORM_OFFSET) * power / max(wi.z, wo.z);
}

// eta^2 cos^2(theta_t) = mu^2 + eta^2 - 1; negative where light is reflected totally.
inline float triace_layered_refracted_cos2(float mu, float eta) {
    // The difference of two squares as a product, and mu^2 with its rounding error: at grazing angles, and at
    // the critical one, little else is left.
    return fma(mu, mu, (eta - 1.0) * (eta + 1.0));
}

// F and T = 1 - F of a smooth dielectric with eta >= 1 at a cosine mu outside, mu > 0.
inline TriaceLayeredEntering triace_layered_split_entering(float mu, float eta) {
    // r_s = (1 - eta^2) / s^2 with s = c + g, and r_p = r_s (c g - sin2) / q with q = c g + sin2. So 1 - r_s^2
    // = 4 c g / s^2, and 1 - r_p^2 = 4 c g eta^2 / (s q)^2. One quotient serves all.
    float c = mu;
    float g = sqrt(triace_layered_refracted_cos2(c, eta));
    float s = c + g;
    float p = c * g;
    float sin2 = 1.0 - c * c;
    float q = p + sin2;
    float s2 = s * s;
    float q2 = q * q;
    float inv = 1.0 / (s2 * q2);
    float r_s = (eta - 1.0) * (eta + 1.0) * (q2 * inv);
    float F = r_s * r_s * ((p * p + sin2 * sin2) * (s2 * inv));
    return TriaceLayeredEntering{F, p * inv * (2.0 * (q2 + eta * eta))};
}

// Exact reflectance of a dielectric with eta >= 1, never total, at a cosine outside, mu > 0.
inline float triace_layered_F_dielectric_entering(float mu, float eta) {
    return triace_layered_split_entering(mu, eta).F;
}

// 1 - F of a smooth dielectric with eta >= 1 at a cosine mu outside; exact where it nearly vanishes.
inline float triace_layered_transmittance_entering(float mu, float eta) {
    return triace_layered_split_entering(mu, eta).T;
}

// n times the cosine inside a layer of index n.
inline float triace_layered_below(float cos_theta, float n) {
    return sqrt(triace_layered_refracted_cos2(cos_theta, n));
}

inline float triace_layered_sin2(float cos_theta) {
    return (1.0 - cos_theta) * (1.0 + cos_theta);
}

// Exact reflectance of the lower surface, between layers of n1 and n2, at a cosine above the upper one.
//
// Both indices are at least 1, relative to where the cosine is: nothing is reflected totally.
inline float triace_layered_F_below(float cos_theta, float n1, float n2) {
    // With g = n cos(theta) on both sides: r_s = (g1 - g2) / (g1 + g2), r_p = (n2^2 g1 - n1^2 g2) / p. Both
    // differences leave n1^2 - n2^2 as a factor, and g from the cosine above has no cancellation.
    float g1 = triace_layered_below(cos_theta, n1);
    float g2 = triace_layered_below(cos_theta, n2);
    float a = n1 * n1;
    float b = n2 * n2;
    float sin2 = triace_layered_sin2(cos_theta);
    float contrast = (n1 - n2) * (n1 + n2);
    float s = g1 + g2;
    float p = b * g1 + a * g2;
    float r_s = contrast / (s * s);
    float r_p = contrast * (a * b - sin2 * (a + b)) / (p * p);
    return 0.5 * (r_s * r_s + r_p * r_p);
}

// 1 - triace_layered_F_below; exact where it nearly vanishes.
inline float triace_layered_transmittance_below(float cos_theta, float n1, float n2) {
    float g1 = triace_layered_below(cos_theta, n1);
    float g2 = triace_layered_below(cos_theta, n2);
    float a = n1 * n1;
    float b = n2 * n2;
    float s = g1 + g2;
    float p = b * g1 + a * g2;
    return 2.0 * (g1 / s * (g2 / s) + a * b * (g1 / p) * (g2 / p));
}

// Factors of the lower layer's glossy and matte reflection (Eq. 4 or 5, and Eq. 9).
inline TriaceLayeredBottomFresnel triace_layered_bottom_fresnel(TriaceLayered params,
    float cos_h) {
    float n1 = params.top_eta;
    float n2 = params.bottom_eta;
    // Both crossings of the upper surface have the same F at angles that belong together.
    float F = triace_layered_F_dielectric_entering(cos_h, n1);
    float T = triace_layered_transmittance_entering(cos_h, n1);
    float glossy = T * T * triace_layered_F_below(cos_h, n1, n2);
    float lost = T * triace_layered_transmittance_below(cos_h, n1, n2);
    // 1 - T triace_layered_F_below and 1 - T T triace_layered_F_below without their cancellation
    return TriaceLayeredBottomFresnel{glossy, T * (F + lost)};
}

// eta^2 - 1.
inline float triace_layered_contrast(float excess) {
    return excess * (2.0 + excess);
}

// eta^2 cos^2(theta_t) = mu^2 + eta^2 - 1.
inline float triace_layered_eta2_cos2(float mu, float excess) {
    // mu^2 with its rounding error: at grazing angles little else is left
    return fma(mu, mu, triace_layered_contrast(excess));
}

// The direction inside a layer with eta >= 1 that belongs to w outside.
inline float3 triace_layered_refract(float3 w, float excess) {
    return float3(w.x, w.y, sqrt(triace_layered_eta2_cos2(w.z, excess))) * (1.0 / (1.0 + excess));
}

// exp(-sigma_a d (1 / mu_i + 1 / mu_o)): what is left of light after its way in and out (Bouguer).
//
// wi, wo: refracted directions. sigma_a: absorption per unit of the thickness d.
inline float3 triace_layered_attenuation(float3 sigma_a, float thickness, float3 wi,
    float3 wo) {
    return exp(-sigma_a * (thickness * ((wi.z + wo.z) / (wi.z * wo.z))));
}

// Eq. 2 or 3.
inline float3 triace_layered_absorption(TriaceLayered params, float3 wi, float3 wo) {
    return triace_layered_attenuation(params.sigma_a, params.thickness,
        triace_layered_refract(wi, params.top_eta - 1.0),
            triace_layered_refract(wo, params.top_eta - 1.0));
}

// Eq. 1 twice, with Eq. 2 to 5 between: BRDF value in 1/sr, without the cosine.
inline float3 triace_layered_eval(TriaceLayered params, float3 wi, float3 wo) {
    const float inv_pi = 0.31830987;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return float3(0.0);
    }
    float cos_h = triace_layered_cos_half(wi, wo);
    float F_top = mix(triace_layered_f0_from_eta(params.top_eta), 1.0,
        triace_layered_schlick_weight_half(wi, wo));
    float top = F_top * triace_layered_blinn_phong_highlight(wi, wo, params.top_shininess);
    TriaceLayeredBottomFresnel bottom_fresnel_result = triace_layered_bottom_fresnel(params, cos_h);
    float glossy = bottom_fresnel_result.glossy;
    float matte = bottom_fresnel_result.matte;
    float bottom = glossy * triace_layered_blinn_phong_highlight(wi, wo, params.bottom_shininess);
    float3 below = bottom + matte * params.rho * inv_pi;
    return top + below * triace_layered_absorption(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// A cosine at which light from anywhere meets the facets that it enters by, to choose lobes with.
//
// Halfway between wo.z (the mirror direction) and 1 (wi = wo): at grazing angles tilted facets let in more
// than the mean surface, whose transmittance is nearly 0 there.
inline float triace_layered_usual_cos_half(float3 wo) {
    return 0.5 + 0.5 * wo.z;
}

// (1 - cos_theta)^5 of Schlick's approximation.
inline float triace_layered_schlick_weight(float cos_theta) {
    float k = 1.0 - cos_theta;
    float k2 = k * k;
    return k2 * k2 * k;
}

// Mean of the three channels, by which lobes are weighed against each other.
inline float triace_layered_average(float3 color) {
    return (color.x + color.y + color.z) / 3.0;
}

inline float triace_layered_raised(float probability) {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const float SHARE_LEAST = 0.1;
    const float ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
inline float2 triace_layered_lobes_shares(float first, float second) {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const float BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const float WEIGHT_MIN = 1.0e-37;
    float a = first + BLACK;
    float b = max(second, WEIGHT_MIN);
    float inv = 1.0 / (a + b);
    float P_first = triace_layered_raised(a * inv);
    float P_second = triace_layered_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return float2(smaller ? P_first : 1.0 - P_second, smaller ? 1.0 - P_first : P_second);
}

// Probabilities: upper highlight or lower layer; of that, its highlight or its diffuse part.
inline TriaceLayeredShares triace_layered_shares(TriaceLayered params, float3 wo) {
    // Added to the weight of a lobe, so that the reciprocal of two black lobes' sum has a finite derivative.
    const float LOBE_MIN = 1.0e-12;
    // Smallest share of the samples that a highlight gets: it bounds their weights.
    const float LOBE_SHARE_MIN = 0.1;
    TriaceLayeredBottomFresnel bottom_fresnel_result = triace_layered_bottom_fresnel(params,
        triace_layered_usual_cos_half(wo));
    float glossy = bottom_fresnel_result.glossy;
    float matte = bottom_fresnel_result.matte;
    // The shortest way in, the light's, bounds what the absorption can leave.
    float3 kept = triace_layered_absorption(params, float3(0.0, 0.0, 1.0), wo);
    float top = mix(triace_layered_f0_from_eta(params.top_eta), 1.0,
        triace_layered_schlick_weight(wo.z));
    float bottom = glossy * triace_layered_average(kept);
    float diffuse = matte * triace_layered_average(kept * params.rho) + LOBE_MIN;
    float lower = bottom + diffuse;
    // Half vectors away from the normal reflect more than this estimate, which is made for the normal.
    float2 P_top = triace_layered_lobes_shares(max(top, LOBE_SHARE_MIN * lower), lower);
    float2 P_bottom = triace_layered_lobes_shares(max(bottom, LOBE_SHARE_MIN * diffuse), diffuse);
    return TriaceLayeredShares{P_top, P_bottom};
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
inline TriaceLayeredChoice triace_layered_choose(float probability, float2 u) {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const float SHARE_MIN = 1.0e-12;
    // The largest float32 below 1, up to which random numbers go.
    const float RANDOM_MAX = 0.99999994;
    bool first = u.x < probability;
    float below = u.x / max(probability, SHARE_MIN);
    float above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return TriaceLayeredChoice{first, float2(clamp(first ? below : above, 0.0, RANDOM_MAX), u.y)};
}

// The width that matches an exponent n: sqrt(2 / (n + 2)).
inline float triace_layered_blinn_phong_alpha(float exponent) {
    return sqrt(2.0 / (exponent + 2.0));
}

// Facets that the upper highlight is sampled by: as wide, with a longer tail.
inline TriaceLayeredRoundGGX triace_layered_top(TriaceLayered params) {
    return TriaceLayeredRoundGGX{triace_layered_blinn_phong_alpha(params.top_shininess)};
}

// w where all facets are those of a unit sphere.
inline float3 triace_layered_ggx_unstretched(TriaceLayeredGGX ggx, float3 w) {
    return normalize(float3(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
inline float3 triace_layered_ggx_half_way(TriaceLayeredGGX ggx, float3 w, float drop, float z,
    float v) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(drop * (2.0 - drop), 0.0));
    float phi = two_pi * v;
    float3 h = float3(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(float3(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
inline float3 triace_layered_ggx_sample_visible(TriaceLayeredGGX ggx, float3 wo, float2 u) {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const float RANDOM_MARGIN = 5.9604645e-8;
    float3 w = triace_layered_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    float u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    float height = 1.0 + w.z;
    return triace_layered_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see triace_layered_ggx_sample_visible.
inline float3 triace_layered_round_ggx_sample_visible(TriaceLayeredRoundGGX round_ggx,
    float3 wo, float2 u) {
    return triace_layered_ggx_sample_visible(TriaceLayeredGGX{round_ggx.alpha, round_ggx.alpha}, wo,
        u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
inline float3 triace_layered_mirror(float3 wo, float3 m) {
    return 2.0 * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
inline float3 triace_layered_sample_ggx_lobe(TriaceLayeredRoundGGX facets, float3 wo,
    float2 u) {
    float3 w = triace_layered_mirror(wo, triace_layered_round_ggx_sample_visible(facets, wo, u));
    return float3(w.x, w.y, abs(w.z));
}

// Facets that the lower highlight is sampled by: as wide, with a longer tail.
inline TriaceLayeredRoundGGX triace_layered_bottom(TriaceLayered params) {
    return TriaceLayeredRoundGGX{triace_layered_blinn_phong_alpha(params.bottom_shininess)};
}

// A direction with density cos(theta) / pi.
inline float3 triace_layered_sample_cosine(float2 u) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(u.x, 0.0));
    float phi = two_pi * u.y;
    return float3(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
inline float triace_layered_round_ggx_area(TriaceLayeredRoundGGX round_ggx, float3 w) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrt(a2 + (1.0 - a2) * (w.z * w.z));
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
inline float triace_layered_round_ggx_D_along(TriaceLayeredRoundGGX round_ggx, float3 h) {
    const float inv_pi = 0.31830987;
    float a2 = round_ggx.alpha * round_ggx.alpha;
    float tan2 = triace_layered_tangent2(h);
    float r = (1.0 + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// Density of triace_layered_sample_ggx_lobe in 1/sr.
inline float triace_layered_pdf_ggx_lobe(TriaceLayeredRoundGGX facets, float3 wi, float3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    // Smith's G1 over 4 mu_o
    float seen = 0.5 / (wo.z + triace_layered_round_ggx_area(facets, wo));
    float straight = triace_layered_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    bool exists = wo.z > wi.z;
    float3 across = float3(wi.x, wi.y, exists ? wo.z - wi.z : wi.z);
    float folded = triace_layered_round_ggx_D_along(facets, across
        + float3(wo.x, wo.y, exists ? mu_min : wo.z));
    return (straight + (exists ? folded : 0.0)) * seen;
}

// Density of triace_layered_sample_cosine in 1/sr, for w above the horizon.
inline float triace_layered_pdf_cosine(float3 w) {
    const float inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Density of triace_layered_sample in 1/sr.
inline float triace_layered_pdf(TriaceLayered params, float3 wi, float3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    TriaceLayeredShares shares_result = triace_layered_shares(params, wo);
    float2 P_top = shares_result.P_top;
    float2 P_bottom = shares_result.P_bottom;
    float top = triace_layered_pdf_ggx_lobe(triace_layered_top(params), wi, wo);
    float bottom = triace_layered_pdf_ggx_lobe(triace_layered_bottom(params), wi, wo);
    float matte = triace_layered_pdf_cosine(wi);
    return P_top.x * top + P_top.y * (P_bottom.x * bottom + P_bottom.y * matte);
}

// Diffuse, or the GGX lobe as wide as one of the highlights, chosen by what they reflect.
inline TriaceLayeredSample triace_layered_sample(TriaceLayered params, float3 wo, float2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return TriaceLayeredSample{float3(0.0, 0.0, 1.0), 0.0};
    }
    TriaceLayeredShares shares_result = triace_layered_shares(params, wo);
    float2 P_top = shares_result.P_top;
    float2 P_bottom = shares_result.P_bottom;
    TriaceLayeredChoice choose_result = triace_layered_choose(P_top.x, u);
    bool on_top = choose_result.is_first;
    float2 v = choose_result.u;
    TriaceLayeredChoice choose_result_2 = triace_layered_choose(P_bottom.x, v);
    bool on_bottom = choose_result_2.is_first;
    float2 t = choose_result_2.u;
    float3 w_top = triace_layered_sample_ggx_lobe(triace_layered_top(params), wo, v);
    float3 w_bottom = triace_layered_sample_ggx_lobe(triace_layered_bottom(params), wo, t);
    float3 w_matte = triace_layered_sample_cosine(t);
    float3 wi = on_top ? w_top : on_bottom ? w_bottom : w_matte;
    return TriaceLayeredSample{wi, triace_layered_pdf(params, wi, wo)};
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
inline float3 triace_layered_albedo(TriaceLayered params, float3 wo) {
    // Steps of the rule in triace_layered_albedo: a Fibonacci number, and the golden ratio.
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
        TriaceLayeredSample drawn = triace_layered_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + triace_layered_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
