// Names of cuRAND: shading does not draw numbers, but files with it do.
#pragma once
#include "cuda_runtime.h"
struct curandState { unsigned int seed; };
typedef curandState curandState_t;
typedef curandState curandStateXORWOW_t;
typedef curandState curandStatePhilox4_32_10_t;
inline void curand_init(unsigned long long, unsigned long long, unsigned long long, curandState*) {}
inline float curand_uniform(curandState*) { return 0.5f; }
inline float curand_normal(curandState*) { return 0.0f; }
