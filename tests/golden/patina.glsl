// SPDX-License-Identifier: Apache-2.0
// Patina: copper that turns green, from bare metal to a closed layer.
//
// Source: Elek, "Layered materials in real-time rendering", CESCG 2010, section 4.2: the layered model of
// `weidlich_wilkie` with a coat of cuprite that also scatters, faded in by a map, which
// `gonio.mitsuba.textures.growth_map` makes. Spatial variation is the host's business: growth is a number
// here, and a texture gives each point its own.
// Deviations: by default light that leaves the coat spreads by 1 / eta^2, without which the metal below is
// eta^2 = 9.5 times too bright; facets are GGX's with Smith's masking instead of Beckmann's with
// V-cavities, and F is exact instead of Lazanyi's fit. Options restore each of these. The index that Elek
// mixes with the patina's as that grows is the one of the environment's reflection alone: the metal below
// stays copper.
//
// GLSL 4.5, made by gonio from gonio/models/patina.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: Patina params; params.growth = ...; ... patina_eval(params, wi, wo)

// A sampled direction and its density.
struct PatinaSample {
    vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// patina: Copper under a growing green layer of cuprite. Reciprocal.
// Exported with solid_angle='compressed', distribution='ggx', masking='smith_correlated', fresnel='exact'.
struct Patina {
    float growth;  // the map: where it is dark, the patina grows first; 0 to 1, default 0.5
    float extent;  // from -transition (bare) to 1 + transition (closed); -1 to 2, default 0.45
    float transition;  // softness of the patina's edges; 0.001 to 1, default 0.65
    float thickness;  // thickness of the patina, in the unit of sigma_a; 0 to 5, default 1
    vec3 sigma_a;  // absorption; 1 - sigma_a is the colour; 0 to 1, default (0.66, 0.3, 0.42)
    float alpha;  // slope width of the patina's facets; 0.0001 to 1, default 0.5
    float bare_alpha;  // slope width of the metal's facets where bare; 0.0001 to 1, default 0.15
    float grown_alpha;  // slope width of the metal's facets below patina; 0.0001 to 1, default 0.5
    // the metal's index; the default is copper; 0.01 to 20, default (0.201005, 0.923749, 1.10221)
    vec3 metal_eta;
    vec3 metal_k;  // the metal's extinction; 0 to 20, default (3.91326, 2.45304, 2.14209)
    // the patina's index; the default is cuprite; 1 to 5, default (2.947821, 3.110926, 3.026471)
    vec3 coat_eta;
    // the patina's extinction, at its surface only; 0 to 3, default (0.09478703, 0.2044823, 0.6666183)
    vec3 coat_k;
    float tarnish;  // how much the metal has darkened; a texture can drive it; 0 to 1, default 0.5
    vec3 tarnish_tint;  // colour of the metal at tarnish 1; 0 to 1, default (0.45, 0.2, 0.08)
};

// Facets of GGX with the same width in all directions.
struct PatinaRoundGGX {
    float alpha;  // width of the slopes
};

// What becomes of light at a surface.
struct PatinaSplit {
    vec3 F;  // Is reflected
    vec3 T;  // Enters
};

// What patina_shares returns.
struct PatinaShares {
    vec2 P_bare;
    vec2 P_coat;
    vec2 P_diffuse;
};

// Which of two lobes a sample is taken from.
struct PatinaChoice {
    bool is_first;  // Whether it is the first one
    vec2 u;  // Fresh random numbers, made of those that chose
};

// Facets of GGX, also called Trowbridge-Reitz.
struct PatinaGGX {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
float patina_length2(vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
vec3 patina_half_vector(vec3 wi, vec3 wo) {
    // wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
    // squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
    // much longer.
    const float LENGTHENED = 1.0995116e12;
    vec3 h = LENGTHENED * (wi + wo);
    return h / sqrt(patina_length2(h));  // the root is the cosine's as well
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
float patina_cos_half(vec3 wi, vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(patina_length2(wi + wo));
}

// 1 - patina_cos_half^2, the squared sine at which light meets the facet: of half the length of wi - wo.
float patina_sin2_half(vec3 wi, vec3 wo) {
    vec3 apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// |re + i im| for im of at least 2 ABSORPTION_MIN.
vec3 patina_size(vec3 re, vec3 im) {
    return sqrt(re * re + im * im);
}

// |re + i im|^2 / s2^2 p / q.
vec3 patina_reflected(vec3 re, vec3 im, vec3 s2, vec3 p, vec3 q) {
    // In two quotients, as the square of s2 is 1e-34 for a matched index in the horizon
    return (re * re + im * im) / s2 * (p / (s2 * q));
}

// Exact reflectance of a conductor, eta + i k, from cosine and squared sine at a facet.
vec3 patina_F_conductor_half(float cos_h, float sin2_h, vec3 eta, vec3 k) {
    // A trace of absorption, which keeps a conductor's roots from 0, and their squares from where GPUs
    // take them for 0. By itself it reflects where the index is matched in the horizon, (ABSORPTION_MIN /
    // (2 mu^2))^2.
    const float ABSORPTION_MIN = 1.0e-17;
    // Cosine from which on the square of the sine is the smaller of the two, and keeps the digits.
    const float NEAR_NORMAL = 0.75;
    // As for a dielectric, in complex numbers: contrast = (eta + i k)^2 - 1, g^2 = w = contrast + c^2
    float c = cos_h;
    vec3 contrast_re = (eta - 1.0) * (eta + 1.0) - k * k;
    vec3 half_im = eta * k + ABSORPTION_MIN;
    float c2 = c * c;
    // The same as eta^2 - k^2 - sin^2, of which a small index leaves little else near the normal
    vec3 w_re = mix(contrast_re + c2, eta * eta - k * k - sin2_h, bvec3(cos_h > NEAR_NORMAL));
    vec3 im = 2.0 * half_im;
    vec3 w_abs = patina_size(w_re, im);
    // Of the two parts of the root, the larger has no cancellation; the smaller follows from it.
    vec3 g2 = 0.5 * (w_abs + abs(w_re));
    vec3 g_re = mix(half_im, g2, greaterThan(w_re, vec3(0.0))) * (1.0 / sqrt(g2));
    // |c + g|^2 = c^2 + |w| + cross, and |c g -+ sin2_h|^2 = p -+ cross sin2_h
    vec3 cross = 2.0 * c * g_re;
    vec3 s_abs2 = c2 + w_abs + cross;
    vec3 p = c2 * w_abs + sin2_h * sin2_h;
    return patina_reflected(contrast_re, im, s_abs2, p, p + cross * sin2_h);
}

// The metal's reflectance, as far as it has tarnished.
vec3 patina_metal_F(Patina params, float cos_h, float sin2_h) {
    vec3 tint = mix(vec3(1.0), params.tarnish_tint, vec3(params.tarnish));
    return patina_F_conductor_half(cos_h, sin2_h, params.metal_eta, params.metal_k) * tint;
}

// a + b + c with the rounding error of a + b carried along (Knuth), for a c that cancels it.
float patina_sum3(float a, float b, float c) {
    float ab = a + b;
    float back = ab - a;
    float error = a - (ab - back) + (b - back);
    return ab + c + error;
}

// 1 - extentFactor, with all its digits: a sharp highlight counts however little of it is left.
float patina_bare(Patina params) {
    float rise = patina_sum3(params.growth, -params.extent, params.transition)
        / (2.0 * params.transition);
    float t = clamp(rise, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// extentFactor: 1 - smoothstep(extent - transition, extent + transition, growth).
float patina_grown(Patina params) {
    float rest = patina_sum3(params.extent, -params.growth, params.transition)
        / (2.0 * params.transition);
    float t = clamp(rest, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

float patina_metal_alpha(Patina params) {
    return patina_bare(params) * params.bare_alpha + patina_grown(params) * params.grown_alpha;
}

PatinaRoundGGX patina_bare_facets(Patina params) {
    return PatinaRoundGGX(patina_metal_alpha(params));
}

// Density of facets, in 1/sr. Walter et al., Eq. 33.
float patina_round_ggx_D(PatinaRoundGGX round_ggx, vec3 m) {
    const float inv_pi = 0.31830987;
    float a2 = round_ggx.alpha * round_ggx.alpha;
    float s = a2 + (1.0 - a2) * (m.x * m.x + m.y * m.y);
    return inv_pi * a2 / (s * s);
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
float patina_round_ggx_area(PatinaRoundGGX round_ggx, vec3 w) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrt(a2 + (1.0 - a2) * (w.z * w.z));
}

// G = 1 / (1 + Lambda_i + Lambda_o): correlated by the facet's height. Heitz 2014, Eq. 99.
float patina_V_smith_correlated(PatinaRoundGGX facets, vec3 wi, vec3 wo) {
    return 0.5 / (wo.z * patina_round_ggx_area(facets, wi)
        + wi.z * patina_round_ggx_area(facets, wo));
}

// D G / (4 mu_i mu_o); F is missing.
float patina_reflected_by(PatinaRoundGGX facets, vec3 wi, vec3 wo, vec3 m) {
    return patina_round_ggx_D(facets, m) * patina_V_smith_correlated(facets, wi, wo);
}

// Mean of the three channels, by which lobes are weighed against each other.
float patina_average(vec3 color) {
    return (color.x + color.y + color.z) / 3.0;
}

// The patina's index for refraction, the mean of its channels, minus 1.
float patina_excess(Patina params) {
    return patina_average(params.coat_eta - 1.0);
}

float patina_sin2(float cos_theta) {
    return (1.0 - cos_theta) * (1.0 + cos_theta);
}

// F of a conductor denser than the medium above, and 1 - F, exact where it nearly vanishes.
PatinaSplit patina_split_conductor(float cos_theta, vec3 eta, vec3 k) {
    const float ABSORPTION_MIN = 1.0e-17;
    // With eps = (eta + i k)^2 and g^2 = eps - 1 + c^2: 1 - R_s = 4 c Re(g) / |c + g|^2, and 1 - R_p is 4 c
    // Re(conj(g) eps) / |eps c + g|^2. The roots are those of F.
    float c = cos_theta;
    vec3 contrast_re = (eta - 1.0) * (eta + 1.0) - k * k;
    vec3 half_im = eta * k + ABSORPTION_MIN;
    vec3 eps_re = (eta - k) * (eta + k);
    vec3 eps_im = 2.0 * half_im;
    float c2 = c * c;
    float sin2 = patina_sin2(c);
    vec3 w_re = contrast_re + c2;
    vec3 w_abs = patina_size(w_re, eps_im);
    vec3 g2 = 0.5 * (w_abs + abs(w_re));
    vec3 inv = 1.0 / sqrt(g2);
    vec3 large = g2 * inv;
    vec3 small = half_im * inv;
    vec3 g_re = mix(small, large, greaterThan(w_re, vec3(0.0)));
    vec3 g_im = mix(large, small, greaterThan(w_re, vec3(0.0)));
    vec3 cross = 2.0 * c * g_re;
    vec3 s_abs2 = c2 + w_abs + cross;
    vec3 p = c2 * w_abs + sin2 * sin2;
    vec3 p_re = eps_re * c + g_re;
    vec3 p_im = eps_im * c + g_im;
    vec3 T_p = (eps_re * g_re + eps_im * g_im) / (p_re * p_re + p_im * p_im);
    vec3 F = patina_reflected(contrast_re, eps_im, s_abs2, p, p + cross * sin2);
    return PatinaSplit(F, 2.0 * c * (g_re / s_abs2 + T_p));
}

PatinaRoundGGX patina_facets(Patina params) {
    return PatinaRoundGGX(params.alpha);
}

// 2 mu Lambda, patina_round_ggx_area without mu, exact where it is little.
float patina_round_ggx_hidden(PatinaRoundGGX round_ggx, vec3 w) {
    // The difference would have few digits, which count beside a coat that transmits as little
    float rest = round_ggx.alpha * round_ggx.alpha * ((1.0 - w.z) * (1.0 + w.z));
    return rest / (patina_round_ggx_area(round_ggx, w) + w.z);
}

// 1 - G of patina_V_smith_correlated, exact where G is nearly 1.
float patina_lost_smith_correlated(PatinaRoundGGX facets, vec3 wi, vec3 wo) {
    float rest = wo.z * patina_round_ggx_hidden(facets, wi)
        + wi.z * patina_round_ggx_hidden(facets, wo);
    return 2.0 * rest * patina_V_smith_correlated(facets, wi, wo);
}

// T12 t of Eq. 2 and 4 with lost = 1 - G.
vec3 patina_past_facets(vec3 T, float lost) {
    // 1 - G F would lose the digits of a small T
    return T * (T + lost * (1.0 - T));
}

// T12 t of Eq. 2 and 4 with t = (1 - G) + T21 G, T21 = T12 = T at the half vector.
vec3 patina_through_facets(PatinaRoundGGX facets, vec3 wi, vec3 wo, vec3 T) {
    return patina_past_facets(T, patina_lost_smith_correlated(facets, wi, wo));
}

// eta^2 - 1.
float patina_contrast(float excess) {
    return excess * (2.0 + excess);
}

// eta^2 cos^2(theta_t) = mu^2 + eta^2 - 1.
float patina_eta2_cos2(float mu, float excess) {
    // mu^2 with its rounding error: at grazing angles little else is left
    return fma(mu, mu, patina_contrast(excess));
}

// The direction inside a layer with eta >= 1 that belongs to w outside.
vec3 patina_refract(vec3 w, float excess) {
    return vec3(w.x, w.y, sqrt(patina_eta2_cos2(w.z, excess))) * (1.0 / (1.0 + excess));
}

// exp(-sigma_a d (1 / mu_i + 1 / mu_o)): what is left of light after its way in and out (Bouguer).
//
// wi, wo: refracted directions. sigma_a: absorption per unit of the thickness d.
vec3 patina_attenuation(vec3 sigma_a, float thickness, vec3 wi, vec3 wo) {
    return exp(-sigma_a * (thickness * ((wi.z + wo.z) / (wi.z * wo.z))));
}

// eta times the sum of both refracted directions, which has their half vector's direction.
//
// Where the two are nearly mirrored the tangential parts cancel: they are summed before they are rounded by
// refraction, so that a sharp highlight below keeps its place.
vec3 patina_refracted_sum(vec3 wi, vec3 wo, float excess) {
    float z_i = patina_eta2_cos2(wi.z, excess);
    float z_o = patina_eta2_cos2(wo.z, excess);
    return vec3(wi.x + wo.x, wi.y + wo.y, sqrt(z_i) + sqrt(z_o));
}

// Squared sine at which refracted light meets a facet, from a difference before it is rounded.
float patina_refracted_sin2_half(vec3 wi, vec3 wo, float excess) {
    float z_i = patina_eta2_cos2(wi.z, excess);
    float z_o = patina_eta2_cos2(wo.z, excess);
    // A difference of two roots is that of their squares over their sum
    float z = (wi.z - wo.z) * (wi.z + wo.z) / (sqrt(z_i) + sqrt(z_o));
    vec3 apart = vec3(wi.x - wo.x, wi.y - wo.y, z) / (1.0 + excess);
    return 0.25 * dot(apart, apart);
}

// The metal's under the patina, at least as wide as those of the patina itself (Figure 2).
PatinaRoundGGX patina_facets_below(Patina params) {
    return PatinaRoundGGX(max(patina_metal_alpha(params), params.alpha));
}

// Eq. 2 with a coat that scatters.
vec3 patina_coated(Patina params, vec3 wi, vec3 wo) {
    const float inv_pi = 0.31830987;
    vec3 m = patina_half_vector(wi, wo);
    float cos_h = patina_cos_half(wi, wo);
    float excess = patina_excess(params);
    float index = 1.0 + excess;
    PatinaSplit surface = patina_split_conductor(cos_h, params.coat_eta, params.coat_k);
    PatinaRoundGGX facets = patina_facets(params);
    float glossy = patina_reflected_by(facets, wi, wo, m);
    vec3 coat = surface.F * glossy + (1.0 - params.sigma_a) * surface.T * inv_pi;

    vec3 through = patina_through_facets(facets, wi, wo, surface.T);
    through = through / (index * index);
    vec3 wi_t = patina_refract(wi, excess);
    vec3 wo_t = patina_refract(wo, excess);
    vec3 kept = patina_attenuation(params.sigma_a, params.thickness, wi_t, wo_t);
    vec3 both = patina_refracted_sum(wi, wo, excess);
    float cos_t = 0.5 * length(both) / index;
    vec3 F = patina_metal_F(params, cos_t, patina_refracted_sin2_half(wi, wo, excess));
    PatinaRoundGGX below = patina_facets_below(params);
    vec3 metal = F * patina_reflected_by(below, wi_t, wo_t, normalize(both));
    return coat + metal * through * kept;
}

// The bare and the coated metal, mixed: BRDF value in 1/sr, without the cosine.
vec3 patina_eval(Patina params, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3(0.0);
    }
    vec3 m = patina_half_vector(wi, wo);
    float cos_h = patina_cos_half(wi, wo);
    vec3 F = patina_metal_F(params, cos_h, patina_sin2_half(wi, wo));
    vec3 bare = F * patina_reflected_by(patina_bare_facets(params), wi, wo, m);
    return patina_bare(params) * bare + patina_grown(params) * patina_coated(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// A cosine at which light from anywhere meets the facets that it enters by, to choose lobes with.
//
// Halfway between wo.z (the mirror direction) and 1 (wi = wo): at grazing angles tilted facets let in more
// than the mean surface, whose transmittance is nearly 0 there.
float patina_usual_cos_half(vec3 wo) {
    return 0.5 + 0.5 * wo.z;
}

// The most that patina_attenuation leaves of light that goes out along wo: it came in along the normal.
vec3 patina_attenuation_least(vec3 sigma_a, float thickness, vec3 wo) {
    return patina_attenuation(sigma_a, thickness, vec3(0.0, 0.0, 1.0), wo);
}

float patina_raised(float probability) {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const float SHARE_LEAST = 0.1;
    const float ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
vec2 patina_lobes_shares(float first, float second) {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const float BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const float WEIGHT_MIN = 1.0e-37;
    float a = first + BLACK;
    float b = max(second, WEIGHT_MIN);
    float inv = 1.0 / (a + b);
    float P_first = patina_raised(a * inv);
    float P_second = patina_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return vec2(smaller ? P_first : 1.0 - P_second, smaller ? 1.0 - P_first : P_second);
}

// Probabilities: bare metal or patina; of that, surface or not; of the rest, diffuse or below.
PatinaShares patina_shares(Patina params, vec3 wo) {
    // Added to the weight of a lobe, so that the reciprocal of two black lobes' sum has a finite derivative.
    const float LOBE_MIN = 1.0e-12;
    float grown = patina_grown(params);
    vec3 wo_t = patina_refract(wo, patina_excess(params));
    float mu = wo.z;
    float sin2 = (1.0 - wo.z) * (1.0 + wo.z);
    vec3 F = patina_split_conductor(mu, params.coat_eta, params.coat_k).F;
    vec3 T = patina_split_conductor(patina_usual_cos_half(wo), params.coat_eta, params.coat_k).T;
    vec3 F_metal = patina_metal_F(params, mu, sin2);
    float bare = patina_bare(params) * patina_average(F_metal);
    float coat = grown * patina_average(F);
    float diffuse = grown * patina_average((1.0 - params.sigma_a) * T);
    vec3 kept = patina_attenuation_least(params.sigma_a, params.thickness, wo_t);
    float below = grown * patina_average(T * kept * F_metal) + LOBE_MIN;
    float inside = diffuse + below;
    vec2 P_bare = patina_lobes_shares(bare, coat + inside);
    vec2 P_coat = patina_lobes_shares(coat, inside);
    vec2 P_diffuse = patina_lobes_shares(diffuse, below);
    return PatinaShares(P_bare, P_coat, P_diffuse);
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
PatinaChoice patina_choose(float probability, vec2 u) {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const float SHARE_MIN = 1.0e-12;
    // The largest float32 below 1, up to which random numbers go.
    const float RANDOM_MAX = 0.99999994;
    bool first = u.x < probability;
    float below = u.x / max(probability, SHARE_MIN);
    float above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return PatinaChoice(first, vec2(clamp(first ? below : above, 0.0, RANDOM_MAX), u.y));
}

// w where all facets are those of a unit sphere.
vec3 patina_ggx_unstretched(PatinaGGX ggx, vec3 w) {
    return normalize(vec3(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
vec3 patina_ggx_half_way(PatinaGGX ggx, vec3 w, float drop, float z, float v) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(drop * (2.0 - drop), 0.0));
    float phi = two_pi * v;
    vec3 h = vec3(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(vec3(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
vec3 patina_ggx_sample_visible(PatinaGGX ggx, vec3 wo, vec2 u) {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const float RANDOM_MARGIN = 5.9604645e-8;
    vec3 w = patina_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    float u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    float height = 1.0 + w.z;
    return patina_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see patina_ggx_sample_visible.
vec3 patina_round_ggx_sample_visible(PatinaRoundGGX round_ggx, vec3 wo, vec2 u) {
    return patina_ggx_sample_visible(PatinaGGX(round_ggx.alpha, round_ggx.alpha), wo, u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
vec3 patina_mirror(vec3 wo, vec3 m) {
    return 2.0 * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
vec3 patina_sample_ggx_lobe(PatinaRoundGGX facets, vec3 wo, vec2 u) {
    vec3 w = patina_mirror(wo, patina_round_ggx_sample_visible(facets, wo, u));
    return vec3(w.x, w.y, abs(w.z));
}

// How far down the cap of visible normals goes that mirror wo above the horizon; 1: all the way.
//
// Eto and Tokuyoshi, Eq. 5 and 6; least: the smaller width, at most 1. No normal is left out that would
// mirror wo above the horizon. Of facets of one width 5 % at most of the others are left.
float patina_ggx_bound(float least, vec3 wo) {
    float s = 1.0 + sqrt(max(wo.x * wo.x + wo.y * wo.y, 0.0));
    float a2 = least * least;
    float s2 = s * s;
    return (1.0 - a2) * s2 / (s2 + a2 * wo.z * wo.z);
}

// A normal that wo sees, without those that mirror wo below the horizon, or most of them.
//
// Eto and Tokuyoshi, "Bounded VNDF sampling for Smith-GGX reflections", 2023; bound: see patina_ggx_bound.
vec3 patina_ggx_sample_bounded(PatinaGGX ggx, vec3 wo, vec2 u, float bound) {
    const float RANDOM_MARGIN = 5.9604645e-8;
    vec3 w = patina_ggx_unstretched(ggx, wo);
    float u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -bound w.z: z = 1 - u (1 + bound w.z), and z + w.z as a sum of positive terms
    float height = 1.0 + bound * w.z;
    return patina_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height + (1.0 - bound) * w.z, u.y);
}

// A normal that wo sees, without most that mirror wo downwards; see patina_ggx_sample_bounded.
vec3 patina_round_ggx_sample_bounded(PatinaRoundGGX round_ggx, vec3 wo, vec2 u, float bound) {
    return patina_ggx_sample_bounded(PatinaGGX(round_ggx.alpha, round_ggx.alpha), wo, u, bound);
}

// A facet's normal.
vec3 patina_sample_facet(PatinaRoundGGX facets, vec3 wo, vec2 u) {
    return patina_round_ggx_sample_bounded(facets, wo, u, patina_ggx_bound(facets.alpha, wo));
}

// Cosine inside the layer of the flattest direction that leaves it; 0 for eta <= 1.
float patina_critical_cosine(float excess) {
    return sqrt(max(patina_contrast(excess), 0.0)) / (1.0 + excess);
}

// The outer direction for a direction inside: refracted, or spread out if it cannot leave.
vec3 patina_leave(vec3 w, float excess) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    // Below this squared sine the azimuth of wo is taken as 0: any azimuth is right there, and the square of
    // its reciprocal still fits into a float32.
    const float SIN2_MIN = 1.0e-18;
    // Flattest direction that a sample leaves in: derivatives by the index fit in a float32 there.
    const float LEAVE_MIN = 1.0e-12;
    float k = patina_critical_cosine(excess);
    float eta = 1.0 + excess;
    bool refracted = w.z > k;
    float spread = min(w.z / max(k, mu_min), 1.0);
    // The sine from x and y: under many layers 1 - z^2 has few digits
    float sin2 = w.x * w.x + w.y * w.y;
    float z = refracted ? sqrt(max(1.0 - eta * eta * sin2, 0.0)) : spread;
    // Refracted sines are eta times as large, of which 1 - z^2 would leave no digits near the normal
    float spread_out = sqrt(max(1.0 - spread * spread, 0.0)) / sqrt(max(sin2, SIN2_MIN));
    float scale = refracted ? eta : spread_out;
    // A sample above the horizon stays there, however flat.
    z = w.z > 0.0 ? max(z, LEAVE_MIN) : -1.0;
    return normalize(vec3(w.x * scale, w.y * scale, z));
}

// A direction with density cos(theta) / pi.
vec3 patina_sample_cosine(vec2 u) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(u.x, 0.0));
    float phi = two_pi * u.y;
    return vec3(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// Density of wo mirrored at a visible normal m that a bound leaves, in 1/sr.
float patina_pdf_bounded(PatinaRoundGGX facets, vec3 wo, vec3 m, float bound) {
    return 0.5 * patina_round_ggx_D(facets, m) / (bound * wo.z + patina_round_ggx_area(facets, wo));
}

// Density of wo mirrored at patina_sample_facet, in 1/sr.
float patina_pdf_facet(PatinaRoundGGX facets, vec3 wo, vec3 m) {
    return patina_pdf_bounded(facets, wo, m, patina_ggx_bound(facets.alpha, wo));
}

// Density of what the metal below mirrors, inside the patina.
float patina_pdf_below(Patina params, vec3 wo_t, vec3 m) {
    return patina_pdf_facet(patina_facets_below(params), wo_t, m);
}

// The inner direction that patina_leave spreads to w; z = 0 for eta <= 1, which has none.
vec3 patina_gather(vec3 w, float excess) {
    const float SIN2_MIN = 1.0e-18;
    float k = patina_critical_cosine(excess);
    float z = k * w.z;
    float sin2 = w.x * w.x + w.y * w.y;
    float scale = sqrt(max(1.0 - z * z, 0.0)) / sqrt(max(sin2, SIN2_MIN));
    bool near = sin2 < SIN2_MIN;  // no azimuth: any is right
    float x = near ? sqrt(max(1.0 - z * z, 0.0)) : w.x * scale;
    return vec3(x, near ? 0.0 : w.y * scale, z);
}

// Density of patina_leave at w, from the inner density at w_t = refract(w) and at gather(w).
float patina_pdf_leave(float pdf_refracted, float pdf_gathered, vec3 w, vec3 w_t,
    float excess) {
    // Solid angle over cosine-weighted one: 1 / mu. Refraction shrinks the latter by eta^2, gathering by k^2,
    // and the cosines are k mu and mu.
    float eta = 1.0 + excess;
    return pdf_refracted * w.z / (eta * eta * w_t.z)
        + pdf_gathered * patina_critical_cosine(excess);
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
vec2 patina_slopes(vec3 h) {
    float inv = 1.0 / h.z;
    return vec2(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
float patina_tangent2(vec3 h) {
    vec2 t = patina_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
float patina_round_ggx_D_along(PatinaRoundGGX round_ggx, vec3 h) {
    const float inv_pi = 0.31830987;
    float a2 = round_ggx.alpha * round_ggx.alpha;
    float tan2 = patina_tangent2(h);
    float r = (1.0 + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// Density of patina_sample_ggx_lobe in 1/sr.
float patina_pdf_ggx_lobe(PatinaRoundGGX facets, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    float seen = 0.5 / (wo.z + patina_round_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    float straight = patina_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    bool exists = wo.z > wi.z;
    vec3 across = vec3(wi.x, wi.y, exists ? wo.z - wi.z : wi.z);
    float folded = patina_round_ggx_D_along(facets, across
        + vec3(wo.x, wo.y, exists ? mu_min : wo.z));
    return (straight + (exists ? folded : 0.0)) * seen;
}

// Density of patina_sample_cosine in 1/sr, for w above the horizon.
float patina_pdf_cosine(vec3 w) {
    const float inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Density of patina_sample in 1/sr.
float patina_pdf(Patina params, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    PatinaShares shares_result = patina_shares(params, wo);
    vec2 P_bare = shares_result.P_bare;
    vec2 P_coat = shares_result.P_coat;
    vec2 P_diffuse = shares_result.P_diffuse;
    float excess = patina_excess(params);
    vec3 wi_t = patina_refract(wi, excess);
    vec3 wo_t = patina_refract(wo, excess);
    float refracted = patina_pdf_below(params, wo_t,
        normalize(patina_refracted_sum(wi, wo, excess)));
    vec3 w = patina_gather(wi, excess);
    float gathered = patina_pdf_below(params, wo_t, patina_half_vector(w, wo_t));
    float below = patina_pdf_leave(refracted, gathered, wi, wi_t, excess);
    float coat = patina_pdf_ggx_lobe(patina_facets(params), wi, wo);
    float bare = patina_pdf_ggx_lobe(patina_bare_facets(params), wi, wo);
    float inside = P_diffuse.x * patina_pdf_cosine(wi) + P_diffuse.y * below;
    return P_bare.x * bare + P_bare.y * (P_coat.x * coat + P_coat.y * inside);
}

// One of the bare metal, the patina's surface, its diffuse part, and the metal below.
PatinaSample patina_sample(Patina params, vec3 wo, vec2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return PatinaSample(vec3(0.0, 0.0, 1.0), 0.0);
    }
    PatinaShares shares_result = patina_shares(params, wo);
    vec2 P_bare = shares_result.P_bare;
    vec2 P_coat = shares_result.P_coat;
    vec2 P_diffuse = shares_result.P_diffuse;
    float excess = patina_excess(params);
    PatinaChoice choose_result = patina_choose(P_bare.x, u);
    bool on_bare = choose_result.is_first;
    vec2 v = choose_result.u;
    PatinaChoice choose_result_2 = patina_choose(P_coat.x, v);
    bool on_coat = choose_result_2.is_first;
    vec2 s = choose_result_2.u;
    PatinaChoice choose_result_3 = patina_choose(P_diffuse.x, s);
    bool on_diffuse = choose_result_3.is_first;
    vec2 t = choose_result_3.u;
    vec3 w_bare = patina_sample_ggx_lobe(patina_bare_facets(params), wo, v);
    vec3 w_coat = patina_sample_ggx_lobe(patina_facets(params), wo, s);
    vec3 wo_t = patina_refract(wo, excess);
    vec3 m = patina_sample_facet(patina_facets_below(params), wo_t, t);
    vec3 w_below = patina_leave(patina_mirror(wo_t, m), excess);
    vec3 w_patina = mix(mix(w_below, patina_sample_cosine(t), bvec3(on_diffuse)), w_coat,
        bvec3(on_coat));
    vec3 wi = on_bare ? w_bare : w_patina;
    return PatinaSample(wi, patina_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
vec3 patina_albedo(Patina params, vec3 wo) {
    // Steps of the rule in patina_albedo: a Fibonacci number, and the golden ratio.
    const float ALBEDO_SAMPLES = 987.0;
    const float GOLDEN = 0.618034;
    // Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
    const float HORIZON = 1.0e-6;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z < 0.0) {  // below the horizon
        return vec3(0.0);
    }
    vec3 w = vec3(wo.x, wo.y, max(wo.z, HORIZON));
    vec3 total = vec3(0.0);
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        vec2 u = vec2((i + 0.5) / ALBEDO_SAMPLES, fract((i + 0.5) * GOLDEN));
        PatinaSample drawn = patina_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + patina_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
