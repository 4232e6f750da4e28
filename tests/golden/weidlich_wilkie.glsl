// SPDX-License-Identifier: Apache-2.0
// Weidlich-Wilkie: a rough clear coat over any base, which may be coated itself.
//
// Source: Elek, "Layered materials in real-time rendering", CESCG 2010, Eq. 2 to 4 and Algorithm 1, after
// Weidlich, Wilkie, "Arbitrarily layered micro-facet surfaces", GRAPHITE 2007. Symbols are Elek's.
// Deviations: refracted directions keep the azimuth of the ones they belong to (Algorithm 1 mirrors them at
// the normal, which would turn an anisotropic base by 180 degrees); F is exact by default, not
// Lazanyi's fit;
// D carries the 1 / pi that Elek's lacks; a coloured coat, which has an index and an extinction for each
// channel as in Algorithm 1, refracts by one index. What Eq. 2 leaves out can be switched on: Fresnel's
// reflection at both crossings, the compression of solid angles, and the light that bounces between
// base and
// surface.
//
// Lambert: ideal diffuse reflection.
//
// Source: Johann Heinrich Lambert, "Photometria", 1760.
//
// GLSL 4.5, made by gonio from gonio/models/weidlich_wilkie.py, gonio/models/lambert.py; free to use under
// Apache-2.0. wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: WeidlichWilkie params; params.eta = ...; ... weidlich_wilkie_eval(params, wi, wo)

