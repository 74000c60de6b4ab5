#include "stiction/build.hpp"

#include "multiversion.hpp"

#include <gsl/gsl_version.h>

namespace stiction {
namespace {

template <std::size_t Width>
STICTION_INLINE void simd_width_kernel(std::size_t& width) {
  width = Width;
}

// The loader selects all function versions by one rule, so `simd_width` reports the SIMD width of the hot loops.
STICTION_KERNEL(simd_width, (std::size_t& width), (width))

std::string instruction_set() {
  std::size_t width = 0;
  simd_width(width);
  if (width == 8) {
    return "AVX-512";
  }
  if (width == 4) {
    return "AVX2, FMA";
  }
#if defined(__x86_64__)
  return "SSE2";
#elif defined(__aarch64__)
  return "NEON";
#else
  return "plain";
#endif
}

std::string compiler() {
#if defined(__clang__)
  return __VERSION__;  // Clang's version string includes the name of the compiler
#elif defined(__GNUC__)
  return "GCC " __VERSION__;
#else
  return "unknown";
#endif
}

}  // namespace

Build build() { return {compiler(), instruction_set(), gsl_version}; }

}  // namespace stiction
