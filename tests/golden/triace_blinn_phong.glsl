// SPDX-License-Identifier: Apache-2.0
// tri-Ace Blinn-Phong: a normalised Blinn-Phong highlight with Fresnel, cheap enough for a console.
//
// Source: Gotanda, "Beyond a simple physically based Blinn-Phong model in real-time", SIGGRAPH 2012
// course "Practical physically based shading in film and game production", Eq. 1; Eq. 25 for the rough
// diffuse part of its Figures 6, 11 and 14, which shares the highlight's exponent.
// The course's shaders return pi f cos(theta_i); this is f. Its linear factor 0.0397436 n + 0.0856832 is a
// fit of (n + 2) / (4 pi (2 - 2^(-n / 2))): within 0.6 % for n >= 10, 32 % too small at n = 1.
//
// GLSL 4.5, made by gonio from gonio/models/triace_blinn_phong.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: TriaceBlinnPhong params; params.rho = ...; ... triace_blinn_phong_eval(params, wi, wo)

// A sampled direction and its density.
struct TriaceBlinnPhongSample {
    vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// triace_blinn_phong: Lambert under a Blinn-Phong highlight with Schlick's Fresnel. Reciprocal. Exported
// with diffuse='lambert'.
struct TriaceBlinnPhong {
    vec3 rho;  // diffuse albedo R_d, linear RGB; 0 to 1, default (0.5, 0.5, 0.5)
    vec3 f0;  // reflectance at normal incidence, linear RGB; 0 to 1, default (0.04, 0.04, 0.04)
    float shininess;  // Blinn-Phong exponent n; 0 to 100000, default 50
};

// Which of two lobes a sample is taken from.
struct TriaceBlinnPhongChoice {
    bool is_first;  // Whether it is the first one
    vec2 u;  // Fresh random numbers, made of those that chose
};

// Facets of GGX with the same width in all directions.
struct TriaceBlinnPhongRoundGGX {
    float alpha;  // width of the slopes
};

// Facets of GGX, also called Trowbridge-Reitz.
struct TriaceBlinnPhongGGX {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
float triace_blinn_phong_length2(vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
float triace_blinn_phong_cos_half(vec3 wi, vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(triace_blinn_phong_length2(wi + wo));
}

// 1 - triace_blinn_phong_cos_half^2, the squared sine at which light meets the facet: of half the length of
// wi - wo.
float triace_blinn_phong_sin2_half(vec3 wi, vec3 wo) {
    vec3 apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
float triace_blinn_phong_weight(float cos_h, float sin2_h) {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    float k = sin2_h / (1.0 + cos_h);
    float k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
float triace_blinn_phong_schlick_weight_half(vec3 wi, vec3 wo) {
    return triace_blinn_phong_weight(triace_blinn_phong_cos_half(wi, wo),
        triace_blinn_phong_sin2_half(wi, wo));
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
vec2 triace_blinn_phong_slopes(vec3 h) {
    float inv = 1.0 / h.z;
    return vec2(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
float triace_blinn_phong_tangent2(vec3 h) {
    vec2 t = triace_blinn_phong_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
float triace_blinn_phong_atanh_over(float y) {
    float y2 = y * y;
    return 1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0 + y2 * (1.0 / 9.0))));
}

// log(cos) of the angle between the normal and h, which need not be unit.
float triace_blinn_phong_log_cos_along(vec3 h) {
    // Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
    const float LOG1P_SMALL = 0.25;
    // log(cos) = -log(1 + tan^2) / 2 = -atanh(y)
    float tan2 = triace_blinn_phong_tangent2(h);
    float y = tan2 / (2.0 + tan2);
    return tan2 < LOG1P_SMALL ? -y * triace_blinn_phong_atanh_over(y) : -0.5 * log(1.0 + tan2);
}

// (N.m)^exponent of the normal m along h, exact for sharp lobes.
float triace_blinn_phong_cos_power(vec3 h, float exponent) {
    return exp(exponent * triace_blinn_phong_log_cos_along(h));
}

// (0.0397436 n + 0.0856832) (N.H)^n / max(mu_i, mu_o): Eq. 1's highlight without Fresnel.
float triace_blinn_phong_blinn_phong_highlight(vec3 wi, vec3 wo, float shininess) {
    const float NORM_SLOPE = 0.0397436;  // Eq. 1: the normalisation as a linear function of n.
    const float NORM_OFFSET = 0.0856832;
    float power = triace_blinn_phong_cos_power(wi + wo, shininess);
    return (NORM_SLOPE * shininess + NORM_OFFSET) * power / max(wi.z, wo.z);
}

// Eq. 1 without the cosine and the factor pi: BRDF value in 1/sr.
vec3 triace_blinn_phong_eval(TriaceBlinnPhong params, vec3 wi, vec3 wo) {
    const float inv_pi = 0.31830987;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3(0.0);
    }
    vec3 F = mix(params.f0, vec3(1.0), vec3(triace_blinn_phong_schlick_weight_half(wi, wo)));
    vec3 diffuse = params.rho * (1.0 - params.f0) * inv_pi;
    return diffuse + F * triace_blinn_phong_blinn_phong_highlight(wi, wo, params.shininess);
}

// ---- sampling ------------------------------------------------------------------------------

// The width that matches an exponent n: sqrt(2 / (n + 2)).
float triace_blinn_phong_blinn_phong_alpha(float exponent) {
    return sqrt(2.0 / (exponent + 2.0));
}

// (1 - cos_theta)^5 of Schlick's approximation.
float triace_blinn_phong_schlick_weight(float cos_theta) {
    float k = 1.0 - cos_theta;
    float k2 = k * k;
    return k2 * k2 * k;
}

// Mean of the three channels, by which lobes are weighed against each other.
float triace_blinn_phong_average(vec3 color) {
    return (color.x + color.y + color.z) / 3.0;
}

float triace_blinn_phong_raised(float probability) {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const float SHARE_LEAST = 0.1;
    const float ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
vec2 triace_blinn_phong_lobes_shares(float first, float second) {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const float BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const float WEIGHT_MIN = 1.0e-37;
    float a = first + BLACK;
    float b = max(second, WEIGHT_MIN);
    float inv = 1.0 / (a + b);
    float P_first = triace_blinn_phong_raised(a * inv);
    float P_second = triace_blinn_phong_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return vec2(smaller ? P_first : 1.0 - P_second, smaller ? 1.0 - P_first : P_second);
}

// Probabilities of the diffuse lobe and of the highlight.
vec2 triace_blinn_phong_shares(TriaceBlinnPhong params, vec3 wo) {
    vec3 F = mix(params.f0, vec3(1.0), vec3(triace_blinn_phong_schlick_weight(wo.z)));
    return triace_blinn_phong_lobes_shares(triace_blinn_phong_average(params.rho
        * (1.0 - params.f0)), triace_blinn_phong_average(F));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
TriaceBlinnPhongChoice triace_blinn_phong_choose(float probability, vec2 u) {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const float SHARE_MIN = 1.0e-12;
    // The largest float32 below 1, up to which random numbers go.
    const float RANDOM_MAX = 0.99999994;
    bool first = u.x < probability;
    float below = u.x / max(probability, SHARE_MIN);
    float above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return TriaceBlinnPhongChoice(first, vec2(clamp(first ? below : above, 0.0, RANDOM_MAX), u.y));
}

// A direction with density cos(theta) / pi.
vec3 triace_blinn_phong_sample_cosine(vec2 u) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(u.x, 0.0));
    float phi = two_pi * u.y;
    return vec3(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// w where all facets are those of a unit sphere.
vec3 triace_blinn_phong_ggx_unstretched(TriaceBlinnPhongGGX ggx, vec3 w) {
    return normalize(vec3(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
vec3 triace_blinn_phong_ggx_half_way(TriaceBlinnPhongGGX ggx, vec3 w, float drop, float z,
    float v) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(drop * (2.0 - drop), 0.0));
    float phi = two_pi * v;
    vec3 h = vec3(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(vec3(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
vec3 triace_blinn_phong_ggx_sample_visible(TriaceBlinnPhongGGX ggx, vec3 wo, vec2 u) {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const float RANDOM_MARGIN = 5.9604645e-8;
    vec3 w = triace_blinn_phong_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    float u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    float height = 1.0 + w.z;
    return triace_blinn_phong_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see triace_blinn_phong_ggx_sample_visible.
vec3 triace_blinn_phong_round_ggx_sample_visible(TriaceBlinnPhongRoundGGX round_ggx, vec3 wo,
    vec2 u) {
    return triace_blinn_phong_ggx_sample_visible(TriaceBlinnPhongGGX(round_ggx.alpha,
        round_ggx.alpha), wo, u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
vec3 triace_blinn_phong_mirror(vec3 wo, vec3 m) {
    return 2.0 * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
vec3 triace_blinn_phong_sample_ggx_lobe(TriaceBlinnPhongRoundGGX facets, vec3 wo, vec2 u) {
    vec3 w = triace_blinn_phong_mirror(wo,
        triace_blinn_phong_round_ggx_sample_visible(facets, wo, u));
    return vec3(w.x, w.y, abs(w.z));
}

// A direction of one of the two lobes; shares: the probabilities of the matte one and of the other.
vec3 triace_blinn_phong_sample_matte_gloss(vec3 wo, float alpha, vec2 shares, vec2 u) {
    TriaceBlinnPhongChoice choose_result = triace_blinn_phong_choose(shares.x, u);
    bool matte = choose_result.is_first;
    vec2 v = choose_result.u;
    return mix(triace_blinn_phong_sample_ggx_lobe(TriaceBlinnPhongRoundGGX(alpha), wo, v),
        triace_blinn_phong_sample_cosine(v), bvec3(matte));
}

// Density of triace_blinn_phong_sample_cosine in 1/sr, for w above the horizon.
float triace_blinn_phong_pdf_cosine(vec3 w) {
    const float inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
float triace_blinn_phong_round_ggx_area(TriaceBlinnPhongRoundGGX round_ggx, vec3 w) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrt(a2 + (1.0 - a2) * (w.z * w.z));
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
float triace_blinn_phong_round_ggx_D_along(TriaceBlinnPhongRoundGGX round_ggx, vec3 h) {
    const float inv_pi = 0.31830987;
    float a2 = round_ggx.alpha * round_ggx.alpha;
    float tan2 = triace_blinn_phong_tangent2(h);
    float r = (1.0 + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// Density of triace_blinn_phong_sample_ggx_lobe in 1/sr.
float triace_blinn_phong_pdf_ggx_lobe(TriaceBlinnPhongRoundGGX facets, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    // Smith's G1 over 4 mu_o
    float seen = 0.5 / (wo.z + triace_blinn_phong_round_ggx_area(facets, wo));
    float straight = triace_blinn_phong_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    bool exists = wo.z > wi.z;
    vec3 across = vec3(wi.x, wi.y, exists ? wo.z - wi.z : wi.z);
    float folded = triace_blinn_phong_round_ggx_D_along(facets, across
        + vec3(wo.x, wo.y, exists ? mu_min : wo.z));
    return (straight + (exists ? folded : 0.0)) * seen;
}

// Density of triace_blinn_phong_sample_matte_gloss in 1/sr.
float triace_blinn_phong_pdf_matte_gloss(vec3 wi, vec3 wo, float alpha, vec2 shares) {
    return shares.x * triace_blinn_phong_pdf_cosine(wi)
        + shares.y * triace_blinn_phong_pdf_ggx_lobe(TriaceBlinnPhongRoundGGX(alpha), wi, wo);
}

// Density of triace_blinn_phong_sample in 1/sr.
float triace_blinn_phong_pdf(TriaceBlinnPhong params, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    float alpha = triace_blinn_phong_blinn_phong_alpha(params.shininess);
    vec2 P = triace_blinn_phong_shares(params, wo);
    return triace_blinn_phong_pdf_matte_gloss(wi, wo, alpha, P);
}

// Cosine-weighted, or the GGX lobe of the same width, whose longer tail bounds the weights.
TriaceBlinnPhongSample triace_blinn_phong_sample(TriaceBlinnPhong params, vec3 wo, vec2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return TriaceBlinnPhongSample(vec3(0.0, 0.0, 1.0), 0.0);
    }
    float alpha = triace_blinn_phong_blinn_phong_alpha(params.shininess);
    vec3 wi = triace_blinn_phong_sample_matte_gloss(wo, alpha,
        triace_blinn_phong_shares(params, wo), u);
    return TriaceBlinnPhongSample(wi, triace_blinn_phong_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
vec3 triace_blinn_phong_albedo(TriaceBlinnPhong params, vec3 wo) {
    // Steps of the rule in triace_blinn_phong_albedo: a Fibonacci number, and the golden ratio.
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
        TriaceBlinnPhongSample drawn = triace_blinn_phong_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + triace_blinn_phong_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
