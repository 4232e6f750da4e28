// SPDX-License-Identifier: Apache-2.0
// Disney: the principled model of 2012, all eleven parameters.
//
// Source: Burley, "Physically-based shading at Disney", SIGGRAPH 2012 course notes, section 5 and appendix
// B, and its reference code disney.brdf. In the notes the masking of the highlight has its own width
// (0.5 + roughness / 2)^2, the same along x and y; the code was changed later to the highlight's own
// widths, which masking="anisotropic" gives.
// Deviation: base_color is linear here, the code takes it with a gamma of 2.2.
//
// HLSL, made by gonio from gonio/models/disney.py; free to use under Apache-2.0.
// wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose
// normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.
// albedo has no closed form here; it takes many evaluations, for tables and previews.
// Usage: Disney params; params.base_color = ...; ... disney_eval(params, wi, wo)

// A sampled direction and its density.
struct DisneySample {
    float3 wi;  // direction towards the light, unit, local frame
    float pdf;  // its density in 1/sr; 0 marks a wasted sample
};

// disney: Artists' model of cloth, plastic, metal and lacquer. Reciprocal; gains energy at grazing angles.
// Exported with masking='remapped'.
struct Disney {
    float3 base_color;  // surface colour, linear RGB; 0 to 1, default (0.8, 0.8, 0.8)
    float subsurface;  // blend from rough diffuse to a flat subsurface look; 0 to 1, default 0
    float metallic;  // 0 for dielectrics, 1 for metals; 0 to 1, default 0
    float specular;  // F0 of dielectrics in units of 0.08; 0 to 1, default 0.5
    // how much of the base colour's hue the dielectric F0 has; 0 to 1, default 0
    float specular_tint;
    float roughness;  // perceptual roughness, alpha = roughness^2; 0 to 1, default 0.5
    // stretches the highlight along x: aspect sqrt(1 - 0.9 a); 0 to 1, default 0
    float anisotropic;
    float sheen;  // additional grazing reflection, for cloth; 0 to 1, default 0
    float sheen_tint;  // how much of the base colour's hue the sheen has; 0 to 1, default 0.5
    float clearcoat;  // strength of a second, colourless highlight; 0 to 1, default 0
    float clearcoat_gloss;  // 0 for a satin clearcoat, 1 for a glossy one; 0 to 1, default 1
};

// Generalised Trowbridge-Reitz with exponent 1: the facets of Disney's clearcoat.
struct DisneyGTR1 {
    float alpha;  // width of the slopes
};

// Facets of GGX with the same width in all directions.
struct DisneyRoundGGX {
    float alpha;  // width of the slopes
};

// Facets of GGX, also called Trowbridge-Reitz.
struct DisneyGGX {
    float alpha_x;  // width of the slopes along x
    float alpha_y;  // width of the slopes along y
};

// Which of two lobes a sample is taken from.
struct DisneyChoice {
    bool is_first;  // Whether it is the first one
    float2 u;  // Fresh random numbers, made of those that chose
};

// ---- evaluation ----------------------------------------------------------------------------

// The base colour's hue and saturation, with a luminance of 1.
float3 disney_tint(Disney params) {
    const float LUMINANCE_MIN = 1.0e-18;  // Smallest luminance that is divided by.
    float3 color = params.base_color;
    float luminance = dot(color, float3(0.3, 0.6, 0.1));
    float3 tint = color / max(luminance, LUMINANCE_MIN);
    return luminance > 0.0 ? tint : float3(1.0, 1.0, 1.0);
}

float3 disney_f0(Disney params) {
    const float F0_SPECULAR = 0.08;  // F0 at specular 1
    float3 dielectric = F0_SPECULAR * params.specular
        * lerp(float3(1.0, 1.0, 1.0), disney_tint(params),
            float3(params.specular_tint, params.specular_tint, params.specular_tint));
    return lerp(dielectric, params.base_color,
        float3(params.metallic, params.metallic, params.metallic));
}

// Squared length, added up from the tangential part, which is of use by itself: shaders share it.
float disney_length2(float3 h) {
    return h.x * h.x + h.y * h.y + h.z * h.z;
}

// wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo.
float disney_cos_half(float3 wi, float3 wo) {
    // 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(disney_length2(wi + wo));
}

// 1 - disney_cos_half^2, the squared sine at which light meets the facet: of half the length of wi - wo.
float disney_sin2_half(float3 wi, float3 wo) {
    float3 apart = wi - wo;
    return 0.25 * dot(apart, apart);
}

// (1 - c)^5 at a facet, from cosine and squared sine there.
float disney_weight(float cos_h, float sin2_h) {
    // 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the weight
    // keeps its digits where the two meet and it goes to 0.
    float k = sin2_h / (1.0 + cos_h);
    float k2 = k * k;
    return k2 * k2 * k;
}

// (1 - c)^5 at c = wo . m, the half vector's cosine.
float disney_schlick_weight_half(float3 wi, float3 wo) {
    return disney_weight(disney_cos_half(wi, wo), disney_sin2_half(wi, wo));
}

// (1 - cos_theta)^5 of Schlick's approximation.
float disney_schlick_weight(float cos_theta) {
    float k = 1.0 - cos_theta;
    float k2 = k * k;
    return k2 * k2 * k;
}

// 1 - (1 - c)^5, with the factor c taken out so that it keeps its digits as c goes to 0.
float disney_schlick_complement(float c) {
    float k = 1.0 - c;
    float k2 = k * k;
    return c * ((1.0 + k) * (1.0 + k2) + k2 * k2);
}

float3 disney_sheen(Disney params) {
    return params.sheen * lerp(float3(1.0, 1.0, 1.0), disney_tint(params),
        float3(params.sheen_tint, params.sheen_tint, params.sheen_tint));
}

// The clearcoat's facets.
DisneyGTR1 disney_coat(Disney params) {
    const float COAT_ALPHA_SATIN = 0.1;  // width of the clearcoat without gloss
    const float COAT_ALPHA_GLOSS = 0.001;  // and with it
    DisneyGTR1 result;
    result.alpha = lerp(COAT_ALPHA_SATIN, COAT_ALPHA_GLOSS, params.clearcoat_gloss);
    return result;
}

// Of the facet whose normal is along h, which is above the horizon and need not be unit.
float2 disney_slopes(float3 h) {
    float inv = 1.0 / h.z;
    return float2(h.x * inv, h.y * inv);
}

// Squared tangent of that facet's angle.
float disney_tangent2(float3 h) {
    float2 t = disney_slopes(h);
    return t.x * t.x + t.y * t.y;
}

