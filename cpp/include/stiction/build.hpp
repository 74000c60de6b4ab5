// Build information for problem reports: compiler, instruction set and GSL version.
#pragma once

#include <string>

namespace stiction {

/// Information about the compiled library.
struct Build {
  std::string compiler;  ///< name and version of the compiler
  /// Instruction set that the loader selected for hot loops: "AVX-512", "AVX2, FMA", "SSE2" or "NEON".
  std::string instruction_set;
  std::string gsl;  ///< version of the linked GNU Scientific Library
};

Build build();

}  // namespace stiction
