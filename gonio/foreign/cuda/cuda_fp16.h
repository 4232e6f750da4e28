#pragma once
#include "cuda_runtime.h"
typedef float half;
typedef float __half;
inline half __float2half(float x) { return x; }
inline float __half2float(half x) { return x; }
