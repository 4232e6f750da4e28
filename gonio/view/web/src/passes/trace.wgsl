// One more sample of every pixel of a band: a path with multiple importance sampling (balance heuristic).
// WebGL2 gets the same text in GLSL, from glsl.mjs. What the rows of U are says `frame` in trace.js.
@group(0) @binding(0) var<uniform> U: array<vec4f, 52>;
@group(0) @binding(1) var<uniform> P: array<vec4f, MEMBERS>;
@group(0) @binding(2) var<storage, read> nodes: array<vec4f>;
@group(0) @binding(3) var<storage, read> places: array<vec4f>;
@group(0) @binding(4) var<storage, read> looks: array<vec4f>;
@group(0) @binding(5) var<storage, read> alias_table: array<vec4f>;
@group(0) @binding(6) var sky: texture_2d<f32>;
@group(0) @binding(7) var maps: texture_2d_array<f32>;
@group(0) @binding(8) var<storage, read> before: array<vec4f>;
@group(0) @binding(9) var<storage, read_write> film: array<vec4f>;

//BEGIN
const TAU: f32 = 6.2831853;
const FAR: f32 = 1e30;

fn map_texel(at: vec2i, layer: i32) -> vec4f {
    let size: vec2i = vec2i(textureDimensions(maps).xy);
    return textureLoad(maps, ((at % size) + size) % size, layer, 0);
}
fn map_nearest(uv: vec2f, layer: i32) -> vec4f {
    return map_texel(vec2i(floor(uv * vec2f(textureDimensions(maps).xy))), layer);
}
fn map_linear(uv: vec2f, layer: i32) -> vec4f {
    let at: vec2f = uv * vec2f(textureDimensions(maps).xy) - 0.5;
    let low: vec2f = floor(at);
    let k: vec2i = vec2i(low);
    let f: vec2f = at - low;
    return mix(mix(map_texel(k, layer), map_texel(k + vec2i(1, 0), layer), f.x),
        mix(map_texel(k + vec2i(0, 1), layer), map_texel(k + vec2i(1, 1), layer), f.x), f.y);
}
//MODEL

// --- random numbers: Sobol's first two dimensions, shuffled and scrambled as Owen does, by hashes ------
fn hash(x0: u32) -> u32 {
    var x: u32 = x0;
    x ^= x >> 16u; x *= 0x7feb352du; x ^= x >> 15u; x *= 0x846ca68bu; x ^= x >> 16u;
    return x;
}
fn owen(x0: u32, seed: u32) -> u32 {
    var x: u32 = reverseBits(x0);
    x ^= x * 0x3d20adeau; x += seed; x *= (seed >> 16u) | 1u; x ^= x * 0x05526c56u; x ^= x * 0x53a22864u;
    return reverseBits(x);
}
fn sobol2(index: u32) -> vec2u {
    var second: u32 = 0u;
    var column: u32 = 0x80000000u;
    for (var i: u32 = index; i != 0u; i >>= 1u) {
        if ((i & 1u) != 0u) { second ^= column; }
        column ^= column >> 1u;
    }
    return vec2u(reverseBits(index), second);
}
var<private> pixel_seed: u32;
fn unit2(pair: u32) -> vec2f {
    let seed: u32 = hash(pixel_seed ^ (pair * 0x9e3779b9u));
    let point: vec2u = sobol2(owen(u32(U[0].z), seed));
    let x: u32 = owen(point.x, hash(seed ^ 0x68bc21ebu));
    let y: u32 = owen(point.y, hash(seed ^ 0x02e5be93u));
    return vec2f(f32(x >> 8u), f32(y >> 8u)) * (1.0 / 16777216.0);
}

// --- what a ray meets ---------------------------------------------------------------------------------
struct Hit { t: f32, what: i32, u: f32, v: f32 }

