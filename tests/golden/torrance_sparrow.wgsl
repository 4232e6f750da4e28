// SPDX-License-Identifier: Apache-2.0
// Torrance-Sparrow: mirrors of microscopic size, with every published choice of D, G and F.
//
// f = F D G / (4 mu_i mu_o). Also called Cook-Torrance, whose own paper prints 1 / pi in place of 1 / 4.
//
// Sources:
// Torrance, Sparrow, "Theory for off-specular reflection from roughened surfaces", JOSA 57, 1967;
// Cook, Torrance, "A reflectance model for computer graphics", 1982;
// Walter et al., "Microfacet models for refraction through rough surfaces", EGSR 2007;
// Kulla, Conty, "Revisiting physically based shading at Imageworks", SIGGRAPH 2017 course;
// Turquin, "Practical multiple scattering compensation for microfacet models", 2019;
// Elek, "Layered materials in real-time rendering", CESCG 2010, Algorithm 1: a matte part below.
// Those of D, G and F are named in gonio.parts.distribution, masking and fresnel.
//
// WGSL (WebGPU), made by gonio from gonio/models/torrance_sparrow.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: var params: TorranceSparrow; params.alpha = ...; ... torrance_sparrow_eval(params, wi, wo)

// A sampled direction and its density.
struct TorranceSparrowSample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// torrance_sparrow: Rough metal, or the reflection of a rough dielectric. Reciprocal; loses energy
// when rough.
// Exported with distribution='ggx', masking='smith_correlated', fresnel='conductor',
// compensation='none', diffuse='none'.
struct TorranceSparrow {
    alpha: f32,  // width of the facets' slopes: GGX's alpha, Beckmann's m; 0.0001 to 1, default 0.3
    // 0 round, 1 smoothest along y; only ggx and beckmann have it; 0 to 1, default 0
    anisotropy: f32,
    // index of refraction; the default is gold's; 0.01 to 20, default (0.143037, 0.375306, 1.44204)
    eta: vec3f,
    // extinction, the imaginary part of the index; not for dielectric; 0 to 20, default (3.98299,
    // 2.38556, 1.60336)
    k: vec3f,
}

// Facets of GGX, also called Trowbridge-Reitz.
struct TorranceSparrowGGX {
    alpha_x: f32,  // width of the slopes along x
    alpha_y: f32,  // width of the slopes along y
}

