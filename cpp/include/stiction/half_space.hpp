// Normal contact of an elastic half-space with a rigid rough surface, computed on successively finer grids.
#pragma once

#include "stiction/elastic_kernel.hpp"
#include "stiction/thread_pool.hpp"
#include "stiction/values.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace stiction {

/// Arrays of the solver for one calculation on a grid. Later calculations reuse the memory of these arrays.
struct SolverMemory;

/// Grid hierarchy and elastic kernels, shared by all contact problems on the same grid.
/// Each coarser grid has about half as many points along each axis that has at least 32 points.
/// Several threads may use the same HalfSpaceGrids at the same time.
class HalfSpaceGrids {
 public:
  struct Kernels {
    std::shared_ptr<const ElasticKernel> points;
    std::shared_ptr<const ElasticKernel> blocks;  ///< kernels of the blocks of an area, see Preconditioner
  };

  HalfSpaceGrids(const Grid& finest, double effective_modulus);

  const std::vector<Grid>& levels() const { return levels_; }
  double effective_modulus() const { return effective_modulus_; }

  Kernels kernels(std::size_t level = 0, const ThreadPool& pool = ThreadPool()) const;

  double uniform_pressure_deviation() const;

  /// Return the displacement [µm/GPa] of each grid point due to a pressure on the first grid point.
  /// Returns an empty array if the grid is too large for storing the displacements of all points.
  std::span<const double> influence(const ThreadPool& pool = ThreadPool()) const;

  /// `pressure` and `displacements` may be the same array.
  void displacement(Values pressure, std::span<double> displacements, const ThreadPool& pool = ThreadPool()) const;

  struct ReturnMemory {
    const HalfSpaceGrids* grids;
    void operator()(SolverMemory* memory) const;
  };
  using BorrowedMemory = std::unique_ptr<SolverMemory, ReturnMemory>;

  /// Memory is reused, because the operating system clears each page of new memory, which is slow for large grids.
  BorrowedMemory borrow_memory() const;

 private:
  std::vector<Grid> levels_;
  double effective_modulus_;
  mutable std::mutex mutex_;
  mutable std::vector<Kernels> kernels_;
  mutable std::optional<double> uniform_pressure_deviation_;
  mutable std::vector<double> influence_;
  mutable std::vector<std::shared_ptr<SolverMemory>> memories_;
};

struct HalfSpaceSolution {
  std::vector<double> pressure;
  double approach = 0.0;
  double error = 0.0;
  std::int64_t iterations = 0;  ///< number of iterations on the finest grid
  /// Potential [µm] (initial gap plus displacement) at the points whose pressure bound is above 0.
  /// `potential` is empty if all points share one bound, the solver did not converge, or displacements are missing.
  std::vector<double> potential;
};

/// Progress callback, called with the iteration number and the relative error at each iteration on the finest grid.
/// An exception thrown by the callback ends the calculation.
using HalfSpaceProgress = std::function<void(std::int64_t, double)>;

/// Solver for contact pressures p that minimise the energy at a given total load, subject to 0 <= p <= bound.
///
/// The method is projected conjugate gradients (Polonsky & Keer, Wear 231 (1999) 206; see ProjectedCgSolver).
/// The relative error is the larger of the largest gap under pressure and the largest overlap, divided by `scale`.
class HalfSpaceSolver {
 public:
  /// `gap` [µm] must outlive the solver.
  /// If the gap is 0 everywhere, the solver finds shear tractions up to given bounds instead of contact pressures.
  /// `bound` [GPa] contains one pressure bound for all points, which may be infinite, or one bound for each point.
  /// Points with a pressure bound of 0 carry no pressure and may overlap.
  /// Throws std::invalid_argument if an array has a wrong size, or if the tolerance is not positive.
  HalfSpaceSolver(Values gap, std::shared_ptr<const HalfSpaceGrids> grids, Values bound, double tolerance,
                  const ThreadPool& pool = ThreadPool());

  /// Return the length [µm] by which gaps and overlaps are divided to obtain a relative error.
  /// The length is the standard deviation of the gap or, if larger, of the displacements at `mean_pressure` [GPa].
  double scale(double mean_pressure) const;

  const Grid& grid() const { return grids_->levels()[0]; }
  double tolerance() const { return tolerance_; }

  /// If `near` contains the pressures at another load, the solver may start from these pressures.
  HalfSpaceSolution at(double mean_pressure, Values near = {}, const ThreadPool& pool = ThreadPool(),
                       const HalfSpaceProgress& progress = {}) const;

  /// Solve the contact problem for a given approach [µm], with trial solutions at about six loads.
  HalfSpaceSolution at_approach(double approach, Values near = {}, const ThreadPool& pool = ThreadPool(),
                                const HalfSpaceProgress& progress = {}) const;

 private:
  bool is_good_start(Values near, double mean_pressure) const;
  double unit_load_deviation(const ThreadPool& pool) const;
  Values gap(std::size_t level) const { return level == 0 ? gap_ : Values(coarse_gaps_[level - 1]); }
  HalfSpaceSolution solve_finest(std::vector<double> start, double mean_pressure, SolverMemory& memory,
                                 const ThreadPool& pool, const HalfSpaceProgress& progress) const;
  HalfSpaceSolution solve_level(std::size_t level, std::vector<double> start, double mean_pressure, double tolerance,
                                SolverMemory& memory, const ThreadPool& pool, const HalfSpaceProgress& progress) const;

  Values gap_;
  std::vector<std::vector<double>> coarse_gaps_;
  std::shared_ptr<const HalfSpaceGrids> grids_;
  std::vector<double> bound_;
  double tolerance_;
  double gap_scale_ = 0.0;
  double displacement_scale_ = 0.0;
};

/// Displacement of a fixed contact area per unit of normal load, if the load displaces all contact points equally.
struct LinearResponse {
  double compliance = 0.0;       ///< dδ/dp [µm/GPa], where p is the sum of the pressures; 0 at full contact
  std::vector<double> pressure;  ///< pressures on the grid; the sum of all pressures is 1
};

/// The compliance is proportional to a minimal energy, so errors of the pressures change it only in second order.
/// The relative error of the compliance is about 1e-7.
LinearResponse linear_response(const HalfSpaceGrids& grids, std::span<const bool> in_contact,
                               const ThreadPool& pool = ThreadPool());

}  // namespace stiction