// disney_gtr1_D_narrow at the normal along h, which need not be unit.
float disney_gtr1_D_narrow_along(DisneyGTR1 gtr1, float3 h) {
    const float inv_pi = 0.31830987;
    float a2 = gtr1.alpha * gtr1.alpha;
    float tan2 = disney_tangent2(h);
    return inv_pi * (1.0 - a2) * (1.0 + tan2) / (-log(a2) * (a2 + tan2));
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
float disney_round_ggx_area(DisneyRoundGGX round_ggx, float3 w) {
    float a2 = round_ggx.alpha * round_ggx.alpha;
    return sqrt(a2 + (1.0 - a2) * (w.z * w.z));
}

// G = G1(wi) G1(wo): masking and shadowing taken as independent.
float disney_V_smith(DisneyRoundGGX facets, float3 wi, float3 wo) {
    return 1.0 / ((wi.z + disney_round_ggx_area(facets, wi))
        * (wo.z + disney_round_ggx_area(facets, wo)));
}

// All but the highlight: diffuse, sheen and clearcoat, which are not stretched.
float3 disney_eval_round(Disney params, float3 wi, float3 wo) {
    const float inv_pi = 0.31830987;
    const float COAT_ALPHA_MASKING = 0.25;  // width by which the clearcoat's facets hide each other
    const float COAT_F0 = 0.04;  // the clearcoat's, of an index of 1.5
    const float COAT_STRENGTH = 0.25;
    // Diffuse with retro-reflection
    float F_i = disney_schlick_weight(wi.z);
    float F_o = disney_schlick_weight(wo.z);
    float c = disney_cos_half(wi, wo);
    float F90 = c * c * params.roughness;
    float rise = 2.0 * F90 - 0.5;
    float F_d = (1.0 + rise * F_i) * (1.0 + rise * F_o);
    // Hanrahan-Krueger's isotropic subsurface scattering; 1 + (F90 - 1) F as a sum of positive terms
    float F_ss = (disney_schlick_complement(wi.z) + F90 * F_i)
        * (disney_schlick_complement(wo.z) + F90 * F_o);
    float scattered = 1.25 * (F_ss * (1.0 / (wi.z + wo.z) - 0.5) + 0.5);
    float3 diffuse = inv_pi * lerp(F_d, scattered, params.subsurface) * params.base_color;
    float F_H = disney_schlick_weight_half(wi, wo);
    float3 base = (1.0 - params.metallic) * (diffuse + F_H * disney_sheen(params));

    float D_c = disney_gtr1_D_narrow_along(disney_coat(params), wi + wo);
    DisneyRoundGGX round_ggx;
    round_ggx.alpha = COAT_ALPHA_MASKING;
    float V_c = disney_V_smith(round_ggx, wi, wo);
    float F_c = params.clearcoat * lerp(COAT_STRENGTH * COAT_F0, COAT_STRENGTH, F_H);
    return base + F_c * (D_c * V_c);
}

// Widths along x and y: aspect sqrt(1 - 0.9 anisotropy), their product remains alpha^2.
//
// Burley, appendix B, without its lower limit.
float2 disney_anisotropic_alpha(float alpha, float anisotropy) {
    float aspect2 = 1.0 - 0.9 * anisotropy;
    float stretch = 1.0 / sqrt(aspect2);
    return float2(alpha * stretch, alpha * (aspect2 * stretch));
}

// The facets of the highlight.
DisneyGGX disney_facets(Disney params) {
    const float ALPHA_DISNEY = 0.001;  // smallest width of the highlight
    float alpha = params.roughness * params.roughness;
    float2 a = disney_anisotropic_alpha(alpha, params.anisotropic);
    DisneyGGX result;
    result.alpha_x = max(a.x, ALPHA_DISNEY);
    result.alpha_y = max(a.y, ALPHA_DISNEY);
    return result;
}

// Density of facets at the normal along h, which need not be unit, in 1/sr.
float disney_ggx_D_along(DisneyGGX ggx, float3 h) {
    const float inv_pi = 0.31830987;
    float2 t = disney_slopes(h);
    // By slopes, s is (1 + (x / alpha_x)^2 + (y / alpha_y)^2) / (1 + x^2 + y^2). Times the squares of both
    // widths no width is a divisor, and the steepest slopes, 1e18, have squares.
    float x = ggx.alpha_y * t.x;
    float y = ggx.alpha_x * t.y;
    float a2 = ggx.alpha_x * ggx.alpha_y;
    float r = a2 * (1.0 + (t.x * t.x + t.y * t.y)) / (a2 * a2 + x * x + y * y);
    return inv_pi * a2 * (r * r);
}

// Masking of the highlight, G / (4 mu_i mu_o).
float disney_V(Disney params, float3 wi, float3 wo) {
    float alpha_g = (0.5 + 0.5 * params.roughness) * (0.5 + 0.5 * params.roughness);
    DisneyRoundGGX round_ggx;
    round_ggx.alpha = alpha_g;
    return disney_V_smith(round_ggx, wi, wo);
}

// The highlight without F.
float disney_highlight(Disney params, float3 wi, float3 wo) {
    return disney_ggx_D_along(disney_facets(params), wi + wo) * disney_V(params, wi, wo);
}

// BRDF value in 1/sr, without the cosine.
float3 disney_eval(Disney params, float3 wi, float3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return float3(0.0, 0.0, 0.0);
    }
    float3 F = lerp(disney_f0(params), float3(1.0, 1.0, 1.0),
        disney_schlick_weight_half(wi, wo).xxx);
    return disney_eval_round(params, wi, wo) + F * disney_highlight(params, wi, wo);
}

// ---- sampling ------------------------------------------------------------------------------

// The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|.
float3 disney_half_vector(float3 wi, float3 wo) {
    // wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The
    // squares of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so
    // much longer.
    const float LENGTHENED = 1.0995116e12;
    float3 h = LENGTHENED * (wi + wo);
    return h / sqrt(disney_length2(h));  // the root is the cosine's as well
}

