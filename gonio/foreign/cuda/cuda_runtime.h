// CUDA's words, vectors and functions of numbers for a C++ compiler, for code that others wrote. After the CUDA
// C++ Programming Guide 12, chapters 7 and 14. Functions that are fast and inexact on a GPU are exact here; half
// is float; kernels compile but are not called.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <math.h>

#define __host__
#define __device__
#define __global__
#define __shared__
#define __managed__
#define __constant__
#define __restrict__
#define __forceinline__ inline
#define __noinline__
#define __launch_bounds__(...)
#define __align__(n) alignas(n)
#define __syncthreads()
#define __ldg(pointer) (*(pointer))

#define GONIO_VECTORS(type, base) \
    struct base##1 { type x; }; \
    struct base##2 { type x, y; }; \
    struct base##3 { type x, y, z; }; \
    struct base##4 { type x, y, z, w; }; \
    inline base##1 make_##base##1(type x) { return {x}; } \
    inline base##2 make_##base##2(type x, type y) { return {x, y}; } \
    inline base##3 make_##base##3(type x, type y, type z) { return {x, y, z}; } \
    inline base##4 make_##base##4(type x, type y, type z, type w) { return {x, y, z, w}; }
GONIO_VECTORS(float, float)
GONIO_VECTORS(double, double)
GONIO_VECTORS(int, int)
GONIO_VECTORS(unsigned, uint)
GONIO_VECTORS(unsigned char, uchar)
#undef GONIO_VECTORS

struct dim3 { unsigned x = 1, y = 1, z = 1; };
static const uint3 threadIdx = {0, 0, 0}, blockIdx = {0, 0, 0};
static const dim3 blockDim, gridDim;

using std::max;
using std::min;
inline float __saturatef(float x) { return fminf(fmaxf(x, 0.0f), 1.0f); }
inline float rsqrtf(float x) { return 1.0f / sqrtf(x); }
inline double rsqrt(double x) { return 1.0 / sqrt(x); }
inline float __frsqrt_rn(float x) { return 1.0f / sqrtf(x); }
inline float __fsqrt_rn(float x) { return sqrtf(x); }
inline float __frcp_rn(float x) { return 1.0f / x; }
inline float __fdividef(float x, float y) { return x / y; }
inline float fdividef(float x, float y) { return x / y; }
inline float __fmaf_rn(float x, float y, float z) { return fmaf(x, y, z); }
inline float __expf(float x) { return expf(x); }
inline float __exp10f(float x) { return powf(10.0f, x); }
inline float __logf(float x) { return logf(x); }
inline float __log2f(float x) { return log2f(x); }
inline float __powf(float x, float y) { return powf(x, y); }
inline float __sinf(float x) { return sinf(x); }
inline float __cosf(float x) { return cosf(x); }
inline float __tanf(float x) { return tanf(x); }
inline void __sincosf(float x, float* s, float* c) { *s = sinf(x); *c = cosf(x); }
inline float sinpif(float x) { return sinf(3.14159265f * x); }
inline float cospif(float x) { return cosf(3.14159265f * x); }
inline float norm3df(float x, float y, float z) { return sqrtf(x * x + y * y + z * z); }
inline float rnorm3df(float x, float y, float z) { return 1.0f / norm3df(x, y, z); }
inline float rhypotf(float x, float y) { return 1.0f / hypotf(x, y); }
inline float rcbrtf(float x) { return 1.0f / cbrtf(x); }

#define CUDART_PI_F 3.141592654f
#define CUDART_PIO2_F 1.570796327f
#define CUDART_PIO4_F 0.785398163f
#define CUDART_2_OVER_PI_F 0.636619772f
#define CUDART_PI 3.1415926535897931e+0
#define CUDART_INF_F __builtin_inff()
#define CUDART_NAN_F __builtin_nanf("")
