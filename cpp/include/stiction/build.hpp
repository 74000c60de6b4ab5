// What this library was built with, and what it uses of the machine that it runs on: for reports of problems.
#pragma once

#include <string>

namespace stiction {

struct Build {
  std::string compiler;         ///< name and version
  std::string instruction_set;  ///< of the hot loops, as the loader picked them: "AVX-512", "AVX2, FMA", "SSE2", "NEON"
  std::string gsl;              ///< version of the GNU Scientific Library that is linked
};

/// Answers of builds that differ in these agree to rounding, not to the bit.
Build build();

}  // namespace stiction
