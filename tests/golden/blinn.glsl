// SPDX-License-Identifier: Apache-2.0
// Blinn: a diffuse term and a highlight around the half vector, as early hardware shaded it.
//
// Source: Blinn, "Models of light reflection for computer synthesized pictures", SIGGRAPH 1977: Phong's
// formula with the angle between the normal and the half vector in place of that to the mirror direction.
// The formula gives the radiance f cos(theta_i), which is divided by the cosine here.
//
// GLSL 4.5, made by gonio from gonio/models/blinn.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: Blinn params; params.rho = ...; ... blinn_eval(params, wi, wo)

// A sampled direction and its density.
struct BlinnSample {
    vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// blinn: The classic Blinn-Phong: diffuse, specular and gloss, without Fresnel or normalisation.
struct Blinn {
    vec3 rho;  // albedo of the diffuse term, linear RGB; 0 to 1, default (0.5, 0.5, 0.5)
    vec3 specular;  // weight of the highlight, linear RGB; 0 to 1, default (0.3, 0.3, 0.3)
    float shininess;  // exponent n of the highlight, its gloss; 0 to 100000, default 50
};

// Which of two lobes a sample is taken from.
struct BlinnChoice {
    bool is_first;  // Whether it is the first one
    vec2 u;  // Fresh random numbers, made of those that chose
};

// Facets of GGX with the same width in all directions.
struct BlinnRoundGGX {
    float alpha;  // width of the slopes
};

// Facets of GGX, also called Trowbridge-Reitz.
struct BlinnGGX {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// ---- evaluation ----------------------------------------------------------------------------

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
vec2 blinn_slopes(vec3 h) {
    float inv = 1.0 / h.z;
    return vec2(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
float blinn_tangent2(vec3 h) {
    vec2 t = blinn_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
float blinn_atanh_over(float y) {
    float y2 = y * y;
    return 1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0 + y2 * (1.0 / 9.0))));
}

// log(cos) of the angle between the normal and h, which need not be unit.
float blinn_log_cos_along(vec3 h) {
    // Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
    const float LOG1P_SMALL = 0.25;
    // log(cos) = -log(1 + tan^2) / 2 = -atanh(y)
    float tan2 = blinn_tangent2(h);
    float y = tan2 / (2.0 + tan2);
    return tan2 < LOG1P_SMALL ? -y * blinn_atanh_over(y) : -0.5 * log(1.0 + tan2);
}

// (N.m)^exponent of the normal m along h, exact for sharp lobes.
float blinn_cos_power(vec3 h, float exponent) {
    return exp(exponent * blinn_log_cos_along(h));
}

// The highlight without its weight.
float blinn_highlight(Blinn params, vec3 wi, vec3 wo) {
    return blinn_cos_power(wi + wo, params.shininess) / wi.z;
}

// BRDF value in 1/sr, without the cosine.
vec3 blinn_eval(Blinn params, vec3 wi, vec3 wo) {
    const float inv_pi = 0.31830987;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3(0.0);
    }
    return params.rho * inv_pi + params.specular * blinn_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// The width that matches an exponent n: sqrt(2 / (n + 2)).
float blinn_blinn_phong_alpha(float exponent) {
    return sqrt(2.0 / (exponent + 2.0));
}

// Mean of the three channels, by which lobes are weighed against each other.
float blinn_average(vec3 color) {
    return (color.x + color.y + color.z) / 3.0;
}

float blinn_raised(float probability) {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const float SHARE_LEAST = 0.1;
    const float ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
vec2 blinn_lobes_shares(float first, float second) {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const float BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const float WEIGHT_MIN = 1.0e-37;
    float a = first + BLACK;
    float b = max(second, WEIGHT_MIN);
    float inv = 1.0 / (a + b);
    float P_first = blinn_raised(a * inv);
    float P_second = blinn_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return vec2(smaller ? P_first : 1.0 - P_second, smaller ? 1.0 - P_first : P_second);
}

// Probabilities of the diffuse lobe and of the highlight.
vec2 blinn_shares(Blinn params, vec3 wo) {
    const float pi = 3.1415927;
    // 4 mu_h dw_h of a narrow lobe; half of it lies below the horizon at grazing angles
    float highlight = 4.0 * pi / (params.shininess + 2.0) * (1.0 + wo.z);
    return blinn_lobes_shares(blinn_average(params.rho),
        blinn_average(params.specular) * highlight);
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
BlinnChoice blinn_choose(float probability, vec2 u) {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const float SHARE_MIN = 1.0e-12;
    // The largest float32 below 1, up to which random numbers go.
    const float RANDOM_MAX = 0.99999994;
    bool first = u.x < probability;
    float below = u.x / max(probability, SHARE_MIN);
    float above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return BlinnChoice(first, vec2(clamp(first ? below : above, 0.0, RANDOM_MAX), u.y));
}

// A direction with density cos(theta) / pi.
vec3 blinn_sample_cosine(vec2 u) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(u.x, 0.0));
    float phi = two_pi * u.y;
    return vec3(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// w where all facets are those of a unit sphere.
vec3 blinn_ggx_unstretched(BlinnGGX ggx, vec3 w) {
    return normalize(vec3(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
vec3 blinn_ggx_half_way(BlinnGGX ggx, vec3 w, float drop, float z, float v) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(drop * (2.0 - drop), 0.0));
    float phi = two_pi * v;
    vec3 h = vec3(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(vec3(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
vec3 blinn_ggx_sample_visible(BlinnGGX ggx, vec3 wo, vec2 u) {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const float RANDOM_MARGIN = 5.9604645e-8;
    vec3 w = blinn_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    float u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    float height = 1.0 + w.z;
    return blinn_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see blinn_ggx_sample_visible.
vec3 blinn_round_ggx_sample_visible(BlinnRoundGGX round_ggx, vec3 wo, vec2 u) {
    return blinn_ggx_sample_visible(BlinnGGX(round_ggx.alpha, round_ggx.alpha), wo, u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
vec3 blinn_mirror(vec3 wo, vec3 m) {
    return 2.0 * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
vec3 blinn_sample_ggx_lobe(BlinnRoundGGX facets, vec3 wo, vec2 u) {
    vec3 w = blinn_mirror(wo, blinn_round_ggx_sample_visible(facets, wo, u));
    return vec3(w.x, w.y, abs(w.z));
}

// A direction of one of the two lobes; shares: the probabilities of the matte one and of the other.
vec3 blinn_sample_matte_gloss(vec3 wo, float alpha, vec2 shares, vec2 u) {
    BlinnChoice choose_result = blinn_choose(shares.x, u);
    bool matte = choose_result.is_first;
    vec2 v = choose_result.u;
    return mix(blinn_sample_ggx_lobe(BlinnRoundGGX(alpha), wo, v), blinn_sample_cosine(v),
        bvec3(matte));
}

// Density of blinn_sample_cosine in 1/sr, for w above the horizon.
float blinn_pdf_cosine(vec3 w) {
    const float inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
float blinn_round_ggx_area(BlinnRoundGGX round_ggx, vec3 w) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrt(a2 + (1.0 - a2) * (w.z * w.z));
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
float blinn_round_ggx_D_along(BlinnRoundGGX round_ggx, vec3 h) {
    const float inv_pi = 0.31830987;
    float a2 = round_ggx.alpha * round_ggx.alpha;
    float tan2 = blinn_tangent2(h);
    float r = (1.0 + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// Density of blinn_sample_ggx_lobe in 1/sr.
float blinn_pdf_ggx_lobe(BlinnRoundGGX facets, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    float seen = 0.5 / (wo.z + blinn_round_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    float straight = blinn_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    bool exists = wo.z > wi.z;
    vec3 across = vec3(wi.x, wi.y, exists ? wo.z - wi.z : wi.z);
    float folded = blinn_round_ggx_D_along(facets, across
        + vec3(wo.x, wo.y, exists ? mu_min : wo.z));
    return (straight + (exists ? folded : 0.0)) * seen;
}

// Density of blinn_sample_matte_gloss in 1/sr.
float blinn_pdf_matte_gloss(vec3 wi, vec3 wo, float alpha, vec2 shares) {
    return shares.x * blinn_pdf_cosine(wi)
        + shares.y * blinn_pdf_ggx_lobe(BlinnRoundGGX(alpha), wi, wo);
}

// Density of blinn_sample in 1/sr.
float blinn_pdf(Blinn params, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return blinn_pdf_matte_gloss(wi, wo, blinn_blinn_phong_alpha(params.shininess),
        blinn_shares(params, wo));
}

// Cosine-weighted, or the GGX lobe of the same width, whose longer tail bounds the weights.
BlinnSample blinn_sample(Blinn params, vec3 wo, vec2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return BlinnSample(vec3(0.0, 0.0, 1.0), 0.0);
    }
    vec3 wi = blinn_sample_matte_gloss(wo, blinn_blinn_phong_alpha(params.shininess),
        blinn_shares(params, wo), u);
    return BlinnSample(wi, blinn_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
vec3 blinn_albedo(Blinn params, vec3 wo) {
    // Steps of the rule in blinn_albedo: a Fibonacci number, and the golden ratio.
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
        BlinnSample drawn = blinn_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + blinn_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
