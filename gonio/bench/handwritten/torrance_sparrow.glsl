// GGX Torrance-Sparrow with the exact Fresnel term of a conductor and height-correlated Smith masking, written
// by hand: the yardstick for the GLSL that `gonio export torrance_sparrow` makes.
//
// From Walter et al. 2007, Burley 2012 (anisotropy), Heitz 2014 (masking) and the complex Fresnel equations as
// engines have them (Lagarde, "Memo on Fresnel equations", 2013), by an engine programmer who wants all digits
// of a float32 and none of the roots and divisions that the products of the terms do not need. `gonio bench
// shaders` and `gonio cost --by-hand` compare the two.

struct TorranceSparrow {
    float alpha;
    float anisotropy;
    vec3 eta;
    vec3 k;
    vec3 f0;
    vec3 f90;
};

vec3 torrance_sparrow_fresnel(float c, float s2, vec3 eta, vec3 k) {
    float c2 = c * c;
    // (a + i b)^2 = (eta + i k)^2 - s2, of absolute value ab2; contrast is the real part of (eta + i k)^2 - 1.
    // A trace of absorption keeps the roots from 0, and their squares within what a GPU's float32 has.
    vec3 ek = eta * k + 1.0e-17;
    vec3 im = 2.0 * ek;
    vec3 contrast = (eta - 1.0) * (eta + 1.0) - k * k;
    // A small index leaves little of the contrast and c2 near the normal
    vec3 w = c > 0.7 ? (eta - k) * (eta + k) - s2 : contrast + c2;
    vec3 ab2 = sqrt(w * w + im * im);
    // The larger of a and b has no cancellation, and a b = eta k
    vec3 larger = sqrt(0.5 * (ab2 + abs(w)));
    vec3 a = mix(ek / larger, larger, greaterThan(w, vec3(0.0)));
    // With t1 +- t2 = (c +- a)^2 + b^2, R_s is (t1 - t2) / (t1 + t2) = |contrast|^2 / (t1 + t2)^2.
    // R_p = R_s (t3 - t4) / (t3 + t4), so that (R_s + R_p) / 2 = R_s t3 / (t3 + t4).
    vec3 t2 = 2.0 * c * a;
    vec3 t1 = c2 + ab2 + t2;
    vec3 t3 = c2 * ab2 + s2 * s2;
    return (contrast * contrast + im * im) / t1 * t3 / (t1 * (t3 + t2 * s2));
}

vec3 torrance_sparrow_eval(TorranceSparrow params, vec3 wi, vec3 wo) {
    if (min(wi.z, wo.z) <= 0.0) {
        return vec3(0.0);
    }
    // Squares of the widths along x and y, whose product is a2^2
    float a2 = params.alpha * params.alpha;
    float aspect2 = 1.0 - 0.9 * params.anisotropy;
    vec3 widths = vec3(a2 / aspect2, a2 * aspect2, 1.0);

    vec3 apart = wi - wo;
    float sin2_h = 0.25 * dot(apart, apart);
    vec3 h = wi + wo;
    float length2 = max(dot(h, h), 1.0e-36);
    float cos_h = 0.5 * sqrt(length2);
    // D is t^2 / (pi a2). Of slopes: between opposite directions at the horizon squares of h.xy are 0 on a GPU.
    vec2 slopes2 = h.xy * (1.0 / h.z);
    slopes2 *= slopes2;
    float a4 = a2 * a2;
    float t = a4 * (1.0 + slopes2.x + slopes2.y) / (a4 + dot(slopes2, widths.yx));
    float V = 0.5 / (wo.z * sqrt(dot(wi * wi, widths)) + wi.z * sqrt(dot(wo * wo, widths)));
    return 0.3183098862 * t * t * V / a2 * torrance_sparrow_fresnel(cos_h, sin2_h, params.eta, params.k);
}
