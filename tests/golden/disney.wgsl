// SPDX-License-Identifier: Apache-2.0
// Disney: the principled model of 2012, all eleven parameters.
//
// Source: Burley, "Physically-based shading at Disney", SIGGRAPH 2012 course notes, section 5 and appendix
// B, and its reference code disney.brdf. In the notes the masking of the highlight has its own width
// (0.5 + roughness / 2)^2, the same along x and y; the code was changed later to the highlight's own
// widths, which masking="anisotropic" gives.
// Deviation: base_color is linear here, the code takes it with a gamma of 2.2.
//
// WGSL (WebGPU), made by gonio from gonio/models/disney.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: var params: Disney; params.base_color = ...; ... disney_eval(params, wi, wo)

// A sampled direction and its density.
struct DisneySample {
    wi: vec3f,  // direction towards the light, unit, local frame
    pdf: f32,  // its density in 1/sr; 0 marks a wasted sample
}

// disney: Artists' model of cloth, plastic, metal and lacquer. Reciprocal; gains energy at grazing angles.
// Exported with masking='remapped'.
struct Disney {
    base_color: vec3f,  // surface colour, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    subsurface: f32,  // blend from rough diffuse to a flat subsurface look; 0 to 1, default 0
    metallic: f32,  // 0 for dielectrics, 1 for metals; 0 to 1, default 0
    specular: f32,  // F0 of dielectrics in units of 0.08; 0 to 1, default 0.5
    // how much of the base colour's hue the dielectric F0 has; 0 to 1, default 0
    specular_tint: f32,
    roughness: f32,  // perceptual roughness, alpha = roughness^2; 0 to 1, default 0.5
    anisotropic: f32,  // stretches the highlight along x: aspect sqrt(1 - 0.9 a); 0 to 1, default 0
    sheen: f32,  // additional grazing reflection, for cloth; 0 to 1, default 0
    sheen_tint: f32,  // how much of the base colour's hue the sheen has; 0 to 1, default 0.5
    clearcoat: f32,  // strength of a second, colourless highlight; 0 to 1, default 0
    clearcoat_gloss: f32,  // 0 for a satin clearcoat, 1 for a glossy one; 0 to 1, default 1
}

// Generalised Trowbridge-Reitz with exponent 1: the facets of Disney's clearcoat.
struct DisneyGTR1 {
    alpha: f32,  // width of the slopes
}

// Facets of GGX with the same width in all directions.
struct DisneyRoundGGX {
    alpha: f32,  // width of the slopes
}

// Facets of GGX, also called Trowbridge-Reitz.
struct DisneyGGX {
    alpha_x: f32,  // width of the slopes along x
    alpha_y: f32,  // width of the slopes along y
}

// Which of two lobes a sample is taken from.
struct DisneyChoice {
    is_first: bool,  // Whether it is the first one
    u: vec2f,  // Fresh random numbers, made of those that chose
}

// ---- evaluation ----------------------------------------------------------------------------

// The base colour's hue and saturation, with a luminance of 1.
fn disney_tint(params: Disney) -> vec3f {
    const LUMINANCE_MIN = 1.0e-18;  // Smallest luminance that is divided by.
    let color = params.base_color;
    let luminance = dot(color, vec3f(0.3, 0.6, 0.1));
    let tint = color / max(luminance, LUMINANCE_MIN);
    return select(vec3f(1.0), tint, luminance > 0.0);
}

