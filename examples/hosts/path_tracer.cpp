// A path tracer around an exported material: a sphere on grey ground under a white sky with a small sun.
//   gonio export material=orange_lacquer --to cpp --load --manifest -o .
//   g++ -O2 path_tracer.cpp -o path_tracer && ./path_tracer 256 64 sphere.pfm
// Parameters come from material.values: one line "x y z 0" for each member of the struct, which values.py takes
// from the manifest: python values.py > material.values
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "material.h"

using namespace gonio_material;

static Vec3 vec(float x, float y, float z) { return Vec3{x, y, z}; }
static Vec3 add(Vec3 a, Vec3 b) { return Vec3{a.x + b.x, a.y + b.y, a.z + b.z}; }
static Vec3 mul(Vec3 a, Vec3 b) { return Vec3{a.x * b.x, a.y * b.y, a.z * b.z}; }
static Vec3 times(Vec3 a, float s) { return Vec3{a.x * s, a.y * s, a.z * s}; }
static float inner(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static Vec3 unit(Vec3 a) { return times(a, 1.0f / sqrtf(inner(a, a))); }
static Vec3 outer(Vec3 a, Vec3 b) {
    return Vec3{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Random numbers: PCG, O'Neill 2014.
static uint64_t state = 1;
static float uniform() {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    uint32_t x = (uint32_t)(((state >> 18) ^ state) >> 27), turn = (uint32_t)(state >> 59);
    return (float)(((x >> turn) | (x << ((-turn) & 31))) >> 8) * (1.0f / 16777216.0f);
}

// The scene: a unit sphere about (0, 1, 0), ground at y = 0, sky of radiance 1, sun of irradiance 2.
static const Vec3 SUN = unit(vec(0.5f, 0.8f, 0.6f));
static const float SUN_COS = 0.995f, PI = 3.14159265f;
static const float SUN_SOLID = 2 * PI * (1 - SUN_COS), SUN_RADIANCE = 2 / SUN_SOLID, GREY = 0.3f;

struct Hit {
    float t;
    Vec3 normal;
    bool ball;
};

static Hit meet(Vec3 o, Vec3 d) {
    Hit hit{1e30f, vec(0, 1, 0), false};
    if (d.y < -1e-6f) hit.t = -o.y / d.y;
    Vec3 c = add(vec(0, 1, 0), times(o, -1));
    float b = inner(c, d);
    Vec3 e = add(c, times(d, -b));
    float q = 1 - inner(e, e);
    if (q > 0) {
        float t = b - sqrtf(q);
        if (t < 1e-3f) t = b + sqrtf(q);
        if (t > 1e-3f && t < hit.t) hit = Hit{t, unit(add(add(o, times(d, t)), vec(0, -1, 0))), true};
    }
    return hit;
}

static float sky(Vec3 d) { return 1 + (inner(d, SUN) > SUN_COS ? SUN_RADIANCE : 0); }
static float sun_pdf(Vec3 d) { return inner(d, SUN) > SUN_COS ? 1 / SUN_SOLID : 0; }

static void frame(Vec3 n, Vec3& s, Vec3& t) {
    s = unit(outer(fabsf(n.y) < 0.99f ? vec(0, 1, 0) : vec(1, 0, 0), n));
    t = outer(n, s);
}
static Vec3 local(Vec3 d, Vec3 s, Vec3 t, Vec3 n) { return vec(inner(d, s), inner(d, t), inner(d, n)); }
static Vec3 world(Vec3 d, Vec3 s, Vec3 t, Vec3 n) {
    return add(add(times(s, d.x), times(t, d.y)), times(n, d.z));
}

static Vec3 trace(const Material& material, Vec3 o, Vec3 d) {
    Vec3 light = vec(0, 0, 0), weight = vec(1, 1, 1);
    float pdf = -1;  // of the direction that leads here; none for the camera's
    for (int bounce = 0; bounce < 12; ++bounce) {
        Hit hit = meet(o, d);
        if (hit.t >= 1e30f) {  // the sky is found by the material's samples, the sun by both
            float sun = sky(d) - 1, share = pdf < 0 ? 1 : pdf / (pdf + sun_pdf(d));
            return add(light, times(weight, 1 + sun * share));
        }
        Vec3 n = hit.normal, s, t;
        frame(n, s, t);
        o = add(add(o, times(d, hit.t)), times(n, 1e-3f));
        Vec3 wo = local(times(d, -1), s, t, n);

        // One sample of the sun, weighed against the material's density (balance heuristic)
        Vec3 sun_s, sun_t;
        frame(SUN, sun_s, sun_t);
        float z = 1 - uniform() * (1 - SUN_COS), r = sqrtf(1 - z * z), phi = 2 * PI * uniform();
        Vec3 to_sun = world(vec(r * cosf(phi), r * sinf(phi), z), sun_s, sun_t, SUN);
        Vec3 wi = local(to_sun, s, t, n);
        if (wi.z > 0 && meet(o, to_sun).t >= 1e30f) {
            Vec3 f = hit.ball ? material_eval(material, wi, wo) : times(vec(1, 1, 1), GREY / PI);
            float other = hit.ball ? material_pdf(material, wi, wo) : wi.z / PI;
            light = add(light, mul(weight, times(f, wi.z * SUN_RADIANCE / (1 / SUN_SOLID + other))));
        }

        // One sample of the material
        if (hit.ball) {
            MaterialSample drawn = material_sample(material, wo, Vec2{uniform(), uniform()});
            if (drawn.pdf <= 0) return light;
            wi = drawn.wi;
            pdf = drawn.pdf;
            weight = mul(weight, times(material_eval(material, wi, wo), wi.z / pdf));
        } else {
            float a = sqrtf(uniform()), b = 2 * PI * uniform();
            wi = vec(a * cosf(b), a * sinf(b), sqrtf(1 - a * a));
            pdf = wi.z / PI;
            weight = times(weight, GREY);
        }
        d = unit(world(wi, s, t, n));
    }
    return light;
}

int main(int count, char** given) {
    if (count != 4) return fprintf(stderr, "path_tracer SIZE SAMPLES OUTPUT.pfm\n"), 1;
    int size = atoi(given[1]), samples = atoi(given[2]);
    FILE* file = fopen("material.values", "r");
    if (!file) return fprintf(stderr, "there is no material.values; run: python values.py > material.values\n"), 1;
    float values[64][4] = {};
    for (int i = 0; i < 64 && fscanf(file, "%f %f %f %f", values[i], values[i] + 1, values[i] + 2, values[i] + 3) == 4;) ++i;
    fclose(file);
    Material material = material_load(values);

    Vec3 eye = vec(0, 1.6f, 7), ahead = unit(vec(0, -0.6f, -7)), right = vec(1, 0, 0), up = outer(right, ahead);
    std::vector<float> picture;
    for (int y = size - 1; y >= 0; --y) {  // a PFM begins with the lowest line
        for (int x = 0; x < size; ++x) {
            Vec3 sum = vec(0, 0, 0);
            for (int k = 0; k < samples; ++k) {
                float u = 2 * (x + uniform()) / size - 1, v = 1 - 2 * (y + uniform()) / size;
                Vec3 d = unit(add(ahead, add(times(right, 0.25f * u), times(up, 0.25f * v))));
                sum = add(sum, trace(material, eye, d));
            }
            for (float c : {sum.x, sum.y, sum.z}) picture.push_back(c / samples);
        }
    }
    file = fopen(given[3], "wb");
    if (!file) return perror(given[3]), 1;
    fprintf(file, "PF\n%d %d\n-1.0\n", size, size);
    fwrite(picture.data(), sizeof(float), picture.size(), file);
    return fclose(file);
}
