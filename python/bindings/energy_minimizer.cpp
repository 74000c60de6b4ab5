#include "stiction/energy_minimizer.hpp"

#include "arrays.hpp"
#include "cancellation.hpp"
#include "stiction/half_space.hpp"

#include <cstdint>
#include <memory>

namespace stiction::python {
namespace {

using Fields = py::typing::Dict<py::str, py::object>;

template <class T>
std::span<const T> all_values(const py::array_t<T, py::array::c_style>& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

template <class T>
std::vector<T> read_array(const Fields& fields, const char* name) {
  const auto array = fields[name].template cast<py::array_t<T, py::array::c_style>>();
  return {array.data(), array.data() + array.size()};
}

template <class T>
py::array_t<T> copy_array(const std::vector<T>& values) {
  return py::array_t<T>(static_cast<py::ssize_t>(values.size()), values.data());
}

MinimizationState read_fields(const Fields& fields) {
  MinimizationState state;
  state.gap = read_array<double>(fields, "gap");
  state.net_pressure = read_array<double>(fields, "net_pressure");
  state.direction = read_array<float>(fields, "direction");
  state.residual = read_array<float>(fields, "residual");
  state.approach = fields["approach"].cast<double>();
  state.approach_direction = fields["approach_direction"].cast<double>();
  state.approach_residual = fields["approach_residual"].cast<double>();
  state.slope = fields["slope"].cast<double>();
  state.number = fields["number"].cast<std::int64_t>();
  state.num_failed_descents = fields["num_failed_descents"].cast<std::int64_t>();
  state.recomputation_number = fields["recomputation_number"].cast<std::int64_t>();
  return state;
}

Fields copy_fields(const MinimizationState& state) {
  Fields fields;
  fields["gap"] = copy_array(state.gap);
  fields["net_pressure"] = copy_array(state.net_pressure);
  fields["direction"] = copy_array(state.direction);
  fields["residual"] = copy_array(state.residual);
  fields["approach"] = state.approach;
  fields["approach_direction"] = state.approach_direction;
  fields["approach_residual"] = state.approach_residual;
  fields["slope"] = state.slope;
  fields["number"] = state.number;
  fields["num_failed_descents"] = state.num_failed_descents;
  fields["recomputation_number"] = state.recomputation_number;
  return fields;
}

const char* outcome_name(MinimizationOutcome outcome) {
  switch (outcome) {
    case MinimizationOutcome::balanced:
      return "balanced";
    case MinimizationOutcome::separated:
      return "separated";
    case MinimizationOutcome::stalled:
      return "stalled";
    case MinimizationOutcome::unfinished:
      break;
  }
  return "unfinished";
}

}  // namespace

void bind_energy_minimizer(py::module_& module) {
  py::class_<MinimizationState>(module, "MinimizationState",
                                "State between two steps of an energy minimization, from which it can be resumed.")
      .def(py::init(&read_fields), py::arg("fields"), "Restore a state from the arrays and numbers of `fields`.")
      .def("fields", &copy_fields, "Return the arrays and numbers of the state.")
      .def_readonly("approach", &MinimizationState::approach)
      .def_readonly("number", &MinimizationState::number);

  py::class_<EnergyMinimizer>(module, "EnergyMinimizer",
                              "Energy of an adhesive contact under a constant load, minimized by conjugate gradients.")
      .def(py::init([](const Array& gap, const std::shared_ptr<HalfSpaceGrids>& grids, double max_attraction,
                       double range, double hardness, std::size_t threads) {
             const auto heights = all_values(gap);
             const CancellationCheck check_cancellation = keyboard_interrupt_check();
             const py::gil_scoped_release release;
             return std::make_unique<EnergyMinimizer>(heights, grids->levels()[0], grids->effective_modulus(),
                                                      AdhesiveInterface{max_attraction, range, hardness},
                                                      ThreadPool(threads, check_cancellation));
           }),
           py::keep_alive<1, 2>(), py::arg("gap").noconvert(), py::arg("grids"), py::kw_only(),
           py::arg("max_attraction"), py::arg("range"), py::arg("hardness"), py::arg("threads") = 1)
      .def(
          "start",
          [](EnergyMinimizer& minimizer, const Array& pressure, const Array& attraction, double load,
             std::size_t threads) {
            const auto pressures = all_values(pressure);
            const auto attractions = all_values(attraction);
            const CancellationCheck check_cancellation = keyboard_interrupt_check();
            const py::gil_scoped_release release;
            return minimizer.start(pressures, attractions, load, ThreadPool(threads, check_cancellation));
          },
          py::arg("pressure").noconvert(), py::arg("attraction").noconvert(), py::arg("load"), py::kw_only(),
          py::arg("threads") = 1, "Return the state at the start of a minimization under a mean pressure [GPa].")
      .def(
          "step",
          [](EnergyMinimizer& minimizer, MinimizationState& state, double load, double max_residual,
             double max_accepted_residual, double min_contact_load, std::size_t threads) {
            const CancellationCheck check_cancellation = keyboard_interrupt_check();
            const py::gil_scoped_release release;
            return outcome_name(minimizer.step(state, load, {max_residual, max_accepted_residual, min_contact_load},
                                               ThreadPool(threads, check_cancellation)));
          },
          py::arg("state"), py::arg("load"), py::kw_only(), py::arg("max_residual"), py::arg("max_accepted_residual"),
          py::arg("min_contact_load"), py::arg("threads") = 1,
          "Perform a step. Returns \"unfinished\", or why no step was performed: \"balanced\", \"separated\" or "
          "\"stalled\".")
      .def(
          "stresses",
          [](const EnergyMinimizer& minimizer, const MinimizationState& state) {
            AdhesiveStresses stresses = minimizer.stresses(state);
            return std::pair(to_array(std::move(stresses.pressure)), to_array(std::move(stresses.attraction)));
          },
          py::arg("state"), "Return the pressure and the attraction [GPa] at each grid point.");
}

}  // namespace stiction::python