fn disney_f0(params: Disney) -> vec3f {
    const F0_SPECULAR = 0.08;  // F0 at specular 1
    let dielectric = F0_SPECULAR * params.specular
        * mix(vec3f(1.0), disney_tint(params), vec3f(params.specular_tint));
    return mix(dielectric, params.base_color, vec3f(params.metallic));
}

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
fn disney_length2(h: vec3f) -> f32 {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
fn disney_cos_half(wi: vec3f, wo: vec3f) -> f32 {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(disney_length2(wi + wo));
}

// 1 - disney_cos_half^2, the squared sine at which light meets the facet: of half the length of wi - wo.
fn disney_sin2_half(wi: vec3f, wo: vec3f) -> f32 {
    let apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
fn disney_weight(cos_h: f32, sin2_h: f32) -> f32 {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    let k = sin2_h / (1.0 + cos_h);
    let k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
fn disney_schlick_weight_half(wi: vec3f, wo: vec3f) -> f32 {
    return disney_weight(disney_cos_half(wi, wo), disney_sin2_half(wi, wo));
}

// (1 - cos_theta)^5 of Schlick's approximation.
fn disney_schlick_weight(cos_theta: f32) -> f32 {
    let k = 1.0 - cos_theta;
    let k2 = k * k;
    return k2 * k2 * k;
}

// 1 - (1 - c)^5, with the factor c taken out so that it keeps its digits as c goes to 0.
fn disney_schlick_complement(c: f32) -> f32 {
    let k = 1.0 - c;
    let k2 = k * k;
    return c * ((1.0 + k) * (1.0 + k2) + k2 * k2);
}

fn disney_sheen(params: Disney) -> vec3f {
    return params.sheen * mix(vec3f(1.0), disney_tint(params), vec3f(params.sheen_tint));
}

// The clearcoat's facets.
fn disney_coat(params: Disney) -> DisneyGTR1 {
    const COAT_ALPHA_SATIN = 0.1;  // width of the clearcoat without gloss
    const COAT_ALPHA_GLOSS = 0.001;  // and with it
    return DisneyGTR1(mix(COAT_ALPHA_SATIN, COAT_ALPHA_GLOSS, params.clearcoat_gloss));
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
fn disney_slopes(h: vec3f) -> vec2f {
    let inv = 1.0 / h.z;
    return vec2f(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
fn disney_tangent2(h: vec3f) -> f32 {
    let t = disney_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// disney_gtr1_D_narrow at the normal along h, which need not be unit.
fn disney_gtr1_D_narrow_along(gtr1: DisneyGTR1, h: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    let a2 = gtr1.alpha * gtr1.alpha;
    let tan2 = disney_tangent2(h);
    return inv_pi * (1.0 - a2) * (1.0 + tan2) / (-log(a2) * (a2 + tan2));
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
fn disney_round_ggx_area(round_ggx: DisneyRoundGGX, w: vec3f) -> f32 {
    let a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrt(a2 + (1.0 - a2) * (w.z * w.z));
}

// G = G1(wi) G1(wo): masking and shadowing taken as independent.
fn disney_V_smith(facets: DisneyRoundGGX, wi: vec3f, wo: vec3f) -> f32 {
    return 1.0 / ((wi.z + disney_round_ggx_area(facets, wi))
        * (wo.z + disney_round_ggx_area(facets, wo)));
}

// All but the highlight: diffuse, sheen and clearcoat, which are not stretched.
fn disney_eval_round(params: Disney, wi: vec3f, wo: vec3f) -> vec3f {
    const inv_pi = 0.31830987;
    const COAT_ALPHA_MASKING = 0.25;  // width by which the clearcoat's facets hide each other
    const COAT_F0 = 0.04;  // the clearcoat's, of an index of 1.5
    const COAT_STRENGTH = 0.25;
    // Diffuse with retro-reflection
    let F_i = disney_schlick_weight(wi.z);
    let F_o = disney_schlick_weight(wo.z);
    let c = disney_cos_half(wi, wo);
    let F90 = c * c * params.roughness;
    let rise = 2.0 * F90 - 0.5;
    let F_d = (1.0 + rise * F_i) * (1.0 + rise * F_o);
    // Hanrahan-Krueger's isotropic subsurface scattering; 1 + (F90 - 1) F as a sum of positive terms
    let F_ss = (disney_schlick_complement(wi.z) + F90 * F_i)
        * (disney_schlick_complement(wo.z) + F90 * F_o);
    let scattered = 1.25 * (F_ss * (1.0 / (wi.z + wo.z) - 0.5) + 0.5);
    let diffuse = inv_pi * mix(F_d, scattered, params.subsurface) * params.base_color;
    let F_H = disney_schlick_weight_half(wi, wo);
    let base = (1.0 - params.metallic) * (diffuse + F_H * disney_sheen(params));

    let D_c = disney_gtr1_D_narrow_along(disney_coat(params), wi + wo);
    let V_c = disney_V_smith(DisneyRoundGGX(COAT_ALPHA_MASKING), wi, wo);
    let F_c = params.clearcoat * mix(COAT_STRENGTH * COAT_F0, COAT_STRENGTH, F_H);
    return base + F_c * (D_c * V_c);
}

// Widths along x and y: aspect sqrt(1 - 0.9 anisotropy), their product remains alpha^2.
//
// Burley, appendix B, without its lower limit.
fn disney_anisotropic_alpha(alpha: f32, anisotropy: f32) -> vec2f {
    let aspect2 = 1.0 - 0.9 * anisotropy;
    let stretch = 1.0 / sqrt(aspect2);
    return vec2f(alpha * stretch, alpha * (aspect2 * stretch));
}

// The facets of the highlight.
fn disney_facets(params: Disney) -> DisneyGGX {
    const ALPHA_DISNEY = 0.001;  // smallest width of the highlight
    let alpha = params.roughness * params.roughness;
    let a = disney_anisotropic_alpha(alpha, params.anisotropic);
    return DisneyGGX(max(a.x, ALPHA_DISNEY), max(a.y, ALPHA_DISNEY));
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
fn disney_ggx_D_along(ggx: DisneyGGX, h: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    let t = disney_slopes(h);
    // By slopes, s is (1 + (x / alpha_x)^2 + (y / alpha_y)^2) / (1 + x^2 + y^2). Times the squares of both
    // widths no width is a divisor, and the steepest slopes, 1e18, have squares.
    let x = ggx.alpha_y * t.x;
    let y = ggx.alpha_x * t.y;
    let a2 = ggx.alpha_x * ggx.alpha_y;
    let r = a2 * (1.0 + (t.x * t.x + t.y * t.y)) / (a2 * a2 + x * x + y * y);
    return inv_pi * a2 * (r * r);
}

// Masking of the highlight, G / (4 mu_i mu_o).
fn disney_V(params: Disney, wi: vec3f, wo: vec3f) -> f32 {
    let alpha_g = (0.5 + 0.5 * params.roughness) * (0.5 + 0.5 * params.roughness);
    return disney_V_smith(DisneyRoundGGX(alpha_g), wi, wo);
}

// The highlight without F.
fn disney_highlight(params: Disney, wi: vec3f, wo: vec3f) -> f32 {
    return disney_ggx_D_along(disney_facets(params), wi + wo) * disney_V(params, wi, wo);
}

// BRDF value in 1/sr, without the cosine.
fn disney_eval(params: Disney, wi: vec3f, wo: vec3f) -> vec3f {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return vec3f(0.0);
    }
    let F = mix(disney_f0(params), vec3f(1.0), vec3f(disney_schlick_weight_half(wi, wo)));
    return disney_eval_round(params, wi, wo) + F * disney_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
fn disney_half_vector(wi: vec3f, wo: vec3f) -> vec3f {
    // wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
    // squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
    // much longer.
    const LENGTHENED = 1.0995116e12;
    let h = LENGTHENED * (wi + wo);
    return h / sqrt(disney_length2(h));  // the root is the cosine's as well
}

// Mean of the three channels, by which lobes are weighed against each other.
fn disney_average(color: vec3f) -> f32 {
    return (color.x + color.y + color.z) / 3.0;
}

// An estimate, for the choice of lobes.
fn disney_highlight_albedo(params: Disney, wo: vec3f) -> f32 {
    return disney_average(mix(disney_f0(params), vec3f(1.0), vec3f(disney_schlick_weight(wo.z))));
}

// An estimate, for the choice of lobes.
fn disney_coat_albedo(params: Disney, wo: vec3f) -> f32 {
    const COAT_F0 = 0.04;  // the clearcoat's, of an index of 1.5
    const COAT_STRENGTH = 0.25;
    return COAT_STRENGTH * params.clearcoat * mix(COAT_F0, 1.0, disney_schlick_weight(wo.z));
}

fn disney_raised(probability: f32) -> f32 {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const SHARE_LEAST = 0.1;
    const ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
fn disney_shares(first: f32, second: f32) -> vec2f {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const WEIGHT_MIN = 1.0e-37;
    let a = first + BLACK;
    let b = max(second, WEIGHT_MIN);
    let inv = 1.0 / (a + b);
    let P_first = disney_raised(a * inv);
    let P_second = disney_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    let smaller = a < b;
    return vec2f(select(1.0 - P_second, P_first, smaller),
        select(P_second, 1.0 - P_first, smaller));
}

// Probabilities of the diffuse lobe and of the two others.
fn disney_diffuse_shares(params: Disney, wo: vec3f) -> vec2f {
    // Estimate of the white sheen's albedo, for the choice of lobes only.
    const SHEEN_ALBEDO = 0.06;
    let base = params.base_color + SHEEN_ALBEDO * disney_sheen(params);
    let diffuse = disney_average((1.0 - params.metallic) * base);
    return disney_shares(diffuse, disney_highlight_albedo(params, wo)
        + disney_coat_albedo(params, wo));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
fn disney_choose(probability: f32, u: vec2f) -> DisneyChoice {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const SHARE_MIN = 1.0e-12;
    const RANDOM_MAX = 0.99999994;  // The largest float32 below 1, up to which random numbers go.
    let first = u.x < probability;
    let below = u.x / max(probability, SHARE_MIN);
    let above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    return DisneyChoice(first, vec2f(clamp(select(above, below, first), 0.0, RANDOM_MAX), u.y));
}

// Probabilities of the highlight and of the clearcoat, if it is not the diffuse lobe.
fn disney_specular_shares(params: Disney, wo: vec3f) -> vec2f {
    return disney_shares(disney_highlight_albedo(params, wo), disney_coat_albedo(params, wo));
}

// exp(x) - 1, exact where x is small.
fn disney_expm1(x: f32) -> f32 {
    // Below this the series needs few terms; above, the plain difference is exact to 2e-7 in float32.
    const EXPM1_SMALL = 0.3;
    let near = max(min(x, EXPM1_SMALL), -EXPM1_SMALL);
    // Taylor's series
    let over = 1.0 + near
        * (0.5 + near * (0.16666667
            + near * (0.041666668
                + near * (0.008333334 + near * (0.0013888889 + near * 0.0001984127)))));
    return select(exp(x) - 1.0, near * over, x > -EXPM1_SMALL && x < EXPM1_SMALL);
}

// A normal with a given slope and the azimuth 2 pi u.
fn disney_polar(tan_theta: f32, u: f32) -> vec3f {
    const two_pi = 6.2831855;
    let phi = two_pi * u;
    return normalize(vec3f(tan_theta * cos(phi), tan_theta * sin(phi), 1.0));
}

// A normal with density D m.z. Burley, Eq. 5.
fn disney_gtr1_sample(gtr1: DisneyGTR1, u: vec2f) -> vec3f {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const RANDOM_MARGIN = 5.9604645e-8;
    // sin^2 = alpha^2 (alpha^(-2 u) - 1) / (1 - alpha^2); both differences vanish at alpha = 1
    let a2 = gtr1.alpha * gtr1.alpha;
    let log_a2 = log(a2);
    let below_one = (gtr1.alpha - 1.0) * (gtr1.alpha + 1.0);
    let down = disney_expm1(-u.x * log_a2);
    let up = disney_expm1((1.0 - u.x) * log_a2);
    // tan^2 = sin^2 / cos^2 with cos^2 = (1 - alpha^(2 - 2 u)) / (1 - alpha^2)
    let round_ = below_one > -1.0e-6;
    let tan2 = select(a2 * down / max(-up, RANDOM_MARGIN * a2), u.x / (1.0 - u.x + RANDOM_MARGIN),
        round_);
    return disney_polar(sqrt(max(tan2, 0.0)), u.y);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
fn disney_mirror(wo: vec3f, m: vec3f) -> vec3f {
    return 2.0 * dot(wo, m) * m - wo;
}

// w where all facets are those of a unit sphere.
fn disney_ggx_unstretched(ggx: DisneyGGX, w: vec3f) -> vec3f {
    return normalize(vec3f(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
fn disney_ggx_half_way(ggx: DisneyGGX, w: vec3f, drop: f32, z: f32, v: f32) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(drop * (2.0 - drop), 0.0));
    let phi = two_pi * v;
    let h = vec3f(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(vec3f(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
fn disney_ggx_sample_visible(ggx: DisneyGGX, wo: vec3f, u: vec2f) -> vec3f {
    const RANDOM_MARGIN = 5.9604645e-8;
    let w = disney_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    let u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    let height = 1.0 + w.z;
    return disney_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
fn disney_sample_ggx_lobe(facets: DisneyGGX, wo: vec3f, u: vec2f) -> vec3f {
    let w = disney_mirror(wo, disney_ggx_sample_visible(facets, wo, u));
    return vec3f(w.x, w.y, abs(w.z));
}

// Part of the diffuse samples that is uniform: the subsurface term is like 1 / mu at grazing.
fn disney_uniform_share(params: Disney) -> f32 {
    return 0.5 * params.subsurface;
}

// A direction with density 1 / (2 pi).
fn disney_sample_uniform(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    let z = 1.0 - u.x;
    let r = sqrt(max(u.x * (1.0 + z), 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), z);
}

// A direction with density cos(theta) / pi.
fn disney_sample_cosine(u: vec2f) -> vec3f {
    const two_pi = 6.2831855;
    let r = sqrt(max(u.x, 0.0));
    let phi = two_pi * u.y;
    return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// Density of facets in 1/sr for alpha up to 0.5, where nothing cancels in its norm.
fn disney_gtr1_D_narrow(gtr1: DisneyGTR1, m: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    let a2 = gtr1.alpha * gtr1.alpha;
    let below_one = 1.0 - a2;
    return inv_pi * below_one / (-log(a2) * (a2 + below_one * (m.x * m.x + m.y * m.y)));
}

// |wi + wo| / 2, the same with all digits however short it is: for what is divided by it.
fn disney_half_length(wi: vec3f, wo: vec3f) -> f32 {
    const LENGTHENED = 1.0995116e12;
    return 0.5 / LENGTHENED * sqrt(disney_length2(LENGTHENED * (wi + wo)));
}

// Density of disney_mirror in 1/sr, if m has the given density and cos_h = wo . m.
fn disney_pdf_mirror(density: f32, cos_h: f32) -> f32 {
    // Walter et al., Eq. 14
    return 0.25 * density / cos_h;
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
fn disney_ggx_area(ggx: DisneyGGX, w: vec3f) -> f32 {
    return length(vec3f(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// Density of disney_sample_ggx_lobe in 1/sr.
fn disney_pdf_ggx_lobe(facets: DisneyGGX, wi: vec3f, wo: vec3f) -> f32 {
    const mu_min = 1.0e-18;  // cosine of the horizon
    let seen = 0.5 / (wo.z + disney_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    let straight = disney_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    let exists = wo.z > wi.z;
    let across = vec3f(wi.x, wi.y, select(wi.z, wo.z - wi.z, exists));
    let folded = disney_ggx_D_along(facets, across
        + vec3f(wo.x, wo.y, select(wo.z, mu_min, exists)));
    return (straight + select(0.0, folded, exists)) * seen;
}

// Density of disney_sample_cosine in 1/sr, for w above the horizon.
fn disney_pdf_cosine(w: vec3f) -> f32 {
    const inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Density of disney_sample in 1/sr.
fn disney_pdf(params: Disney, wi: vec3f, wo: vec3f) -> f32 {
    const inv_two_pi = 0.15915494;
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    let P = disney_diffuse_shares(params, wo);
    let Q = disney_specular_shares(params, wo);
    let m = disney_half_vector(wi, wo);
    let coat = disney_pdf_mirror(disney_gtr1_D_narrow(disney_coat(params), m) * m.z,
        disney_half_length(wi, wo));
    let specular = Q.x * disney_pdf_ggx_lobe(disney_facets(params), wi, wo) + Q.y * coat;
    let diffuse = mix(disney_pdf_cosine(wi), inv_two_pi, disney_uniform_share(params));
    return P.x * diffuse + P.y * specular;
}

// Cosine-weighted, a visible GGX normal or a clearcoat normal, by the estimated albedos.
fn disney_sample(params: Disney, wo: vec3f, u: vec2f) -> DisneySample {
    const mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        return DisneySample(vec3f(0.0, 0.0, 1.0), 0.0);
    }
    let choose_result = disney_choose(disney_diffuse_shares(params, wo).x, u);
    let diffuse = choose_result.is_first;
    let v = choose_result.u;
    let choose_result_2 = disney_choose(disney_specular_shares(params, wo).x, v);
    let highlight = choose_result_2.is_first;
    let w = choose_result_2.u;
    let coat = disney_mirror(wo, disney_gtr1_sample(disney_coat(params), w));
    let specular = select(coat, disney_sample_ggx_lobe(disney_facets(params), wo, w), highlight);
    let choose_result_3 = disney_choose(disney_uniform_share(params), v);
    let uniform = choose_result_3.is_first;
    let t = choose_result_3.u;
    let wi = select(specular, select(disney_sample_cosine(t), disney_sample_uniform(t), uniform),
        diffuse);
    return DisneySample(wi, disney_pdf(params, wi, wo));
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
fn disney_albedo(params: Disney, wo: vec3f) -> vec3f {
    // Steps of the rule in disney_albedo: a Fibonacci number, and the golden ratio.
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
        let drawn = disney_sample(params, w, u);
        let weight = select(0.0, drawn.wi.z / max(drawn.pdf, mu_min), drawn.pdf > 0.0);
        total = total + disney_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