fn away_from_zero(x: f32) -> f32 { return select(x, 1e-12, abs(x) < 1e-12); }
fn box(o: vec3f, inv: vec3f, low: vec3f, high: vec3f, far: f32) -> f32 {
    let a: vec3f = (low - o) * inv;
    let b: vec3f = (high - o) * inv;
    let near: vec3f = min(a, b);
    let away: vec3f = max(a, b);
    let t0: f32 = max(max(near.x, near.y), max(near.z, 0.0));
    let t1: f32 = min(min(away.x, away.y), min(away.z, far));
    return select(FAR, t0, t0 <= t1 * 1.0000004);
}
fn ball(o: vec3f, d: vec3f, far: f32) -> f32 {
    let c: vec3f = U[8].xyz - o;
    let b: f32 = dot(c, d);
    let e: vec3f = c - b * d; // across the ray: the difference of squares keeps its digits
    let q: f32 = U[8].w * U[8].w - dot(e, e);
    if (q <= 0.0 || U[8].w <= 0.0) { return FAR; }
    let s: f32 = sqrt(q);
    let t: f32 = select(b - s, b + s, b - s < 1e-4);
    return select(FAR, t, t > 1e-4 && t < far);
}
fn lamp_count() -> i32 { return i32(U[6].z); }
fn turned(v: vec3f, sense: f32) -> vec3f {
    let s: f32 = U[6].y * sense;
    return vec3f(U[6].x * v.x + s * v.z, v.y, U[6].x * v.z - s * v.x);
}
fn meet(o: vec3f, d: vec3f, far: f32, any: bool) -> Hit {
    var hit: Hit = Hit(far, -1, 0.0, 0.0);
    let t_ball: f32 = ball(o, d, hit.t);
    if (t_ball < hit.t) { hit = Hit(t_ball, -2, 0.0, 0.0); if (any) { return hit; } }
    for (var k: i32 = 0; k < lamp_count(); k++) {
        let c: vec3f = U[12 + 5 * k].xyz;
        let a: vec3f = U[13 + 5 * k].xyz;
        let b: vec3f = U[14 + 5 * k].xyz;
        let n: vec3f = U[16 + 5 * k].xyz;
        let down: f32 = dot(n, d);
        let t: f32 = dot(n, c - o) / select(down, 1e-20, down == 0.0);
        if (t > 1e-3 && t < hit.t) {
            let q: vec3f = o + t * d - c;
            let x: f32 = dot(q, a) / dot(a, a);
            let y: f32 = dot(q, b) / dot(b, b);
            let inside: f32 = select(max(abs(x), abs(y)), sqrt(x * x + y * y), U[12 + 5 * k].w > 0.5);
            if (inside <= 1.0) { hit = Hit(t, -3 - k, 0.0, 0.0); if (any) { return hit; } }
        }
    }
    if (U[7].y < 1.0) { return hit; }
    let inv: vec3f = 1.0 / vec3f(away_from_zero(d.x), away_from_zero(d.y), away_from_zero(d.z));
    var stack: array<i32, 40>;
    var top: i32 = 0;
    var at: i32 = 0;
    if (box(o, inv, nodes[0].xyz, nodes[1].xyz, hit.t) >= FAR) { return hit; }
    loop {
        let first: i32 = i32(nodes[2 * at].w);
        let count: i32 = i32(nodes[2 * at + 1].w);
        if (count > 0) {
            for (var i: i32 = first; i < first + count; i++) {
                let e1: vec3f = places[3 * i + 1].xyz;
                let e2: vec3f = places[3 * i + 2].xyz;
                let h: vec3f = cross(d, e2);
                let a: f32 = dot(e1, h);
                if (abs(a) > 1e-14) {
                    let f: f32 = 1.0 / a;
                    let s: vec3f = o - places[3 * i].xyz;
                    let u: f32 = f * dot(s, h);
                    let q: vec3f = cross(s, e1);
                    let v: f32 = f * dot(d, q);
                    let t: f32 = f * dot(e2, q);
                    if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-4 && t < hit.t) {
                        hit = Hit(t, i, u, v);
                        if (any) { return hit; }
                    }
                }
            }
            if (top == 0) { break; }
            top--; at = stack[top];
        } else {
            var one: i32 = first;
            var two: i32 = first + 1;
            var t1: f32 = box(o, inv, nodes[2 * one].xyz, nodes[2 * one + 1].xyz, hit.t);
            var t2: f32 = box(o, inv, nodes[2 * two].xyz, nodes[2 * two + 1].xyz, hit.t);
            if (t2 < t1) { let k: i32 = one; one = two; two = k; let t: f32 = t1; t1 = t2; t2 = t; }
            if (t1 >= FAR) { if (top == 0) { break; } top--; at = stack[top]; }
            else { at = one; if (t2 < FAR) { stack[top] = two; top++; } }
        }
    }
    return hit;
}

