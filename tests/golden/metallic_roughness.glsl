// SPDX-License-Identifier: Apache-2.0
// Metallic-roughness: one colour, a metalness and a roughness, the way games describe materials.
//
// Source: "PBR theory, part 1: foundations" (SZ's temple, 2019), section 4, after Burley 2012: Lambert with
// k_d = 1 - F and c_d = base_color (1 - metallic), Cook-Torrance with GGX, Smith and Schlick, F0 between
// 0.04 and the base colour. The text leaves Smith's form open: both are here.
// Deviation: alpha = roughness^2 is at least ALPHA_MIN, where the highlight still is a function.
//
// GLSL 4.5, made by gonio from gonio/models/metallic_roughness.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: MetallicRoughness params; params.base_color = ...; ... metallic_roughness_eval(params, wi, wo)

// A sampled direction and its density.
struct MetallicRoughnessSample {
    vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// metallic_roughness: Diffuse below a GGX highlight, which takes its share of the light facet by facet.
// Reciprocal. Exported with masking='smith_correlated'.
struct MetallicRoughness {
    // diffuse colour, or F0 of metals, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    vec3 base_color;
    float metallic;  // 0 for dielectrics, 1 for metals; 0 to 1, default 0
    float roughness;  // perceptual roughness, alpha = roughness^2; 0 to 1, default 0.5
};

// Facets of GGX with the same width in all directions.
struct MetallicRoughnessRoundGGX {
    float alpha;  // width of the slopes
};

// Which of two lobes a sample is taken from.
struct MetallicRoughnessChoice {
    bool is_first;  // Whether it is the first one
    vec2 u;  // Fresh random numbers, made of those that chose
};

// Facets of GGX, also called Trowbridge-Reitz.
struct MetallicRoughnessGGX {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// ---- evaluation ----------------------------------------------------------------------------

vec3 metallic_roughness_f0(MetallicRoughness params) {
    const float F0_DIELECTRIC = 0.04;  // Reflectance of every dielectric at normal incidence.
    return mix(vec3(F0_DIELECTRIC), params.base_color, vec3(params.metallic));
}

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
float metallic_roughness_length2(vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
float metallic_roughness_cos_half(vec3 wi, vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(metallic_roughness_length2(wi + wo));
}

// 1 - metallic_roughness_cos_half^2, the squared sine at which light meets the facet: of half the length of
// wi - wo.
float metallic_roughness_sin2_half(vec3 wi, vec3 wo) {
    vec3 apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
float metallic_roughness_weight(float cos_h, float sin2_h) {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    float k = sin2_h / (1.0 + cos_h);
    float k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
float metallic_roughness_schlick_weight_half(vec3 wi, vec3 wo) {
    return metallic_roughness_weight(metallic_roughness_cos_half(wi, wo),
        metallic_roughness_sin2_half(wi, wo));
}

// 1 - (1 - c)^5, with the factor c taken out so that it keeps its digits as c goes to 0.
float metallic_roughness_schlick_complement(float c) {
    float k = 1.0 - c;
    float k2 = k * k;
    return c * ((1.0 + k) * (1.0 + k2) + k2 * k2);
}

float metallic_roughness_alpha(MetallicRoughness params) {
    // Sharpest facets: a float32 direction is good to 6e-8, a thousandth of this width, so the shape of the
    // highlight is still resolved. The peak of D, 3e7, and its derivatives fit into a float32.
    const float ALPHA_MIN = 1.0e-4;
    return max(params.roughness * params.roughness, ALPHA_MIN);
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
vec2 metallic_roughness_slopes(vec3 h) {
    float inv = 1.0 / h.z;
    return vec2(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
float metallic_roughness_tangent2(vec3 h) {
    vec2 t = metallic_roughness_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
float metallic_roughness_round_ggx_D_along(MetallicRoughnessRoundGGX round_ggx, vec3 h) {
    const float inv_pi = 0.31830987;
    float a2 = round_ggx.alpha * round_ggx.alpha;
    float tan2 = metallic_roughness_tangent2(h);
    float r = (1.0 + tan2) / (a2 + tan2);
    return inv_pi * a2 * (r * r);
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
float metallic_roughness_round_ggx_area(MetallicRoughnessRoundGGX round_ggx, vec3 w) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrt(a2 + (1.0 - a2) * (w.z * w.z));
}

// G = 1 / (1 + Lambda_i + Lambda_o): correlated by the facet's height. Heitz 2014, Eq. 99.
float metallic_roughness_V_smith_correlated(MetallicRoughnessRoundGGX facets, vec3 wi,
    vec3 wo) {
    return 0.5 / (wo.z * metallic_roughness_round_ggx_area(facets, wi)
        + wi.z * metallic_roughness_round_ggx_area(facets, wo));
}

// D G / (4 mu_i mu_o): the highlight without F.
float metallic_roughness_highlight(MetallicRoughness params, vec3 wi, vec3 wo) {
    MetallicRoughnessRoundGGX facets = MetallicRoughnessRoundGGX(metallic_roughness_alpha(params));
    float D = metallic_roughness_round_ggx_D_along(facets, wi + wo);
    return D * metallic_roughness_V_smith_correlated(facets, wi, wo);
}

// BRDF value in 1/sr, without the cosine.
vec3 metallic_roughness_eval(MetallicRoughness params, vec3 wi, vec3 wo) {
    const float inv_pi = 0.31830987;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3(0.0);
    }
    vec3 f0 = metallic_roughness_f0(params);
    vec3 F = mix(f0, vec3(1.0), vec3(metallic_roughness_schlick_weight_half(wi, wo)));
    // 1 - F without its cancellation
    vec3 k_d = (1.0 - f0)
        * metallic_roughness_schlick_complement(metallic_roughness_cos_half(wi, wo));
    vec3 diffuse = inv_pi * (1.0 - params.metallic) * params.base_color * k_d;
    return diffuse + F * metallic_roughness_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// Mean of the three channels, by which lobes are weighed against each other.
float metallic_roughness_average(vec3 color) {
    return (color.x + color.y + color.z) / 3.0;
}

// (1 - cos_theta)^5 of Schlick's approximation.
float metallic_roughness_schlick_weight(float cos_theta) {
    float k = 1.0 - cos_theta;
    float k2 = k * k;
    return k2 * k2 * k;
}

float metallic_roughness_raised(float probability) {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const float SHARE_LEAST = 0.1;
    const float ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
vec2 metallic_roughness_lobes_shares(float first, float second) {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const float BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const float WEIGHT_MIN = 1.0e-37;
    float a = first + BLACK;
    float b = max(second, WEIGHT_MIN);
    float inv = 1.0 / (a + b);
    float P_first = metallic_roughness_raised(a * inv);
    float P_second = metallic_roughness_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return vec2(smaller ? P_first : 1.0 - P_second, smaller ? 1.0 - P_first : P_second);
}

// Probabilities of the diffuse lobe and of the highlight.
vec2 metallic_roughness_shares(MetallicRoughness params, vec3 wo) {
    vec3 f0 = metallic_roughness_f0(params);
    vec3 diffuse = (1.0 - params.metallic) * params.base_color * (1.0 - f0);
    return metallic_roughness_lobes_shares(metallic_roughness_average(diffuse),
        metallic_roughness_average(mix(f0, vec3(1.0),
            vec3(metallic_roughness_schlick_weight(wo.z)))));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
MetallicRoughnessChoice metallic_roughness_choose(float probability, vec2 u) {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const float SHARE_MIN = 1.0e-12;
    // The largest float32 below 1, up to which random numbers go.
    const float RANDOM_MAX = 0.99999994;
    bool first = u.x < probability;
    float below = u.x / max(probability, SHARE_MIN);
    float above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return MetallicRoughnessChoice(first, vec2(clamp(first ? below : above, 0.0, RANDOM_MAX), u.y));
}

// A direction with density cos(theta) / pi.
vec3 metallic_roughness_sample_cosine(vec2 u) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(u.x, 0.0));
    float phi = two_pi * u.y;
    return vec3(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// w where all facets are those of a unit sphere.
vec3 metallic_roughness_ggx_unstretched(MetallicRoughnessGGX ggx, vec3 w) {
    return normalize(vec3(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
vec3 metallic_roughness_ggx_half_way(MetallicRoughnessGGX ggx, vec3 w, float drop, float z,
    float v) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(drop * (2.0 - drop), 0.0));
    float phi = two_pi * v;
    vec3 h = vec3(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(vec3(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
vec3 metallic_roughness_ggx_sample_visible(MetallicRoughnessGGX ggx, vec3 wo, vec2 u) {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const float RANDOM_MARGIN = 5.9604645e-8;
    vec3 w = metallic_roughness_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    float u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    float height = 1.0 + w.z;
    return metallic_roughness_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m); see metallic_roughness_ggx_sample_visible.
vec3 metallic_roughness_round_ggx_sample_visible(MetallicRoughnessRoundGGX round_ggx, vec3 wo,
    vec2 u) {
    return metallic_roughness_ggx_sample_visible(MetallicRoughnessGGX(round_ggx.alpha,
        round_ggx.alpha), wo, u);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
vec3 metallic_roughness_mirror(vec3 wo, vec3 m) {
    return 2.0 * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
vec3 metallic_roughness_sample_ggx_lobe(MetallicRoughnessRoundGGX facets, vec3 wo, vec2 u) {
    vec3 w = metallic_roughness_mirror(wo,
        metallic_roughness_round_ggx_sample_visible(facets, wo, u));
    return vec3(w.x, w.y, abs(w.z));
}

// A direction of one of the two lobes; shares: the probabilities of the matte one and of the other.
vec3 metallic_roughness_sample_matte_gloss(vec3 wo, float alpha, vec2 shares, vec2 u) {
    MetallicRoughnessChoice choose_result = metallic_roughness_choose(shares.x, u);
    bool matte = choose_result.is_first;
    vec2 v = choose_result.u;
    return mix(metallic_roughness_sample_ggx_lobe(MetallicRoughnessRoundGGX(alpha), wo, v),
        metallic_roughness_sample_cosine(v), bvec3(matte));
}

// Density of metallic_roughness_sample_cosine in 1/sr, for w above the horizon.
float metallic_roughness_pdf_cosine(vec3 w) {
    const float inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Density of metallic_roughness_sample_ggx_lobe in 1/sr.
float metallic_roughness_pdf_ggx_lobe(MetallicRoughnessRoundGGX facets, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    // Smith's G1 over 4 mu_o
    float seen = 0.5 / (wo.z + metallic_roughness_round_ggx_area(facets, wo));
    float straight = metallic_roughness_round_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    bool exists = wo.z > wi.z;
    vec3 across = vec3(wi.x, wi.y, exists ? wo.z - wi.z : wi.z);
    float folded = metallic_roughness_round_ggx_D_along(facets, across
        + vec3(wo.x, wo.y, exists ? mu_min : wo.z));
    return (straight + (exists ? folded : 0.0)) * seen;
}

// Density of metallic_roughness_sample_matte_gloss in 1/sr.
float metallic_roughness_pdf_matte_gloss(vec3 wi, vec3 wo, float alpha, vec2 shares) {
    return shares.x * metallic_roughness_pdf_cosine(wi)
        + shares.y * metallic_roughness_pdf_ggx_lobe(MetallicRoughnessRoundGGX(alpha), wi, wo);
}

// Density of metallic_roughness_sample in 1/sr.
float metallic_roughness_pdf(MetallicRoughness params, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return metallic_roughness_pdf_matte_gloss(wi, wo, metallic_roughness_alpha(params),
        metallic_roughness_shares(params, wo));
}

// Cosine-weighted or a visible GGX normal, by the estimated albedos.
MetallicRoughnessSample metallic_roughness_sample(MetallicRoughness params, vec3 wo, vec2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return MetallicRoughnessSample(vec3(0.0, 0.0, 1.0), 0.0);
    }
    vec3 wi = metallic_roughness_sample_matte_gloss(wo, metallic_roughness_alpha(params),
        metallic_roughness_shares(params, wo), u);
    return MetallicRoughnessSample(wi, metallic_roughness_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
vec3 metallic_roughness_albedo(MetallicRoughness params, vec3 wo) {
    // Steps of the rule in metallic_roughness_albedo: a Fibonacci number, and the golden ratio.
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
        MetallicRoughnessSample drawn = metallic_roughness_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + metallic_roughness_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
