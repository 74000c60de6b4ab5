#include "stiction/loading.hpp"

#include "arrays.hpp"
#include "checkpoint.hpp"

namespace stiction::python {

namespace {

template <class Bodies>
py::array_t<double> approaches_of(const Bodies& bodies, const Array& loads, const Array& left, const Array& right,
                                  double mu0, double tau0, const ContactModel& model) {
  const Values wanted = view(loads);
  const Values from = view(left);
  const Values to = view(right);
  const Checkpoint checkpoint = until_interrupted();
  std::vector<double> result;
  {
    const py::gil_scoped_release release;
    result = approaches_at(bodies, wanted, from, to, mu0, tau0, model, checkpoint);
  }
  return array_from(std::move(result));
}

template <class Found>
void bind_approaches(py::module_& module, const char* words) {
  module.def("approaches_at", &approaches_of<Found>, py::arg("found"), py::kw_only(), py::arg("loads").noconvert(),
             py::arg("left").noconvert(), py::arg("right").noconvert(), py::arg("mu0"), py::arg("tau0"),
             py::arg("model"), words);
}

}  // namespace

void bind_loading(py::module_& module) {
  module.def(
      "approaches_at",
      [](const Array& upper, const Array& lower, double spacing, const Array& loads, const Array& left,
         const Array& right, double mu0, double tau0, const ContactModel& model) {
        const ProfilePair pair{view(upper), view(lower), spacing};
        return approaches_of(pair, loads, left, right, mu0, tau0, model);
      },
      py::arg("upper").noconvert(), py::arg("lower").noconvert(), py::kw_only(), py::arg("spacing"),
      py::arg("loads").noconvert(), py::arg("left").noconvert(), py::arg("right").noconvert(), py::arg("mu0"),
      py::arg("tau0"), py::arg("model"),
      "Approaches [µm] in brackets at which the normal load rises through loads [mN].");
  bind_approaches<Candidates>(module, "The same, of candidates.");
  bind_approaches<ArealCandidates>(module, "The same, of candidates of two maps.");
}

}  // namespace stiction::python
