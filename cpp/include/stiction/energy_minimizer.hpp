// Energy of an adhesive half-space contact under a constant load, minimised by preconditioned conjugate gradients.
#pragma once

#include "stiction/elastic_kernel.hpp"
#include "stiction/thread_pool.hpp"
#include "stiction/values.hpp"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace stiction {

/// Attraction (w/ρ) exp(-gap/ρ) [GPa] between facing points of two surfaces, and upper limit of the contact pressure.
struct AdhesiveInterface {
  double max_attraction = 0.0;                                ///< w/ρ [GPa], attraction of points in contact
  double range = 1.0;                                         ///< range ρ of the attraction [µm] > 0
  double hardness = std::numeric_limits<double>::infinity();  ///< largest contact pressure [GPa] > 0
};

struct MinimizationLimits {
  double max_residual = 0.0;           ///< relative residual below which the state is an equilibrium
  double max_accepted_residual = 0.0;  ///< relative residual that is accepted if round-off prevents further steps
  double min_contact_load = 0.0;       ///< mean contact pressure [GPa] below which the bodies count as separate
};

struct MinimizationState {
  std::vector<double> gap;           ///< gap [µm] at each grid point
  std::vector<double> net_pressure;  ///< pressure minus attraction [GPa] on the extended grid of StiffnessKernel
  double approach = 0.0;             ///< [µm]
  std::vector<float> direction;      ///< last direction of the displacements; empty before the first step
  std::vector<float> residual;       ///< derivative of the energy before the last step, with respect to displacements
  double approach_direction = 0.0;
  double approach_residual = 0.0;
  double slope = 0.0;                     ///< product of the residual and the preconditioned residual
  std::int64_t number = 0;                ///< number of steps
  std::int64_t num_failed_descents = 0;   ///< number of successive directions along which round-off raises the energy
  std::int64_t recomputation_number = 0;  ///< number of the step before which the net pressure was recomputed
};

/// Outcome of a step of the minimisation. A step changes the state only if its outcome is `unfinished`.
enum class MinimizationOutcome {
  unfinished,
  balanced,   ///< the state is an equilibrium
  separated,  ///< the bodies have separated
  stalled,    ///< round-off prevents the state from reaching an equilibrium
};

struct AdhesiveStresses {
  std::vector<double> pressure;
  std::vector<double> attraction;
};

/// Minimiser of the sum of three energies of a contact: elastic energy, energy of the attraction, and work of the load.
///
/// The unknowns are the gaps and, on free grids, also the approach and the displacements of points around the grid.
/// On free grids, the net pressure must vanish at all points around the grid.
/// Points in contact keep a gap of 0 as long as their pressure is between 0 and the hardness.
/// Each step ends at the first minimum of the energy along the direction of the step.
/// Only one thread at a time may use an EnergyMinimizer.
class EnergyMinimizer {
 public:
  /// `gap` [µm], the gap between the undeformed surfaces, must outlive the minimiser.
  /// Throws std::invalid_argument if attraction range or hardness is not positive, or an array has the wrong size.
  EnergyMinimizer(Values gap, const Grid& grid, double effective_modulus, const AdhesiveInterface& interface,
                  const ThreadPool& pool = ThreadPool());

  /// Return the state from which a minimisation starts. `load` is the external load as a mean pressure [GPa].
  /// `pressure` and `attraction` [GPa] are estimates of the solution, such as the solution at a similar load.
  MinimizationState start(Values pressure, Values attraction, double load, const ThreadPool& pool = ThreadPool());

  MinimizationOutcome step(MinimizationState& state, double load, const MinimizationLimits& limits,
                           const ThreadPool& pool = ThreadPool());

  AdhesiveStresses stresses(const MinimizationState& state) const;

 private:
  struct Residual;
  struct Direction;

  template <class Sums, class Work>
  Sums sum_rows(const ThreadPool& pool, const Work& work) const;
  void check(const MinimizationState& state) const;
  double attraction(double gap) const;
  std::size_t on_extended_grid(std::size_t point) const;
  Residual compute_residual(const MinimizationState& state, double load, const ThreadPool& pool);
  double compute_conjugate_direction(MinimizationState& state, double approach_residual, const ThreadPool& pool);
  Direction fix_contact_points(MinimizationState& state, const ThreadPool& pool);
  double find_step_length(const MinimizationState& state, const Direction& direction, double load,
                          const ThreadPool& pool);
  void change_state(MinimizationState& state, double step, double load, const ThreadPool& pool);
  void recompute_net_pressure(MinimizationState& state, double load, const ThreadPool& pool);

  Values gap_;
  Grid grid_;
  AdhesiveInterface interface_;
  StiffnessKernel kernel_;
  double uniform_stiffness_ = 0.0;  // sum of pressures due to a uniform displacement of a free grid; 0 if periodic
  // Arrays on the extended grid of the kernel. Every step of the minimisation reuses their memory.
  Workspace workspace_;
  std::vector<double> displacement_;
  std::vector<float> residual_;
  std::vector<float> descent_;              // negative residual after preconditioning
  std::vector<float> displacement_change_;  // direction including the approach
  std::vector<float> pressure_change_;      // net pressures due to displacement_change_
  std::vector<double> attracted_gaps_;      // gaps of the points whose attraction changes along the direction
  std::vector<double> attracted_gap_changes_;
};

}  // namespace stiction
