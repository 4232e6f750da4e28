// OSL's types and functions of values for a C++ compiler: what shading functions need, after the Open Shading
// Language Specification 1.13, chapters 5 and 7. Closures, noise and textures belong to a renderer.
#pragma once
#include <cmath>

struct vector {
    float x, y, z;
    vector() : x(0), y(0), z(0) {}
    vector(float s) : x(s), y(s), z(s) {}
    vector(float x, float y, float z) : x(x), y(y), z(z) {}
    float& operator[](int k) { return (&x)[k]; }
    const float& operator[](int k) const { return (&x)[k]; }
};
typedef vector color;
typedef vector point;
typedef vector normal;
typedef const char* string;

#define GONIO_OPERATOR(op)                                                                             \
    inline vector operator op(const vector& a, const vector& b) {                                      \
        return vector(a.x op b.x, a.y op b.y, a.z op b.z);                                             \
    }                                                                                                  \
    inline vector operator op(const vector& a, float b) { return vector(a.x op b, a.y op b, a.z op b); } \
    inline vector operator op(float a, const vector& b) { return vector(a op b.x, a op b.y, a op b.z); } \
    inline vector& operator op##=(vector& a, const vector& b) { return a = a op b; }
GONIO_OPERATOR(+)
GONIO_OPERATOR(-)
GONIO_OPERATOR(*)
GONIO_OPERATOR(/)
#undef GONIO_OPERATOR
inline vector operator-(const vector& a) { return vector(-a.x, -a.y, -a.z); }
inline bool operator==(const vector& a, const vector& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
inline bool operator!=(const vector& a, const vector& b) { return !(a == b); }

// Names that <cmath> has for double as well; ours are for float and vectors alone.
namespace osl {
#define GONIO_UNARY(name, value)                                                                       \
    inline float name(float a) { return value; }                                                       \
    inline vector name(const vector& v) { return vector(name(v.x), name(v.y), name(v.z)); }
GONIO_UNARY(abs, __builtin_fabsf(a))
GONIO_UNARY(fabs, __builtin_fabsf(a))
GONIO_UNARY(acos, __builtin_acosf(__builtin_fminf(__builtin_fmaxf(a, -1.0f), 1.0f)))
GONIO_UNARY(asin, __builtin_asinf(__builtin_fminf(__builtin_fmaxf(a, -1.0f), 1.0f)))
GONIO_UNARY(atan, __builtin_atanf(a))
GONIO_UNARY(ceil, __builtin_ceilf(a))
GONIO_UNARY(cos, __builtin_cosf(a))
GONIO_UNARY(degrees, a * 57.2957795f)
GONIO_UNARY(exp, __builtin_expf(a))
GONIO_UNARY(exp2, __builtin_exp2f(a))
GONIO_UNARY(floor, __builtin_floorf(a))
GONIO_UNARY(inversesqrt, a > 0 ? 1.0f / __builtin_sqrtf(a) : 0.0f)
GONIO_UNARY(log, __builtin_logf(__builtin_fmaxf(a, 1.17549435e-38f)))
GONIO_UNARY(log2, __builtin_log2f(__builtin_fmaxf(a, 1.17549435e-38f)))
GONIO_UNARY(radians, a * 0.0174532925f)
GONIO_UNARY(round, __builtin_roundf(a))
GONIO_UNARY(sign, a > 0 ? 1.0f : a < 0 ? -1.0f : 0.0f)
GONIO_UNARY(sin, __builtin_sinf(a))
GONIO_UNARY(sinh, __builtin_sinhf(a))
GONIO_UNARY(cosh, __builtin_coshf(a))
GONIO_UNARY(tanh, __builtin_tanhf(a))
GONIO_UNARY(sqrt, a > 0 ? __builtin_sqrtf(a) : 0.0f)
GONIO_UNARY(tan, __builtin_tanf(a))
GONIO_UNARY(trunc, __builtin_truncf(a))
GONIO_UNARY(erf, __builtin_erff(a))
GONIO_UNARY(cbrt, __builtin_cbrtf(a))
#undef GONIO_UNARY

#define GONIO_BINARY(name, value)                                                                      \
    inline float name(float a, float b) { return value; }                                              \
    inline vector name(const vector& u, const vector& v) {                                             \
        return vector(name(u.x, v.x), name(u.y, v.y), name(u.z, v.z));                                 \
    }                                                                                                  \
    inline vector name(const vector& u, float b) { return name(u, vector(b)); }
GONIO_BINARY(atan2, __builtin_atan2f(a, b))
GONIO_BINARY(fmod, b != 0 ? __builtin_fmodf(a, b) : 0.0f)
GONIO_BINARY(max, a > b ? a : b)
GONIO_BINARY(min, a < b ? a : b)
GONIO_BINARY(mod, b != 0 ? a - b * __builtin_floorf(a / b) : 0.0f)
GONIO_BINARY(pow, __builtin_powf(a, b))
GONIO_BINARY(step, b < a ? 0.0f : 1.0f)
#undef GONIO_BINARY
inline int max(int a, int b) { return a > b ? a : b; }
inline int min(int a, int b) { return a < b ? a : b; }
inline float max(int a, float b) { return max(float(a), b); }
inline float max(float a, int b) { return max(a, float(b)); }
inline float min(int a, float b) { return min(float(a), b); }
inline float min(float a, int b) { return min(a, float(b)); }
inline float pow(float a, int b) { return pow(a, float(b)); }
inline vector pow(const vector& a, int b) { return pow(a, vector(float(b))); }

inline float clamp(float a, float low, float high) { return min(max(a, low), high); }
inline vector clamp(const vector& a, const vector& low, const vector& high) { return min(max(a, low), high); }
inline float mix(float a, float b, float t) { return a * (1.0f - t) + b * t; }
inline vector mix(const vector& a, const vector& b, const vector& t) { return a * (vector(1.0f) - t) + b * t; }
inline float select(float a, float b, float t) { return t != 0 ? b : a; }
inline vector select(const vector& a, const vector& b, float t) { return t != 0 ? b : a; }
inline float smoothstep(float low, float high, float a) {
    float t = clamp((a - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}
inline float linearstep(float low, float high, float a) { return clamp((a - low) / (high - low), 0.0f, 1.0f); }
inline float hypot(float a, float b) { return __builtin_hypotf(a, b); }
inline float dot(const vector& a, const vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline vector cross(const vector& a, const vector& b) {
    return vector(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
inline float length(const vector& a) { return sqrt(dot(a, a)); }
inline float distance(const vector& a, const vector& b) { return length(a - b); }
inline vector normalize(const vector& a) {
    float l = length(a);
    return l > 0 ? a / l : vector(0.0f);
}
inline vector reflect(const vector& i, const vector& n) { return i - 2.0f * dot(n, i) * n; }
inline float luminance(const color& c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }
inline void sincos(float a, float& s, float& c) {
    s = sin(a);
    c = cos(a);
}
inline int isnan(float a) { return __builtin_isnan(a); }
inline int isinf(float a) { return __builtin_isinf(a); }
inline int isfinite(float a) { return __builtin_isfinite(a); }
template <class T> inline int isconnected(const T&) { return 1; }

// The surface is the local frame.
static const normal N = vector(0.0f, 0.0f, 1.0f), Ng = vector(0.0f, 0.0f, 1.0f);
static const vector dPdu = vector(1.0f, 0.0f, 0.0f), dPdv = vector(0.0f, 1.0f, 0.0f);
static const point P = vector(0.0f);
}  // namespace osl

#undef M_PI
#undef M_PI_2
#undef M_PI_4
#undef M_2_PI
#undef M_1_PI
#undef M_E
#undef M_LN2
#undef M_LN10
#undef M_SQRT2
#undef M_SQRT1_2
const float M_PI = 3.14159265f, M_PI_2 = 1.57079633f, M_PI_4 = 0.785398163f, M_2PI = 6.28318531f;
const float M_2_PI = 0.636619772f, M_1_PI = 0.318309886f, M_E = 2.71828183f, M_LN2 = 0.693147181f;
const float M_LN10 = 2.30258509f, M_SQRT2 = 1.41421356f, M_SQRT1_2 = 0.707106781f;
