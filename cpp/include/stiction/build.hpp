// Build information for problem reports: compiler, instruction set and GSL version.
#pragma once

#include <string>

namespace stiction {

struct Build {
  std::string compiler;  ///< name and version of the compiler
  /// Instruction set of the hot loops, selected by the loader: "AVX-512", "AVX2, FMA", "SSE2" or "NEON".
  std::string instruction_set;
  std::string gsl;  ///< version of the linked GNU Scientific Library
};

Build build();

}  // namespace stiction