// ---- evaluation ----------------------------------------------------------------------------

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
fn torrance_sparrow_length2(h: vec3f) -> f32 {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
fn torrance_sparrow_cos_half(wi: vec3f, wo: vec3f) -> f32 {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(torrance_sparrow_length2(wi + wo));
}

// 1 - torrance_sparrow_cos_half^2, the squared sine at which light meets the facet: of half the length of
// wi - wo.
fn torrance_sparrow_sin2_half(wi: vec3f, wo: vec3f) -> f32 {
    let apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// |re + i im| for im of at least 2 ABSORPTION_MIN.
fn torrance_sparrow_size(re: vec3f, im: vec3f) -> vec3f {
    return sqrt(re * re + im * im);
}

// |re + i im|^2 / s2^2 p / q.
fn torrance_sparrow_reflected(re: vec3f, im: vec3f, s2: vec3f, p: vec3f, q: vec3f) -> vec3f {
    // In two quotients, as the square of s2 is 1e-34 for a matched index in the horizon
    return (re * re + im * im) / s2 * (p / (s2 * q));
}

// Exact reflectance of a conductor, eta + i k, from cosine and squared sine at a facet.
fn torrance_sparrow_F_conductor_half(cos_h: f32, sin2_h: f32, eta: vec3f, k: vec3f) -> vec3f {
    // A trace of absorption, which keeps a conductor's roots from 0, and their squares from where GPUs
    // take them for 0. By itself it reflects where the index is matched in the horizon, (ABSORPTION_MIN /
    // (2 mu^2))^2.
    const ABSORPTION_MIN = 1.0e-17;
    // Cosine from which on the square of the sine is the smaller of the two, and keeps the digits.
    const NEAR_NORMAL = 0.75;
    // As for a dielectric, in complex numbers: contrast = (eta + i k)^2 - 1, g^2 = w = contrast + c^2
    let c = cos_h;
    let contrast_re = (eta - 1.0) * (eta + 1.0) - k * k;
    let half_im = eta * k + ABSORPTION_MIN;
    let c2 = c * c;
    // The same as eta^2 - k^2 - sin^2, of which a small index leaves little else near the normal
    let w_re = select(contrast_re + c2, eta * eta - k * k - sin2_h, cos_h > NEAR_NORMAL);
    let im = 2.0 * half_im;
    let w_abs = torrance_sparrow_size(w_re, im);
    // Of the two parts of the root, the larger has no cancellation; the smaller follows from it.
    let g2 = 0.5 * (w_abs + abs(w_re));
    let g_re = select(half_im, g2, w_re > vec3f(0.0)) * (1.0 / sqrt(g2));
    // |c + g|^2 = c^2 + |w| + cross, and |c g -+ sin2_h|^2 = p -+ cross sin2_h
    let cross = 2.0 * c * g_re;
    let s_abs2 = c2 + w_abs + cross;
    let p = c2 * w_abs + sin2_h * sin2_h;
    return torrance_sparrow_reflected(contrast_re, im, s_abs2, p, p + cross * sin2_h);
}

// Widths along x and y: aspect sqrt(1 - 0.9 anisotropy), their product remains alpha^2.
//
// Burley, appendix B, without its lower limit.
fn torrance_sparrow_anisotropic_alpha(alpha: f32, anisotropy: f32) -> vec2f {
    let aspect2 = 1.0 - 0.9 * anisotropy;
    let stretch = 1.0 / sqrt(aspect2);
    return vec2f(alpha * stretch, alpha * (aspect2 * stretch));
}

// D and its widths.
fn torrance_sparrow_facets(params: TorranceSparrow) -> TorranceSparrowGGX {
    let a = torrance_sparrow_anisotropic_alpha(params.alpha, params.anisotropy);
    return TorranceSparrowGGX(a.x, a.y);
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
fn torrance_sparrow_slopes(h: vec3f) -> vec2f {
    let inv = 1.0 / h.z;
    return vec2f(h.x * inv, h.y * inv);
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
fn torrance_sparrow_ggx_D_along(ggx: TorranceSparrowGGX, h: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    let t = torrance_sparrow_slopes(h);
    // By slopes, s is (1 + (x / alpha_x)^2 + (y / alpha_y)^2) / (1 + x^2 + y^2). Times the squares of both
    // widths no width is a divisor, and the steepest slopes, 1e18, have squares.
    let x = ggx.alpha_y * t.x;
    let y = ggx.alpha_x * t.y;
    let a2 = ggx.alpha_x * ggx.alpha_y;
    let r = a2 * (1.0 + (t.x * t.x + t.y * t.y)) / (a2 * a2 + x * x + y * y);
    return inv_pi * a2 * (r * r);
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
fn torrance_sparrow_ggx_area(ggx: TorranceSparrowGGX, w: vec3f) -> f32 {
    return length(vec3f(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// G = 1 / (1 + Lambda_i + Lambda_o): correlated by the facet's height. Heitz 2014, Eq. 99.
fn torrance_sparrow_V_smith_correlated(facets: TorranceSparrowGGX, wi: vec3f,
    wo: vec3f) -> f32 {
    return 0.5 / (wo.z * torrance_sparrow_ggx_area(facets, wi)
        + wi.z * torrance_sparrow_ggx_area(facets, wo));
}

// G / (4 mu_i mu_o).
fn torrance_sparrow_V(params: TorranceSparrow, wi: vec3f, wo: vec3f) -> f32 {
    return torrance_sparrow_V_smith_correlated(torrance_sparrow_facets(params), wi, wo);
}

// D G / (4 mu_i mu_o): what facets reflect once, without F.
fn torrance_sparrow_highlight(params: TorranceSparrow, wi: vec3f, wo: vec3f) -> f32 {
    return torrance_sparrow_ggx_D_along(torrance_sparrow_facets(params), wi + wo)
        * torrance_sparrow_V(params, wi, wo);
}

// BRDF value in 1/sr, without the cosine.
fn torrance_sparrow_eval(params: TorranceSparrow, wi: vec3f, wo: vec3f) -> vec3f {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    let cos_h = torrance_sparrow_cos_half(wi, wo);
    let single = torrance_sparrow_F_conductor_half(cos_h, torrance_sparrow_sin2_half(wi, wo),
        params.eta, params.k) * torrance_sparrow_highlight(params, wi, wo);
    return single;
}

// ---- sampling ------------------------------------------------------------------------------

// w where all facets are those of a unit sphere.
fn torrance_sparrow_ggx_unstretched(ggx: TorranceSparrowGGX, w: vec3f) -> vec3f {
    return normalize(vec3f(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
fn torrance_sparrow_ggx_half_way(ggx: TorranceSparrowGGX, w: vec3f, drop: f32, z: f32,
    v: f32) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(drop * (2.0 - drop), 0.0));
    let phi = two_pi * v;
    let h = vec3f(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(vec3f(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
fn torrance_sparrow_ggx_sample_visible(ggx: TorranceSparrowGGX, wo: vec3f, u: vec2f) -> vec3f {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const RANDOM_MARGIN = 5.9604645e-8;
    let w = torrance_sparrow_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    let u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    let height = 1.0 + w.z;
    return torrance_sparrow_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
fn torrance_sparrow_mirror(wo: vec3f, m: vec3f) -> vec3f {
    return 2.0 * dot(wo, m) * m - wo;
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
fn torrance_sparrow_sample_ggx_lobe(facets: TorranceSparrowGGX, wo: vec3f, u: vec2f) -> vec3f {
    let w = torrance_sparrow_mirror(wo, torrance_sparrow_ggx_sample_visible(facets, wo, u));
    return vec3f(w.x, w.y, abs(w.z));
}

// wo mirrored at a visible normal, or at any.
//
// Visible normals need Smith's G1, and a G that is no larger than it. With the G of grooves their weights
// grow like alpha / mu_o in the horizon, but those of all normals are at most 2.
fn torrance_sparrow_sample_facets(params: TorranceSparrow, wo: vec3f, u: vec2f) -> vec3f {
    return torrance_sparrow_sample_ggx_lobe(torrance_sparrow_facets(params), wo, u);
}

// Density of torrance_sparrow_sample_ggx_lobe in 1/sr.
fn torrance_sparrow_pdf_ggx_lobe(facets: TorranceSparrowGGX, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    let seen = 0.5 / (wo.z + torrance_sparrow_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    let straight = torrance_sparrow_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    let exists = wo.z > wi.z;
    let across = vec3f(wi.x, wi.y, select(wi.z, wo.z - wi.z, exists));
    let folded = torrance_sparrow_ggx_D_along(facets, across
        + vec3f(wo.x, wo.y, select(wo.z, mu_min, exists)));
    return (straight + select(0.0, folded, exists)) * seen;
}

// Density of torrance_sparrow_sample_facets.
fn torrance_sparrow_pdf_facets(params: TorranceSparrow, wi: vec3f, wo: vec3f) -> f32 {
    return torrance_sparrow_pdf_ggx_lobe(torrance_sparrow_facets(params), wi, wo);
}

// Density of torrance_sparrow_sample in 1/sr.
fn torrance_sparrow_pdf(params: TorranceSparrow, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    let specular = torrance_sparrow_pdf_facets(params, wi, wo);
    return specular;
}

// Visible normals where the masking has them, else normals; with lobes for what is added.
fn torrance_sparrow_sample(params: TorranceSparrow, wo: vec3f,
    u: vec2f) -> TorranceSparrowSample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return TorranceSparrowSample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let wi = torrance_sparrow_sample_facets(params, wo, u);
    return TorranceSparrowSample(wi, torrance_sparrow_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
fn torrance_sparrow_albedo(params: TorranceSparrow, wo: vec3f) -> vec3f {
    // Steps of the rule in torrance_sparrow_albedo: a Fibonacci number, and the golden ratio.
    const ALBEDO_SAMPLES = 987.0;
    const GOLDEN = 0.618034;
    // Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
    const HORIZON = 1.0e-6;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z < 0.0) {  // below the horizon
        return vec3f(0.0);
    }
    let w = vec3f(wo.x, wo.y, max(wo.z, HORIZON));
    var total = vec3f(0.0);
    for (var i_step = 0; i_step < i32(ALBEDO_SAMPLES); i_step++) {
        let i = f32(i_step);
        let u = vec2f((i + 0.5) / ALBEDO_SAMPLES, fract((i + 0.5) * GOLDEN));
        let drawn = torrance_sparrow_sample(params, w, u);
        let weight = select(0.0, drawn.wi.z / max(drawn.pdf, mu_min), drawn.pdf > 0.0);
        total = total + torrance_sparrow_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
