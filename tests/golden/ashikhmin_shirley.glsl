// SPDX-License-Identifier: Apache-2.0
// Ashikhmin-Shirley: an anisotropic Phong highlight over a diffuse part that it takes its light from.
//
// Source: Ashikhmin, Shirley, "An anisotropic Phong BRDF model", Journal of Graphics Tools 5(2), 2000: Eq.
// 4, 5 and, for samples, 6 to 9.
// Deviation: (N.H) to its power is taken from the slopes of H, which a sharp lobe needs in float32.
//
// GLSL 4.5, made by gonio from gonio/models/ashikhmin_shirley.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: AshikhminShirley params; params.rho = ...; ... ashikhmin_shirley_eval(params, wi, wo)

// A sampled direction and its density.
struct AshikhminShirleySample {
    vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// ashikhmin_shirley: Brushed metal and varnished wood by two exponents. Reciprocal.
struct AshikhminShirley {
    vec3 rho;  // diffuse reflectance R_d, linear RGB; 0 to 1, default (0.5, 0.5, 0.5)
    vec3 f0;  // reflectance R_s at normal incidence, linear RGB; 0 to 1, default (0.04, 0.04, 0.04)
    float shininess_x;  // exponent n_u along x; 0 to 100000, default 100
    float shininess_y;  // exponent n_v along y; 0 to 100000, default 100
};

// Which of two lobes a sample is taken from.
struct AshikhminShirleyChoice {
    bool is_first;  // Whether it is the first one
    vec2 u;  // Fresh random numbers, made of those that chose
};

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
float ashikhmin_shirley_length2(vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
float ashikhmin_shirley_cos_half(vec3 wi, vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(ashikhmin_shirley_length2(wi + wo));
}

// 1 - ashikhmin_shirley_cos_half^2, the squared sine at which light meets the facet: of half the length of
// wi - wo.
float ashikhmin_shirley_sin2_half(vec3 wi, vec3 wo) {
    vec3 apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
float ashikhmin_shirley_weight(float cos_h, float sin2_h) {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    float k = sin2_h / (1.0 + cos_h);
    float k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
float ashikhmin_shirley_schlick_weight_half(vec3 wi, vec3 wo) {
    return ashikhmin_shirley_weight(ashikhmin_shirley_cos_half(wi, wo),
        ashikhmin_shirley_sin2_half(wi, wo));
}

// 1 - (1 - mu / 2)^5, with the factor mu taken out.
float ashikhmin_shirley_below(float mu) {
    float k = 1.0 - 0.5 * mu;
    return 0.5 * mu * (1.0 + k * (1.0 + k * (1.0 + k * (1.0 + k))));
}

// The diffuse part, which is not stretched (Eq. 5).
vec3 ashikhmin_shirley_eval_round(AshikhminShirley params, vec3 wi, vec3 wo) {
    // Eq. 5: 28 / 23 makes the diffuse part of a black highlight lose nothing.
    const float DIFFUSE = 1.2173913;
    const float inv_pi = 0.31830987;
    float below = ashikhmin_shirley_below(wi.z) * ashikhmin_shirley_below(wo.z);
    return DIFFUSE * inv_pi * below * params.rho * (1.0 - params.f0);
}

// |wi + wo| / 2, the same with all digits however short it is: for what is divided by it.
float ashikhmin_shirley_half_length(vec3 wi, vec3 wo) {
    // wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
    // squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
    // much longer.
    const float LENGTHENED = 1.0995116e12;
    return 0.5 / LENGTHENED * sqrt(ashikhmin_shirley_length2(LENGTHENED * (wi + wo)));
}

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
vec3 ashikhmin_shirley_half_vector(vec3 wi, vec3 wo) {
    const float LENGTHENED = 1.0995116e12;
    vec3 h = LENGTHENED * (wi + wo);
    return h / sqrt(ashikhmin_shirley_length2(h));  // the root is the cosine's as well
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
float ashikhmin_shirley_atanh_over(float y) {
    float y2 = y * y;
    return 1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0 + y2 * (1.0 / 9.0))));
}

// log(1 + x) / x for x > -1; 1 at x = 0.
float ashikhmin_shirley_log1p_over(float x) {
    // Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
    const float LOG1P_SMALL = 0.25;
    float near = max(min(x, LOG1P_SMALL), -LOG1P_SMALL);
    bool small = x > -LOG1P_SMALL && x < LOG1P_SMALL;
    float far = small ? 1.0 : x;
    float series = ashikhmin_shirley_atanh_over(near / (2.0 + near));
    return small ? 2.0 / (2.0 + near) * series : log(1.0 + far) / far;
}

// Density of normals, times a weight.
//
// sqrt((n_u + 1) (n_v + 1)) / (2 pi) (N.m)^(n_u cos^2 + n_v sin^2 of the azimuth).
float ashikhmin_shirley_weighed(AshikhminShirley params, vec3 m, float weight) {
    const float inv_two_pi = 0.15915494;
    // -log(N.m) (n_u x^2 + n_v y^2) / (x^2 + y^2) with log(N.m) = -log(1 + tan^2) / 2: the square of the
    // sine cancels
    float x2 = m.x * m.x;
    float y2 = m.y * m.y;
    float z2 = m.z * m.z;
    float steep = 0.25 * ashikhmin_shirley_log1p_over((x2 + y2) / z2) / z2;
    float norm = inv_two_pi * sqrt((params.shininess_x + 1.0) * (params.shininess_y + 1.0));
    // The root of the power, which twice has a place in a float32 where the power by itself has none
    float root = exp(-(params.shininess_x * x2 + params.shininess_y * y2) * steep);
    return norm * root * (root * weight);
}

// The highlight of Eq. 4 without F.
float ashikhmin_shirley_highlight(AshikhminShirley params, vec3 wi, vec3 wo) {
    // Largest V of the maskings that grow like 1 / mu^2 where both directions graze: times the largest D, 3e7,
    // it still is a float32. It is reached at cosines of 5e-16.
    const float V_MAX = 1.0e30;
    float V = min(0.25 / ashikhmin_shirley_half_length(wi, wo) / max(wi.z, wo.z), V_MAX);
    return ashikhmin_shirley_weighed(params, ashikhmin_shirley_half_vector(wi, wo), V);
}

// Eq. 4 and 5: BRDF value in 1/sr, without the cosine.
vec3 ashikhmin_shirley_eval(AshikhminShirley params, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3(0.0);
    }
    vec3 F = mix(params.f0, vec3(1.0), vec3(ashikhmin_shirley_schlick_weight_half(wi, wo)));
    return ashikhmin_shirley_eval_round(params, wi, wo)
        + F * ashikhmin_shirley_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// (1 - cos_theta)^5 of Schlick's approximation.
float ashikhmin_shirley_schlick_weight(float cos_theta) {
    float k = 1.0 - cos_theta;
    float k2 = k * k;
    return k2 * k2 * k;
}

// Mean of the three channels, by which lobes are weighed against each other.
float ashikhmin_shirley_average(vec3 color) {
    return (color.x + color.y + color.z) / 3.0;
}

float ashikhmin_shirley_raised(float probability) {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const float SHARE_LEAST = 0.1;
    const float ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
vec2 ashikhmin_shirley_lobes_shares(float first, float second) {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const float BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const float WEIGHT_MIN = 1.0e-37;
    float a = first + BLACK;
    float b = max(second, WEIGHT_MIN);
    float inv = 1.0 / (a + b);
    float P_first = ashikhmin_shirley_raised(a * inv);
    float P_second = ashikhmin_shirley_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return vec2(smaller ? P_first : 1.0 - P_second, smaller ? 1.0 - P_first : P_second);
}

// Probabilities of the diffuse part and of the highlight.
vec2 ashikhmin_shirley_shares(AshikhminShirley params, vec3 wo) {
    vec3 F = mix(params.f0, vec3(1.0), vec3(ashikhmin_shirley_schlick_weight(wo.z)));
    return ashikhmin_shirley_lobes_shares(ashikhmin_shirley_average(params.rho * (1.0 - params.f0)),
        ashikhmin_shirley_average(F));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
AshikhminShirleyChoice ashikhmin_shirley_choose(float probability, vec2 u) {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const float SHARE_MIN = 1.0e-12;
    // The largest float32 below 1, up to which random numbers go.
    const float RANDOM_MAX = 0.99999994;
    bool first = u.x < probability;
    float below = u.x / max(probability, SHARE_MIN);
    float above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return AshikhminShirleyChoice(first, vec2(clamp(first ? below : above, 0.0, RANDOM_MAX), u.y));
}

// A direction with density cos(theta) / pi.
vec3 ashikhmin_shirley_sample_cosine(vec2 u) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(u.x, 0.0));
    float phi = two_pi * u.y;
    return vec3(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// exp(x) - 1, exact where x is small.
float ashikhmin_shirley_expm1(float x) {
    // Below this the series needs few terms; above, the plain difference is exact to 2e-7 in float32.
    const float EXPM1_SMALL = 0.3;
    float near = max(min(x, EXPM1_SMALL), -EXPM1_SMALL);
    // Taylor's series
    float over = 1.0 + near
        * (0.5 + near * (0.16666667
            + near * (0.041666668
                + near * (0.008333334 + near * (0.0013888889 + near * 0.0001984127)))));
    return x > -EXPM1_SMALL && x < EXPM1_SMALL ? near * over : exp(x) - 1.0;
}

vec3 ashikhmin_shirley_normal(AshikhminShirley params, vec2 u) {
    const float two_pi = 6.2831855;
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const float RANDOM_MARGIN = 5.9604645e-8;
    float phi = two_pi * u.y;
    float x = cos(phi) / sqrt(params.shininess_x + 1.0);
    float y = sin(phi) / sqrt(params.shininess_y + 1.0);
    float r2 = x * x + y * y;
    float exponent = (params.shininess_x * x * x + params.shininess_y * y * y) / r2;
    float tan2 = ashikhmin_shirley_expm1(-2.0 / (exponent + 1.0)
        * log(max(1.0 - u.x, RANDOM_MARGIN)));
    float scale = sqrt(max(tan2, 0.0)) / sqrt(r2);
    return normalize(vec3(x * scale, y * scale, 1.0));
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
vec3 ashikhmin_shirley_mirror(vec3 wo, vec3 m) {
    return 2.0 * dot(wo, m) * m - wo;
}

// Density of ashikhmin_shirley_sample_cosine in 1/sr, for w above the horizon.
float ashikhmin_shirley_pdf_cosine(vec3 w) {
    const float inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Density of ashikhmin_shirley_sample in 1/sr (Eq. 8).
float ashikhmin_shirley_pdf(AshikhminShirley params, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    vec2 P = ashikhmin_shirley_shares(params, wo);
    float facets = ashikhmin_shirley_weighed(params, ashikhmin_shirley_half_vector(wi, wo),
        0.25 / ashikhmin_shirley_half_length(wi, wo));
    return P.x * ashikhmin_shirley_pdf_cosine(wi) + P.y * facets;
}

// Cosine-weighted, or wo mirrored at a normal by its density (Eq. 6, 7 and 9).
AshikhminShirleySample ashikhmin_shirley_sample(AshikhminShirley params, vec3 wo, vec2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return AshikhminShirleySample(vec3(0.0, 0.0, 1.0), 0.0);
    }
    AshikhminShirleyChoice choose_result = ashikhmin_shirley_choose(ashikhmin_shirley_shares(params,
        wo).x, u);
    bool matte = choose_result.is_first;
    vec2 v = choose_result.u;
    vec3 wi = mix(ashikhmin_shirley_mirror(wo, ashikhmin_shirley_normal(params, v)),
        ashikhmin_shirley_sample_cosine(v), bvec3(matte));
    return AshikhminShirleySample(wi, ashikhmin_shirley_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
vec3 ashikhmin_shirley_albedo(AshikhminShirley params, vec3 wo) {
    // Steps of the rule in ashikhmin_shirley_albedo: a Fibonacci number, and the golden ratio.
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
        AshikhminShirleySample drawn = ashikhmin_shirley_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + ashikhmin_shirley_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
