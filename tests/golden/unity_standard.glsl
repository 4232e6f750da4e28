// SPDX-License-Identifier: Apache-2.0
// Unity Standard: BRDF1, the full-quality shading of Unity's built-in render pipeline.
//
// Source: "PBR theory, part 1: foundations" (SZ's temple, 2019), section 5, which walks through
// UnityStandardBRDF.cginc of Unity 2018.2. Unity's own value is pi times f: its diffuse term is not divided
// by pi and its highlight is multiplied by it. The article misses a division by 4 mu_i mu_o, but Unity's V
// holds it already.
// Where it departs from physics: k_d is the constant 0.96 (1 - metallic) in place of 1 - F, so that the
// diffuse term takes no notice of the Fresnel reflection above it; V replaces sqrt(mu^2 + alpha^2 sin^2) of
// Smith by mu (1 - alpha) + alpha.
// Deviation: Unity adds 1e-5 to V's and 1e-7 to D's denominator, against division by zero; neither is here.
// The second dims its highlights: the peak by 4 % at roughness 0.2, 28 % at 0.15 and 91 % at 0.1.
//
// GLSL 4.5, made by gonio from gonio/models/unity_standard.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: UnityStandard params; params.base_color = ...; ... unity_standard_eval(params, wi, wo)

// A sampled direction and its density.
struct UnityStandardSample {
    vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// unity_standard: Burley diffuse plus a GGX highlight with a cheaper Smith term. Reciprocal; gains energy.
struct UnityStandard {
    // diffuse colour, or F0 of metals, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    vec3 base_color;
    float metallic;  // 0 for dielectrics, 1 for metals; 0 to 1, default 0
    float roughness;  // perceptual roughness, 1 - Unity's smoothness; 0 to 1, default 0.5
};

// Facets of GGX with the same width in all directions.
struct UnityStandardRoundGGX {
    float alpha;  // width of the slopes
};

// Which of two lobes a sample is taken from.
struct UnityStandardChoice {
    bool is_first;  // Whether it is the first one
    vec2 u;  // Fresh random numbers, made of those that chose
};

// Facets of GGX, also called Trowbridge-Reitz.
struct UnityStandardGGX {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// ---- evaluation ----------------------------------------------------------------------------

// (1 - cos_theta)^5 of Schlick's approximation.
float unity_standard_schlick_weight(float cos_theta) {
    float k = 1.0 - cos_theta;
    float k2 = k * k;
    return k2 * k2 * k;
}

vec3 unity_standard_f0(UnityStandard params) {
    const float F0_DIELECTRIC = 0.04;  // reflectance of dielectrics (linear colour space)
    return mix(vec3(F0_DIELECTRIC), params.base_color, vec3(params.metallic));
}

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
float unity_standard_length2(vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
float unity_standard_cos_half(vec3 wi, vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(unity_standard_length2(wi + wo));
}

// 1 - unity_standard_cos_half^2, the squared sine at which light meets the facet: of half the length of wi
// - wo.
float unity_standard_sin2_half(vec3 wi, vec3 wo) {
    vec3 apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
float unity_standard_weight(float cos_h, float sin2_h) {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    float k = sin2_h / (1.0 + cos_h);
    float k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
float unity_standard_schlick_weight_half(vec3 wi, vec3 wo) {
    return unity_standard_weight(unity_standard_cos_half(wi, wo), unity_standard_sin2_half(wi, wo));
}

vec3 unity_standard_diffuse(UnityStandard params) {
    const float F0_DIELECTRIC = 0.04;  // reflectance of dielectrics (linear colour space)
    return (1.0 - F0_DIELECTRIC) * (1.0 - params.metallic) * params.base_color;
}

float unity_standard_alpha(UnityStandard params) {
    const float ALPHA_UNITY = 0.002;  // lower limit of alpha
    return max(params.roughness * params.roughness, ALPHA_UNITY);
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
vec2 unity_standard_slopes(vec3 h) {
    float inv = 1.0 / h.z;
    return vec2(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
float unity_standard_tangent2(vec3 h) {
    vec2 t = unity_standard_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
float unity_standard_round_ggx_D_along(UnityStandardRoundGGX round_ggx, vec3 h) {
    const float inv_pi = 0.31830987;
    float a2 = round_ggx.alpha * round_ggx.alpha;
    float tan2 = unity_standard_tangent2(h);
    float r = (1.0 + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// D V: the highlight without F.
float unity_standard_highlight(UnityStandard params, vec3 wi, vec3 wo) {
    float alpha = unity_standard_alpha(params);
    float lambda_v = wi.z * mix(alpha, 1.0, wo.z);
    float lambda_l = wo.z * mix(alpha, 1.0, wi.z);
    float D = unity_standard_round_ggx_D_along(UnityStandardRoundGGX(alpha), wi + wo);
    return D * (0.5 / (lambda_v + lambda_l));
}

// BRDF value in 1/sr, without the cosine.
vec3 unity_standard_eval(UnityStandard params, vec3 wi, vec3 wo) {
    const float inv_pi = 0.31830987;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3(0.0);
    }
    float r = params.roughness;
    // F90 = 0.5 + 2 roughness cos^2(theta_d), and 2 cos^2(theta_d) = 1 + dot(wi, wo)
    float rise = r * (1.0 + dot(wi, wo)) - 0.5;
    float burley = (1.0 + rise * unity_standard_schlick_weight(wi.z))
        * (1.0 + rise * unity_standard_schlick_weight(wo.z));
    vec3 F = mix(unity_standard_f0(params), vec3(1.0),
        vec3(unity_standard_schlick_weight_half(wi, wo)));
    return inv_pi * burley * unity_standard_diffuse(params)
        + F * unity_standard_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// Mean of the three channels, by which lobes are weighed against each other.
float unity_standard_average(vec3 color) {
    return (color.x + color.y + color.z) / 3.0;
}

float unity_standard_raised(float probability) {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const float SHARE_LEAST = 0.1;
    const float ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
vec2 unity_standard_lobes_shares(float first, float second) {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const float BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const float WEIGHT_MIN = 1.0e-37;
    float a = first + BLACK;
    float b = max(second, WEIGHT_MIN);
    float inv = 1.0 / (a + b);
    float P_first = unity_standard_raised(a * inv);
    float P_second = unity_standard_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return vec2(smaller ? P_first : 1.0 - P_second, smaller ? 1.0 - P_first : P_second);
}

// Probabilities of the diffuse lobe and of the highlight.
vec2 unity_standard_shares(UnityStandard params, vec3 wo) {
    vec3 F = mix(unity_standard_f0(params), vec3(1.0), vec3(unity_standard_schlick_weight(wo.z)));
    return unity_standard_lobes_shares(unity_standard_average(unity_standard_diffuse(params)),
        unity_standard_average(F));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
UnityStandardChoice unity_standard_choose(float probability, vec2 u) {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const float SHARE_MIN = 1.0e-12;
    // The largest float32 below 1, up to which random numbers go.
    const float RANDOM_MAX = 0.99999994;
    bool first = u.x < probability;
    float below = u.x / max(probability, SHARE_MIN);
    float above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return UnityStandardChoice(first, vec2(clamp(first ? below : above, 0.0, RANDOM_MAX), u.y));
}

// A direction with density cos(theta) / pi.
vec3 unity_standard_sample_cosine(vec2 u) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(u.x, 0.0));
    float phi = two_pi * u.y;
    return vec3(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// w where all facets are those of a unit sphere.
vec3 unity_standard_ggx_unstretched(UnityStandardGGX ggx, vec3 w) {
    return normalize(vec3(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
vec3 unity_standard_ggx_half_way(UnityStandardGGX ggx, vec3 w, float drop, float z, float v) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(drop * (2.0 - drop), 0.0));
    float phi = two_pi * v;
    vec3 h = vec3(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(vec3(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
vec3 unity_standard_ggx_sample_visible(UnityStandardGGX ggx, vec3 wo, vec2 u) {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const float RANDOM_MARGIN = 5.9604645e-8;
    vec3 w = unity_standard_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    float u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    float height = 1.0 + w.z;
    return unity_standard_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see unity_standard_ggx_sample_visible.
vec3 unity_standard_round_ggx_sample_visible(UnityStandardRoundGGX round_ggx, vec3 wo, vec2 u) {
    return unity_standard_ggx_sample_visible(UnityStandardGGX(round_ggx.alpha, round_ggx.alpha), wo,
        u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
vec3 unity_standard_mirror(vec3 wo, vec3 m) {
    return 2.0 * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
vec3 unity_standard_sample_ggx_lobe(UnityStandardRoundGGX facets, vec3 wo, vec2 u) {
    vec3 w = unity_standard_mirror(wo, unity_standard_round_ggx_sample_visible(facets, wo, u));
    return vec3(w.x, w.y, abs(w.z));
}

// A direction of one of the two lobes; shares: the probabilities of the matte one and of the other.
vec3 unity_standard_sample_matte_gloss(vec3 wo, float alpha, vec2 shares, vec2 u) {
    UnityStandardChoice choose_result = unity_standard_choose(shares.x, u);
    bool matte = choose_result.is_first;
    vec2 v = choose_result.u;
    return mix(unity_standard_sample_ggx_lobe(UnityStandardRoundGGX(alpha), wo, v),
        unity_standard_sample_cosine(v), bvec3(matte));
}

// Density of unity_standard_sample_cosine in 1/sr, for w above the horizon.
float unity_standard_pdf_cosine(vec3 w) {
    const float inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
float unity_standard_round_ggx_area(UnityStandardRoundGGX round_ggx, vec3 w) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrt(a2 + (1.0 - a2) * (w.z * w.z));
}

// Density of unity_standard_sample_ggx_lobe in 1/sr.
float unity_standard_pdf_ggx_lobe(UnityStandardRoundGGX facets, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    // Smith's G1 over 4 mu_o
    float seen = 0.5 / (wo.z + unity_standard_round_ggx_area(facets, wo));
    float straight = unity_standard_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    bool exists = wo.z > wi.z;
    vec3 across = vec3(wi.x, wi.y, exists ? wo.z - wi.z : wi.z);
    float folded = unity_standard_round_ggx_D_along(facets, across
        + vec3(wo.x, wo.y, exists ? mu_min : wo.z));
    return (straight + (exists ? folded : 0.0)) * seen;
}

// Density of unity_standard_sample_matte_gloss in 1/sr.
float unity_standard_pdf_matte_gloss(vec3 wi, vec3 wo, float alpha, vec2 shares) {
    return shares.x * unity_standard_pdf_cosine(wi)
        + shares.y * unity_standard_pdf_ggx_lobe(UnityStandardRoundGGX(alpha), wi, wo);
}

// Density of unity_standard_sample in 1/sr.
float unity_standard_pdf(UnityStandard params, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return unity_standard_pdf_matte_gloss(wi, wo, unity_standard_alpha(params),
        unity_standard_shares(params, wo));
}

// Cosine-weighted or a visible GGX normal, by the estimated albedos.
UnityStandardSample unity_standard_sample(UnityStandard params, vec3 wo, vec2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return UnityStandardSample(vec3(0.0, 0.0, 1.0), 0.0);
    }
    vec3 wi = unity_standard_sample_matte_gloss(wo, unity_standard_alpha(params),
        unity_standard_shares(params, wo), u);
    return UnityStandardSample(wi, unity_standard_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
vec3 unity_standard_albedo(UnityStandard params, vec3 wo) {
    // Steps of the rule in unity_standard_albedo: a Fibonacci number, and the golden ratio.
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
        UnityStandardSample drawn = unity_standard_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + unity_standard_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