// A sampled direction and its density.
struct WeidlichWilkieSample {
    vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// Parameters of lambert: Ideal diffuse: the same radiance in every direction. Reciprocal; the albedo
// is rho.
struct WeidlichWilkieBase {
    vec3 rho;  // albedo, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
};

// weidlich_wilkie: A clear, tinted coat over any base; nest it for more layers. Reciprocal if the base is.
// Exported with interface='rough', distribution='beckmann', masking='cook_torrance', fresnel='exact',
// transmission='half_vector', solid_angle='none', bounces='none', roughness_clamp='on'.
struct WeidlichWilkie {
    float eta;  // index of the coat over that of the medium above it; 1 to 3, default 1.5
    float alpha;  // slope width of the coat's facets; unused when smooth; 0.0001 to 1, default 0.1
    vec3 sigma_a;  // absorption of the coat per unit of thickness; 0 to 10, default (0, 0, 0)
    float thickness;  // thickness of the coat, in the unit of sigma_a; 0 to 1, default 1
    WeidlichWilkieBase base;  // what lies below; its indices are relative to the coat
};

// What becomes of light at the surface of something denser.
struct WeidlichWilkieEntering {
    float F;  // Is reflected
    float T;  // Enters
};

// Beckmann's facets with the same width in all directions.
struct WeidlichWilkieRoundBeckmann {
    float alpha;  // width of the slopes
};

// Which of two lobes a sample is taken from.
struct WeidlichWilkieChoice {
    bool is_first;  // Whether it is the first one
    vec2 u;  // Fresh random numbers, made of those that chose
};

// Beckmann's facets: slopes with a normal distribution of variance alpha^2 / 2.
struct WeidlichWilkieBeckmann {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// ---- evaluation ----------------------------------------------------------------------------

// eta^2 - 1.
float weidlich_wilkie_contrast(float excess) {
    return excess * (2.0 + excess);
}

// eta^2 cos^2(theta_t) = mu^2 + eta^2 - 1.
float weidlich_wilkie_eta2_cos2(float mu, float excess) {
    // mu^2 with its rounding error: at grazing angles little else is left
    return fma(mu, mu, weidlich_wilkie_contrast(excess));
}

// The direction inside a layer with eta >= 1 that belongs to w outside.
vec3 weidlich_wilkie_refract(vec3 w, float excess) {
    return vec3(w.x, w.y, sqrt(weidlich_wilkie_eta2_cos2(w.z, excess))) * (1.0 / (1.0 + excess));
}

// exp(-sigma_a d (1 / mu_i + 1 / mu_o)): what is left of light after its way in and out (Bouguer).
//
// wi, wo: refracted directions. sigma_a: absorption per unit of the thickness d.
vec3 weidlich_wilkie_attenuation(vec3 sigma_a, float thickness, vec3 wi, vec3 wo) {
    return exp(-sigma_a * (thickness * ((wi.z + wo.z) / (wi.z * wo.z))));
}

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
float weidlich_wilkie_length2(vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
float weidlich_wilkie_cos_half(vec3 wi, vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(weidlich_wilkie_length2(wi + wo));
}

// eta^2 cos^2(theta_t) = mu^2 + eta^2 - 1; negative where light is reflected totally.
float weidlich_wilkie_refracted_cos2(float mu, float eta) {
    // The difference of two squares as a product, and mu^2 with its rounding error: at grazing angles, and at
    // the critical one, little else is left.
    return fma(mu, mu, (eta - 1.0) * (eta + 1.0));
}

// F and T = 1 - F of a smooth dielectric with eta >= 1 at a cosine mu outside, mu > 0.
WeidlichWilkieEntering weidlich_wilkie_split_entering(float mu, float eta) {
    // r_s = (1 - eta^2) / s^2 with s = c + g, and r_p = r_s (c g - sin2) / q with q = c g + sin2. So 1 - r_s^2
    // = 4 c g / s^2, and 1 - r_p^2 = 4 c g eta^2 / (s q)^2. One quotient serves all.
    float c = mu;
    float g = sqrt(weidlich_wilkie_refracted_cos2(c, eta));
    float s = c + g;
    float p = c * g;
    float sin2 = 1.0 - c * c;
    float q = p + sin2;
    float s2 = s * s;
    float q2 = q * q;
    float inv = 1.0 / (s2 * q2);
    float r_s = (eta - 1.0) * (eta + 1.0) * (q2 * inv);
    float F = r_s * r_s * ((p * p + sin2 * sin2) * (s2 * inv));
    return WeidlichWilkieEntering(F, p * inv * (2.0 * (q2 + eta * eta)));
}

// 1 - F of a smooth dielectric with eta >= 1 at a cosine mu outside; exact where it nearly vanishes.
float weidlich_wilkie_transmittance_entering(float mu, float eta) {
    return weidlich_wilkie_split_entering(mu, eta).T;
}

// 1 - G of V-grooves, 1 - 4 h.z min(mu_i, mu_o) / |h|^2 with h = wi + wo, exact where G is nearly 1.
//
// To within 1e-7 in float32. Shaders' compilers rearrange sums, and what was carried along would be 0.
float weidlich_wilkie_lost_cook_torrance(vec3 wi, vec3 wo) {
    vec3 h = wi + wo;
    float low = min(wi.z, wo.z);
    float high = max(wi.z, wo.z);
    // h.z^2 - 4 h.z low = h.z (high - 3 low); in two steps, both are exact where G is nearly 1
    float rest = high - 2.0 * low - low;
    return max((h.x * h.x + h.y * h.y + h.z * rest) / weidlich_wilkie_length2(h), 0.0);
}

// T12 t of Eq. 2 and 4 with lost = 1 - G.
float weidlich_wilkie_past_facets(float T, float lost) {
    // 1 - G F would lose the digits of a small T
    return T * (T + lost * (1.0 - T));
}

// T12 t: what the surface lets in and out again.
float weidlich_wilkie_transmitted(WeidlichWilkie params, vec3 wi, vec3 wo) {
    float T = weidlich_wilkie_transmittance_entering(weidlich_wilkie_cos_half(wi, wo), params.eta);
    // Eq. 4
    return weidlich_wilkie_past_facets(T, weidlich_wilkie_lost_cook_torrance(wi, wo));
}

// rho / pi.
vec3 weidlich_wilkie_base_eval_above(WeidlichWilkieBase params) {
    const float inv_pi = 0.31830987;
    return params.rho * inv_pi;
}

// Exact reflectance of a dielectric with eta >= 1, never total, at a cosine outside, mu > 0.
float weidlich_wilkie_F_dielectric_entering(float mu, float eta) {
    return weidlich_wilkie_split_entering(mu, eta).F;
}

WeidlichWilkieRoundBeckmann weidlich_wilkie_facets(WeidlichWilkie params) {
    return WeidlichWilkieRoundBeckmann(params.alpha);
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
vec2 weidlich_wilkie_slopes(vec3 h) {
    float inv = 1.0 / h.z;
    return vec2(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
float weidlich_wilkie_tangent2(vec3 h) {
    vec2 t = weidlich_wilkie_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
float weidlich_wilkie_round_beckmann_D_along(WeidlichWilkieRoundBeckmann round_beckmann,
    vec3 h) {
    const float inv_pi = 0.31830987;
    float inv_a2 = 1.0 / (round_beckmann.alpha * round_beckmann.alpha);
    float tan2 = weidlich_wilkie_tangent2(h);
    // The root of D, as 1 / cos^4 leaves a float32 where the exponential is 0
    float root = (1.0 + tan2) * exp(-0.5 * tan2 * inv_a2);
    return inv_pi * inv_a2 * (root * root);
}

// G over 4 mu_i mu_o.
float weidlich_wilkie_V_cook_torrance(vec3 wi, vec3 wo) {
    // Largest V of the maskings that grow like 1 / mu^2 where both directions graze: times the largest D, 3e7,
    // it still is a float32. It is reached at cosines of 5e-16.
    const float V_MAX = 1.0e30;
    vec3 h = wi + wo;
    return min(min(h.z / weidlich_wilkie_length2(h) * min(wi.z, wo.z), 0.25) / (wi.z * wo.z),
        V_MAX);
}

// Eq. 2: BRDF value in 1/sr, without the cosine.
vec3 weidlich_wilkie_eval(WeidlichWilkie params, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3(0.0);
    }
    vec3 wi_t = weidlich_wilkie_refract(wi, params.eta - 1.0);
    vec3 wo_t = weidlich_wilkie_refract(wo, params.eta - 1.0);
    vec3 kept = weidlich_wilkie_attenuation(params.sigma_a, params.thickness, wi_t, wo_t);
    float through = weidlich_wilkie_transmitted(params, wi, wo);
    vec3 below = weidlich_wilkie_base_eval_above(params.base) * (kept * through);
    float F = weidlich_wilkie_F_dielectric_entering(weidlich_wilkie_cos_half(wi, wo), params.eta);
    float coat = F * weidlich_wilkie_round_beckmann_D_along(weidlich_wilkie_facets(params), wi + wo)
        * weidlich_wilkie_V_cook_torrance(wi, wo);
    return below + coat;
}

// ---- sampling ------------------------------------------------------------------------------

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
vec3 weidlich_wilkie_half_vector(vec3 wi, vec3 wo) {
    // wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
    // squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
    // much longer.
    const float LENGTHENED = 1.0995116e12;
    vec3 h = LENGTHENED * (wi + wo);
    return h / sqrt(weidlich_wilkie_length2(h));  // the root is the cosine's as well
}

// A cosine at which light from anywhere meets the facets that it enters by, to choose lobes with.
//
// Halfway between wo.z (the mirror direction) and 1 (wi = wo): at grazing angles tilted facets let in more
// than the mean surface, whose transmittance is nearly 0 there.
float weidlich_wilkie_usual_cos_half(vec3 wo) {
    return 0.5 + 0.5 * wo.z;
}

// The most that weidlich_wilkie_attenuation leaves of light that goes out along wo: it came in along
// the normal.
vec3 weidlich_wilkie_attenuation_least(vec3 sigma_a, float thickness, vec3 wo) {
    return weidlich_wilkie_attenuation(sigma_a, thickness, vec3(0.0, 0.0, 1.0), wo);
}

// Mean of the three channels, by which lobes are weighed against each other.
float weidlich_wilkie_average(vec3 color) {
    return (color.x + color.y + color.z) / 3.0;
}

float weidlich_wilkie_raised(float probability) {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const float SHARE_LEAST = 0.1;
    const float ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
vec2 weidlich_wilkie_lobes_shares(float first, float second) {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const float BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const float WEIGHT_MIN = 1.0e-37;
    float a = first + BLACK;
    float b = max(second, WEIGHT_MIN);
    float inv = 1.0 / (a + b);
    float P_first = weidlich_wilkie_raised(a * inv);
    float P_second = weidlich_wilkie_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return vec2(smaller ? P_first : 1.0 - P_second, smaller ? 1.0 - P_first : P_second);
}

// Probabilities of the coat and of the base: their parts of the light, if the base were white.
vec2 weidlich_wilkie_shares(WeidlichWilkie params, vec3 wo, vec3 wo_t) {
    // The coat gets at least a tenth as many samples as the base: facets reflect more than the mean surface
    // where they are tilted, and this bounds their weight.
    const float COAT_SHARE_MIN = 0.1;
    // Added to the weight of a lobe, so that the reciprocal of two black lobes' sum has a finite derivative.
    const float LOBE_MIN = 1.0e-12;
    float mu = weidlich_wilkie_usual_cos_half(wo);
    float through = weidlich_wilkie_transmittance_entering(mu, params.eta)
        * weidlich_wilkie_average(weidlich_wilkie_attenuation_least(params.sigma_a,
            params.thickness, wo_t));
    float reflected = max(weidlich_wilkie_F_dielectric_entering(wo.z, params.eta),
        COAT_SHARE_MIN * through + LOBE_MIN);
    return weidlich_wilkie_lobes_shares(reflected, through);
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
WeidlichWilkieChoice weidlich_wilkie_choose(float probability, vec2 u) {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const float SHARE_MIN = 1.0e-12;
    // The largest float32 below 1, up to which random numbers go.
    const float RANDOM_MAX = 0.99999994;
    bool first = u.x < probability;
    float below = u.x / max(probability, SHARE_MIN);
    float above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return WeidlichWilkieChoice(first, vec2(clamp(first ? below : above, 0.0, RANDOM_MAX), u.y));
}

// A direction with density cos(theta) / pi.
vec3 weidlich_wilkie_sample_cosine(vec2 u) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(u.x, 0.0));
    float phi = two_pi * u.y;
    return vec3(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// Density of weidlich_wilkie_sample_cosine in 1/sr, for w above the horizon.
float weidlich_wilkie_pdf_cosine(vec3 w) {
    const float inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Cosine-weighted, which is exact here.
WeidlichWilkieSample weidlich_wilkie_base_sample(vec3 wo, vec2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return WeidlichWilkieSample(vec3(0.0, 0.0, 1.0), 0.0);
    }
    vec3 wi = weidlich_wilkie_sample_cosine(u);
    return WeidlichWilkieSample(wi, wi.z > mu_min ? weidlich_wilkie_pdf_cosine(wi) : 0.0);
}

// Cosine inside the layer of the flattest direction that leaves it; 0 for eta <= 1.
float weidlich_wilkie_critical_cosine(float excess) {
    return sqrt(max(weidlich_wilkie_contrast(excess), 0.0)) / (1.0 + excess);
}

// The outer direction for a direction inside: refracted, or spread out if it cannot leave.
vec3 weidlich_wilkie_leave(vec3 w, float excess) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    // Below this squared sine the azimuth of wo is taken as 0: any azimuth is right there, and the square of
    // its reciprocal still fits into a float32.
    const float SIN2_MIN = 1.0e-18;
    // Flattest direction that a sample leaves in: derivatives by the index fit in a float32 there.
    const float LEAVE_MIN = 1.0e-12;
    float k = weidlich_wilkie_critical_cosine(excess);
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

// weidlich_wilkie_base_sample inside a kernel for a base under layers: the direction in which the light
// leaves them.
//
// wo: inside the lowest layer. excess: the product of the layers' indices, minus 1. Layers over layers
// override it: each calls the next once, whose light refracts as if there were one layer.
vec3 weidlich_wilkie_base_sample_leaving(vec3 wo, vec2 u, float excess) {
    return weidlich_wilkie_leave(weidlich_wilkie_base_sample(wo, u).wi, excess);
}

// A normal with density D m.z. Walter et al., Eq. 28 and 29.
vec3 weidlich_wilkie_beckmann_sample(WeidlichWilkieBeckmann beckmann, vec2 u) {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const float RANDOM_MARGIN = 5.9604645e-8;
    const float two_pi = 6.2831855;
    float r = sqrt(max(-log(max(1.0 - u.x, RANDOM_MARGIN)), 0.0));
    float phi = two_pi * u.y;
    return normalize(vec3(beckmann.alpha_x * r * cos(phi), beckmann.alpha_y * r * sin(phi), 1.0));
}

// A normal with density D m.z.
vec3 weidlich_wilkie_round_beckmann_sample(WeidlichWilkieRoundBeckmann round_beckmann, vec2 u) {
    return weidlich_wilkie_beckmann_sample(WeidlichWilkieBeckmann(round_beckmann.alpha,
        round_beckmann.alpha), u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
vec3 weidlich_wilkie_mirror(vec3 wo, vec3 m) {
    return 2.0 * dot(wo, m) * m - wo;
}

// A direction that the coat mirrors.
//
// Visible normals need a G that is no larger than Smith's G1: with Cook-Torrance's the weights would grow
// like alpha / mu_o in the horizon. Those of all normals are at most 2.
vec3 weidlich_wilkie_sample_coat(WeidlichWilkie params, vec3 wo, vec2 u) {
    return weidlich_wilkie_mirror(wo,
        weidlich_wilkie_round_beckmann_sample(weidlich_wilkie_facets(params), u));
}

// cos(theta_i) / pi.
float weidlich_wilkie_base_pdf(vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return weidlich_wilkie_pdf_cosine(wi);
}

// The inner direction that weidlich_wilkie_leave spreads to w; z = 0 for eta <= 1, which has none.
vec3 weidlich_wilkie_gather(vec3 w, float excess) {
    const float SIN2_MIN = 1.0e-18;
    float k = weidlich_wilkie_critical_cosine(excess);
    float z = k * w.z;
    float sin2 = w.x * w.x + w.y * w.y;
    float scale = sqrt(max(1.0 - z * z, 0.0)) / sqrt(max(sin2, SIN2_MIN));
    bool near = sin2 < SIN2_MIN;  // no azimuth: any is right
    float x = near ? sqrt(max(1.0 - z * z, 0.0)) : w.x * scale;
    return vec3(x, near ? 0.0 : w.y * scale, z);
}

// Density of weidlich_wilkie_leave at w, from the inner density at w_t = refract(w) and at gather(w).
float weidlich_wilkie_pdf_leave(float pdf_refracted, float pdf_gathered, vec3 w, vec3 w_t,
    float excess) {
    // Solid angle over cosine-weighted one: 1 / mu. Refraction shrinks the latter by eta^2, gathering by k^2,
    // and the cosines are k mu and mu.
    float eta = 1.0 + excess;
    return pdf_refracted * w.z / (eta * eta * w_t.z)
        + pdf_gathered * weidlich_wilkie_critical_cosine(excess);
}

// Density of weidlich_wilkie_base_sample_leaving at wi, which is outside all layers, in 1/sr.
float weidlich_wilkie_base_pdf_leaving(vec3 wi, vec3 wo, float excess) {
    vec3 wi_t = weidlich_wilkie_refract(wi, excess);
    return weidlich_wilkie_pdf_leave(weidlich_wilkie_base_pdf(wi_t, wo),
        weidlich_wilkie_base_pdf(weidlich_wilkie_gather(wi, excess), wo), wi, wi_t, excess);
}

// Density of facets, in 1/sr. Walter et al., Eq. 25.
float weidlich_wilkie_round_beckmann_D(WeidlichWilkieRoundBeckmann round_beckmann, vec3 m) {
    // Square of the cosine below which exp(-tan^2 / alpha^2) is 0 in any precision, for alpha up to 3.2.
    const float COS2_MIN = 1.0e-6;
    const float inv_pi = 0.31830987;
    float inv_cos2 = 1.0 / max(m.z * m.z, COS2_MIN);
    float inv_a2 = 1.0 / (round_beckmann.alpha * round_beckmann.alpha);
    float sin2 = m.x * m.x + m.y * m.y;
    return inv_pi * inv_a2 * inv_cos2 * inv_cos2 * exp(-sin2 * inv_cos2 * inv_a2);
}

// Density of weidlich_wilkie_round_beckmann_sample in 1/sr.
float weidlich_wilkie_round_beckmann_density(WeidlichWilkieRoundBeckmann round_beckmann,
    vec3 m) {
    return weidlich_wilkie_round_beckmann_D(round_beckmann, m) * m.z;
}

// |wi + wo| / 2, the same with all digits however short it is: for what is divided by it.
float weidlich_wilkie_half_length(vec3 wi, vec3 wo) {
    const float LENGTHENED = 1.0995116e12;
    return 0.5 / LENGTHENED * sqrt(weidlich_wilkie_length2(LENGTHENED * (wi + wo)));
}

// Density of weidlich_wilkie_mirror in 1/sr, if m has the given density and cos_h = wo . m.
float weidlich_wilkie_pdf_mirror(float density, float cos_h) {
    // Walter et al., Eq. 14
    return 0.25 * density / cos_h;
}

float weidlich_wilkie_pdf_coat(WeidlichWilkie params, vec3 wi, vec3 wo) {
    float density = weidlich_wilkie_round_beckmann_density(weidlich_wilkie_facets(params),
        weidlich_wilkie_half_vector(wi, wo));
    return weidlich_wilkie_pdf_mirror(density, weidlich_wilkie_half_length(wi, wo));
}

// Density of weidlich_wilkie_sample in 1/sr.
float weidlich_wilkie_pdf(WeidlichWilkie params, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    vec3 wo_t = weidlich_wilkie_refract(wo, params.eta - 1.0);
    float below = weidlich_wilkie_base_pdf_leaving(wi, wo_t, params.eta - 1.0);
    vec2 P = weidlich_wilkie_shares(params, wo, wo_t);
    return P.x * weidlich_wilkie_pdf_coat(params, wi, wo) + P.y * below;
}

// The coat by visible normals or the base below, chosen by what the coat reflects and absorbs.
WeidlichWilkieSample weidlich_wilkie_sample(WeidlichWilkie params, vec3 wo, vec2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return WeidlichWilkieSample(vec3(0.0, 0.0, 1.0), 0.0);
    }
    vec3 wo_t = weidlich_wilkie_refract(wo, params.eta - 1.0);
    WeidlichWilkieChoice choose_result = weidlich_wilkie_choose(weidlich_wilkie_shares(params, wo,
        wo_t).x, u);
    bool on_coat = choose_result.is_first;
    vec2 v = choose_result.u;
    vec3 w_base = weidlich_wilkie_base_sample_leaving(wo_t, v, params.eta - 1.0);
    vec3 wi = mix(w_base, weidlich_wilkie_sample_coat(params, wo, v), bvec3(on_coat));
    return WeidlichWilkieSample(wi, weidlich_wilkie_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
vec3 weidlich_wilkie_albedo(WeidlichWilkie params, vec3 wo) {
    // Steps of the rule in weidlich_wilkie_albedo: a Fibonacci number, and the golden ratio.
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
        WeidlichWilkieSample drawn = weidlich_wilkie_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + weidlich_wilkie_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
