#include "stiction/half_space.hpp"

#include "arrays.hpp"
#include "cancellation.hpp"
#include "stiction/patches.hpp"

#include <atomic>
#include <cstdint>

namespace stiction::python {
namespace {

using Singles = py::array_t<float, py::array::c_style>;
using Marks = py::array_t<bool, py::array::c_style>;
using Progress = py::typing::Optional<py::typing::Callable<py::object(std::int64_t, double)>>;

// Number of iterations of running calculations. A solver increases it without acquiring the GIL.
struct IterationCounter {
  std::atomic<std::int64_t> count{0};
};

template <class T>
std::span<const T> grid(const py::array_t<T, py::array::c_style>& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

// Return values as an array that has the same shape as an argument.
template <class T>
py::array_t<T> like(const py::array_t<T, py::array::c_style>& array, std::vector<T>&& values) {
  return to_array(std::move(values)).reshape(std::vector<py::ssize_t>(array.shape(), array.shape() + array.ndim()));
}

Grid grid_of(const std::vector<std::size_t>& shape, const std::vector<double>& spacing, bool periodic) {
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

HalfSpaceProgress to_callback(const Progress& progress, IterationCounter* counter) {
  if (progress.is_none() && counter == nullptr) {
    return {};
  }
  return [&progress, calls = !progress.is_none(), counter](std::int64_t iteration, double error) {
    if (counter != nullptr) {
      ++counter->count;
    }
    if (calls) {
      const py::gil_scoped_acquire acquire;
      progress(iteration, error);
    }
  };
}

template <class Search>
HalfSpaceSolution solve(std::size_t threads, const Progress& progress, IterationCounter* counter, Search search) {
  const HalfSpaceProgress report = to_callback(progress, counter);
  const CancellationCheck check_cancellation = keyboard_interrupt_check();
  const py::gil_scoped_release release;
  return search(ThreadPool(threads, check_cancellation), report);
}

// Return values of a solution as a read-only array, which keeps the solution alive.
py::array_t<double> field(const std::vector<double>& values, const py::object& solution) {
  py::array_t<double> array(static_cast<py::ssize_t>(values.size()), values.data(), solution);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

// Reshape sums to the shape (directions, patches).
py::array_t<double> by_direction(std::vector<double>&& values, py::ssize_t directions) {
  return to_array(std::move(values)).reshape({directions, py::ssize_t{-1}});
}

}  // namespace

void bind_half_space(py::module_& module) {
  py::class_<IterationCounter, std::shared_ptr<IterationCounter>>(
      module, "IterationCounter", "Number of solver iterations, which other threads may read during a calculation.")
      .def(py::init<>())
      .def_property_readonly("count", [](const IterationCounter& counter) { return counter.count.load(); })
      .def(
          "add", [](IterationCounter& counter, std::int64_t iterations) { counter.count += iterations; },
          py::arg("iterations"), "Add iterations of an earlier calculation whose result is reused.");

  py::class_<HalfSpaceGrids, std::shared_ptr<HalfSpaceGrids>>(
      module, "HalfSpaceGrids", "Grid hierarchy and elastic kernels, shared by all contact problems on the same grid.")
      .def(py::init([](const std::vector<std::size_t>& shape, const std::vector<double>& spacing,
                       double effective_modulus, bool periodic) {
             return std::make_shared<HalfSpaceGrids>(grid_of(shape, spacing, periodic), effective_modulus);
           }),
           py::arg("shape"), py::arg("spacing"), py::kw_only(), py::arg("effective_modulus"), py::arg("periodic"))
      .def_property_readonly("periodic", [](const HalfSpaceGrids& grids) { return grids.levels()[0].periodic; })
      .def(
          "displacement",
          [](const HalfSpaceGrids& grids, const Array& pressure, std::size_t threads) {
            std::vector<double> displacements(static_cast<std::size_t>(pressure.size()));
            {
              const CancellationCheck check_cancellation = keyboard_interrupt_check();
              const py::gil_scoped_release release;
              grids.displacement(grid(pressure), displacements, ThreadPool(threads, check_cancellation));
            }
            return like(pressure, std::move(displacements));
          },
          py::arg("pressure").noconvert(), py::kw_only(), py::arg("threads") = 1,
          "Compute the displacement [µm] of each point under a pressure [GPa].")
      .def(
          "linear_response",
          [](const HalfSpaceGrids& grids, const Marks& in_contact, std::size_t threads) {
            LinearResponse response;
            {
              const auto marks = grid(in_contact);
              const CancellationCheck check_cancellation = keyboard_interrupt_check();
              const py::gil_scoped_release release;
              response = linear_response(grids, marks, ThreadPool(threads, check_cancellation));
            }
            const std::vector<py::ssize_t> shape(in_contact.shape(), in_contact.shape() + in_contact.ndim());
            const py::array_t<double> pressure = to_array(std::move(response.pressure)).reshape(shape);
            return std::pair(pressure, response.compliance);
          },
          py::arg("in_contact").noconvert(), py::kw_only(), py::arg("threads") = 1,
          "Compute the pressures [GPa] with a sum of 1 that displace all contact points equally. Also returns the "
          "displacement [µm].");

  py::class_<HalfSpaceSolution>(
      module, "HalfSpaceSolution",
      "Solution of a contact problem: pressures [GPa], approach [µm], relative error and number of iterations.")
      .def_property_readonly(
          "pressure",
          [](const py::object& self) { return field(self.cast<const HalfSpaceSolution&>().pressure, self); })
      .def_property_readonly(
          "potential",
          [](const py::object& self) { return field(self.cast<const HalfSpaceSolution&>().potential, self); },
          "Gap plus displacement [µm] at the points whose pressure bound is above 0, or an empty array.")
      .def_readonly("approach", &HalfSpaceSolution::approach)
      .def_readonly("error", &HalfSpaceSolution::error)
      .def_readonly("iterations", &HalfSpaceSolution::iterations);

  const auto bind_at = [](auto& solver, const char* name, auto method, const char* targets, const char* description) {
    solver.def(
        name,
        [method](const HalfSpaceSolver& self, double value, const std::optional<Array>& near, std::size_t threads,
                 const Progress& progress, const std::optional<std::shared_ptr<IterationCounter>>& counter) {
          const Values start = near ? grid(*near) : Values();
          return solve(threads, progress, counter ? counter->get() : nullptr,
                       [&](const ThreadPool& pool, const HalfSpaceProgress& report) {
                         return (self.*method)(value, start, pool, report);
                       });
        },
        py::arg(targets), py::kw_only(), py::arg("near").noconvert() = py::none(), py::arg("threads") = 1,
        py::arg("progress") = py::none(), py::arg("counter") = py::none(), description);
  };
  py::class_<HalfSpaceSolver> solver(module, "HalfSpaceSolver",
                                     "Solver for the contact of a half-space with a given gap, at successive loads.");
  solver.def(py::init([](const Array& gap, std::shared_ptr<HalfSpaceGrids> grids, const Array& bound, double tolerance,
                         std::size_t threads) {
               const auto heights = grid(gap);
               const auto bounds = grid(bound);
               const CancellationCheck check_cancellation = keyboard_interrupt_check();
               const py::gil_scoped_release release;
               return std::make_unique<HalfSpaceSolver>(heights, std::move(grids), bounds, tolerance,
                                                        ThreadPool(threads, check_cancellation));
             }),
             py::keep_alive<1, 2>(), py::arg("gap").noconvert(), py::arg("grids"), py::kw_only(),
             py::arg("bound").noconvert(), py::arg("tolerance"), py::arg("threads") = 1);
  bind_at(solver, "at", &HalfSpaceSolver::at, "mean_pressure",
          "Solve the contact problem at a mean pressure [GPa]. The solver starts from `near`, the pressures at another "
          "load, if given.");
  bind_at(
      solver, "at_approach", &HalfSpaceSolver::at_approach, "approach",
      "Solve the contact problem at an approach [µm]. The solver starts from `near`, the pressures at another load, "
      "if given.");

  module.def(
      "patches_of",
      [](const Array& pressure, bool periodic, double hardness) {
        const std::vector<std::size_t> shape(pressure.shape(), pressure.shape() + pressure.ndim());
        const Grid on = grid_of(shape, std::vector<double>(shape.size(), 1.0), periodic);
        const Values values = grid(pressure);
        Patches candidates;
        {
          const py::gil_scoped_release release;
          candidates = patches_of(values, on, hardness);
        }
        return py::make_tuple(to_array(std::move(candidates.points)), to_array(std::move(candidates.pressure)),
                              to_array(std::move(candidates.contact_fraction)), to_array(std::move(candidates.patch)));
      },
      py::arg("pressure").noconvert(), py::kw_only(), py::arg("periodic"), py::arg("hardness"),
      "Return the points under pressure: index, pressure [GPa], contact fraction of the cell, and patch number "
      "(from 1).");
  module.def(
      "patch_sums",
      [](const Array& force, const Array& area, const std::optional<Array>& slope_y, const Array& slope_x,
         const py::array_t<std::int32_t, py::array::c_style>& patch,
         const std::vector<std::array<double, 2>>& directions) {
        const Values along_y = slope_y ? view(*slope_y) : Values();
        PatchSums sums;
        {
          const Values forces = view(force);
          const Values areas = view(area);
          const Values along_x = view(slope_x);
          const std::span<const std::int32_t> patches = grid(patch);
          const py::gil_scoped_release release;
          sums = patch_sums(forces, areas, along_y, along_x, patches, directions);
        }
        py::typing::Dict<py::str, py::object> named;
        named["force"] = to_array(std::move(sums.force));
        named["area"] = to_array(std::move(sums.area));
        const auto ways = static_cast<py::ssize_t>(directions.size());
        named["leaning"] = by_direction(std::move(sums.leaning), ways);
        named["upward"] = by_direction(std::move(sums.upward), ways);
        named["forward"] = by_direction(std::move(sums.forward), ways);
        named["upward_area"] = by_direction(std::move(sums.upward_area), ways);
        named["forward_area"] = by_direction(std::move(sums.forward_area), ways);
        named["steepness"] = py::float_(sums.steepness);
        return named;
      },
      py::arg("force").noconvert(), py::arg("area").noconvert(), py::arg("slope_y").noconvert(),
      py::arg("slope_x").noconvert(), py::arg("patch").noconvert(), py::arg("directions"),
      "Compute force and area sums over the points of each contact patch, some of them for each direction (x, y). "
      "Returns a dict of arrays.");
}

}  // namespace stiction::python
