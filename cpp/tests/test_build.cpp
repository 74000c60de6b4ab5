#include "stiction/build.hpp"

#include <doctest/doctest.h>

#include <gsl/gsl_version.h>

using namespace stiction;

TEST_CASE("a build says with what it was made, and what it uses of the machine") {
  const Build found = build();
  CHECK(found.gsl == GSL_VERSION);
  CHECK(found.compiler.find(__VERSION__) != std::string::npos);
#if defined(__x86_64__)
  const bool is_wide = found.instruction_set == "AVX-512" || found.instruction_set == "AVX2, FMA";
  CHECK((is_wide || found.instruction_set == "SSE2"));
  // Never more than the machine has.
  if (found.instruction_set == "AVX-512") {
    CHECK(__builtin_cpu_supports("avx512f"));
  }
  if (is_wide) {
    CHECK(__builtin_cpu_supports("avx2"));
  }
#endif
}
