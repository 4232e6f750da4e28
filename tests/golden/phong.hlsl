// SPDX-License-Identifier: Apache-2.0
// Phong: a diffuse term and a highlight around the mirror direction.
//
// Sources: Phong, "Illumination for computer generated pictures", Communications of the ACM 18(6), 1975;
// Lafortune, Willems, "Using the modified Phong reflectance model for physically based rendering", 1994,
// for the normalised form. alpha is the angle between wi and the mirror direction of wo.
// Phong's formula gives the radiance f cos(theta_i); "classical" is that formula divided by the cosine.
//
// HLSL, made by gonio from gonio/models/phong.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: Phong params; params.rho = ...; ... phong_eval(params, wi, wo)

// A sampled direction and its density.
struct PhongSample {
    float3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// phong: Diffuse with a round highlight around the mirror direction, the classic of computer graphics.
// Exported with form='normalized'.
struct Phong {
    float3 rho;  // albedo of the diffuse term, linear RGB; 0 to 1, default (0.5, 0.5, 0.5)
    float3 specular;  // weight of the highlight, linear RGB; 0 to 1, default (0.3, 0.3, 0.3)
    float shininess;  // exponent n of the highlight; 0 to 100000, default 20
};

// Which of two lobes a sample is taken from.
struct PhongChoice {
    bool is_first;  // Whether it is the first one
    float2 u;  // Fresh random numbers, made of those that chose
};

// ---- evaluation ----------------------------------------------------------------------------

// Cosine between wi and the mirror direction of wo: mu_i mu_o - wi.x wo.x - wi.y wo.y.
//
// Near 0 the three products cancel. The rounding errors of the last two and of their sum are carried along
// (Kahan's and Knuth's ways to find them), so that a broad lobe fades out with all its digits; the first
// product comes in with a single rounding, which is small beside what is left.
float phong_cos_alpha(float3 wi, float3 wo) {
    float x = wi.x * wo.x;
    float y = wi.y * wo.y;
    float s = x + y;
    float back_y = s - x;
    float error_s = x - (s - back_y) + (y - back_y);
    float error = mad(wi.x, wo.x, -x) + mad(wi.y, wo.y, -y) + error_s;
    return mad(wi.z, wo.z, -s) - error;
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
float phong_atanh_over(float y) {
    float y2 = y * y;
    return 1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0 + y2 * (1.0 / 9.0))));
}

// log(1 + x) for x from -LOG1P_SMALL to LOG1P_SMALL.
float phong_log1p_small(float x) {
    float y = x / (2.0 + x);
    return 2.0 * y * phong_atanh_over(y);
}

// max(0, cos(alpha))^exponent; half of all directions have 0 for exponent 0 as well.
float phong_lobe(float3 wi, float3 wo, float exponent) {
    // Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
    const float LOG1P_SMALL = 0.25;
    // Smallest cosine whose logarithm is taken: its reciprocal, the derivative, still is a float32.
    const float COS_MIN = 1.0e-37;
    // Inside, the digits of a sharp lobe are in 1 - cos(alpha): half the squared distance to the
    // mirror direction.
    float3 apart = float3(wi.x + wo.x, wi.y + wo.y, wi.z - wo.z);
    float q = 0.5 * dot(apart, apart);
    float c = phong_cos_alpha(wi, wo);
    float near = phong_log1p_small(-min(q, LOG1P_SMALL));
    float log_cos = q < LOG1P_SMALL ? near : log(clamp(c, COS_MIN, 1.0));
    return c > 0.0 ? exp(exponent * log_cos) : 0.0;
}

// The highlight without its weight.
float phong_highlight(Phong params, float3 wi, float3 wo) {
    const float inv_two_pi = 0.15915494;
    float n = params.shininess;
    return inv_two_pi * (n + 2.0) * phong_lobe(wi, wo, n);
}

// BRDF value in 1/sr, without the cosine.
float3 phong_eval(Phong params, float3 wi, float3 wo) {
    const float inv_pi = 0.31830987;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return float3(0.0, 0.0, 0.0);
    }
    return params.rho * inv_pi + params.specular * phong_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// Mean of the three channels, by which lobes are weighed against each other.
float phong_average(float3 color) {
    return (color.x + color.y + color.z) / 3.0;
}

