// SPDX-License-Identifier: Apache-2.0
// Car paint: metal flakes of all directions under a tinted clear coat.
//
// Source: Elek, "Layered materials in real-time rendering", CESCG 2010, section 4.1: the layered model of
// `weidlich_wilkie` over a metal whose normal alone is perturbed by a map of flakes, tiled and unfiltered.
// `gonio.mitsuba.textures.flake_map` makes such maps. Spatial variation is the host's business: flake_x and
// flake_y are numbers here, and a texture gives each point its own.
// Deviations: by default light that leaves the coat spreads by 1 / eta^2, without which the metal is
// eta^2 times too bright; both crossings of the surface count at the mean normal, because 1 - F(wo.H)
// lets too much of a tilted flake's light through; and a flake counts as much as both light and viewer
// see of it, so that the model stays reciprocal. Facets are GGX's with Smith's masking instead of
// Beckmann's with V-cavities, F is exact instead of Lazanyi's fit, the coat absorbs along paths through
// the mean surface instead of the flake, and a flake counts as much as the normal above it instead of
// half as much. Options restore each of these. No option restores that Algorithm 1 weighs what the metal
// reflects by the cosine outside, which the light that is shone on it has already. The metal's index is
// taken relative to the coat.
//
// GLSL 4.5, made by gonio from gonio/models/car_paint.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: CarPaint params; params.eta = ...; ... car_paint_eval(params, wi, wo)

