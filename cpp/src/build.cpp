#include "stiction/build.hpp"

#include "multiversion.hpp"

#include <gsl/gsl_version.h>

namespace stiction {
namespace {

template <std::size_t Width>
STICTION_INLINE void numbers_at_once_kernel(std::size_t& numbers) {
  numbers = Width;
}

// Picked like the loops that it tells of.
STICTION_KERNEL(numbers_at_once, (std::size_t& numbers), (numbers))

std::string instruction_set() {
  std::size_t numbers = 0;
  numbers_at_once(numbers);
  if (numbers == 8) {
    return "AVX-512";
  }
  if (numbers == 4) {
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
  return __VERSION__;  // with its name
#elif defined(__GNUC__)
  return "GCC " __VERSION__;
#else
  return "unknown";
#endif
}

}  // namespace

Build build() { return {compiler(), instruction_set(), gsl_version}; }

}  // namespace stiction
