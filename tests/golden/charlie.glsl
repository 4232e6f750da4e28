// SPDX-License-Identifier: Apache-2.0
// Charlie: sheen of cloth, fibres that stand up.
//
// Source: Estevez, Kulla, "Production friendly microfacet sheen BRDF", SIGGRAPH 2017 course, Eq. 2 for the
// distribution; its masking grows without bound in the horizon, and real-time renderers took that of
// Neubelt, Pettineo, "Crafting a next-gen material pipeline for The Order: 1886", SIGGRAPH 2013 course,
// which is here.
//
// GLSL 4.5, made by gonio from gonio/models/charlie.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: Charlie params; params.rho = ...; ... charlie_eval(params, wi, wo)

// A sampled direction and its density.
struct CharlieSample {
    vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// charlie: Velvet and felt: bright at the edges, to be laid over a base. Reciprocal.
struct Charlie {
    vec3 rho;  // colour of the sheen, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    // roughness of the fibres; 1 / alpha is the sine's exponent; 0.05 to 1, default 0.4
    float alpha;
};

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
float charlie_length2(vec3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
vec3 charlie_half_vector(vec3 wi, vec3 wo) {
    // wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
    // squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
    // much longer.
    const float LENGTHENED = 1.0995116e12;
    vec3 h = LENGTHENED * (wi + wo);
    return h / sqrt(charlie_length2(h));  // the root is the cosine's as well
}

// D / (4 (mu_i + mu_o - mu_i mu_o)): BRDF value in 1/sr, without the cosine.
vec3 charlie_eval(Charlie params, vec3 wi, vec3 wo) {
    const float inv_two_pi = 0.15915494;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    // Smallest squared sine of a half vector: below it grazing directions have no digits left for it.
    const float SIN2_LEAST = 1.0e-12;
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3(0.0);
    }
    vec3 m = charlie_half_vector(wi, wo);
    float inv = 1.0 / params.alpha;
    float sin2 = max(m.x * m.x + m.y * m.y, SIN2_LEAST);
    float D = inv_two_pi * (2.0 + inv) * exp(0.5 * inv * log(sin2));
    return params.rho * (0.25 * D / (wi.z + wo.z * (1.0 - wi.z)));
}

// ---- sampling ------------------------------------------------------------------------------

// A direction with density 1 / (2 pi).
vec3 charlie_sample_uniform(vec2 u) {
    const float two_pi = 6.2831855;
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    float z = 1.0 - u.x;
    float r = sqrt(max(u.x * (1.0 + z), 0.0));
    float phi = two_pi * u.y;
    return vec3(r * cos(phi), r * sin(phi), z);
}

// Density of charlie_sample in 1/sr.
float charlie_pdf(Charlie params, vec3 wi, vec3 wo) {
    const float inv_two_pi = 0.15915494;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return inv_two_pi;
}

// Uniform: mu_i / (mu_i + mu_o) has a bound.
CharlieSample charlie_sample(Charlie params, vec3 wo, vec2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return CharlieSample(vec3(0.0, 0.0, 1.0), 0.0);
    }
    vec3 wi = charlie_sample_uniform(u);
    return CharlieSample(wi, charlie_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
vec3 charlie_albedo(Charlie params, vec3 wo) {
    // Steps of the rule in charlie_albedo: a Fibonacci number, and the golden ratio.
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
        CharlieSample drawn = charlie_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + charlie_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
