#include "stiction/student.hpp"

#include "arrays.hpp"

namespace stiction::python {

void bind_student(py::module_& module) {
  module.def("student_probability", py::vectorize(student_probability), py::arg("freedom"), py::arg("t"),
             "Probability of a smaller t by Student's distribution with so many degrees of freedom.");
  module.def("student_quantile", py::vectorize(student_quantile), py::arg("freedom"), py::arg("probability"),
             "The t below which a probability lies by Student's distribution with so many degrees of freedom.");
}

}  // namespace stiction::python
