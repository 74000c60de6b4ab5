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

/// Solver for the minimum of 1/2 p·Kp + p·g0 over the pressures p, by projected conjugate gradients.
/// The pressures satisfy 0 <= p <= bound at each point, and their sum is `total`.
///
/// The kernel K maps pressures [GPa] to displacements [µm].
/// The caller computes products of vectors with K, and with a preconditioner M that approximates the inverse of K.
/// `potential` is K p + g0, so the gap at approach δ is potential - δ.
/// A point is free if its pressure lies strictly between the bounds.
/// A point at a bound is also free if the gap at the point drives the pressure away from the bound.
/// One iteration of the solver consists of the following calls:
///
/// restart(potential), then  update_free_points()  ->  residual()  ->  step(M residual, K previous step)
/// ->  advance(K step)
///
/// The preconditioner M acts on the whole grid, so the residual r is extended to points that are not free.
/// The best extension of r minimises r·Mr. The minimum of r·Mr equals r·K⁻¹r on the free points.
/// On areas, r is set to 0 at points that are not free, which gives nearly the smallest r·Mr.
/// On lines with short contacts, r = 0 at these points would give a much larger r·Mr than the best extension.
/// On lines, r is interpolated linearly between free points. M r is multiplied by the transpose of the interpolation.
/// The interpolation of r continues across the edges of the grid, because M is periodic.
///
/// After each step, all pressures are within their bounds, and the sum of the pressures is `total`.
/// Only pressures at free points change to restore the total load, so points out of contact keep zero pressure.
/// The energy never increases. Source of the method: Polonsky & Keer, Wear 231 (1999) 206.
class ProjectedCgSolver {
 public:
  /// Arrays on the grid. A later solver can reuse the memory of these arrays.
  struct Arrays {
    std::vector<double> potential;
    std::vector<float> residual;
    std::vector<float> step;
  };

  /// Start from given pressures >= 0, which are first changed so that they satisfy the bounds and the total load.
  /// `line` is true if the points form a line, so that neighbours in memory are neighbours on the grid.
  /// `bound` contains one pressure bound for all points, which may be infinite, or one bound for each point.
  /// If each point has its own bound, the memory of `bound` must outlive the solver, which does not copy it.
  /// Points with a pressure bound of 0 carry no pressure.
  /// Throws std::invalid_argument for 2³¹ points or more, and for negative pressure bounds.
  /// Also throws std::invalid_argument if the total load is not positive, or not below the sum of the bounds.
  /// The solver reuses the memory of `arrays`, whose values are ignored.
  ProjectedCgSolver(std::vector<double> pressure, double total, Values bound, bool line, Arrays arrays = {});

  /// Determine the approach and the free points. Returns the largest |potential - approach| [µm] over the free points.
  /// The gap of a point under pressure is at most the returned length.
  /// The overlap of a point whose pressure is below its bound is at most the returned length.
  /// Returns infinity if potentials are not finite. Throws std::logic_error before the first `restart`.
  double update_free_points(const ThreadPool& pool = ThreadPool());

  /// Return the residual [µm].
  /// At free points, the residual is the mean potential of all free points minus the potential of the point.
  /// At points that are not free, the residual is 0 on areas, and linearly interpolated on lines.
  std::span<const float> residual(const ThreadPool& pool = ThreadPool());

  /// Return the free points found by the last `update_free_points`, in increasing order.
  std::span<const std::int32_t> free_points() const { return free_points_; }

  /// Return whether the next step is a steepest-descent step.
  /// A steepest-descent step uses the residual instead of the preconditioned residual, and always lowers the energy.
  bool is_steepest_descent() const { return steepest_descent_; }

  /// Compute the direction of the next pressure step [GPa]. The direction is 0 at points that are not free.
  /// `response` is K times the previous step, or empty.
  std::span<const float> step(std::span<const float> preconditioned, std::span<const float> response,
                              const ThreadPool& pool = ThreadPool());

  /// Move the pressures along the step to the minimum of the energy. `response` is K times the step.
  /// `response` must stay valid until the next `update_free_points`. Returns whether any pressure changed.
  bool advance(std::span<const float> response, const ThreadPool& pool = ThreadPool());

  /// Scale the pressures that are below their bounds, so that the sum of all pressures equals the total load.
  /// The caller must then recompute the potential.
  void rescale_to_total();

  /// Replace the potential by a recomputed potential, and restart with steepest descent.
  void restart(std::vector<double> potential);

  /// Return Σ pressure · potential [GPa µm] after `update_free_points`.
  /// If the initial gap is zero, Σ pressure · potential is twice the elastic energy divided by the area of a cell.
  double pressure_dot_potential() const;

  double approach() const { return approach_; }
  Values pressure() const { return pressure_; }
  Values potential() const { return potential_; }
  std::vector<double> take_pressure() { return std::move(pressure_); }
  /// Move the potential out of the solver, so that its memory can be reused.
  /// After `take_potential`, call `restart` with a new potential before the next `update_free_points`.
  std::vector<double> take_potential() { return std::move(potential_); }
  /// Move the arrays out of the solver, which must not be used afterwards.
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
  // Marks of blocks, or an empty array if all points have the same bound. Potentials are updated only in marked blocks.
  // A block is marked with 1 if at least one point of the block has a pressure bound above 0.
  std::vector<std::uint8_t> can_touch_;
  bool line_;
  std::vector<std::int32_t> free_points_;     // points at which residual_ may differ from 0
  std::vector<std::int32_t> stepped_points_;  // points at which step_ may differ from 0
  std::vector<float> residual_;               // residual on the grid
  std::vector<float> step_;                   // direction of the step on the grid
  std::vector<double> preconditioned_;        // preconditioned residual at free points
  std::vector<double> target_;                // pressure at free points after a full step
  std::vector<double> free_bounds_;           // bound at free points
  // Response of the last step: the kernel K times the step.
  // The potential does not yet include the last response, multiplied by `pending_fraction_`.
  std::span<const float> pending_response_;
  double pending_fraction_ = 0.0;
  std::vector<std::vector<std::int32_t>> task_free_points_;  // free points found by each task
  double approach_ = 0.0;
  double mean_potential_ = 0.0;  // mean potential of free points
  double step_length_ = 1.0;     // length of the next preconditioned step
  double descent_length_ = 1.0;  // length of the next steepest-descent step
  // Length of the last steepest-descent step before the last preconditioned step.
  double previous_descent_length_ = 1.0;
  int failed_steps_ = 0;        // number of failed preconditioned steps since the last successful step
  int descent_steps_left_ = 0;  // number of remaining steepest-descent steps
  double curvature_ = 0.0;      // scalar product of the step and K step
  bool conjugate_ = false;
  bool steepest_descent_ = false;
  bool clipped_ = false;
};

}  // namespace stiction