// Ground that fades into what is behind it, as gonio render has it: where a ray meets it, and how much is there.
fn ground_at(o: vec3f, d: vec3f) -> f32 {
    let t: f32 = -o.y / select(d.y, 1e-20, d.y == 0.0);
    return select(FAR, t, U[7].w > 0.0 && t > 1e-4);
}
fn ground_share(p: vec3f) -> f32 {
    let t: f32 = clamp((length(p.xz) - U[7].z) / max(U[7].w - U[7].z, 1e-6), 0.0, 1.0);
    let x: f32 = 1.0 - t * t * (3.0 - 2.0 * t);
    return x * x;
}

// --- light --------------------------------------------------------------------------------------------
fn sky_texel(x: i32, y: i32) -> vec3f {
    let w: i32 = i32(U[10].x);
    return textureLoad(sky, vec2i(((x % w) + w) % w, clamp(y, 0, i32(U[10].y) - 1)), 0).rgb;
}
fn sky_place(d: vec3f) -> vec2f {
    let w: vec3f = turned(d, -1.0);
    // The middle of the picture is behind the object, at -z.
    return vec2f(fract(atan2(-w.x, w.z) / TAU), acos(clamp(w.y, -1.0, 1.0)) / (0.5 * TAU)) * U[10].xy;
}
fn surround(d: vec3f) -> vec3f {
    if (U[5].w < 0.5) { return U[5].xyz; }
    let at: vec2f = sky_place(d) - 0.5;
    let low: vec2f = floor(at);
    let f: vec2f = at - low;
    let k: vec2i = vec2i(low);
    let value: vec3f = mix(mix(sky_texel(k.x, k.y), sky_texel(k.x + 1, k.y), f.x),
        mix(sky_texel(k.x, k.y + 1), sky_texel(k.x + 1, k.y + 1), f.x), f.y);
    return value * U[5].xyz;
}
fn sky_pdf(d: vec3f) -> f32 {
    let at: vec2u = min(vec2u(sky_place(d)), vec2u(U[10].xy) - 1u);
    return U[6].w * alias_table[at.y * u32(U[10].x) + at.x].z;
}
// A lamp is chosen by about what it sends to a surface: its power, distance and both cosines, never 0.
fn lamp_weight(k: i32, o: vec3f, n: vec3f) -> f32 {
    let way: vec3f = U[12 + 5 * k].xyz - o;
    let square: f32 = max(dot(way, way), 1e-6);
    let d: vec3f = way / sqrt(square);
    let above: f32 = clamp(dot(n, d) + sqrt(U[13 + 5 * k].w / square), 0.05, 1.0);
    return U[15 + 5 * k].w * (0.1 + max(-dot(U[16 + 5 * k].xyz, d), 0.0)) * above / square;
}
// The lamp that u chooses, or the known one if that is not below 0, and how often it is chosen.
struct Choice { k: i32, share: f32 }
fn choose(o: vec3f, n: vec3f, u: f32, known: i32) -> Choice {
    var found: Choice = Choice(max(known, 0), 0.0);
    var total: f32 = 0.0;
    var rest: f32 = u;
    for (var k: i32 = 0; k < lamp_count(); k++) {
        let weight: f32 = lamp_weight(k, o, n);
        total += weight;
        // One of those so far takes the place of the last choice; what is left of u is random again
        let p: f32 = weight / total;
        if (k == known || (known < 0 && rest < p)) { found = Choice(k, weight); rest /= p; }
        else { rest = (rest - p) / max(1.0 - p, 1e-20); }
    }
    found.share /= max(total, 1e-20);
    return found;
}
fn lamp_pdf(lamp: Choice, t: f32, d: vec3f) -> f32 {
    let seen: f32 = max(-dot(U[16 + 5 * lamp.k].xyz, d), 1e-6) * U[13 + 5 * lamp.k].w;
    return (1.0 - U[6].w) * lamp.share * t * t / seen;
}
// Towards the light; of the picture, as far as FAR, the radiance is known only where the ray has got there.
struct Light { d: vec3f, far: f32, radiance: vec3f, pdf: f32 }
fn sample_light(o: vec3f, normal: vec3f, u: vec2f, choice: vec2f) -> Light {
    if (choice.x < U[6].w) {
        let size: vec2u = vec2u(U[10].xy);
        let x: f32 = choice.x / U[6].w * f32(size.x * size.y);
        let cell: u32 = min(u32(x), size.x * size.y - 1u);
        let entry: vec4f = alias_table[cell];
        let k: u32 = select(u32(entry.y), cell, choice.y < entry.x);
        let place: vec2f = vec2f(f32(k % size.x) + u.x, f32(k / size.x) + u.y) / U[10].xy;
        let th: f32 = place.y * 0.5 * TAU;
        let ph: f32 = place.x * TAU;
        let d: vec3f = turned(vec3f(-sin(th) * sin(ph), cos(th), sin(th) * cos(ph)), 1.0);
        return Light(d, FAR, vec3f(1.0), U[6].w * alias_table[k].z);
    }
    let lamp: Choice = choose(o, normal, (choice.x - U[6].w) / (1.0 - U[6].w), -1);
    let k: i32 = lamp.k;
    var s: vec2f = 2.0 * u - 1.0;
    if (U[12 + 5 * k].w > 0.5) { s = sqrt(u.x) * vec2f(cos(TAU * u.y), sin(TAU * u.y)); }
    let way: vec3f = U[12 + 5 * k].xyz + s.x * U[13 + 5 * k].xyz + s.y * U[14 + 5 * k].xyz - o;
    let t: f32 = length(way);
    let d: vec3f = way / t;
    if (dot(U[16 + 5 * k].xyz, d) >= 0.0 || lamp_count() < 1) { return Light(d, 0.0, vec3f(0.0), 0.0); }
    return Light(d, t * 0.9999, U[15 + 5 * k].xyz, lamp_pdf(lamp, t, d));
}

