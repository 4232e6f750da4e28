// SPDX-License-Identifier: Apache-2.0
// SGD: the shifted gamma distribution of facets, which was fitted to a hundred measured materials.
//
// Source: Bagher, Soler, Holzschuch, "Accurate fitting of measured reflectances using a shifted gamma
// micro-facet distribution", Computer Graphics Forum 31(4), 2012. Every number has three channels; K, the
// masking and F are free of each other, as in the published fits. Deviations: c (theta - theta_0)^k is
// ((theta - theta_0) / width)^k with width = c^(-1/k), as c of some fits is above 10^100; F and G are never
// below 0.
//
// HLSL, made by gonio from gonio/models/sgd.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: Sgd params; params.rho = ...; ... sgd_eval(params, wi, wo)

float3 sgd_select(bool3 condition, float3 yes, float3 no) {
    return float3(condition.x ? yes.x : no.x, condition.y ? yes.y : no.y, condition.z ? yes.z : no.z);
}

// A sampled direction and its density.
struct SgdSample {
    float3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// sgd: Paints, metals and plastics as they were measured; the default is a gold paint. Reciprocal.
struct Sgd {
    float3 rho;  // diffuse albedo, linear RGB; 0 to 1, default (0.147708, 0.0806975, 0.033172)
    // weight of the highlight, linear RGB; 0 to 10, default (0.160592, 0.217282, 0.236425)
    float3 specular;
    // shift, and width of the squared slopes; 1e-05 to 1, default (0.122506, 0.108069, 0.12187)
    float3 alpha;
    float3 p;  // power of the distribution's tail; 0 to 2, default (0.795078, 0.637578, 0.936117)
    float3 f0;  // F's constant; 0 to 10, default (0, 0, 0.0024589)
    // F's slope: f0 - f1 at normal incidence; -2 to 10, default (-0.596835, -0.331147, -0.140729)
    float3 f1;
    // K: 1 / (alpha Gamma(1 - p, alpha)) where D is normalized; 0 to 100000, default (5.98176,
    // 7.35539, 5.29722)
    float3 normalization;
    float3 masking_strength;  // Lambda; 0 to 1e+08, default (2.64832, 3.04253, 2.3013)
    // theta_0 in radians: G is 1 up to there; -1 to 1.5, default (-0.284195, -0.277297, -0.245352)
    float3 masking_angle;
    // c^(-1/k): radians from there on; 0.01 to 100, default (1.943735, 1.94587, 1.890624)
    float3 masking_width;
    // k: how suddenly masking begins; 1 to 1000, default (24.3593, 24.4037, 25.3623)
    float3 masking_exponent;
};

// Densities of one channel's facets for samples: s^-p up to s = 1, and exp(1 - s) beyond.
//
// s is alpha + tan^2 / alpha. The distribution itself, s^-p exp(-s), has no inverse; it is at most the one
// for samples, and at least a third of that before s = 1.
struct SgdShiftedGamma {
    float alpha;  // Shift, and width of the squared slopes
    float p;  // Power of the tail
};

// Which of two lobes a sample is taken from.
struct SgdChoice {
    bool is_first;  // Whether it is the first one
    float2 u;  // Fresh random numbers, made of those that chose
};

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
float sgd_length2(float3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
float3 sgd_half_vector(float3 wi, float3 wo) {
    // wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
    // squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
    // much longer.
    const float LENGTHENED = 1.0995116e12;
    float3 h = LENGTHENED * (wi + wo);
    return h / sqrt(sgd_length2(h));  // the root is the cosine's as well
}

// 2 atan(v) / v for v in [-1, 1], the angle whose half has the tangent v; 2 at v = 0.
float sgd_twice_atan_over(float v) {
    const float ATAN_0 = 2.0;  // 2 atan(v) / v in v^2 on [0, 1]; fitted, relative error below 2e-8.
    const float ATAN_1 = -0.66666144;
    const float ATAN_2 = 0.3998524;
    const float ATAN_3 = -0.28407288;
    const float ATAN_4 = 0.21281867;
    const float ATAN_5 = -0.15008585;
    const float ATAN_6 = 0.085383;
    const float ATAN_7 = -0.03213723;
    const float ATAN_8 = 0.005699773;
    float q = v * v;
    float p = ATAN_4 + q * (ATAN_5 + q * (ATAN_6 + q * (ATAN_7 + q * ATAN_8)));
    return ATAN_0 + q * (ATAN_1 + q * (ATAN_2 + q * (ATAN_3 + q * p)));
}

// exp(x) - 1, exact where x is small.
float sgd_expm1(float x) {
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

// 1 + Lambda (1 - exp(((theta - theta_0) / width)^k)).
float3 sgd_G(Sgd params, float3 w) {
    // Largest x of exp(x) in the masking, where G of all fits is 0 before; and the smallest, where 1.8e-35 of
    // Lambda changes no G and still is a normal float32.
    const float LOG_MAX = 3.0;
    const float LOG_MIN = -80.0;
    // Angles and squared cosines below which a logarithm or quotient leaves a float32.
    const float ANGLE_MIN = 1.0e-12;
    float v = sqrt(w.x * w.x + w.y * w.y) / (1.0 + w.z);
    float3 beyond = v * sgd_twice_atan_over(v) - params.masking_angle;
    float3 x = log(max(beyond, float3(ANGLE_MIN, ANGLE_MIN, ANGLE_MIN)))
        - log(params.masking_width);
    float3 t = max(min(params.masking_exponent * x, float3(LOG_MAX, LOG_MAX, LOG_MAX)),
        float3(LOG_MIN, LOG_MIN, LOG_MIN));
    // expm1 of each channel
    float3 lost = exp(t);
    float3 masked = params.masking_strength
        * float3(sgd_expm1(lost.x), sgd_expm1(lost.y), sgd_expm1(lost.z));
    return sgd_select(beyond > float3(0.0, 0.0, 0.0),
        clamp(1.0 - masked, float3(0.0, 0.0, 0.0), float3(1.0, 1.0, 1.0)), float3(1.0, 1.0, 1.0));
}

// K s^-p exp(-s) / cos^4 with s = alpha + tan^2 / alpha.
float3 sgd_D(Sgd params, float3 m) {
    // Largest squared slope over alpha, where D is 0 in every precision.
    const float SLOPE_MAX = 10000.0;
    const float COS2_MIN = 1.0e-30;
    float z2 = max(m.z * m.z, COS2_MIN);
    float3 s = params.alpha
        + min((m.x * m.x + m.y * m.y) / z2 / params.alpha, float3(SLOPE_MAX, SLOPE_MAX, SLOPE_MAX));
    return params.normalization * exp(-params.p * log(s) - s - 2.0 * log(z2));
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
float sgd_cos_half(float3 wi, float3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(sgd_length2(wi + wo));
}

// Schlick's with a slope.
float3 sgd_F(Sgd params, float cos_h) {
    float c = 1.0 - min(cos_h, 1.0);
    float c5 = c * c * (c * c) * c;
    return max(params.f0 - params.f1 * cos_h + (1.0 - params.f0) * c5, float3(0.0, 0.0, 0.0));
}

// rho / pi + specular / pi F D G / (mu_i mu_o): BRDF value in 1/sr, without the cosine.
float3 sgd_eval(Sgd params, float3 wi, float3 wo) {
    const float inv_pi = 0.31830987;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    // Largest 1 / (mu_i mu_o), at cosines of 1e-4: times D and its derivatives it still is a float32.
    const float V_SGD = 1.0e8;
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return float3(0.0, 0.0, 0.0);
    }
    float3 m = sgd_half_vector(wi, wo);
    float3 G = sgd_G(params, wi) * sgd_G(params, wo);
    float3 D = sgd_D(params, m) * min(1.0 / wi.z / wo.z, V_SGD);
    return inv_pi * (params.rho + params.specular * sgd_F(params, sgd_cos_half(wi, wo)) * (G * D));
}

// ---- sampling ------------------------------------------------------------------------------

// The facets of a channel.
SgdShiftedGamma sgd_red(Sgd params) {
    SgdShiftedGamma result;
    result.alpha = params.alpha.x;
    result.p = params.p.x;
    return result;
}

// 1 - p, not quite 0.
float sgd_shifted_gamma_one_less(SgdShiftedGamma shifted_gamma) {
    // Nearer to 1 than this, 1 - p is taken as this: what is divided by it differs by as little.
    const float POWER_MIN = 1.0e-4;
    float q = 1.0 - shifted_gamma.p;
    return q < 0.0 ? min(q, -POWER_MIN) : max(q, POWER_MIN);
}

// The integral of s^-p from alpha to 1; that of the rest is 1.
float sgd_shifted_gamma_near(SgdShiftedGamma shifted_gamma) {
    float q = sgd_shifted_gamma_one_less(shifted_gamma);
    return -sgd_expm1(q * log(shifted_gamma.alpha)) / q;
}

// The facets of a channel.
SgdShiftedGamma sgd_green(Sgd params) {
    SgdShiftedGamma result;
    result.alpha = params.alpha.y;
    result.p = params.p.y;
    return result;
}

// The facets of a channel.
SgdShiftedGamma sgd_blue(Sgd params) {
    SgdShiftedGamma result;
    result.alpha = params.alpha.z;
    result.p = params.p.z;
    return result;
}

// Mean of the three channels, by which lobes are weighed against each other.
float sgd_average(float3 color) {
    return (color.x + color.y + color.z) / 3.0;
}

float sgd_raised(float probability) {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const float SHARE_LEAST = 0.1;
    const float ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
float2 sgd_lobes_shares(float first, float second) {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const float BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const float WEIGHT_MIN = 1.0e-37;
    float a = first + BLACK;
    float b = max(second, WEIGHT_MIN);
    float inv = 1.0 / (a + b);
    float P_first = sgd_raised(a * inv);
    float P_second = sgd_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return float2(smaller ? P_first : 1.0 - P_second, smaller ? 1.0 - P_first : P_second);
}

// Probabilities of the diffuse part and of the highlight, as if it was a mirror.
float2 sgd_shares(Sgd params, float3 wo) {
    float3 near = float3(sgd_shifted_gamma_near(sgd_red(params)),
        sgd_shifted_gamma_near(sgd_green(params)), sgd_shifted_gamma_near(sgd_blue(params)));
    float3 mass = params.normalization * params.alpha * (near + 1.0);
    return sgd_lobes_shares(sgd_average(params.rho),
        4.0 * sgd_average(params.specular * sgd_F(params, wo.z) * mass));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
SgdChoice sgd_choose(float probability, float2 u) {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const float SHARE_MIN = 1.0e-12;
    // The largest float32 below 1, up to which random numbers go.
    const float RANDOM_MAX = 0.99999994;
    bool first = u.x < probability;
    float below = u.x / max(probability, SHARE_MIN);
    float above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    SgdChoice result;
    result.is_first = first;
    result.u = float2(clamp(first ? below : above, 0.0, RANDOM_MAX), u.y);
    return result;
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
float sgd_atanh_over(float y) {
    float y2 = y * y;
    return 1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0 + y2 * (1.0 / 9.0))));
}

// log(1 + x) / x for x > -1; 1 at x = 0.
float sgd_log1p_over(float x) {
    // Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
    const float LOG1P_SMALL = 0.25;
    float near = max(min(x, LOG1P_SMALL), -LOG1P_SMALL);
    bool small = x > -LOG1P_SMALL && x < LOG1P_SMALL;
    float far = small ? 1.0 : x;
    float series = sgd_atanh_over(near / (2.0 + near));
    return small ? 2.0 / (2.0 + near) * series : log(1.0 + far) / far;
}

// log(1 + x) for x > -1, exact where x is small.
float sgd_log1p(float x) {
    return x * sgd_log1p_over(x);
}

// A normal.
float3 sgd_shifted_gamma_sample(SgdShiftedGamma shifted_gamma, float2 u) {
    const float ANGLE_MIN = 1.0e-12;
    const float two_pi = 6.2831855;
    float near = sgd_shifted_gamma_near(shifted_gamma);
    float q = sgd_shifted_gamma_one_less(shifted_gamma);
    float v = u.x * (near + 1.0);
    bool inside = v < near;
    // s = alpha (1 + q v alpha^-q)^(1/q), less alpha
    float grown = sgd_log1p(q * min(v, near) * exp(-q * log(shifted_gamma.alpha))) / q;
    float x = shifted_gamma.alpha * sgd_expm1(grown);
    float far = 1.0 - shifted_gamma.alpha - log(max(1.0 + near - v, ANGLE_MIN));
    float tangent = sqrt(shifted_gamma.alpha * max(inside ? x : far, 0.0));
    float phi = two_pi * u.y;
    return normalize(float3(tangent * cos(phi), tangent * sin(phi), 1.0));
}

// A direction with density cos(theta) / pi.
float3 sgd_sample_cosine(float2 u) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(u.x, 0.0));
    float phi = two_pi * u.y;
    return float3(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
float3 sgd_mirror(float3 wo, float3 m) {
    return 2.0 * dot(wo, m) * m - wo;
}

// Of normals in 1/sr.
float sgd_shifted_gamma_density(SgdShiftedGamma shifted_gamma, float3 m) {
    const float SLOPE_MAX = 10000.0;
    const float COS2_MIN = 1.0e-30;
    const float inv_pi = 0.31830987;
    float z2 = max(m.z * m.z, COS2_MIN);
    float x = min((m.x * m.x + m.y * m.y) / z2 / shifted_gamma.alpha, SLOPE_MAX);
    float s = shifted_gamma.alpha + x;
    float tail = s < 1.0 ? exp(-shifted_gamma.p * log(min(s, 1.0))) : exp(min(1.0 - s, 0.0));
    return inv_pi * tail / ((sgd_shifted_gamma_near(shifted_gamma) + 1.0) * shifted_gamma.alpha)
        / z2 * (m.z / z2);
}

// Density of sgd_sample_cosine in 1/sr, for w above the horizon.
float sgd_pdf_cosine(float3 w) {
    const float inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// |wi + wo| / 2, the same with all digits however short it is: for what is divided by it.
float sgd_half_length(float3 wi, float3 wo) {
    const float LENGTHENED = 1.0995116e12;
    return 0.5 / LENGTHENED * sqrt(sgd_length2(LENGTHENED * (wi + wo)));
}

// Density of sgd_mirror in 1/sr, if m has the given density and cos_h = wo . m.
float sgd_pdf_mirror(float density, float cos_h) {
    // Walter et al., Eq. 14
    return 0.25 * density / cos_h;
}

// Density of sgd_sample in 1/sr.
float sgd_pdf(Sgd params, float3 wi, float3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    float2 P = sgd_shares(params, wo);
    float3 m = sgd_half_vector(wi, wo);
    float facets = sgd_shifted_gamma_density(sgd_red(params), m)
        + sgd_shifted_gamma_density(sgd_green(params), m);
    facets = (facets + sgd_shifted_gamma_density(sgd_blue(params), m)) / 3.0;
    return P.x * sgd_pdf_cosine(wi) + P.y * sgd_pdf_mirror(facets, sgd_half_length(wi, wo));
}

// Cosine-weighted, or wo mirrored at a normal of one of the channels.
SgdSample sgd_sample(Sgd params, float3 wo, float2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        SgdSample result;
        result.wi = float3(0.0, 0.0, 1.0);
        result.pdf = 0.0;
        return result;
    }
    SgdChoice choose_result = sgd_choose(sgd_shares(params, wo).x, u);
    bool matte = choose_result.is_first;
    float2 v = choose_result.u;
    float thirds = 3.0 * v.x;
    float2 w = float2(frac(thirds), v.y);
    float3 m = sgd_shifted_gamma_sample(sgd_red(params), w);
    m = thirds < 1.0 ? m : sgd_shifted_gamma_sample(sgd_green(params), w);
    m = thirds < 2.0 ? m : sgd_shifted_gamma_sample(sgd_blue(params), w);
    float3 wi = matte ? sgd_sample_cosine(v) : sgd_mirror(wo, m);
    SgdSample result;
    result.wi = wi;
    result.pdf = sgd_pdf(params, wi, wo);
    return result;
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
float3 sgd_albedo(Sgd params, float3 wo) {
    // Steps of the rule in sgd_albedo: a Fibonacci number, and the golden ratio.
    const float ALBEDO_SAMPLES = 987.0;
    const float GOLDEN = 0.618034;
    // Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
    const float HORIZON = 1.0e-6;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z < 0.0) {  // below the horizon
        return float3(0.0, 0.0, 0.0);
    }
    float3 w = float3(wo.x, wo.y, max(wo.z, HORIZON));
    float3 total = float3(0.0, 0.0, 0.0);
    for (int i_step = 0; i_step < int(ALBEDO_SAMPLES); ++i_step) {
        float i = float(i_step);
        float2 u = float2((i + 0.5) / ALBEDO_SAMPLES, frac((i + 0.5) * GOLDEN));
        SgdSample drawn = sgd_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + sgd_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
