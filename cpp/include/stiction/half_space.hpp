// Pressure between a rigid gap and an elastic half-space, from coarse grids to fine ones.
#pragma once

#include "stiction/array.hpp"
#include "stiction/crew.hpp"
#include "stiction/elastic_kernel.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace stiction {

/// The grid of a problem and coarser ones down to some 16 points an axis, each with about half of the points along an
/// axis, and their kernels, for as many problems as have that shape. Many threads may ask at once.
class HalfSpaceGrids {
 public:
  struct Kernels {
    std::shared_ptr<const ElasticKernel> points;
    std::shared_ptr<const ElasticKernel> blocks;  ///< of areas, see NearInverse
  };

  /// Throws std::invalid_argument as ElasticKernel does.
  HalfSpaceGrids(const Grid& finest, double effective_modulus);

  const std::vector<Grid>& levels() const { return levels_; }
  double effective_modulus() const { return effective_modulus_; }

  /// Made when first asked for; large ones of coarser grids are not kept.
  Kernels kernels(std::size_t level = 0, const Crew& crew = Crew()) const;

  /// Root-mean-square deviation [µm/GPa] of displacements under an even pressure, which only a free grid has.
  double even_deviation() const;

  /// Displacement [µm/GPa] of each point under a pressure on the first one; empty of grids too large to keep it.
  std::span<const double> influence(const Crew& crew = Crew()) const;

 private:
  std::vector<Grid> levels_;
  double effective_modulus_;
  mutable std::mutex mutex_;
  mutable std::vector<Kernels> kernels_;
  mutable std::optional<double> even_deviation_;
  mutable std::vector<double> influence_;
};

/// A pressure [GPa], the approach [µm] and what is known of them.
struct HalfSpaceSolution {
  std::vector<double> pressure;
  double approach = 0.0;
  double error = 0.0;
  std::int64_t iterations = 0;  ///< on the finest grid
};

/// Called in each iteration on the finest grid with its number and the error; what it throws ends the calculation.
using HalfSpaceProgress = std::function<void(std::int64_t, double)>;

/// The pressures of one gap at one load after the other: the least energy with a given sum, 0 <= p <= bound.
///
/// Polonsky & Keer, Wear 231 (1999) 206, for projected conjugate gradients (see PressureSearch); here preconditioned by
/// what resembles the inverse on the points that are free to move (E*|k|/2 on lines, NearInverse on areas), and begun
/// from the solution on every second point. Errors are distances that no point under pressure is open by more than, nor
/// overlaps by more, in root-mean-square deviations of the gap, or of displacements under the load where heights say
/// nothing or less.
class HalfSpaceSolver {
 public:
  /// `gap` [µm], 0 everywhere where it is not a contact that is sought but a traction, must outlive the solver. `bound`
  /// [GPa]: one for all points, which may be infinite, or one for each; where it is 0 nothing is borne and nothing
  /// asked of the gap. Throws std::invalid_argument for wrong sizes and a tolerance that is not above 0.
  HalfSpaceSolver(Values gap, std::shared_ptr<const HalfSpaceGrids> grids, Values bound, double tolerance,
                  const Crew& crew = Crew());

  /// The unit [µm] of errors at a mean pressure [GPa].
  double scale(double mean_pressure) const;

  /// The pressure with a given mean over the grid; `near` may be one at another load.
  HalfSpaceSolution at(double mean_pressure, Values near = {}, const Crew& crew = Crew(),
                       const HalfSpaceProgress& progress = {}) const;

  /// The pressure at an approach [µm], which grows with the load: some six solutions.
  HalfSpaceSolution at_approach(double approach, Values near = {}, const Crew& crew = Crew(),
                                const HalfSpaceProgress& progress = {}) const;

 private:
  bool is_near(Values near, double mean_pressure) const;
  double displacement_of_load(const Crew& crew) const;
  Values gap(std::size_t level) const { return level == 0 ? gap_ : Values(coarse_gaps_[level - 1]); }
  HalfSpaceSolution finest(std::vector<double> start, double mean_pressure, Workspace& workspace, const Crew& crew,
                           const HalfSpaceProgress& progress) const;
  HalfSpaceSolution on_level(std::size_t level, std::vector<double> start, double mean_pressure, double tolerance,
                             Workspace& workspace, const Crew& crew, const HalfSpaceProgress& progress) const;

  Values gap_;
  std::vector<std::vector<double>> coarse_gaps_;
  std::shared_ptr<const HalfSpaceGrids> grids_;
  std::vector<double> bound_;
  double tolerance_;
  double heights_scale_ = 0.0;
  double pressure_scale_ = 0.0;
};

/// What free points answer as they are to a load, under which all of them move alike.
struct LinearAnswer {
  double compliance = 0.0;       ///< dδ/dp [µm/GPa] for the sum of pressures; 0 at full contact
  std::vector<double> pressure;  ///< on the grid, of sum 1
};

/// `free`: not 0 where a point is. The compliance is right to 1e-7 of itself: the energy of pressures whose error is
/// its root.
LinearAnswer linear_answer(const HalfSpaceGrids& grids, std::span<const bool> free, const Crew& crew = Crew());

}  // namespace stiction
