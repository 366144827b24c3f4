/* CUDA on the host: every thread of a grid in turn, and memory of the device that is memory. For tests; given with
 * -include. */
#ifndef EMULATE_H
#define EMULATE_H

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define SYMGEN_EMULATED
#define __device__
#define __host__
#define __global__ static
#define __forceinline__ inline
#define __noinline__ __attribute__((noinline))
#define __launch_bounds__(threads)

typedef struct {
    unsigned x;
} emulated_index;
static __attribute__((unused)) emulated_index blockIdx, threadIdx;

template <class T> static inline T __ldg(const T *x)
{
    return *x;
}

enum { cudaErrorInvalidValue = 1, cudaErrorMemoryAllocation = 2 };
enum { cudaMemcpyHostToDevice = 1, cudaMemcpyDeviceToHost = 2 };

static inline int cudaGetLastError(void)
{
    return 0;
}

static inline int cudaDeviceSynchronize(void)
{
    return 0;
}

static inline int cudaMalloc(void **to, size_t bytes)
{
    *to = malloc(bytes);
    return *to ? 0 : cudaErrorMemoryAllocation;
}

static inline int cudaFree(void *x)
{
    free(x);
    return 0;
}

static inline int cudaMemcpy(void *to, const void *from, size_t bytes, int)
{
    memcpy(to, from, bytes);
    return 0;
}

#define SYMGEN_LAUNCH(kernel, blocks, stream, ...)                               \
    do {                                                                         \
        (void)stream;                                                            \
        for (blockIdx.x = 0; blockIdx.x < blocks; ++blockIdx.x) {                \
            for (threadIdx.x = 0; threadIdx.x < SYMGEN_THREADS; ++threadIdx.x) { \
                kernel(__VA_ARGS__);                                             \
            }                                                                    \
        }                                                                        \
    } while (0)

#endif
