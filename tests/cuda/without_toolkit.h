/* What clang needs of CUDA's headers to make PTX of a .cuh without a toolkit. For tests; given with -include. */
#define __CUDACC__
#pragma clang force_cuda_host_device begin
#include <math.h>
#include <stdint.h>
#pragma clang force_cuda_host_device end

#define __device__ __attribute__((device))
#define __host__ __attribute__((host))
#define __global__ __attribute__((global))
#define __forceinline__ inline __attribute__((always_inline))
#define __noinline__ __attribute__((noinline))
#define __launch_bounds__(threads) __attribute__((launch_bounds(threads)))

struct test_index {
    unsigned x;
};
#define blockIdx (test_index{(unsigned)__nvvm_read_ptx_sreg_ctaid_x()})
#define threadIdx (test_index{(unsigned)__nvvm_read_ptx_sreg_tid_x()})

template <class T> __device__ __forceinline__ T __ldg(const T *x)
{
    return *x;
}

enum { cudaErrorInvalidValue = 1 };
int cudaGetLastError();

/* what <<<>>> stands for */
struct dim3 {
    unsigned x, y, z;
    __host__ __device__ dim3(unsigned count) : x(count), y(1), z(1) {}
};
extern "C" int cudaConfigureCall(dim3 grid, dim3 block, size_t shared = 0, void *stream = 0);
extern "C" unsigned __cudaPushCallConfiguration(dim3 grid, dim3 block, size_t shared = 0, void *stream = 0);