// A sampled direction and its density.
struct CarPaintSample {
    vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// car_paint: One flake's worth of metallic paint; a map of flakes makes it sparkle. Reciprocal.
// Exported with transmission='both_ways', solid_angle='compressed',
// distribution='ggx', masking='smith_correlated', fresnel='exact',
// absorption='surface', tilt='distance', flake_cosine='reciprocal'.
struct CarPaint {
    float eta;  // index of the clear coat; 1 to 3, default 1.5
    float alpha;  // slope width of the coat's facets; 0.0001 to 1, default 0.03
    // absorption of the coat per unit of thickness; 0 to 10, default (0.15, 1.2, 1.4)
    vec3 sigma_a;
    float thickness;  // thickness of the coat, in the unit of sigma_a; 0 to 1, default 1
    // the flakes' index; the default is chromium; 0.01 to 20, default (3.626635, 3.075734, 1.820037)
    vec3 metal_eta;
    vec3 metal_k;  // the flakes' extinction; 0 to 20, default (4.32121, 4.462329, 4.12937)
    float metal_alpha;  // slope width of each flake, at least the coat's; 0.0001 to 1, default 0.15
    float flake_x;  // slope of the flake's normal along x; for a texture; -2 to 2, default 0
    float flake_y;  // slope of the flake's normal along y; for a texture; -2 to 2, default 0
    float distance;  // of the viewer; above 1 it evens out the flakes; 0 to 1000000, default 1
};

// Facets of GGX with the same width in all directions.
struct CarPaintRoundGGX {
    float alpha;  // width of the slopes
};

// What becomes of light at the surface of something denser.
struct CarPaintEntering {
    float F;  // Is reflected
    float T;  // Enters
};

// Which of two lobes a sample is taken from.
struct CarPaintChoice {
    bool is_first;  // Whether it is the first one
    vec2 u;  // Fresh random numbers, made of those that chose
};

// Facets of GGX, also called Trowbridge-Reitz.
struct CarPaintGGX {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
float car_paint_length2(vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
vec3 car_paint_half_vector(vec3 wi, vec3 wo) {
    // wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
    // squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
    // much longer.
    const float LENGTHENED = 1.0995116e12;
    vec3 h = LENGTHENED * (wi + wo);
    return h / sqrt(car_paint_length2(h));  // the root is the cosine's as well
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
float car_paint_cos_half(vec3 wi, vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(car_paint_length2(wi + wo));
}

CarPaintRoundGGX car_paint_facets(CarPaint params) {
    return CarPaintRoundGGX(params.alpha);
}

// eta^2 cos^2(theta_t) = mu^2 + eta^2 - 1; negative where light is reflected totally.
float car_paint_refracted_cos2(float mu, float eta) {
    // The difference of two squares as a product, and mu^2 with its rounding error: at grazing angles, and at
    // the critical one, little else is left.
    return fma(mu, mu, (eta - 1.0) * (eta + 1.0));
}

// F and T = 1 - F of a smooth dielectric with eta >= 1 at a cosine mu outside, mu > 0.
CarPaintEntering car_paint_split_entering(float mu, float eta) {
    // r_s = (1 - eta^2) / s^2 with s = c + g, and r_p = r_s (c g - sin2) / q with q = c g + sin2. So 1 - r_s^2
    // = 4 c g / s^2, and 1 - r_p^2 = 4 c g eta^2 / (s q)^2. One quotient serves all.
    float c = mu;
    float g = sqrt(car_paint_refracted_cos2(c, eta));
    float s = c + g;
    float p = c * g;
    float sin2 = 1.0 - c * c;
    float q = p + sin2;
    float s2 = s * s;
    float q2 = q * q;
    float inv = 1.0 / (s2 * q2);
    float r_s = (eta - 1.0) * (eta + 1.0) * (q2 * inv);
    float F = r_s * r_s * ((p * p + sin2 * sin2) * (s2 * inv));
    return CarPaintEntering(F, p * inv * (2.0 * (q2 + eta * eta)));
}

// Exact reflectance of a dielectric with eta >= 1, never total, at a cosine outside, mu > 0.
float car_paint_F_dielectric_entering(float mu, float eta) {
    return car_paint_split_entering(mu, eta).F;
}

// Density of facets, in 1/sr. Walter et al., Eq. 33.
float car_paint_round_ggx_D(CarPaintRoundGGX round_ggx, vec3 m) {
    const float inv_pi = 0.31830987;
    float a2 = round_ggx.alpha * round_ggx.alpha;
    float s = a2 + (1.0 - a2) * (m.x * m.x + m.y * m.y);
    return inv_pi * a2 / (s * s);
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
float car_paint_round_ggx_area(CarPaintRoundGGX round_ggx, vec3 w) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrt(a2 + (1.0 - a2) * (w.z * w.z));
}

// G = 1 / (1 + Lambda_i + Lambda_o): correlated by the facet's height. Heitz 2014, Eq. 99.
float car_paint_V_smith_correlated(CarPaintRoundGGX facets, vec3 wi, vec3 wo) {
    return 0.5 / (wo.z * car_paint_round_ggx_area(facets, wi)
        + wi.z * car_paint_round_ggx_area(facets, wo));
}

// D G / (4 mu_i mu_o); F is missing.
float car_paint_reflected_by(CarPaintRoundGGX facets, vec3 wi, vec3 wo, vec3 m) {
    return car_paint_round_ggx_D(facets, m) * car_paint_V_smith_correlated(facets, wi, wo);
}

// 1 - F of a smooth dielectric with eta >= 1 at a cosine mu outside; exact where it nearly vanishes.
float car_paint_transmittance_entering(float mu, float eta) {
    return car_paint_split_entering(mu, eta).T;
}

// eta^2 - 1.
float car_paint_contrast(float excess) {
    return excess * (2.0 + excess);
}

// eta^2 cos^2(theta_t) = mu^2 + eta^2 - 1.
float car_paint_eta2_cos2(float mu, float excess) {
    // mu^2 with its rounding error: at grazing angles little else is left
    return fma(mu, mu, car_paint_contrast(excess));
}

// The direction inside a layer with eta >= 1 that belongs to w outside.
vec3 car_paint_refract(vec3 w, float excess) {
    return vec3(w.x, w.y, sqrt(car_paint_eta2_cos2(w.z, excess))) * (1.0 / (1.0 + excess));
}

// eta times the sum of both refracted directions, which has their half vector's direction.
//
// Where the two are nearly mirrored the tangential parts cancel: they are summed before they are rounded by
// refraction, so that a sharp highlight below keeps its place.
vec3 car_paint_refracted_sum(vec3 wi, vec3 wo, float excess) {
    float z_i = car_paint_eta2_cos2(wi.z, excess);
    float z_o = car_paint_eta2_cos2(wo.z, excess);
    return vec3(wi.x + wo.x, wi.y + wo.y, sqrt(z_i) + sqrt(z_o));
}

// Squared sine at which refracted light meets a facet, from a difference before it is rounded.
float car_paint_refracted_sin2_half(vec3 wi, vec3 wo, float excess) {
    float z_i = car_paint_eta2_cos2(wi.z, excess);
    float z_o = car_paint_eta2_cos2(wo.z, excess);
    // A difference of two roots is that of their squares over their sum
    float z = (wi.z - wo.z) * (wi.z + wo.z) / (sqrt(z_i) + sqrt(z_o));
    vec3 apart = vec3(wi.x - wo.x, wi.y - wo.y, z) / (1.0 + excess);
    return 0.25 * dot(apart, apart);
}

// |re + i im| for im of at least 2 ABSORPTION_MIN.
vec3 car_paint_size(vec3 re, vec3 im) {
    return sqrt(re * re + im * im);
}

// |re + i im|^2 / s2^2 p / q.
vec3 car_paint_reflected(vec3 re, vec3 im, vec3 s2, vec3 p, vec3 q) {
    // In two quotients, as the square of s2 is 1e-34 for a matched index in the horizon
    return (re * re + im * im) / s2 * (p / (s2 * q));
}

// Exact reflectance of a conductor, eta + i k, from cosine and squared sine at a facet.
vec3 car_paint_F_conductor_half(float cos_h, float sin2_h, vec3 eta, vec3 k) {
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
    vec3 w_abs = car_paint_size(w_re, im);
    // Of the two parts of the root, the larger has no cancellation; the smaller follows from it.
    vec3 g2 = 0.5 * (w_abs + abs(w_re));
    vec3 g_re = mix(half_im, g2, greaterThan(w_re, vec3(0.0))) * (1.0 / sqrt(g2));
    // |c + g|^2 = c^2 + |w| + cross, and |c g -+ sin2_h|^2 = p -+ cross sin2_h
    vec3 cross = 2.0 * c * g_re;
    vec3 s_abs2 = c2 + w_abs + cross;
    vec3 p = c2 * w_abs + sin2_h * sin2_h;
    return car_paint_reflected(contrast_re, im, s_abs2, p, p + cross * sin2_h);
}

// normalize(N_flake + max(distance, 1) N) with N_flake = normalize(slope_x, slope_y, 1).
//
// Elek, "Layered materials in real-time rendering", CESCG 2010, section 4.1: flakes that cannot be told
// apart any more even out.
vec3 car_paint_flake_normal(float slope_x, float slope_y, float distance) {
    vec3 flake = normalize(vec3(slope_x, slope_y, 1.0));
    return normalize(vec3(flake.x, flake.y, flake.z + max(distance, 1.0)));
}

// s = cos(phi_i - phi_o) sin(theta_i) sin(theta_o), the inner product of the tangential parts.
//
// It is divided by cosines that may be tiny, so its last bits count: the rounding error of one
// product is carried along (Kahan), which plain wi.x wo.x + wi.y wo.y or dot(wi, wo) - mu_i mu_o loses.
float car_paint_tangential_dot(vec3 wi, vec3 wo) {
    float q = wi.y * wo.y;
    float error = fma(wi.y, wo.y, -q);
    return fma(wi.x, wo.x, q) + error;
}

// w in the frame of n, turned there the shortest way; n.z > 0.
vec3 car_paint_to_tilted(vec3 w, vec3 n) {
    // Its sign decides whether the surface is seen at all: the last digits count.
    float z = car_paint_tangential_dot(w, n) + w.z * n.z;
    float along = (z + w.z) / (n.z + 1.0);
    return vec3(w.x - along * n.x, w.y - along * n.y, z);
}

// w, or the flake's normal in place of a direction behind it, which is masked elsewhere.
vec3 car_paint_facing(vec3 w) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    return mix(vec3(0.0, 0.0, 1.0), w, bvec3(w.z > mu_min));
}

// How much of a tilted facet a direction sees, at most as much as of the flat surface.
float car_paint_seen(float cos_tilted, float mu) {
    return min(max(cos_tilted, 0.0) / mu, 1.0);
}

CarPaintRoundGGX car_paint_flake_facets(CarPaint params) {
    return CarPaintRoundGGX(max(params.metal_alpha, params.alpha));
}

// The flake's facets in its own frame; both: eta times the sum of the directions.
float car_paint_flake(CarPaint params, vec3 wi_t, vec3 wo_t, vec3 both) {
    vec3 n = car_paint_flake_normal(params.flake_x, params.flake_y, params.distance);
    vec3 tilted_i = car_paint_to_tilted(wi_t, n);
    vec3 tilted_o = car_paint_to_tilted(wo_t, n);
    vec3 wi = car_paint_facing(tilted_i);
    vec3 wo = car_paint_facing(tilted_o);
    float visible = car_paint_seen(tilted_i.z, wi_t.z) * car_paint_seen(tilted_o.z, wo_t.z);
    vec3 m = normalize(car_paint_to_tilted(both, n));
    float f = car_paint_reflected_by(car_paint_flake_facets(params), wi, wo, m);
    return tilted_o.z > 0.0 ? f * visible : 0.0;
}

// exp(-sigma_a d (1 / mu_i + 1 / mu_o)): what is left of light after its way in and out (Bouguer).
//
// wi, wo: refracted directions. sigma_a: absorption per unit of the thickness d.
vec3 car_paint_attenuation(vec3 sigma_a, float thickness, vec3 wi, vec3 wo) {
    return exp(-sigma_a * (thickness * ((wi.z + wo.z) / (wi.z * wo.z))));
}

// Eq. 2 with a tilted base: BRDF value in 1/sr, without the cosine.
vec3 car_paint_eval(CarPaint params, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3(0.0);
    }
    vec3 m = car_paint_half_vector(wi, wo);
    float cos_h = car_paint_cos_half(wi, wo);
    CarPaintRoundGGX facets = car_paint_facets(params);
    float coat = car_paint_F_dielectric_entering(cos_h, params.eta)
        * car_paint_reflected_by(facets, wi, wo, m);

    float through = car_paint_transmittance_entering(wi.z, params.eta)
        * car_paint_transmittance_entering(wo.z, params.eta);
    through = through / (params.eta * params.eta);
    float excess = params.eta - 1.0;
    vec3 wi_t = car_paint_refract(wi, excess);
    vec3 wo_t = car_paint_refract(wo, excess);
    vec3 both = car_paint_refracted_sum(wi, wo, excess);
    float cos_t = 0.5 * length(both) / params.eta;
    vec3 metal_eta = params.metal_eta / params.eta;
    vec3 metal_k = params.metal_k / params.eta;
    float sin2_t = car_paint_refracted_sin2_half(wi, wo, excess);
    vec3 F = car_paint_F_conductor_half(cos_t, sin2_t, metal_eta, metal_k);
    vec3 flake = F * car_paint_flake(params, wi_t, wo_t, both);
    return coat + flake * (car_paint_attenuation(params.sigma_a, params.thickness, wi_t, wo_t)
        * through);
}

// ---- sampling ------------------------------------------------------------------------------

// The most that car_paint_attenuation leaves of light that goes out along wo: it came in along the normal.
vec3 car_paint_attenuation_least(vec3 sigma_a, float thickness, vec3 wo) {
    return car_paint_attenuation(sigma_a, thickness, vec3(0.0, 0.0, 1.0), wo);
}

// Mean of the three channels, by which lobes are weighed against each other.
float car_paint_average(vec3 color) {
    return (color.x + color.y + color.z) / 3.0;
}

float car_paint_raised(float probability) {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const float SHARE_LEAST = 0.1;
    const float ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
vec2 car_paint_lobes_shares(float first, float second) {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const float BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const float WEIGHT_MIN = 1.0e-37;
    float a = first + BLACK;
    float b = max(second, WEIGHT_MIN);
    float inv = 1.0 / (a + b);
    float P_first = car_paint_raised(a * inv);
    float P_second = car_paint_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return vec2(smaller ? P_first : 1.0 - P_second, smaller ? 1.0 - P_first : P_second);
}

// Probabilities of the coat and of the flake.
vec2 car_paint_shares(CarPaint params, vec3 wo, vec3 wo_t) {
    // The coat gets at least a tenth as many samples as the metal: facets reflect more than the mean surface
    // where they are tilted, and this bounds their weight.
    const float COAT_SHARE_MIN = 0.1;
    // Added to the weight of a lobe, so that the reciprocal of two black lobes' sum has a finite derivative.
    const float LOBE_MIN = 1.0e-12;
    float mu = wo.z;
    float below = car_paint_transmittance_entering(mu, params.eta)
        * car_paint_average(car_paint_attenuation_least(params.sigma_a, params.thickness, wo_t));
    vec3 tilted = car_paint_to_tilted(wo_t,
        car_paint_flake_normal(params.flake_x, params.flake_y, params.distance));
    float lit = below * car_paint_seen(tilted.z, wo_t.z);
    float F = car_paint_F_dielectric_entering(wo.z, params.eta);
    float coat = max(F, COAT_SHARE_MIN * below + LOBE_MIN);
    return car_paint_lobes_shares(coat, lit);
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
CarPaintChoice car_paint_choose(float probability, vec2 u) {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const float SHARE_MIN = 1.0e-12;
    // The largest float32 below 1, up to which random numbers go.
    const float RANDOM_MAX = 0.99999994;
    bool first = u.x < probability;
    float below = u.x / max(probability, SHARE_MIN);
    float above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return CarPaintChoice(first, vec2(clamp(first ? below : above, 0.0, RANDOM_MAX), u.y));
}

// w where all facets are those of a unit sphere.
vec3 car_paint_ggx_unstretched(CarPaintGGX ggx, vec3 w) {
    return normalize(vec3(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
vec3 car_paint_ggx_half_way(CarPaintGGX ggx, vec3 w, float drop, float z, float v) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(drop * (2.0 - drop), 0.0));
    float phi = two_pi * v;
    vec3 h = vec3(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(vec3(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
vec3 car_paint_ggx_sample_visible(CarPaintGGX ggx, vec3 wo, vec2 u) {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const float RANDOM_MARGIN = 5.9604645e-8;
    vec3 w = car_paint_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    float u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    float height = 1.0 + w.z;
    return car_paint_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see car_paint_ggx_sample_visible.
vec3 car_paint_round_ggx_sample_visible(CarPaintRoundGGX round_ggx, vec3 wo, vec2 u) {
    return car_paint_ggx_sample_visible(CarPaintGGX(round_ggx.alpha, round_ggx.alpha), wo, u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
vec3 car_paint_mirror(vec3 wo, vec3 m) {
    return 2.0 * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
vec3 car_paint_sample_ggx_lobe(CarPaintRoundGGX facets, vec3 wo, vec2 u) {
    vec3 w = car_paint_mirror(wo, car_paint_round_ggx_sample_visible(facets, wo, u));
    return vec3(w.x, w.y, abs(w.z));
}

// How far down the cap of visible normals goes that mirror wo above the horizon; 1: all the way.
//
// Eto and Tokuyoshi, Eq. 5 and 6; least: the smaller width, at most 1. No normal is left out that would
// mirror wo above the horizon. Of facets of one width 5 % at most of the others are left.
float car_paint_ggx_bound(float least, vec3 wo) {
    float s = 1.0 + sqrt(max(wo.x * wo.x + wo.y * wo.y, 0.0));
    float a2 = least * least;
    float s2 = s * s;
    return (1.0 - a2) * s2 / (s2 + a2 * wo.z * wo.z);
}

// A normal that wo sees, without those that mirror wo below the horizon, or most of them.
//
// Eto and Tokuyoshi, "Bounded VNDF sampling for Smith-GGX reflections", 2023; bound:
// see car_paint_ggx_bound.
vec3 car_paint_ggx_sample_bounded(CarPaintGGX ggx, vec3 wo, vec2 u, float bound) {
    const float RANDOM_MARGIN = 5.9604645e-8;
    vec3 w = car_paint_ggx_unstretched(ggx, wo);
    float u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -bound w.z: z = 1 - u (1 + bound w.z), and z + w.z as a sum of positive terms
    float height = 1.0 + bound * w.z;
    return car_paint_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height + (1.0 - bound) * w.z,
        u.y);
}

// A normal that wo sees, without most that mirror wo downwards; see car_paint_ggx_sample_bounded.
vec3 car_paint_round_ggx_sample_bounded(CarPaintRoundGGX round_ggx, vec3 wo, vec2 u,
    float bound) {
    return car_paint_ggx_sample_bounded(CarPaintGGX(round_ggx.alpha, round_ggx.alpha), wo, u,
        bound);
}

// A facet's normal.
vec3 car_paint_sample_facet(CarPaintRoundGGX facets, vec3 wo, vec2 u) {
    return car_paint_round_ggx_sample_bounded(facets, wo, u, car_paint_ggx_bound(facets.alpha, wo));
}

// The inverse of car_paint_to_tilted.
vec3 car_paint_from_tilted(vec3 w, vec3 n) {
    return car_paint_to_tilted(w, vec3(-n.x, -n.y, n.z));
}

// Cosine inside the layer of the flattest direction that leaves it; 0 for eta <= 1.
float car_paint_critical_cosine(float excess) {
    return sqrt(max(car_paint_contrast(excess), 0.0)) / (1.0 + excess);
}

// The outer direction for a direction inside: refracted, or spread out if it cannot leave.
vec3 car_paint_leave(vec3 w, float excess) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    // Below this squared sine the azimuth of wo is taken as 0: any azimuth is right there, and the square of
    // its reciprocal still fits into a float32.
    const float SIN2_MIN = 1.0e-18;
    // Flattest direction that a sample leaves in: derivatives by the index fit in a float32 there.
    const float LEAVE_MIN = 1.0e-12;
    float k = car_paint_critical_cosine(excess);
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

// Density of wo mirrored at a visible normal m that a bound leaves, in 1/sr.
float car_paint_pdf_bounded(CarPaintRoundGGX facets, vec3 wo, vec3 m, float bound) {
    return 0.5 * car_paint_round_ggx_D(facets, m)
        / (bound * wo.z + car_paint_round_ggx_area(facets, wo));
}

// Density of wo mirrored at car_paint_sample_facet, in 1/sr.
float car_paint_pdf_facet(CarPaintRoundGGX facets, vec3 wo, vec3 m) {
    return car_paint_pdf_bounded(facets, wo, m, car_paint_ggx_bound(facets.alpha, wo));
}

// Density inside the coat of the flake's part of car_paint_sample; both: along the half vector.
float car_paint_pdf_flake(CarPaint params, vec3 wi_t, vec3 wo_t, vec3 both) {
    vec3 n = car_paint_flake_normal(params.flake_x, params.flake_y, params.distance);
    vec3 tilted_i = car_paint_to_tilted(wi_t, n);
    vec3 tilted_o = car_paint_to_tilted(wo_t, n);
    vec3 m = normalize(car_paint_to_tilted(both, n));
    vec3 facing = car_paint_facing(tilted_o);
    float density = car_paint_pdf_facet(car_paint_flake_facets(params), facing, m);
    // Of a viewer behind the flake the half vector may be behind it as well, where no facet looks
    return tilted_i.z > 0.0 && wi_t.z > 0.0 && m.z > 0.0 ? density : 0.0;
}

// The inner direction that car_paint_leave spreads to w; z = 0 for eta <= 1, which has none.
vec3 car_paint_gather(vec3 w, float excess) {
    const float SIN2_MIN = 1.0e-18;
    float k = car_paint_critical_cosine(excess);
    float z = k * w.z;
    float sin2 = w.x * w.x + w.y * w.y;
    float scale = sqrt(max(1.0 - z * z, 0.0)) / sqrt(max(sin2, SIN2_MIN));
    bool near = sin2 < SIN2_MIN;  // no azimuth: any is right
    float x = near ? sqrt(max(1.0 - z * z, 0.0)) : w.x * scale;
    return vec3(x, near ? 0.0 : w.y * scale, z);
}

// Density of car_paint_leave at w, from the inner density at w_t = refract(w) and at gather(w).
float car_paint_pdf_leave(float pdf_refracted, float pdf_gathered, vec3 w, vec3 w_t,
    float excess) {
    // Solid angle over cosine-weighted one: 1 / mu. Refraction shrinks the latter by eta^2, gathering by k^2,
    // and the cosines are k mu and mu.
    float eta = 1.0 + excess;
    return pdf_refracted * w.z / (eta * eta * w_t.z)
        + pdf_gathered * car_paint_critical_cosine(excess);
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
vec2 car_paint_slopes(vec3 h) {
    float inv = 1.0 / h.z;
    return vec2(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
float car_paint_tangent2(vec3 h) {
    vec2 t = car_paint_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
float car_paint_round_ggx_D_along(CarPaintRoundGGX round_ggx, vec3 h) {
    const float inv_pi = 0.31830987;
    float a2 = round_ggx.alpha * round_ggx.alpha;
    float tan2 = car_paint_tangent2(h);
    float r = (1.0 + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// Density of car_paint_sample_ggx_lobe in 1/sr.
float car_paint_pdf_ggx_lobe(CarPaintRoundGGX facets, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    float seen = 0.5 / (wo.z + car_paint_round_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    float straight = car_paint_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    bool exists = wo.z > wi.z;
    vec3 across = vec3(wi.x, wi.y, exists ? wo.z - wi.z : wi.z);
    float folded = car_paint_round_ggx_D_along(facets, across
        + vec3(wo.x, wo.y, exists ? mu_min : wo.z));
    return (straight + (exists ? folded : 0.0)) * seen;
}

// Density of car_paint_sample in 1/sr.
float car_paint_pdf(CarPaint params, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    float excess = params.eta - 1.0;
    vec3 wi_t = car_paint_refract(wi, excess);
    vec3 wo_t = car_paint_refract(wo, excess);
    float refracted = car_paint_pdf_flake(params, wi_t, wo_t,
        car_paint_refracted_sum(wi, wo, excess));
    vec3 w = car_paint_gather(wi, excess);
    float gathered = car_paint_pdf_flake(params, w, wo_t, w + wo_t);
    float below = car_paint_pdf_leave(refracted, gathered, wi, wi_t, excess);
    float coat = car_paint_pdf_ggx_lobe(car_paint_facets(params), wi, wo);
    vec2 P = car_paint_shares(params, wo, wo_t);
    return P.x * coat + P.y * below;
}

// Normals of the coat, or of the flake and then out through the coat.
CarPaintSample car_paint_sample(CarPaint params, vec3 wo, vec2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return CarPaintSample(vec3(0.0, 0.0, 1.0), 0.0);
    }
    vec3 n = car_paint_flake_normal(params.flake_x, params.flake_y, params.distance);
    vec3 wo_t = car_paint_refract(wo, params.eta - 1.0);
    CarPaintChoice choose_result = car_paint_choose(car_paint_shares(params, wo, wo_t).x, u);
    bool on_coat = choose_result.is_first;
    vec2 v = choose_result.u;
    vec3 w_coat = car_paint_sample_ggx_lobe(car_paint_facets(params), wo, v);
    vec3 tilted = car_paint_facing(car_paint_to_tilted(wo_t, n));
    vec3 m = car_paint_sample_facet(car_paint_flake_facets(params), tilted, v);
    vec3 flake = car_paint_mirror(tilted, m);
    // What the flake mirrors behind itself is wasted.
    vec3 w_flake = car_paint_leave(mix(vec3(0.0, 0.0, -1.0), car_paint_from_tilted(flake, n),
        bvec3(flake.z > 0.0)), params.eta - 1.0);
    vec3 wi = on_coat ? w_coat : w_flake;
    return CarPaintSample(wi, car_paint_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
vec3 car_paint_albedo(CarPaint params, vec3 wo) {
    // Steps of the rule in car_paint_albedo: a Fibonacci number, and the golden ratio.
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
        CarPaintSample drawn = car_paint_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + car_paint_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
