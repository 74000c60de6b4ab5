#include "stiction/profile_batch.hpp"

#include "arrays.hpp"
#include "cancellation.hpp"
#include "height_statistics.hpp"
#include "sums.hpp"

namespace stiction::python {

void bind_profile_batch(py::module_& module) {
  module.def(
      "press_profile_batches",
      [](Eigen::Ref<Matrix> upper, const MatrixView& upper_statistics, Eigen::Ref<Matrix> lower,
         const MatrixView& lower_statistics, double spacing, const Array& amplitudes, const std::string& measure,
         const Array& approaches, const std::vector<ContactModel>& models, Eigen::Ref<Matrix> scratch) {
        const std::vector<HeightStatistics> upper_list = to_height_statistics(upper_statistics);
        const std::vector<HeightStatistics> lower_list = to_height_statistics(lower_statistics);
        const Amplitudes targets{view(amplitudes), amplitude_measure(measure)};
        const Values steps = view(approaches);
        const CancellationCheck check_cancellation = keyboard_interrupt_check();
        const std::vector<Sums> sums = [&] {
          const py::gil_scoped_release release;
          return press_profile_batches({upper, upper_list}, {lower, lower_list}, spacing, targets, steps, models,
                                       scratch, check_cancellation);
        }();
        return to_table(sums);
      },
      py::arg("upper").noconvert(), py::arg("upper_statistics").noconvert(), py::arg("lower").noconvert(),
      py::arg("lower_statistics").noconvert(), py::kw_only(), py::arg("spacing"), py::arg("amplitudes").noconvert(),
      py::arg("measure"), py::arg("approaches").noconvert(), py::arg("models"), py::arg("scratch").noconvert(),
      "Compute the contact sums of each pair of rows, for each amplitude [µm], model and approach [µm], as a dict of "
      "columns. The heights are overwritten.");
}

}  // namespace stiction::python
