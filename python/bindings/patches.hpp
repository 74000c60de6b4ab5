// Contacts on a grid as arguments of the bindings.
#pragma once

#include "arrays.hpp"
#include "stiction/elastic_kernel.hpp"
#include "stiction/patches.hpp"

#include <cstdint>
#include <tuple>
#include <vector>

namespace stiction::python {

using Indices = py::array_t<std::int64_t, py::array::c_style>;
using PatchNumbers = py::array_t<std::int32_t, py::array::c_style>;

// Points under pressure, with pressure [GPa], contact fraction of the cell and patch number of each point.
using Contact = std::tuple<Indices, Array, Array, PatchNumbers>;

template <class T>
std::span<const T> grid(const py::array_t<T, py::array::c_style>& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

inline std::vector<ContactView> to_views(const std::vector<Contact>& contacts) {
  std::vector<ContactView> views;
  views.reserve(contacts.size());
  for (const auto& [points, pressure, fraction, patch] : contacts) {
    views.push_back({grid(points), grid(pressure), grid(fraction), grid(patch)});
  }
  return views;
}

inline Grid grid_of(const std::vector<std::size_t>& shape, const std::vector<double>& spacing, bool periodic) {
  if (shape.empty() || shape.size() > 2 || spacing.size() != shape.size()) {
    throw py::value_error("shape and spacing must have one element each (line) or two (area)");
  }
  return {shape.size() == 1 ? 1 : shape[0],
          shape.back(),
          spacing.size() == 1 ? 1.0 : spacing[0],
          spacing.back(),
          shape.size() == 1,
          periodic};
}

}  // namespace stiction::python
