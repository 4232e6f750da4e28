// Two films to the screen: exposure, tone curve, comparison, sRGB. What the rows of D are says `screen` in display.js.
//BEGIN
fn texel_of(second: bool, x: i32, y: i32) -> vec3f {
    let k: i32 = select(0, 1, second);
    let w: i32 = i32(D[k].z);
    let h: i32 = i32(D[k].w);
    let cx: i32 = clamp(x, 0, w - 1);
    let cy: i32 = clamp(y, 0, h - 1);
    return film_at(second, cx, cy, w).rgb * select(D[2].x, D[2].y, second);
}
fn picture(second: bool, at: vec2f) -> vec3f {
    let k: i32 = select(0, 1, second);
    // A film of another shape, until there is one of this: not stretched, for its shorter side has the camera's angle
    let wide: f32 = D[3].x / D[3].y * select(1.0, 0.5, D[0].x == 3.0);
    let film_wide: f32 = D[k].z / D[k].w;
    let fit: vec2f = max(vec2f(wide, 1.0 / wide), vec2f(1.0)) / max(vec2f(film_wide, 1.0 / film_wide), vec2f(1.0));
    let q: vec2f = ((at - 0.5) * fit + 0.5) * D[k].zw - 0.5;
    let low: vec2f = floor(q);
    let f: vec2f = q - low;
    let x: i32 = i32(low.x);
    let y: i32 = i32(low.y);
    return mix(mix(texel_of(second, x, y), texel_of(second, x + 1, y), f.x),
        mix(texel_of(second, x, y + 1), texel_of(second, x + 1, y + 1), f.x), f.y);
}
fn toned(x: vec3f) -> vec3f {
    let tone: i32 = i32(D[1].y);
    let y: f32 = dot(x, vec3f(0.2126, 0.7152, 0.0722));
    if (tone == 1) { return x * ((1.0 + y / 16.0) / (1.0 + y)); } // Reinhard, Eq. 4, white at 4
    if (tone == 2) { // Hable's curve for Uncharted 2, white at 11.2
        let white: f32 = 1.379064;
        let v: vec3f = 2.0 * x;
        return white * ((v * (0.15 * v + 0.05) + 0.004) / (v * (0.15 * v + 0.5) + 0.06) - 0.0666667);
    }
    return x;
}
fn encoded(x: f32) -> f32 {
    let y: f32 = clamp(x, 0.0, 1.0);
    return select(1.055 * pow(max(y, 1e-9), 1.0 / 2.4) - 0.055, 12.92 * y, y < 0.0031308);
}
fn screen(at: vec2f) -> vec4f {
    let mode: i32 = i32(D[0].x);
    var place: vec2f = at;
    var second: bool = mode == 1;
    if (mode == 2) { second = at.x > D[0].y; }
    if (mode == 3) { second = at.x > 0.5; place.x = fract(at.x * 2.0); }
    var x: vec3f = picture(second, place);
    if (mode == 4) { x = 10.0 * abs(picture(true, at) - picture(false, at)); }
    else { x = toned(x * D[1].x); }
    // Half a step of noise: eight bits would show bands in a backdrop
    let noise: f32 = fract(52.9829189 * fract(dot(at * 4096.0, vec2f(0.06711056, 0.00583715)))) - 0.5;
    return vec4f(vec3f(encoded(x.x), encoded(x.y), encoded(x.z)) + noise / 255.0, 1.0);
}
//END
