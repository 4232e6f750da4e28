// The C++ that `gonio bench` compares gonio with: every model typed from its paper, float32, one scalar function
// per model, called once per direction pair in a straight loop. Compiled and driven by native.py.
//
// It is meant to be neither slowed down nor tuned: no intrinsics, no -ffast-math, no table, nothing computed twice.
// Two loops run the same functions:
//   calls     through a function pointer, one call per pair, as a renderer calls its BSDF; this is the baseline;
//   inlined   the function is a template argument, so the compiler may inline it, move constants out of the loop
//             and vectorise: the best that plain C++ of this kind can do.
//
// Directions are unit vectors in the local frame (N = +z), above the horizon; no function checks that. wo is known,
// wi is sampled. Values are BRDFs in 1/sr without the cosine.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <memory>
#include <thread>
#include <vector>

namespace {

const float PI = 3.14159265f;

struct Vec3 {
    float x, y, z;
};

Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec3 operator*(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
Vec3 operator/(Vec3 a, Vec3 b) { return {a.x / b.x, a.y / b.y, a.z / b.z}; }
Vec3 operator*(Vec3 a, float b) { return {a.x * b, a.y * b, a.z * b}; }
Vec3 operator/(Vec3 a, float b) { return a * (1.0f / b); }
Vec3 white() { return {1.0f, 1.0f, 1.0f}; }
float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
float length(Vec3 a) { return std::sqrt(dot(a, a)); }
Vec3 normalize(Vec3 a) { return a / length(a); }
float mix(float a, float b, float t) { return a + t * (b - a); }

struct Params {
    Vec3 rho;
    float roughness;  // sigma in radians, r or the shininess n: whatever the model takes
};

// ---- Values ----------------------------------------------------------------------------------------------------

Vec3 lambert(const Params& p, Vec3, Vec3) { return p.rho / PI; }

// Oren and Nayar 1994, Eq. 27-29, with interreflection.
Vec3 oren_nayar(const Params& p, Vec3 wi, Vec3 wo) {
    float sigma2 = p.roughness * p.roughness;
    float theta_i = std::acos(wi.z), theta_o = std::acos(wo.z);
    float alpha = std::max(theta_i, theta_o), beta = std::min(theta_i, theta_o);
    float sines = std::sqrt((1.0f - wi.z * wi.z) * (1.0f - wo.z * wo.z));
    float c = sines > 0.0f ? (wi.x * wo.x + wi.y * wo.y) / sines : 0.0f;  // cos(phi_i - phi_o)

    float b = 2.0f * beta / PI;
    float C1 = 1.0f - 0.5f * sigma2 / (sigma2 + 0.33f);
    float C2 = 0.45f * sigma2 / (sigma2 + 0.09f) * (c >= 0.0f ? std::sin(alpha) : std::sin(alpha) - b * b * b);
    float a = 4.0f * alpha * beta / (PI * PI);
    float C3 = 0.125f * sigma2 / (sigma2 + 0.09f) * a * a;
    float single = C1 + c * C2 * std::tan(beta) + (1.0f - std::abs(c)) * C3 * std::tan(0.5f * (alpha + beta));
    float twice = 0.17f * sigma2 / (sigma2 + 0.13f) * (1.0f - c * b * b);
    return p.rho / PI * single + p.rho * p.rho / PI * twice;
}

// s / t of the qualitative model (Oren and Nayar 1994, Eq. 30) and of Fujii's, which keeps the negative s.
float s_over_t_qon(Vec3 wi, Vec3 wo) {
    float s = dot(wi, wo) - wi.z * wo.z;
    return s > 0.0f ? s / std::max(wi.z, wo.z) : 0.0f;
}

float s_over_t_fujii(Vec3 wi, Vec3 wo) {
    float s = dot(wi, wo) - wi.z * wo.z;
    return s > 0.0f ? s / std::max(wi.z, wo.z) : s;
}

Vec3 qon(const Params& p, Vec3 wi, Vec3 wo) {
    float sigma2 = p.roughness * p.roughness;
    float A = 1.0f - 0.5f * sigma2 / (sigma2 + 0.33f);
    float B = 0.45f * sigma2 / (sigma2 + 0.09f);
    return p.rho / PI * (A + B * s_over_t_qon(wi, wo));
}

Vec3 qon_footnote(const Params& p, Vec3 wi, Vec3 wo) {
    float sigma2 = p.roughness * p.roughness;
    float A = 1.0f - 0.5f * sigma2 / (sigma2 + 0.57f);
    float B = 0.45f * sigma2 / (sigma2 + 0.09f);
    return p.rho / PI * (A + B * s_over_t_qon(wi, wo));
}

Vec3 qon_fujii(const Params& p, Vec3 wi, Vec3 wo) {
    float sigma2 = p.roughness * p.roughness;
    Vec3 A = white() * (1.0f - 0.5f * sigma2 / (sigma2 + 0.33f)) + p.rho * (0.17f * sigma2 / (sigma2 + 0.13f));
    float B = 0.45f * sigma2 / (sigma2 + 0.09f);
    return p.rho / PI * (A + white() * (B * s_over_t_fujii(wi, wo)));
}

// EON, arXiv:2410.18026, Listing 1.
const float constant1_FON = 0.5f - 2.0f / (3.0f * PI);
const float constant2_FON = 2.0f / 3.0f - 28.0f / (15.0f * PI);

Vec3 fon(const Params& p, Vec3 wi, Vec3 wo) {
    float AF = 1.0f / (1.0f + constant1_FON * p.roughness);
    return p.rho / PI * AF * (1.0f + p.roughness * s_over_t_fujii(wi, wo));
}

float E_FON_exact(float mu, float r) {
    float AF = 1.0f / (1.0f + constant1_FON * r);
    float BF = r * AF;
    float Si = std::sqrt(1.0f - mu * mu);
    float G = Si * (std::acos(mu) - Si * mu) + (2.0f / 3.0f) * ((Si / mu) * (1.0f - (Si * Si * Si)) - Si);
    return AF + (BF / PI) * G;
}

float E_FON_approx(float mu, float r) {
    float mucomp = 1.0f - mu;
    float mucomp2 = mucomp * mucomp;
    // The listing's dot(mat2 * vec2(mucomp, mucomp2), vec2(1, mucomp2)), written out.
    float GoverPi = 0.0571085289f * mucomp + 0.491881867f * mucomp2 +
                    (-0.332181442f * mucomp + 0.0714429953f * mucomp2) * mucomp2;
    return (1.0f + r * GoverPi) / (1.0f + constant1_FON * r);
}

template <bool exact>
Vec3 eon(const Params& p, Vec3 wi, Vec3 wo) {
    float r = p.roughness;
    float AF = 1.0f / (1.0f + constant1_FON * r);
    Vec3 f_ss = p.rho / PI * AF * (1.0f + r * s_over_t_fujii(wi, wo));
    float EFo = exact ? E_FON_exact(wo.z, r) : E_FON_approx(wo.z, r);
    float EFi = exact ? E_FON_exact(wi.z, r) : E_FON_approx(wi.z, r);
    float avgEF = AF * (1.0f + constant2_FON * r);
    Vec3 rho_ms = p.rho * p.rho * avgEF / (white() - p.rho * (1.0f - avgEF));
    const float eps = 1.0e-7f;
    Vec3 f_ms = rho_ms / PI * std::max(eps, 1.0f - EFo) * std::max(eps, 1.0f - EFi) / std::max(eps, 1.0f - avgEF);
    return f_ss + f_ms;
}

// Gotanda 2012, Eq. 25; n is the shininess.
Vec3 triace_oren_nayar(const Params& p, Vec3 wi, Vec3 wo) {
    float n = p.roughness;
    float A = 1.0f - 1.0f / (2.0f + 0.65f * n);
    float B = 1.0f / (2.22222f + 0.1f * n);
    return p.rho / PI * (A + B * s_over_t_fujii(wi, wo));
}

float pow5(float x) {
    float x2 = x * x;
    return x2 * x2 * x;
}

Vec3 burley_diffuse(const Params& p, Vec3 wi, Vec3 wo) {
    float cos_d = dot(wi, normalize(wi + wo));
    float F90 = 0.5f + 2.0f * cos_d * cos_d * p.roughness;
    return p.rho / PI * (1.0f + (F90 - 1.0f) * pow5(1.0f - wi.z)) * (1.0f + (F90 - 1.0f) * pow5(1.0f - wo.z));
}

// ---- Samples ---------------------------------------------------------------------------------------------------

struct Sample {
    Vec3 wi;
    float pdf;
};

Sample cosine_sample(const Params&, Vec3, float u1, float u2) {
    float R = std::sqrt(u1), phi = 2.0f * PI * u2;
    float z = std::sqrt(1.0f - u1);
    return {{R * std::cos(phi), R * std::sin(phi), z}, z / PI};
}

// EON, Listings 2-4.
struct Ltc {
    float a, b, c, d;
};

Ltc ltc_coeffs(float mu, float r) {
    float a = 1.0f + r * (0.303392f + (-0.518982f + 0.111709f * mu) * mu + (-0.276266f + 0.335918f * mu) * r);
    float b = r * (-1.16407f + 1.15859f * mu + (0.150815f - 0.150105f * mu) * r) / (mu * mu * mu - 1.43545f);
    float c = 1.0f + (0.20013f + (-0.506373f + 0.261777f * mu) * mu) * r;
    float d = r * (0.540852f + (-1.01625f + 0.475392f * mu) * mu) / (-1.0743f + mu * (0.0725628f + mu));
    return {a, b, c, d};
}

// First axis of the frame whose x points along the azimuth of w; the second is (-y, x).
Vec3 ltc_x_axis(Vec3 w) {
    float lenSqr = w.x * w.x + w.y * w.y;
    return lenSqr > 0.0f ? Vec3{w.x, w.y, 0.0f} * (1.0f / std::sqrt(lenSqr)) : Vec3{1.0f, 0.0f, 0.0f};
}

Sample cltc_sample(Vec3 wo, float r, float u1, float u2) {
    Ltc m = ltc_coeffs(wo.z, r);
    float R = std::sqrt(u1), phi = 2.0f * PI * u2;
    float x = R * std::cos(phi), y = R * std::sin(phi);
    float vz = 1.0f / std::sqrt(m.d * m.d + 1.0f);
    float s = 0.5f * (1.0f + vz);
    x = mix(std::sqrt(1.0f - y * y), x, s);
    x = m.d < 0.0f ? -x : x;  // the listing has -x always; d turns positive above mu = 0.99986
    Vec3 wh = {x, y, std::sqrt(std::max(1.0f - (x * x + y * y), 0.0f))};
    float pdf_wh = wh.z / (PI * s);
    Vec3 wi = {m.a * wh.x + m.b * wh.z, m.c * wh.y, m.d * wh.x + wh.z};
    float len = length(wi);
    float detM = m.c * (m.a - m.b * m.d);
    float pdf_wi = pdf_wh * len * len * len / detM;
    Vec3 X = ltc_x_axis(wo);
    return {normalize({X.x * wi.x - X.y * wi.y, X.y * wi.x + X.x * wi.y, wi.z}), pdf_wi};
}

float cltc_pdf(Vec3 wo, Vec3 wi, float r) {
    Vec3 X = ltc_x_axis(wo);
    wi = {X.x * wi.x + X.y * wi.y, X.x * wi.y - X.y * wi.x, wi.z};
    Ltc m = ltc_coeffs(wo.z, r);
    float detM = m.c * (m.a - m.b * m.d);
    Vec3 wh = {m.c * (wi.x - m.b * wi.z), (m.a - m.b * m.d) * wi.y, -m.c * (m.d * wi.x - m.a * wi.z)};
    float lenSqr = dot(wh, wh);
    float vz = 1.0f / std::sqrt(m.d * m.d + 1.0f);
    float s = 0.5f * (1.0f + vz);
    return detM * detM / (lenSqr * lenSqr) * std::max(wh.z, 0.0f) / (PI * s);
}

Sample eon_sample(const Params& p, Vec3 wo, float u1, float u2) {
    float mu = wo.z, r = p.roughness;
    float P_u = std::pow(r, 0.1f) * (0.162925f + mu * (-0.372058f + (0.538233f - 0.290822f * mu) * mu));
    float P_c = 1.0f - P_u;
    Sample s;
    if (u1 < P_u) {  // the listing's <= makes 0 / 0 of u1 = 0 at r = 0
        u1 = u1 / P_u;
        float sinTheta = std::sqrt(1.0f - u1 * u1), phi = 2.0f * PI * u2;
        s.wi = {sinTheta * std::cos(phi), sinTheta * std::sin(phi), u1};
        s.pdf = cltc_pdf(wo, s.wi, r);
    } else {
        s = cltc_sample(wo, r, (u1 - P_u) / P_c, u2);
    }
    s.pdf = P_u / (2.0f * PI) + P_c * s.pdf;
    return s;
}

// ---- Loops -----------------------------------------------------------------------------------------------------

using EvalFunction = Vec3(const Params&, Vec3 wi, Vec3 wo);
using SampleFunction = Sample(const Params&, Vec3 wo, float u1, float u2);

// One array per component: wi.xyz, wo.xyz -> value.rgb for eval; wo.xyz, u1, u2 -> wi.xyz, pdf, value.rgb for sample.
using Inputs = const float* const*;
using Outputs = float* const*;

// Always inlined into its callers below, which differ only in whether f is known to the compiler.
[[gnu::always_inline]] inline void eval_loop(EvalFunction* f, Params p, Inputs in, Outputs out, size_t begin,
                                             size_t end) {
    const float *wi_x = in[0], *wi_y = in[1], *wi_z = in[2];
    const float *wo_x = in[3], *wo_y = in[4], *wo_z = in[5];
    float *__restrict red = out[0], *__restrict green = out[1], *__restrict blue = out[2];
    for (size_t i = begin; i < end; i++) {
        Vec3 value = f(p, {wi_x[i], wi_y[i], wi_z[i]}, {wo_x[i], wo_y[i], wo_z[i]});
        red[i] = value.x;
        green[i] = value.y;
        blue[i] = value.z;
    }
}

[[gnu::always_inline]] inline void sample_loop(SampleFunction* sample, EvalFunction* f, Params p, Inputs in,
                                               Outputs out, size_t begin, size_t end) {
    const float *wo_x = in[0], *wo_y = in[1], *wo_z = in[2], *u1 = in[3], *u2 = in[4];
    float *__restrict wi_x = out[0], *__restrict wi_y = out[1], *__restrict wi_z = out[2], *__restrict pdf = out[3];
    float *__restrict red = out[4], *__restrict green = out[5], *__restrict blue = out[6];
    for (size_t i = begin; i < end; i++) {
        Vec3 wo = {wo_x[i], wo_y[i], wo_z[i]};
        Sample s = sample(p, wo, u1[i], u2[i]);
        Vec3 value = f(p, s.wi, wo);
        wi_x[i] = s.wi.x;
        wi_y[i] = s.wi.y;
        wi_z[i] = s.wi.z;
        pdf[i] = s.pdf;
        red[i] = value.x;
        green[i] = value.y;
        blue[i] = value.z;
    }
}

void calls(SampleFunction* sample, EvalFunction* f, const Params& p, Inputs in, Outputs out, size_t begin, size_t end) {
    if (sample)
        sample_loop(sample, f, p, in, out, begin, end);
    else
        eval_loop(f, p, in, out, begin, end);
}

template <EvalFunction* f>
void inlined_eval(const Params& p, Inputs in, Outputs out, size_t begin, size_t end) {
    eval_loop(f, p, in, out, begin, end);
}

template <SampleFunction* sample, EvalFunction* f>
void inlined_sample(const Params& p, Inputs in, Outputs out, size_t begin, size_t end) {
    sample_loop(sample, f, p, in, out, begin, end);
}

using InlinedLoop = void(const Params&, Inputs, Outputs, size_t begin, size_t end);

struct Row {
    const char* name;
    SampleFunction* sample;  // null: the row times eval alone
    EvalFunction* eval;
    InlinedLoop* inlined;
};

template <EvalFunction* f>
constexpr Row row(const char* name) {
    return {name, nullptr, f, inlined_eval<f>};
}

template <SampleFunction* sample, EvalFunction* f>
constexpr Row row(const char* name) {
    return {name, sample, f, inlined_sample<sample, f>};
}

const Row ROWS[] = {
    row<lambert>("lambert"),
    row<oren_nayar>("oren_nayar"),
    row<qon>("qon"),
    row<qon_footnote>("qon_footnote"),
    row<qon_fujii>("qon_fujii"),
    row<fon>("fon"),
    row<eon<true>>("eon_exact"),
    row<eon<false>>("eon_fitted"),
    row<triace_oren_nayar>("triace_oren_nayar"),
    row<burley_diffuse>("burley_diffuse"),
    row<cosine_sample, lambert>("lambert"),
    row<eon_sample, eon<true>>("eon_exact"),
    row<eon_sample, eon<false>>("eon_fitted"),
};

// Calls body(begin, end) on `threads` contiguous chunks of 0..n, the last one in this thread, and returns the
// seconds that took. Starting a thread costs some 20 microseconds, against milliseconds for the arrays timed here.
template <class Body>
double timed_parallel(size_t n, int threads, Body body) {
    auto start = std::chrono::steady_clock::now();
    std::vector<std::thread> others;
    for (int t = 0; t + 1 < threads; t++) others.emplace_back(body, n * t / threads, n * (t + 1) / threads);
    body(n * (threads - 1) / threads, n);
    for (std::thread& other : others) other.join();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

extern "C" {

// Name of row i, or null past the last one.
const char* baseline_name(int i) { return i < int(std::size(ROWS)) ? ROWS[i].name : nullptr; }

// Whether row i is sample + pdf + eval (1) or eval (0).
int baseline_samples(int i) { return ROWS[i].sample != nullptr; }

// Runs row i once over n pairs and returns the seconds. parameters: rho r, g, b, roughness.
double baseline_run(int i, int inlined, const float* parameters, const float* const* in, float* const* out, size_t n,
                    int threads) {
    const Row& r = ROWS[i];
    const Params p = {{parameters[0], parameters[1], parameters[2]}, parameters[3]};
    return timed_parallel(n, threads, [&](size_t begin, size_t end) {
        if (inlined)
            r.inlined(p, in, out, begin, end);
        else
            calls(r.sample, r.eval, p, in, out, begin, end);
    });
}

// STREAM's triad a = b + x c over n floats per array: bytes read and written per second, best of `repeat`.
// As in STREAM, the line that a store first fetches is not counted.
double baseline_bandwidth(size_t n, int threads, int repeat) {
    // Not std::vector: pages should be touched first by the thread that uses them.
    std::unique_ptr<float[]> a(new float[n]), b(new float[n]), c(new float[n]);
    timed_parallel(n, threads, [&](size_t begin, size_t end) {
        std::fill(&a[begin], &a[end], 0.0f);
        std::fill(&b[begin], &b[end], 1.0f);
        std::fill(&c[begin], &c[end], 2.0f);
    });
    double best = INFINITY;
    for (int i = 0; i < repeat; i++) {
        float x = 0.5f * i;
        double seconds = timed_parallel(n, threads, [&](size_t begin, size_t end) {
            float* __restrict to = a.get();
            const float *from = b.get(), *scaled = c.get();
            for (size_t j = begin; j < end; j++) to[j] = from[j] + x * scaled[j];
        });
        best = std::min(best, seconds);
    }
    return 3.0 * sizeof(float) * n / best;
}

}  // extern "C"
