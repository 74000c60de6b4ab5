// Half-space contacts at successive loads or approaches, and the elastic responses of their contact points.
#pragma once

#include "stiction/half_space.hpp"
#include "stiction/patches.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace stiction {

struct HalfSpaceContact {
  Patches patches;
  double approach = 0.0;  ///< [µm]
  double error = 0.0;
  std::int64_t iterations = 0;  ///< number of iterations on the finest grid
};

enum class StepQuantity {
  mean_pressure,  ///< mean pressure on the grid [GPa]
  approach        ///< approach [µm]
};

/// Progress callback with the index of the step, the iteration number and the relative error.
using StepProgress = std::function<void(std::size_t, std::int64_t, double)>;

/// Solve the contact at each load or approach in `steps`. Each solution starts from the pressures at the previous step.
/// The solution at the first step starts from the pressures `near`, unless `near` is empty.
/// The hardness [GPa] may be infinite.
/// The calculation ends at the first step whose relative error exceeds the tolerance of the solver.
std::vector<HalfSpaceContact> solve_contacts(const HalfSpaceSolver& solver, StepQuantity quantity, Values steps,
                                             Values near, double hardness, const ThreadPool& pool = ThreadPool(),
                                             const StepProgress& progress = {});

/// Elastic response of a fixed set of contact points to pressures that displace all points of the set equally.
/// The pressures of a response are scaled so that their sum is 1.
struct FixedContactResponse {
  double compliance = 0.0;             ///< displacement of the points [µm/GPa]; 0 at full periodic contact
  double weighted_displacement = 0.0;  ///< Σ pressure · (displacement under a uniform pressure of 1 GPa) [µm/GPa]
};

/// Compute the elastic response of each contact. `contacts` contains the indices of the points of each contact.
/// `uniform_displacement` is the displacement of each grid point under a pressure of 1 GPa on all grid points.
/// Throws std::invalid_argument in the same cases as `linear_response`, and if a point is not on the grid.
std::vector<FixedContactResponse> fixed_contact_responses(const HalfSpaceGrids& grids,
                                                          std::span<const std::span<const std::int64_t>> contacts,
                                                          Values uniform_displacement,
                                                          const ThreadPool& pool = ThreadPool());

}  // namespace stiction
