#include "stiction/build.hpp"

#include <doctest/doctest.h>

#include <gsl/gsl_version.h>

using namespace stiction;

TEST_CASE("build: reports the compiler, the GSL version and a supported instruction set") {
  const Build info = build();
  CHECK(info.gsl == GSL_VERSION);
  CHECK(info.compiler.find(__VERSION__) != std::string::npos);
#if defined(__x86_64__)
  const bool is_wide = info.instruction_set == "AVX-512" || info.instruction_set == "AVX2, FMA";
  CHECK((is_wide || info.instruction_set == "SSE2"));
  if (info.instruction_set == "AVX-512") {
    CHECK(__builtin_cpu_supports("avx512f"));
  }
  if (is_wide) {
    CHECK(__builtin_cpu_supports("avx2"));
  }
#endif
}