// Mean of the three channels, by which lobes are weighed against each other.
float disney_average(float3 color) {
    return (color.x + color.y + color.z) / 3.0;
}

// An estimate, for the choice of lobes.
float disney_highlight_albedo(Disney params, float3 wo) {
    return disney_average(lerp(disney_f0(params), float3(1.0, 1.0, 1.0),
        disney_schlick_weight(wo.z).xxx));
}

// An estimate, for the choice of lobes.
float disney_coat_albedo(Disney params, float3 wo) {
    const float COAT_F0 = 0.04;  // the clearcoat's, of an index of 1.5
    const float COAT_STRENGTH = 0.25;
    return COAT_STRENGTH * params.clearcoat * lerp(COAT_F0, 1.0, disney_schlick_weight(wo.z));
}

float disney_raised(float probability) {
    // The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
    // its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
    const float SHARE_LEAST = 0.1;
    const float ESTIMATE_TRUST = 50.0;
    return max(probability, min(SHARE_LEAST, ESTIMATE_TRUST * probability));
}

// Probabilities of two lobes with the given albedos; the first is all but certain if both are black.
float2 disney_shares(float first, float second) {
    // Added to the first lobe's weight, so that two black lobes still leave something to choose and the
    // reciprocal of their sum has a derivative; no albedo that can be seen is that small.
    const float BLACK = 1.0e-12;
    // The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
    // grazing direction may have a density of 1e22 in that lobe.
    const float WEIGHT_MIN = 1.0e-37;
    float a = first + BLACK;
    float b = max(second, WEIGHT_MIN);
    float inv = 1.0 / (a + b);
    float P_first = disney_raised(a * inv);
    float P_second = disney_raised(b * inv);
    // The smaller one by itself: 1 minus a probability near 1 has no digits left.
    bool smaller = a < b;
    return float2(smaller ? P_first : 1.0 - P_second, smaller ? 1.0 - P_first : P_second);
}

// Probabilities of the diffuse lobe and of the two others.
float2 disney_diffuse_shares(Disney params, float3 wo) {
    // Estimate of the white sheen's albedo, for the choice of lobes only.
    const float SHEEN_ALBEDO = 0.06;
    float3 base = params.base_color + SHEEN_ALBEDO * disney_sheen(params);
    float diffuse = disney_average((1.0 - params.metallic) * base);
    return disney_shares(diffuse, disney_highlight_albedo(params, wo)
        + disney_coat_albedo(params, wo));
}

// Choose the first of two lobes with a probability, and make fresh random numbers of the used ones.
DisneyChoice disney_choose(float probability, float2 u) {
    // Smallest probability that is divided by: a random number falls below it once in a million million.
    const float SHARE_MIN = 1.0e-12;
    // The largest float32 below 1, up to which random numbers go.
    const float RANDOM_MAX = 0.99999994;
    bool first = u.x < probability;
    float below = u.x / max(probability, SHARE_MIN);
    float above = (u.x - probability) / max(1.0 - probability, SHARE_MIN);
    DisneyChoice result;
    result.is_first = first;
    result.u = float2(clamp(first ? below : above, 0.0, RANDOM_MAX), u.y);
    return result;
}

// Probabilities of the highlight and of the clearcoat, if it is not the diffuse lobe.
float2 disney_specular_shares(Disney params, float3 wo) {
    return disney_shares(disney_highlight_albedo(params, wo), disney_coat_albedo(params, wo));
}