float phong_raised(float probability) {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const float SHARE_LEAST = 0.1;
    const float ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
float2 phong_lobes_shares(float first, float second) {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const float BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const float WEIGHT_MIN = 1.0e-37;
    float a = first + BLACK;
    float b = max(second, WEIGHT_MIN);
    float inv = 1.0 / (a + b);
    float P_first = phong_raised(a * inv);
    float P_second = phong_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return float2(smaller ? P_first : 1.0 - P_second, smaller ? 1.0 - P_first : P_second);
}

// Probabilities of the diffuse lobe and of the highlight.
float2 phong_shares(Phong params, float3 wo) {
    const float pi = 3.1415927;
    float n = params.shininess;
    // 1 at the normal; in the horizon about 1 / sqrt(2 pi n), and 1/2 for n = 0
    float highlight = lerp(0.5 / sqrt(1.0 + 0.5 * pi * n), 1.0, wo.z);
    return phong_lobes_shares(phong_average(params.rho),
        phong_average(params.specular) * highlight);
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
PhongChoice phong_choose(float probability, float2 u) {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const float SHARE_MIN = 1.0e-12;
    // The largest float32 below 1, up to which random numbers go.
    const float RANDOM_MAX = 0.99999994;
    bool first = u.x < probability;
    float below = u.x / max(probability, SHARE_MIN);
    float above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    PhongChoice result;
    result.is_first = first;
    result.u = float2(clamp(first ? below : above, 0.0, RANDOM_MAX), u.y);
    return result;
}

// A direction with density cos(theta) / pi.
float3 phong_sample_cosine(float2 u) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(u.x, 0.0));
    float phi = two_pi * u.y;
    return float3(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// exp(x) - 1, exact where x is small.
float phong_expm1(float x) {
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

// Cosine and sine of wo's azimuth; (1, 0) at normal incidence.
float2 phong_azimuth(float3 wo) {
    // Below this squared sine the azimuth of wo is taken as 0: any azimuth is right there, and the square of
    // its reciprocal still fits into a float32.
    const float SIN2_MIN = 1.0e-18;
    float sin2 = wo.x * wo.x + wo.y * wo.y;
    bool tilted = sin2 > SIN2_MIN;
    float inv = 1.0 / sqrt(max(sin2, SIN2_MIN));
    return float2(tilted ? wo.x * inv : 1.0, tilted ? wo.y * inv : 0.0);
}

// A direction around wo's mirror image with density (n + 1) / (2 pi) cos(alpha)^n.
//
// What falls below the horizon is mirrored up again, so that no sample is wasted.
float3 phong_sample_lobe(float3 wo, float exponent, float2 u) {
    const float two_pi = 6.2831855;
    // cos(alpha) = (1 - u)^(1 / (n + 1)), and sin^2 = 1 - cos^2 without cancellation
    float t = log(1.0 - u.x) / (exponent + 1.0);
    float c = exp(t);
    float s = sqrt(max(-phong_expm1(2.0 * t), 0.0));
    float phi = two_pi * u.y;
    // A frame around the mirror direction: towards the normal, and level.
    float2 axis = phong_azimuth(wo);
    float sin_o = sqrt(max(wo.x * wo.x + wo.y * wo.y, 0.0));
    float x = s * cos(phi);
    float y = s * sin(phi);
    float outward = c * sin_o - x * wo.z;
    float up = c * wo.z + x * sin_o;
    float3 w = float3(-axis.x * outward + axis.y * y, -axis.y * outward - axis.x * y, up);
    return normalize(float3(w.x, w.y, abs(w.z)));
}

// Density of phong_sample_cosine in 1/sr, for w above the horizon.
float phong_pdf_cosine(float3 w) {
    const float inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Density of phong_sample_lobe in 1/sr.
float phong_pdf_lobe(float3 wi, float3 wo, float exponent) {
    const float inv_two_pi = 0.15915494;
    float both = phong_lobe(wi, wo, exponent) + phong_lobe(float3(wi.x, wi.y, -wi.z), wo, exponent);
    return inv_two_pi * (exponent + 1.0) * both;
}

// Density of phong_sample in 1/sr.
float phong_pdf(Phong params, float3 wi, float3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    float2 P = phong_shares(params, wo);
    return P.x * phong_pdf_cosine(wi) + P.y * phong_pdf_lobe(wi, wo, params.shininess);
}

// Cosine-weighted, or around the mirror direction, by the estimated albedos.
PhongSample phong_sample(Phong params, float3 wo, float2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        PhongSample result;
        result.wi = float3(0.0, 0.0, 1.0);
        result.pdf = 0.0;
        return result;
    }
    PhongChoice choose_result = phong_choose(phong_shares(params, wo).x, u);
    bool first = choose_result.is_first;
    float2 v = choose_result.u;
    float3 wi = first ? phong_sample_cosine(v) : phong_sample_lobe(wo, params.shininess, v);
    PhongSample result;
    result.wi = wi;
    result.pdf = phong_pdf(params, wi, wo);
    return result;
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
float3 phong_albedo(Phong params, float3 wo) {
    // Steps of the rule in phong_albedo: a Fibonacci number, and the golden ratio.
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
        PhongSample drawn = phong_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + phong_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
