#include "stiction/build.hpp"

#include "arrays.hpp"

#include <map>
#include <string>

namespace stiction::python {

void bind_build(py::module_& module) {
  module.def(
      "build",
      [] {
        const Build found = build();
        return std::map<std::string, std::string>{
            {"compiler", found.compiler}, {"instruction_set", found.instruction_set}, {"gsl", found.gsl}};
      },
      "What the core was built with, and what it uses of this machine: compiler, instruction_set, gsl.");
}

}  // namespace stiction::python
