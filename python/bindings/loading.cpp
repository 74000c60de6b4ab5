#include "stiction/loading.hpp"

#include "arrays.hpp"
#include "cancellation.hpp"

namespace stiction::python {

namespace {

template <class Bodies>
py::array_t<double> find_approaches(const Bodies& bodies, const Array& loads, const Array& left, const Array& right,
                                    double mu0, double tau0, const ContactModel& model) {
  const Values targets = view(loads);
  const Values from = view(left);
  const Values to = view(right);
  const CancellationCheck check_cancellation = keyboard_interrupt_check();
  std::vector<double> result;
  {
    const py::gil_scoped_release release;
    result = approaches_at(bodies, targets, from, to, mu0, tau0, model, check_cancellation);
  }
  return to_array(std::move(result));
}

template <class Found>
void bind_approaches(py::module_& module, const char* description) {
  module.def("approaches_at", &find_approaches<Found>, py::arg("candidates"), py::kw_only(),
             py::arg("loads").noconvert(), py::arg("left").noconvert(), py::arg("right").noconvert(), py::arg("mu0"),
             py::arg("tau0"), py::arg("model"), description);
}

}  // namespace

void bind_loading(py::module_& module) {
  module.def(
      "approaches_at",
      [](const Array& upper, const Array& lower, double spacing, const Array& loads, const Array& left,
         const Array& right, double mu0, double tau0, const ContactModel& model) {
        const ProfilePair pair{view(upper), view(lower), spacing};
        return find_approaches(pair, loads, left, right, mu0, tau0, model);
      },
      py::arg("upper").noconvert(), py::arg("lower").noconvert(), py::kw_only(), py::arg("spacing"),
      py::arg("loads").noconvert(), py::arg("left").noconvert(), py::arg("right").noconvert(), py::arg("mu0"),
      py::arg("tau0"), py::arg("model"),
      "Find the approaches [µm] between `left` and `right` at which two profiles reach the loads [mN].");
  bind_approaches<Candidates>(
      module,
      "Find the approaches [µm] between `left` and `right` at which candidates of two profiles reach the loads [mN].");
  bind_approaches<ArealCandidates>(
      module,
      "Find the approaches [µm] between `left` and `right` at which candidates of two maps reach the loads [mN].");
}

}  // namespace stiction::python
