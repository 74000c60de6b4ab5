// NumPy arrays at the border: in as views of the exact type and layout, out without a copy of their own.
#pragma once

#include "stiction/array.hpp"

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <memory>
#include <vector>

namespace stiction::python {

namespace py = pybind11;

// Converting silently is Python's business, where it is announced: arguments are bound with .noconvert().
using Array = py::array_t<double, py::array::c_style>;

// Named columns of equal length.
using Table = py::typing::Dict<py::str, py::array>;

inline Values view(const Array& array) {
  if (array.ndim() != 1) {
    throw py::value_error("expected an array of 1 dimension, got " + std::to_string(array.ndim()));
  }
  return {array.data(), static_cast<std::size_t>(array.size())};
}

template <class T>
py::array_t<T> array_from(std::vector<T>&& values) {
  auto owner = std::make_unique<std::vector<T>>(std::move(values));
  T* data = owner->data();
  const auto size = static_cast<py::ssize_t>(owner->size());
  py::capsule free(owner.release(), [](void* pointer) { delete static_cast<std::vector<T>*>(pointer); });
  return py::array_t<T>(size, data, free);
}

}  // namespace stiction::python