// --- a path -------------------------------------------------------------------------------------------
fn any_frame(n: vec3f) -> vec3f {
    return normalize(cross(select(vec3f(0.0, 1.0, 0.0), vec3f(1.0, 0.0, 0.0), abs(n.y) > 0.99), n));
}
fn path(origin: vec3f, direction: vec3f) -> vec3f {
    var o: vec3f = origin;
    var d: vec3f = direction;
    var L: vec3f = vec3f(0.0);
    var T: vec3f = vec3f(1.0);
    var pdf: f32 = -1.0; // of the direction that leads here; below 0 for the camera's
    var facing: vec3f = vec3f(0.0); // the normal of the surface that it comes from
    let furnace: bool = U[3].w > 0.5;
    let way: i32 = i32(U[9].z); // 0 both, 1 the model's samples alone, 2 the light's alone
    let depth: i32 = i32(U[4].w);
    // Rays towards lights and those that the path goes on by take turns in one loop, and both directions of a
    // surface in another: what follows a ray and what a model is stand in the shader once, so that it compiles fast.
    var far: f32 = FAR;
    var waiting: vec3f = vec3f(0.0); // light that comes if the ray to it meets nothing
    var shadow: bool = false;
    var onward: vec3f = vec3f(0.0); // where the path goes on after that; it ends where there is no such
    var b: i32 = 0;
    for (var i: i32 = 0; i < 2 * depth; i++) {
        var hit: Hit = meet(o, d, far, shadow);
        let t_ground: f32 = ground_at(o, d);
        let covered: f32 = select(0.0, ground_share(o + t_ground * d), t_ground < hit.t);
        let u_end: vec2f = unit2(u32(4 * b + 4));
        if (!shadow && u_end.y < covered) { hit = Hit(t_ground, 1 << 30, 0.0, 0.0); }
        if (hit.what == -1 && far == FAR) {
            var w: f32 = 1.0;
            if (!shadow && U[6].w > 0.0 && pdf >= 0.0) { w = pdf / (pdf + sky_pdf(d)); if (way == 1) { w = 1.0; } if (way == 2) { w = 0.0; } }
            waiting = select(T, waiting, shadow) * surround(d) * w;
        }
        if (shadow) {
            if (hit.what == -1) { L += waiting * (1.0 - covered); }
            if (dot(onward, onward) == 0.0) { break; }
            shadow = false;
            far = FAR;
            d = onward;
            b++;
            continue;
        }
        if (hit.what == -1) { L += waiting; break; }
        if (hit.what < -2) {
            let k: i32 = -3 - hit.what;
            if (dot(U[16 + 5 * k].xyz, d) < 0.0) {
                var w: f32 = 1.0;
                if (pdf >= 0.0) { w = pdf / (pdf + lamp_pdf(choose(o, facing, 0.0, k), hit.t, d)); if (way == 1) { w = 1.0; } if (way == 2) { w = 0.0; } }
                L += T * U[15 + 5 * k].xyz * w;
            }
            break;
        }
        if (b == depth - 1) { break; }
        // The surface: geometric and shading normal, tangent, texture coordinates
        let x: vec3f = o + hit.t * d;
        var p: vec3f = x;
        var ng: vec3f;
        var n: vec3f;
        var du: vec3f;
        var uv: vec2f = vec2f(0.0);
        var growth: f32 = 0.5;
        var kind: i32 = 0;
        if (hit.what == 1 << 30) {
            ng = vec3f(0.0, 1.0, 0.0);
            n = ng;
            du = vec3f(1.0, 0.0, 0.0);
            kind = 3;
        } else if (hit.what == -2) {
            n = normalize(x - U[8].xyz);
            ng = n;
            du = vec3f(-n.z, 0.0, n.x);
            uv = vec2f(fract(atan2(-n.x, -n.z) / TAU + 1.0), acos(clamp(n.y, -1.0, 1.0)) / (0.5 * TAU));
            p = U[8].xyz + U[8].w * n;
        } else {
            let i: i32 = hit.what;
            let p0: vec3f = places[3 * i].xyz;
            let e1: vec3f = places[3 * i + 1].xyz;
            let e2: vec3f = places[3 * i + 2].xyz;
            let n0: vec3f = looks[5 * i].xyz;
            let n1: vec3f = looks[5 * i + 1].xyz;
            let n2: vec3f = looks[5 * i + 2].xyz;
            let a: f32 = 1.0 - hit.u - hit.v;
            kind = i32(places[3 * i].w);
            ng = normalize(cross(e1, e2));
            n = normalize(a * n0 + hit.u * n1 + hit.v * n2);
            growth = a * looks[5 * i].w + hit.u * looks[5 * i + 1].w + hit.v * looks[5 * i + 2].w;
            let t01: vec4f = looks[5 * i + 3];
            let t2: vec2f = looks[5 * i + 4].xy;
            uv = a * t01.xy + hit.u * t01.zw + hit.v * t2;
            let s1: vec2f = t01.zw - t01.xy;
            let s2: vec2f = t2 - t01.xy;
            du = (e1 * s2.y - e2 * s1.y) * sign(s1.x * s2.y - s1.y * s2.x);
            // The point lifted onto the smooth surface that the normals tell of (Hanika's shadow terminator)
            p = p0 + hit.u * e1 + hit.v * e2;
            let side: f32 = select(-1.0, 1.0, dot(ng, d) < 0.0);
            let q0: vec3f = p - p0;
            let q1: vec3f = q0 - e1;
            let q2: vec3f = q0 - e2;
            let l0: f32 = min(0.0, side * dot(q0, n0));
            let l1: f32 = min(0.0, side * dot(q1, n1));
            let l2: f32 = min(0.0, side * dot(q2, n2));
            if (kind == 0) { p -= side * (a * l0 * n0 + hit.u * l1 * n1 + hit.v * l2 * n2); }
        }
        if (kind == 0) {
            let bump: vec3f = normal_at(uv);
            if (abs(bump.x) + abs(bump.y) > 1e-4) {
                let across: vec3f = du - dot(du, n) * n;
                let u_axis: vec3f = select(any_frame(n), across / max(length(across), 1e-20), dot(across, across) > 1e-16);
                n = normalize(bump.x * u_axis + bump.y * cross(n, u_axis) + bump.z * n);
            }
        }
        if (dot(ng, d) > 0.0) { ng = -ng; n = -n; }
        let below: f32 = dot(n, d);
        if (below > -1e-3) { n = normalize(n - (below + 1e-3) * d); } // smooth normals that look away
        du = du - dot(du, n) * n;
        let tx: vec3f = select(any_frame(n), du / max(length(du), 1e-20), dot(du, du) > 1e-16);
        let ty: vec3f = cross(n, tx);
        let wo: vec3f = vec3f(-dot(d, tx), -dot(d, ty), -dot(d, n));
        p += 1e-4 * ng;

        let u_light: vec2f = unit2(u32(4 * b + 1));
        let u_choice: vec2f = unit2(u32(4 * b + 2));
        let u_model: vec2f = unit2(u32(4 * b + 3));
        let test: bool = kind == 0;
        let grey: vec3f = select(vec3f(select(0.12, 0.32, kind == 1)), U[11].xyz, kind == 3) / (0.5 * TAU);
        var m: Model = model_at(uv, growth, hit.t);
        // Where the path may go on
        var next: vec3f = vec3f(sqrt(u_model.x) * vec2f(cos(TAU * u_model.y), sin(TAU * u_model.y)), sqrt(max(1.0 - u_model.x, 1e-12)));
        var density: f32 = next.z / (0.5 * TAU);
        if (test) {
            let s: ModelSample = model_sample(m, wo, u_model);
            next = s.wi;
            density = s.pdf;
        }
        // What comes from the light, and then what comes from there
        var light: Light = Light(vec3f(0.0), 0.0, vec3f(0.0), 0.0);
        if (!furnace && way != 1 && (U[6].w > 0.0 || lamp_count() > 0)) { light = sample_light(p, n, u_light, u_choice); }
        let to_light: vec3f = vec3f(dot(light.d, tx), dot(light.d, ty), dot(light.d, n));
        var going: vec3f = vec3f(0.0);
        waiting = vec3f(0.0);
        for (var k: i32 = select(1, 0, light.pdf > 0.0 && to_light.z > 0.0); k < select(1, 2, density > 0.0); k++) {
            let wi: vec3f = select(next, to_light, k == 0);
            var f: vec3f = grey;
            if (test) { f = model_eval(m, wi, wo); }
            if (k == 0) {
                var q: f32 = wi.z / (0.5 * TAU);
                if (test) { q = model_pdf(m, wi, wo); }
                if (way == 2) { q = 0.0; }
                waiting = T * f * light.radiance * (wi.z / (light.pdf + q));
            } else {
                going = T * f * (wi.z / density);
            }
        }
        T = going;
        pdf = density;
        o = p;
        facing = n;
        onward = vec3f(0.0);
        let left: f32 = max(T.x, max(T.y, T.z));
        if (left > 0.0) {
            let keep: f32 = select(1.0, max(left, 0.05), !furnace && b >= 2 && left < 1.0);
            if (u_end.x < keep) {
                onward = normalize(tx * next.x + ty * next.y + n * next.z);
                T /= keep;
            }
        }
        shadow = max(waiting.x, max(waiting.y, waiting.z)) > 0.0;
        if (shadow) { d = light.d; far = light.far; continue; }
        if (dot(onward, onward) == 0.0) { break; }
        d = onward;
        b++;
    }
    return L;
}

fn pixel(at: vec2u) -> vec4f {
    pixel_seed = hash(at.x + hash(at.y + hash(u32(U[0].w))));
    let q: vec2f = ((vec2f(at) + unit2(0u)) / U[0].xy * 2.0 - 1.0) * vec2f(U[2].w, -1.0) * U[1].w;
    let L: vec3f = path(U[1].xyz, normalize(U[4].xyz + q.x * U[2].xyz + q.y * U[3].xyz));
    let lum: f32 = dot(L, vec3f(0.2126, 0.7152, 0.0722));
    return vec4f(L, lum * lum);
}
//END

@compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = vec2u(U[0].xy);
    let at = vec2u(id.x, id.y + u32(U[9].x));
    if (at.x >= size.x || at.y >= min(size.y, u32(U[9].y))) { return; }
    let i = at.y * size.x + at.x;
    film[i] = select(before[i], vec4f(0.0), U[0].z < 0.5) + pixel(at);
}
