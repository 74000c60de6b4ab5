#include "stiction/half_space.hpp"

#include "arrays.hpp"
#include "cancellation.hpp"
#include "patches.hpp"
#include "stiction/half_space_contacts.hpp"
#include "stiction/patches.hpp"

#include <atomic>
#include <cstdint>

namespace stiction::python {
namespace {

using Singles = py::array_t<float, py::array::c_style>;
using Marks = py::array_t<bool, py::array::c_style>;
using Progress = py::typing::Optional<py::typing::Callable<py::object(std::int64_t, double)>>;
using ProgressOfSteps = py::typing::Optional<py::typing::Callable<py::object(std::size_t, std::int64_t, double)>>;

// Number of iterations of running calculations. The solver increases this number without acquiring the GIL.
struct IterationCounter {
  std::atomic<std::int64_t> count{0};
};

// Return values as an array that has the same shape as an argument.
template <class T>
py::array_t<T> like(const py::array_t<T, py::array::c_style>& array, std::vector<T>&& values) {
  return to_array(std::move(values)).reshape(std::vector<py::ssize_t>(array.shape(), array.shape() + array.ndim()));
}

// Return a function that counts an iteration, and passes its arguments to a Python function, which may be None.
template <class Callback>
Callback to_callback(const py::object& progress, IterationCounter* counter) {
  if (progress.is_none() && counter == nullptr) {
    return {};
  }
  return [&progress, calls = !progress.is_none(), counter](auto... arguments) {
    if (counter != nullptr) {
      ++counter->count;
    }
    if (calls) {
      const py::gil_scoped_acquire acquire;
      progress(arguments...);
    }
  };
}

template <class Search>
HalfSpaceSolution solve(std::size_t threads, const Progress& progress, IterationCounter* counter, Search search) {
  const auto report = to_callback<HalfSpaceProgress>(progress, counter);
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

// Concatenate the arrays of several contacts.
template <class T>
py::array_t<T> concatenate(const std::vector<HalfSpaceContact>& contacts, std::vector<T> Patches::* field) {
  std::vector<T> values;
  for (const HalfSpaceContact& contact : contacts) {
    const std::vector<T>& more = contact.patches.*field;
    values.insert(values.end(), more.begin(), more.end());
  }
  return to_array(std::move(values));
}

Table to_table(const std::vector<HalfSpaceContact>& contacts) {
  Table table;
  table["points"] = concatenate(contacts, &Patches::points);
  table["values"] = concatenate(contacts, &Patches::pressure);
  table["share"] = concatenate(contacts, &Patches::contact_fraction);
  table["patch"] = concatenate(contacts, &Patches::patch);
  table["num_points"] =
      column(contacts, [](const auto& contact) { return static_cast<std::int64_t>(contact.patches.points.size()); });
  table["approach"] = column(contacts, [](const auto& contact) { return contact.approach; });
  table["error"] = column(contacts, [](const auto& contact) { return contact.error; });
  table["iterations"] = column(contacts, [](const auto& contact) { return contact.iterations; });
  return table;
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
          "displacement [µm].")
      .def(
          "fixed_contact_responses",
          [](const HalfSpaceGrids& grids, const std::vector<Indices>& contacts, const Array& uniform_displacement,
             std::size_t threads) {
            std::vector<std::span<const std::int64_t>> points;
            points.reserve(contacts.size());
            for (const Indices& contact : contacts) {
              points.push_back(grid(contact));
            }
            const Values displacement = grid(uniform_displacement);
            std::vector<FixedContactResponse> responses;
            {
              const CancellationCheck check_cancellation = keyboard_interrupt_check();
              const py::gil_scoped_release release;
              responses = fixed_contact_responses(grids, points, displacement, ThreadPool(threads, check_cancellation));
            }
            std::vector<std::pair<double, double>> pairs;
            pairs.reserve(responses.size());
            for (const FixedContactResponse& response : responses) {
              pairs.emplace_back(response.compliance, response.weighted_displacement);
            }
            return pairs;
          },
          py::arg("contacts").noconvert(), py::arg("uniform_displacement").noconvert(), py::kw_only(),
          py::arg("threads") = 1,
          "Return two displacements [µm] for the points of each contact, under pressures [GPa] with a sum of 1 that "
          "displace all of its points equally: the displacement of these points, and Σ pressure · "
          "uniform_displacement.");

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
  const auto bind_contacts_at = [&solver](const char* name, StepQuantity quantity, const char* steps,
                                          const char* description) {
    solver.def(
        name,
        [quantity](const HalfSpaceSolver& self, const Array& values, const std::optional<Array>& near, double hardness,
                   std::size_t threads, const ProgressOfSteps& progress,
                   const std::optional<std::shared_ptr<IterationCounter>>& counter) {
          const Values targets = view(values);
          const Values start = near ? grid(*near) : Values();
          const auto report = to_callback<StepProgress>(progress, counter ? counter->get() : nullptr);
          const CancellationCheck check_cancellation = keyboard_interrupt_check();
          std::vector<HalfSpaceContact> contacts;
          {
            const py::gil_scoped_release release;
            contacts = solve_contacts(self, quantity, targets, start, hardness, ThreadPool(threads, check_cancellation),
                                      report);
          }
          return to_table(contacts);
        },
        py::arg(steps).noconvert(), py::kw_only(), py::arg("near").noconvert() = py::none(), py::arg("hardness"),
        py::arg("threads") = 1, py::arg("progress") = py::none(), py::arg("counter") = py::none(), description);
  };
  bind_contacts_at("contacts_at", StepQuantity::mean_pressure, "mean_pressures",
                   "Solve for each of several mean pressures over the grid [GPa], up to the first without a solution. "
                   "Returns concatenated arrays of `patches_of`, and one element per contact of the other arrays.");
  bind_contacts_at("contacts_at_approaches", StepQuantity::approach, "approaches",
                   "Solve for each of several approaches [µm]; see `contacts_at`.");

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
      [](const std::vector<Contact>& contacts, const std::optional<Array>& slope_y, const Array& slope_x,
         double cell_area, const std::vector<std::array<double, 2>>& directions) {
        const std::vector<ContactView> views = to_views(contacts);
        const Values along_y = slope_y ? view(*slope_y) : Values();
        const Values along_x = view(slope_x);
        PatchSums sums;
        {
          const py::gil_scoped_release release;
          sums = patch_sums(views, along_y, along_x, cell_area, directions);
        }
        py::typing::Dict<py::str, py::array> named;
        named["force"] = to_array(std::move(sums.force));
        named["area"] = to_array(std::move(sums.area));
        const auto ways = static_cast<py::ssize_t>(directions.size());
        named["leaning"] = by_direction(std::move(sums.leaning), ways);
        named["upward"] = by_direction(std::move(sums.upward), ways);
        named["forward"] = by_direction(std::move(sums.forward), ways);
        named["upward_area"] = by_direction(std::move(sums.upward_area), ways);
        named["forward_area"] = by_direction(std::move(sums.forward_area), ways);
        named["steepness"] = to_array(std::move(sums.steepness));
        named["first_patch"] = to_array(std::move(sums.first_patch));
        return named;
      },
      py::arg("contacts").noconvert(), py::arg("slope_y").noconvert(), py::arg("slope_x").noconvert(), py::kw_only(),
      py::arg("cell_area"), py::arg("directions"),
      "Compute force and area sums over the points of each patch of several contacts, some of them for each direction "
      "(x, y). Each contact is a tuple of arrays as from `patches_of`.");
}

}  // namespace stiction::python
