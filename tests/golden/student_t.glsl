// SPDX-License-Identifier: Apache-2.0
// Student-t: facets whose slopes have tails of any length, between Beckmann's and longer than GGX's.
//
// Source: Ribardiere, Bringier, Meneveaux, Simonot, "STD: Student's t-distribution of slopes for microfacet
// based BSDFs", Computer Graphics Forum 36(2), 2017: D and its samples. gamma = 2 is GGX, and large gammas
// come near Beckmann. Burley's GTR, "Physically-based shading at Disney", 2012, has the same family of
// tails. Deviation: G is Cook and Torrance's, which is exact for V-cavities of any facets and needs no fit.
//
// GLSL 4.5, made by gonio from gonio/models/student_t.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: StudentT params; params.f0 = ...; ... student_t_eval(params, wi, wo)

// A sampled direction and its density.
struct StudentTSample {
    vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// student_t: Metals and plastics whose highlights have the tail that was measured. Reciprocal.
struct StudentT {
    vec3 f0;  // reflectance at normal incidence, linear RGB; 0 to 1, default (0.9, 0.9, 0.9)
    float alpha;  // slope width: GGX's alpha at gamma = 2; 0.001 to 1, default 0.3
    // tail: 2 is GGX's, smaller is longer, 40 is nearly Beckmann's; 1.55 to 40, default 2
    float gamma;
};

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
float student_t_length2(vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
float student_t_cos_half(vec3 wi, vec3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(student_t_length2(wi + wo));
}

// 1 - student_t_cos_half^2, the squared sine at which light meets the facet: of half the length of wi - wo.
float student_t_sin2_half(vec3 wi, vec3 wo) {
    vec3 apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
float student_t_weight(float cos_h, float sin2_h) {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    float k = sin2_h / (1.0 + cos_h);
    float k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
float student_t_schlick_weight_half(vec3 wi, vec3 wo) {
    return student_t_weight(student_t_cos_half(wi, wo), student_t_sin2_half(wi, wo));
}

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
vec3 student_t_half_vector(vec3 wi, vec3 wo) {
    // wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
    // squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
    // much longer.
    const float LENGTHENED = 1.0995116e12;
    vec3 h = LENGTHENED * (wi + wo);
    return h / sqrt(student_t_length2(h));  // the root is the cosine's as well
}

// atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x).
float student_t_atanh_over(float y) {
    float y2 = y * y;
    return 1.0 + y2 * (1.0 / 3.0 + y2 * (1.0 / 5.0 + y2 * (1.0 / 7.0 + y2 * (1.0 / 9.0))));
}

// log(1 + x) / x for x > -1; 1 at x = 0.
float student_t_log1p_over(float x) {
    // Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
    const float LOG1P_SMALL = 0.25;
    float near = max(min(x, LOG1P_SMALL), -LOG1P_SMALL);
    bool small = x > -LOG1P_SMALL && x < LOG1P_SMALL;
    float far = small ? 1.0 : x;
    float series = student_t_atanh_over(near / (2.0 + near));
    return small ? 2.0 / (2.0 + near) * series : log(1.0 + far) / far;
}

// log(1 + x) for x > -1, exact where x is small.
float student_t_log1p(float x) {
    return x * student_t_log1p_over(x);
}

// 1 / (pi a^2 z^4 (1 + x)^g) with x = tan^2 / ((g - 1) a^2).
float student_t_D(StudentT params, vec3 m) {
    // Largest squared slope in units of the widths: more leaves a float32, and D is 0 long before.
    const float RATIO_MAX = 1.0e37;
    const float inv_pi = 0.31830987;
    float a2 = params.alpha * params.alpha;
    float z2 = m.z * m.z;
    float slope2 = (m.x * m.x + m.y * m.y) / ((params.gamma - 1.0) * a2);
    // z^-4 (1 + x)^-g = (z^2 + slope2)^-2 (1 + x)^(2 - g), finite in the horizon; log1p keeps the digits that a
    // large g multiplies
    float x = min(slope2 / z2, RATIO_MAX);
    float whole = z2 + slope2;
    return inv_pi / a2 / (whole * whole) * exp((2.0 - params.gamma) * student_t_log1p(x));
}

// G over 4 mu_i mu_o.
float student_t_V_cook_torrance(vec3 wi, vec3 wo) {
    // Largest V of the maskings that grow like 1 / mu^2 where both directions graze: times the largest D, 3e7,
    // it still is a float32. It is reached at cosines of 5e-16.
    const float V_MAX = 1.0e30;
    vec3 h = wi + wo;
    return min(min(h.z / student_t_length2(h) * min(wi.z, wo.z), 0.25) / (wi.z * wo.z), V_MAX);
}

// D G / (4 mu_i mu_o): the highlight without F.
float student_t_highlight(StudentT params, vec3 wi, vec3 wo) {
    vec3 m = student_t_half_vector(wi, wo);
    return student_t_D(params, m) * student_t_V_cook_torrance(wi, wo);
}

// F D G / (4 mu_i mu_o): BRDF value in 1/sr, without the cosine.
vec3 student_t_eval(StudentT params, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3(0.0);
    }
    return mix(params.f0, vec3(1.0), vec3(student_t_schlick_weight_half(wi, wo)))
        * student_t_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// exp(x) - 1, exact where x is small.
float student_t_expm1(float x) {
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

// tan^2 = (g - 1) a^2 ((1 - u)^(1 / (1 - g)) - 1).
vec3 student_t_normal(StudentT params, vec2 u) {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const float RANDOM_MARGIN = 5.9604645e-8;
    const float two_pi = 6.2831855;
    float spread = student_t_expm1(log(max(1.0 - u.x, RANDOM_MARGIN)) / (1.0 - params.gamma));
    float tangent = params.alpha * sqrt(max((params.gamma - 1.0) * spread, 0.0));
    float phi = two_pi * u.y;
    return normalize(vec3(tangent * cos(phi), tangent * sin(phi), 1.0));
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
vec3 student_t_mirror(vec3 wo, vec3 m) {
    return 2.0 * dot(wo, m) * m - wo;
}

// |wi + wo| / 2, the same with all digits however short it is: for what is divided by it.
float student_t_half_length(vec3 wi, vec3 wo) {
    const float LENGTHENED = 1.0995116e12;
    return 0.5 / LENGTHENED * sqrt(student_t_length2(LENGTHENED * (wi + wo)));
}

// Density of student_t_mirror in 1/sr, if m has the given density and cos_h = wo . m.
float student_t_pdf_mirror(float density, float cos_h) {
    // Walter et al., Eq. 14
    return 0.25 * density / cos_h;
}

// Density of student_t_sample in 1/sr.
float student_t_pdf(StudentT params, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    vec3 m = student_t_half_vector(wi, wo);
    return student_t_pdf_mirror(student_t_D(params, m) * m.z, student_t_half_length(wi, wo));
}

// wo mirrored at a normal by its density.
StudentTSample student_t_sample(StudentT params, vec3 wo, vec2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return StudentTSample(vec3(0.0, 0.0, 1.0), 0.0);
    }
    vec3 wi = student_t_mirror(wo, student_t_normal(params, u));
    return StudentTSample(wi, student_t_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
vec3 student_t_albedo(StudentT params, vec3 wo) {
    // Steps of the rule in student_t_albedo: a Fibonacci number, and the golden ratio.
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
        StudentTSample drawn = student_t_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + student_t_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
