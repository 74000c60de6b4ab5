#include "stiction/pressure_search.hpp"

#include "arrays.hpp"

namespace stiction::python {
namespace {

using Single = py::array_t<float, py::array::c_style>;

std::span<const float> grid(const Single& array) { return {array.data(), static_cast<std::size_t>(array.size())}; }

// Read-only views of what the search owns; they keep it alive.
template <class T>
py::array_t<T> shown(std::span<const T> values, const py::object& owner) {
  py::array_t<T> array(static_cast<py::ssize_t>(values.size()), values.data(), owner);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

PressureSearch& search_of(const py::object& self) { return self.cast<PressureSearch&>(); }

}  // namespace

void bind_pressure_search(py::module_& module) {
  py::class_<PressureSearch>(module, "PressureSearch")
      .def(py::init([](const Array& pressure, double total, const Array& bound, bool line) {
             return PressureSearch(view(pressure), total, view(bound), line);
           }),
           py::arg("pressure").noconvert(), py::kw_only(), py::arg("total"), py::arg("bound").noconvert(),
           py::arg("line"))
      .def("balance", &PressureSearch::balance, py::call_guard<py::gil_scoped_release>())
      .def("residual",
           [](const py::object& self) {
             auto& search = search_of(self);
             std::span<const float> values;
             {
               const py::gil_scoped_release release;
               values = search.residual();
             }
             return shown(values, self);
           })
      .def(
          "sharpened",
          [](const py::object& self, const Array& stencil, std::int64_t columns) {
            auto& search = search_of(self);
            const Values weights = view(stencil);
            std::span<const float> values;
            {
              const py::gil_scoped_release release;
              values = search.sharpened(weights, columns);
            }
            return shown(values, self);
          },
          py::arg("stencil").noconvert(), py::arg("columns"))
      .def(
          "step",
          [](const py::object& self, const Single& preconditioned, const Single& response) {
            auto& search = search_of(self);
            const auto first = grid(preconditioned);
            const auto second = grid(response);
            std::span<const float> values;
            {
              const py::gil_scoped_release release;
              values = search.step(first, second);
            }
            return shown(values, self);
          },
          py::arg("preconditioned").noconvert(), py::arg("response").noconvert())
      .def(
          "advance",
          [](PressureSearch& search, const Single& response) {
            const auto values = grid(response);
            const py::gil_scoped_release release;
            return search.advance(values);
          },
          py::arg("response").noconvert())
      .def("settle", &PressureSearch::settle, py::call_guard<py::gil_scoped_release>())
      .def(
          "restart",
          [](PressureSearch& search, const Array& potential) {
            const Values values = view(potential);
            const py::gil_scoped_release release;
            search.restart(values);
          },
          py::arg("potential").noconvert())
      .def_property_readonly("plain", &PressureSearch::plain)
      .def("work", &PressureSearch::work, py::call_guard<py::gil_scoped_release>())
      .def_property_readonly("approach", &PressureSearch::approach)
      .def_property_readonly("pressure",
                             [](const py::object& self) { return shown(search_of(self).pressure(), self); });
}

}  // namespace stiction::python