// exp(x) - 1, exact where x is small.
float disney_expm1(float x) {
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

// A normal with a given slope and the azimuth 2 pi u.
float3 disney_polar(float tan_theta, float u) {
    const float two_pi = 6.2831855;
    float phi = two_pi * u;
    return normalize(float3(tan_theta * cos(phi), tan_theta * sin(phi), 1.0));
}

// A normal with density D m.z. Burley, Eq. 5.
float3 disney_gtr1_sample(DisneyGTR1 gtr1, float2 u) {
    // Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
    const float RANDOM_MARGIN = 5.9604645e-8;
    // sin^2 = alpha^2 (alpha^(-2 u) - 1) / (1 - alpha^2); both differences vanish at alpha = 1
    float a2 = gtr1.alpha * gtr1.alpha;
    float log_a2 = log(a2);
    float below_one = (gtr1.alpha - 1.0) * (gtr1.alpha + 1.0);
    float down = disney_expm1(-u.x * log_a2);
    float up = disney_expm1((1.0 - u.x) * log_a2);
    // tan^2 = sin^2 / cos^2 with cos^2 = (1 - alpha^(2 - 2 u)) / (1 - alpha^2)
    bool round_ = below_one > -1.0e-6;
    float tan2 = round_ ? u.x / (1.0 - u.x + RANDOM_MARGIN)
        : a2 * down / max(-up, RANDOM_MARGIN * a2);
    return disney_polar(sqrt(max(tan2, 0.0)), u.y);
}

// wo mirrored at a facet with normal m; it may leave below the horizon.
float3 disney_mirror(float3 wo, float3 m) {
    return 2.0 * dot(wo, m) * m - wo;
}

// w where all facets are those of a unit sphere.
float3 disney_ggx_unstretched(DisneyGGX ggx, float3 w) {
    return normalize(float3(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together.
float3 disney_ggx_half_way(DisneyGGX ggx, float3 w, float drop, float z, float v) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(drop * (2.0 - drop), 0.0));
    float phi = two_pi * v;
    float3 h = float3(r * cos(phi) + w.x, r * sin(phi) + w.y, z);
    return normalize(float3(ggx.alpha_x * h.x, ggx.alpha_y * h.y, h.z));
}

// A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3.
float3 disney_ggx_sample_visible(DisneyGGX ggx, float3 wo, float2 u) {
    const float RANDOM_MARGIN = 5.9604645e-8;
    float3 w = disney_ggx_unstretched(ggx, wo);
    // u = 1 would be the facet opposite to w, whose half vector has no direction
    float u1 = min(u.x, 1.0 - RANDOM_MARGIN);
    // A cap down to z = -w.z: z = 1 - u (1 + w.z)
    float height = 1.0 + w.z;
    return disney_ggx_half_way(ggx, w, u1 * height, (1.0 - u1) * height, u.y);
}

// wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.
//
// No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
// mirror below the horizon, the rim of those that are left would be a jump of the density.
float3 disney_sample_ggx_lobe(DisneyGGX facets, float3 wo, float2 u) {
    float3 w = disney_mirror(wo, disney_ggx_sample_visible(facets, wo, u));
    return float3(w.x, w.y, abs(w.z));
}

// Part of the diffuse samples that is uniform: the subsurface term is like 1 / mu at grazing.
float disney_uniform_share(Disney params) {
    return 0.5 * params.subsurface;
}

// A direction with density 1 / (2 pi).
float3 disney_sample_uniform(float2 u) {
    const float two_pi = 6.2831855;
    // z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    float z = 1.0 - u.x;
    float r = sqrt(max(u.x * (1.0 + z), 0.0));
    float phi = two_pi * u.y;
    return float3(r * cos(phi), r * sin(phi), z);
}

// A direction with density cos(theta) / pi.
float3 disney_sample_cosine(float2 u) {
    const float two_pi = 6.2831855;
    float r = sqrt(max(u.x, 0.0));
    float phi = two_pi * u.y;
    return float3(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 0.0)));
}

// Density of facets in 1/sr for alpha up to 0.5, where nothing cancels in its norm.
float disney_gtr1_D_narrow(DisneyGTR1 gtr1, float3 m) {
    const float inv_pi = 0.31830987;
    float a2 = gtr1.alpha * gtr1.alpha;
    float below_one = 1.0 - a2;
    return inv_pi * below_one / (-log(a2) * (a2 + below_one * (m.x * m.x + m.y * m.y)));
}

// |wi + wo| / 2, the same with all digits however short it is: for what is divided by it.
float disney_half_length(float3 wi, float3 wo) {
    const float LENGTHENED = 1.0995116e12;
    return 0.5 / LENGTHENED * sqrt(disney_length2(LENGTHENED * (wi + wo)));
}

// Density of disney_mirror in 1/sr, if m has the given density and cos_h = wo . m.
float disney_pdf_mirror(float density, float cos_h) {
    // Walter et al., Eq. 14
    return 0.25 * density / cos_h;
}

// mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made.
float disney_ggx_area(DisneyGGX ggx, float3 w) {
    return length(float3(ggx.alpha_x * w.x, ggx.alpha_y * w.y, w.z));
}

// Density of disney_sample_ggx_lobe in 1/sr.
float disney_pdf_ggx_lobe(DisneyGGX facets, float3 wi, float3 wo) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    float seen = 0.5 / (wo.z + disney_ggx_area(facets, wo));  // Smith's G1 over 4 mu_o
    float straight = disney_ggx_D_along(facets, wi + wo);
    // The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    // cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    // lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    bool exists = wo.z > wi.z;
    float3 across = float3(wi.x, wi.y, exists ? wo.z - wi.z : wi.z);
    float folded = disney_ggx_D_along(facets, across + float3(wo.x, wo.y, exists ? mu_min : wo.z));
    return (straight + (exists ? folded : 0.0)) * seen;
}

// Density of disney_sample_cosine in 1/sr, for w above the horizon.
float disney_pdf_cosine(float3 w) {
    const float inv_pi = 0.31830987;
    return w.z * inv_pi;
}

// Density of disney_sample in 1/sr.
float disney_pdf(Disney params, float3 wi, float3 wo) {
    const float inv_two_pi = 0.15915494;
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (min(wi.z, wo.z) <= mu_min) {  // in the horizon or below
        return 0.0;
    }
    float2 P = disney_diffuse_shares(params, wo);
    float2 Q = disney_specular_shares(params, wo);
    float3 m = disney_half_vector(wi, wo);
    float coat = disney_pdf_mirror(disney_gtr1_D_narrow(disney_coat(params), m) * m.z,
        disney_half_length(wi, wo));
    float specular = Q.x * disney_pdf_ggx_lobe(disney_facets(params), wi, wo) + Q.y * coat;
    float diffuse = lerp(disney_pdf_cosine(wi), inv_two_pi, disney_uniform_share(params));
    return P.x * diffuse + P.y * specular;
}

// Cosine-weighted, a visible GGX normal or a clearcoat normal, by the estimated albedos.
DisneySample disney_sample(Disney params, float3 wo, float2 u) {
    const float mu_min = 1.0e-18;  // cosine of the horizon
    if (wo.z <= mu_min) {  // in the horizon or below
        DisneySample result;
        result.wi = float3(0.0, 0.0, 1.0);
        result.pdf = 0.0;
        return result;
    }
    DisneyChoice choose_result = disney_choose(disney_diffuse_shares(params, wo).x, u);
    bool diffuse = choose_result.is_first;
    float2 v = choose_result.u;
    DisneyChoice choose_result_2 = disney_choose(disney_specular_shares(params, wo).x, v);
    bool highlight = choose_result_2.is_first;
    float2 w = choose_result_2.u;
    float3 coat = disney_mirror(wo, disney_gtr1_sample(disney_coat(params), w));
    float3 specular = highlight ? disney_sample_ggx_lobe(disney_facets(params), wo, w) : coat;
    DisneyChoice choose_result_3 = disney_choose(disney_uniform_share(params), v);
    bool uniform_ = choose_result_3.is_first;
    float2 t = choose_result_3.u;
    float3 wi = diffuse ? (uniform_ ? disney_sample_uniform(t) : disney_sample_cosine(t))
        : specular;
    DisneySample result;
    result.wi = wi;
    result.pdf = disney_pdf(params, wi, wo);
    return result;
}

// ---- albedo --------------------------------------------------------------------------------

// Directional albedo of a model without a closed form: the mean weight of its own samples.
//
// For tables and previews; the random numbers are a Fibonacci lattice.
float3 disney_albedo(Disney params, float3 wo) {
    // Steps of the rule in disney_albedo: a Fibonacci number, and the golden ratio.
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
        DisneySample drawn = disney_sample(params, w, u);
        float weight = drawn.pdf > 0.0 ? drawn.wi.z / max(drawn.pdf, mu_min) : 0.0;
        total = total + disney_eval(params, drawn.wi, w) * weight;
    }
    return total / ALBEDO_SAMPLES;
}
