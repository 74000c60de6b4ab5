#include "stiction/families.hpp"

#include "arrays.hpp"
#include "checkpoint.hpp"
#include "levels.hpp"
#include "sums.hpp"

namespace stiction::python {

void bind_families(py::module_& module) {
  module.def(
      "press_families",
      [](Eigen::Ref<Matrix> upper, const MatrixView& upper_levels, Eigen::Ref<Matrix> lower,
         const MatrixView& lower_levels, double spacing, const Array& amplitudes, const std::string& measure,
         const Array& approaches, const std::vector<ContactModel>& models, Eigen::Ref<Matrix> scratch) {
        const std::vector<Level> of_upper = levels_of(upper_levels);
        const std::vector<Level> of_lower = levels_of(lower_levels);
        const Amplitudes wanted{view(amplitudes), amplitude_measure(measure)};
        const Values steps = view(approaches);
        const Checkpoint checkpoint = until_interrupted();
        const std::vector<Sums> sums = [&] {
          const py::gil_scoped_release release;
          return press_families({upper, of_upper}, {lower, of_lower}, spacing, wanted, steps, models, scratch,
                                checkpoint);
        }();
        return table_of(sums);
      },
      py::arg("upper").noconvert(), py::arg("upper_levels").noconvert(), py::arg("lower").noconvert(),
      py::arg("lower_levels").noconvert(), py::kw_only(), py::arg("spacing"), py::arg("amplitudes").noconvert(),
      py::arg("measure"), py::arg("approaches").noconvert(), py::arg("models"), py::arg("scratch").noconvert(),
      "Sums of every pair of rows at each amplitude [µm] by each model at each approach [µm]: a dict of columns. Both "
      "families are used up.");
}

}  // namespace stiction::python
