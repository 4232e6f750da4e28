// What the passes call of code that others wrote, of which only `model_value` is known: half of the samples around
// the normal by the cosine, half by half vectors whose angle is a fourth power, which crowd around the normal.
//BEGIN
struct ModelSample { wi: vec3f, pdf: f32 }
fn model_whole(x: f32) -> f32 {
    return select(x, 0.0, (bitcast<u32>(x) & 0x7f800000u) == 0x7f800000u);
}
fn model_eval(m: Model, wi: vec3f, wo: vec3f) -> vec3f {
    if (min(wi.z, wo.z) <= 1e-18) { return vec3f(0.0); }
    let f: vec3f = model_value(m, wi, wo);
    return vec3f(model_whole(f.x), model_whole(f.y), model_whole(f.z));
}
fn model_pdf(m: Model, wi: vec3f, wo: vec3f) -> f32 {
    if (min(wi.z, wo.z) <= 1e-18) { return 0.0; }
    let both: vec3f = wi + wo;
    let h: vec3f = both / max(length(both), 1e-20);
    let theta: f32 = max(atan2(length(h.xy), h.z), 1e-5);
    let t: f32 = sqrt(sqrt(theta / 1.57079633));
    let crowded: f32 = 1.0 / (6.28318531 * sin(theta) * 6.28318531 * t * t * t);
    return 0.5 * (wi.z / 3.14159265 + crowded / (4.0 * max(dot(h, wo), 1e-6)));
}
fn model_around(m: Model, wo: vec3f, u: vec2f, crowd: bool) -> vec3f {
    let phi: f32 = 6.28318531 * u.y;
    if (!crowd) {
        let r: f32 = sqrt(u.x);
        return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 1e-12)));
    }
    let theta: f32 = 1.57079633 * u.x * u.x * u.x * u.x;
    let h: vec3f = vec3f(sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta));
    return 2.0 * dot(h, wo) * h - wo;
}
fn model_sample(m: Model, wo: vec3f, u: vec2f) -> ModelSample {
    let crowd: bool = u.x >= 0.5;
    let part: f32 = select(2.0 * u.x, 2.0 * u.x - 1.0, crowd);
    let wi: vec3f = model_around(m, wo, vec2f(part, u.y), crowd);
    return ModelSample(wi, model_pdf(m, wi, wo));
}
fn model_albedo(m: Model, wo: vec3f) -> vec3f {
    var total: vec3f = vec3f(0.0);
    for (var k: i32 = 0; k < 1600; k++) {
        let u: vec2f = vec2f((f32(k % 40) + 0.5) / 40.0, (f32(k / 40) + 0.5) / 40.0);
        for (var rule: i32 = 0; rule < 2; rule++) {
            let wi: vec3f = model_around(m, wo, u, rule == 1);
            let p: f32 = model_pdf(m, wi, wo);
            if (p > 0.0) { total += model_eval(m, wi, wo) * (wi.z / (2.0 * p)); }
        }
    }
    return total / 1600.0;
}
//END
