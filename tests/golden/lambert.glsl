// SPDX-License-Identifier: Apache-2.0
// Lambert: ideal diffuse reflection.
//
// Source: Johann Heinrich Lambert, "Photometria", 1760.
//
// GLSL 4.5, made by gonio from gonio/models/lambert.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose normal is
// +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// Usage: Lambert params; params.rho = ...; ... lambert_eval(params, wi, wo)

// A sampled direction and its density.
struct LambertSample {
    vec3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// lambert: Ideal diffuse: the same radiance in every direction. Reciprocal; the albedo is rho.
struct Lambert {
    vec3 rho;  // albedo, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
};

// ---- evaluation ----------------------------------------------------------------------------

// rho / pi.
vec3 lambert_eval(Lambert params, vec3 wi, vec3 wo) {
    const float inv_pi = 0.31830987;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3(0.0);
    }
    return params.rho * inv_pi;
}

// ---- sampling ------------------------------------------------------------------------------

// A direction with density cos(theta) / pi.
vec3 lambert_sample_cosine(vec2 u) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(u.x, 0.0));
    float phi = two_pi * u.y;
    return vec3(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// Density of lambert_sample_cosine in 1/sr, for w above the horizon.
float lambert_pdf_cosine(vec3 w) {
    const float inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Cosine-weighted, which is exact here.
LambertSample lambert_sample(Lambert params, vec3 wo, vec2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return LambertSample(vec3(0.0, 0.0, 1.0), 0.0);
    }
    vec3 wi = lambert_sample_cosine(u);
    return LambertSample(wi, wi.z > mu_min ? lambert_pdf_cosine(wi) : 0.0);
}

// cos(theta_i) / pi.
float lambert_pdf(Lambert params, vec3 wi, vec3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    return lambert_pdf_cosine(wi);
}

// ---- albedo --------------------------------------------------------------------------------

// rho.
vec3 lambert_albedo(Lambert params, vec3 wo) {
    if (wo.z < 0.0) {  // below the horizon
        return vec3(0.0);
    }
    return params.rho;
}
