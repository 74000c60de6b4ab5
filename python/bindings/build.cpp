#include "stiction/build.hpp"

#include "arrays.hpp"

#include <map>
#include <string>

namespace stiction::python {

void bind_build(py::module_& module) {
  module.def(
      "build",
      [] {
        const Build candidates = build();
        return std::map<std::string, std::string>{{"compiler", candidates.compiler},
                                                  {"instruction_set", candidates.instruction_set},
                                                  {"gsl", candidates.gsl}};
      },
      "Return build information of the core: compiler, instruction_set and gsl.");
}

}  // namespace stiction::python
