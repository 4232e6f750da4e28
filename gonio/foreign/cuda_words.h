// CUDA's words and vectors for a C++ compiler that does not know them.
#pragma once
#include <cmath>
#include <math.h>
#define __host__
#define __device__
#define __global__
#define __forceinline__ inline
#define __constant__
#define __restrict__
struct float2 { float x, y; };
struct float3 { float x, y, z; };
struct float4 { float x, y, z, w; };
inline float2 make_float2(float x, float y) { return {x, y}; }
inline float3 make_float3(float x, float y, float z) { return {x, y, z}; }
inline float4 make_float4(float x, float y, float z, float w) { return {x, y, z, w}; }
inline float __saturatef(float x) { return fminf(fmaxf(x, 0.0f), 1.0f); }
inline float rsqrtf(float x) { return 1.0f / sqrtf(x); }
