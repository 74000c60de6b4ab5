// Solver for the normal contact of an elastic half-space: projected conjugate gradients.
#pragma once

#include "stiction/thread_pool.hpp"
#include "stiction/values.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace stiction {

/// Solver for the pressures p that minimise 1/2 p·Kp + p·g0 for the initial gap g0, by projected conjugate gradients.
/// Each pressure p satisfies 0 <= p <= bound, and the sum of all pressures is `total`.
///
/// The kernel K maps pressures [GPa] to displacements [µm].
/// The caller computes products of vectors with K, and with a preconditioner M that approximates the inverse of K.
/// `potential` is K p + g0, so the gap at approach δ is potential - δ.
/// A point is free if its pressure lies strictly between 0 and its bound.
/// A point whose pressure is 0 or at its bound is also free if its gap drives the pressure away from this limit.
/// After `restart(potential)`, each iteration consists of the following calls, where a step changes the pressures:
///
/// update_free_points()  ->  residual()  ->  step(M residual, K previous step)  ->  advance(K step)
///
/// M acts on the whole grid. At points that are not free, the residual r is therefore chosen such that r·Mr is small.
/// On areas, r is set to 0 at points that are not free, which gives nearly the smallest r·Mr.
/// On lines, r is interpolated linearly between free points, also across the edges of the grid, because M is periodic.
/// If r is interpolated, M r is then multiplied by the transpose of the interpolation matrix.
///
/// After each step, all pressures are within their bounds, and the sum of the pressures is `total`.
/// The energy never increases. Source of the method: Polonsky & Keer, Wear 231 (1999) 206.
class ProjectedCgSolver {
 public:
  struct Arrays {
    std::vector<double> potential;
    std::vector<float> residual;
    std::vector<float> step;
  };

  /// Start from given pressures >= 0, which are first changed so that they satisfy the bounds and the total load.
  /// `line` is true if the points form a line, so that neighbours in memory are neighbours on the grid.
  /// `bound` [GPa] contains one pressure bound for all points, which may be infinite, or one bound for each point.
  /// An array with one bound for each point must outlive the solver.
  /// Throws std::invalid_argument for 2³¹ points or more, negative bounds, or a total load outside (0, sum of bounds).
  ProjectedCgSolver(std::vector<double> pressure, double total, Values bound, bool line, Arrays arrays = {});

  /// Determine the approach and the free points. Returns the largest |potential - approach| [µm] over the free points.
  /// The returned length limits the gaps under pressure, and the overlaps at points below their pressure bounds.
  /// Returns infinity if potentials are not finite. Throws std::logic_error before the first `restart`.
  double update_free_points(const ThreadPool& pool = ThreadPool());

  /// Return the residual [µm]: the mean potential of all free points minus the potential of a free point.
  /// At points that are not free, the residual is 0 on areas, and linearly interpolated on lines.
  std::span<const float> residual(const ThreadPool& pool = ThreadPool());

  /// On areas, hold free points at their bounds if the direction M r would push their pressures beyond the bounds.
  /// Held points are not free until the next `update_free_points`. The residual of all other points changes in place.
  /// Returns whether any points were held. If so, the caller must compute M r again.
  /// Without held points, steps clipped at many bounds would seldom be conjugate, and might not lower the energy.
  bool hold_points_at_bounds(std::span<const float> preconditioned, const ThreadPool& pool = ThreadPool());

  std::span<const std::int32_t> free_points() const { return free_points_; }

  /// A steepest-descent step uses the residual instead of the preconditioned residual, and always lowers the energy.
  bool is_steepest_descent() const { return steepest_descent_; }

  /// Compute the direction of the next pressure step [GPa]. The direction is 0 at points that are not free.
  /// `response` is K times the previous pressure step, or empty.
  std::span<const float> step(std::span<const float> preconditioned, std::span<const float> response,
                              const ThreadPool& pool = ThreadPool());

  /// Move the pressures along the step to the minimum of the energy. `response` is K times the step.
  /// `response` must stay valid until the next `update_free_points`. Returns whether any pressure changed.
  bool advance(std::span<const float> response, const ThreadPool& pool = ThreadPool());

  /// Scale all pressures below their bounds so that the total load is `total`. The caller must recompute the potential.
  void rescale_to_total();

  /// Restart with a steepest-descent step from a potential that the caller has recomputed.
  void restart(std::vector<double> potential);

  /// Return Σ pressure · potential [GPa µm] over all points of the grid. Call `update_free_points` beforehand.
  /// If the initial gap is zero everywhere, the sum is twice the elastic energy divided by the area of a cell.
  double pressure_dot_potential() const;

  double approach() const { return approach_; }
  Values pressure() const { return pressure_; }
  Values potential() const { return potential_; }
  std::vector<double> take_pressure() { return std::move(pressure_); }
  /// After `take_potential`, call `restart` with a new potential before the next `update_free_points`.
  std::vector<double> take_potential() { return std::move(potential_); }
  /// After `take_arrays`, the solver must not be used.
  Arrays take_arrays();

 private:
  static constexpr std::size_t block = 64;  // number of points that are processed together

  struct Segment {
    std::int32_t first;
    std::int32_t count;
    std::int32_t offset;  // number of constrained points of the run that precede `first`
  };

  void check(std::span<const float> grid) const;
  double bound_at(std::size_t i) const { return bounds_.empty() ? uniform_bound_[0] : bounds_[i]; }
  double approach_from_bounds() const;
  void add_pending_response(std::size_t first, std::size_t count);
  void find_free_points(std::size_t first, std::size_t last, std::vector<std::int32_t>& free_points);
  double max_feasible_fraction() const;
  bool interpolates() const { return line_ && !steepest_descent_ && !free_points_.empty(); }
  template <class Visit>
  void for_each_constrained_run(Visit visit) const;
  void restrict_to_free_points(std::span<const float> preconditioned);

  std::vector<double> pressure_;
  std::vector<double> potential_;
  double total_;
  std::array<double, block> uniform_bound_{};  // copies of the bound, if all points have the same bound
  Values bounds_;                              // bound of each point; empty if all points have the same bound
  // For each block of points: 1 if any pressure bound is above 0, else 0. Potentials are updated only in blocks with 1.
  // `can_touch_` is empty if all points have the same bound.
  std::vector<std::uint8_t> can_touch_;
  bool line_;
  std::vector<std::int32_t> free_points_;     // points at which residual_ may differ from 0
  std::vector<std::int32_t> stepped_points_;  // points at which step_ may differ from 0
  std::vector<float> residual_;
  std::vector<float> step_;
  std::vector<double> preconditioned_;  // preconditioned residual at free points
  std::vector<double> target_;          // pressure at free points after a full step
  std::vector<double> free_bounds_;     // bound at free points
  // K times the last step. The potential does not yet include `pending_fraction_` times this product.
  std::span<const float> pending_response_;
  double pending_fraction_ = 0.0;
  std::vector<std::vector<std::int32_t>> task_free_points_;
  double approach_ = 0.0;
  double mean_potential_ = 0.0;
  double step_length_ = 1.0;
  double descent_length_ = 1.0;
  // `descent_length_` before the last step. It may be restored if a preconditioned step fails.
  double previous_descent_length_ = 1.0;
  int failed_steps_ = 0;  // number of failed preconditioned steps since the last successful step
  int descent_steps_left_ = 0;
  double curvature_ = 0.0;  // scalar product of the step and K step
  bool conjugate_ = false;
  bool steepest_descent_ = false;
  bool clipped_ = false;
};

}  // namespace stiction
