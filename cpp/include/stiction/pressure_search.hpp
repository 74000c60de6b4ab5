// Pressure of an elastic half-space under a gap: the passes over a grid between two convolutions.
#pragma once

#include "stiction/array.hpp"
#include "stiction/crew.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace stiction {

/// Projected conjugate gradients for  min 1/2 p·Kp + p·g0  over  0 <= p <= bound at each point, sum p = total.
///
/// K maps pressure [GPa] to displacement [µm]; the caller applies it, and a preconditioner that resembles its inverse.
/// `potential` is K p + g0, so the gap at approach δ is potential - δ. Free points are those under a pressure strictly
/// between the bounds, and those at a bound that their gap calls away from it. One iteration is
///
///     restart(potential), then  balance()  ->  residual()  ->  step(M residual, K previous step)  ->  advance(K step)
///
/// The inverse of K on free points is the least energy r·Mr of all continuations of r to the other points. On areas a
/// continuation by zero is near it. On lines it is not, where contacts are short: there residuals are continued along
/// straight lines, and what M gives is collected by the transpose. Neighbours are so over the edges too: M is periodic.
///
/// A step leads from one feasible pressure to another. Only free points move, so that a sum to be restored never leaves
/// a trace of pressure on others. Polonsky & Keer, Wear 231 (1999) 206 for the scheme; the energy never rises.
class PressureSearch {
 public:
  /// Begins at `pressure` >= 0, brought to the bounds and the sum. `line`: neighbours in memory are neighbours on a
  /// line. `bound`: one for all points, which may be infinite, or one for each, of which those of 0 bear nothing.
  /// Throws std::invalid_argument for 2³¹ points or more, bounds below 0, and a total that is not positive or not below
  /// their sum.
  PressureSearch(std::vector<double> pressure, double total, Values bound, bool line);

  /// Finds approach and free points; a std::logic_error before the first `restart`. Returns the largest distance
  /// |potential - approach| [µm] of a free point: no point under pressure is open by more, none below its bound
  /// overlaps by more. Infinite where potentials are not finite.
  double balance(const Crew& crew = Crew());

  /// Mean potential of the free points less potential [µm] there, and its continuation, 0 on areas, elsewhere.
  std::span<const float> residual(const Crew& crew = Crew());

  /// Free points of the last balance, rising.
  std::span<const std::int32_t> free() const { return free_; }

  /// Whether the next step wants the residual itself in place of a preconditioned one: descent is then certain.
  bool plain() const { return plain_; }

  /// A step of pressure [GPa], 0 at points that are not free. `response` is K times the step before, or empty.
  std::span<const float> step(std::span<const float> preconditioned, std::span<const float> response,
                              const Crew& crew = Crew());

  /// Goes as far along the step as lowers the energy most, with `response` = K step, which the next balance reads
  /// again. Returns whether it went at all.
  bool advance(std::span<const float> response, const Crew& crew = Crew());

  /// Scales pressures below their bounds to the sum, exact but for round-off, for a potential to be computed anew.
  void settle();

  /// Takes such a potential, and begins again with the steepest descent.
  void restart(std::vector<double> potential);

  /// Σ pressure potential [GPa µm] after a balance; for no gap twice the elastic energy over the area of a cell.
  double work() const;

  double approach() const { return approach_; }
  Values pressure() const { return pressure_; }
  /// The pressure, of which the search is then empty.
  std::vector<double> take_pressure() { return std::move(pressure_); }
  /// The potential, whose memory `restart` can have again, as it must before the next balance.
  std::vector<double> take_potential() { return std::move(potential_); }

 private:
  static constexpr std::size_t block = 64;  // points that are looked at together

  struct Run {
    std::int32_t first;
    std::int32_t count;
    std::int32_t before;  // points that precede it
  };

  void check(std::span<const float> grid) const;
  double bound_at(std::size_t i) const { return bounds_.empty() ? everywhere_[0] : bounds_[i]; }
  double approach_of_bounds() const;
  void add_response(std::size_t first, std::size_t count);
  void mark(std::size_t first, std::size_t last, std::vector<std::int32_t>& found);
  double farthest() const;
  bool continued() const { return line_ && !plain_ && !free_.empty(); }
  template <class Between>
  void for_each_gap(Between between) const;
  void collect(std::span<const float> preconditioned);

  std::vector<double> pressure_;
  std::vector<double> potential_;
  double total_;
  std::array<double, block> everywhere_{};  // the bound, if it is one
  std::vector<double> bounds_;              // one for each point, or empty
  bool line_;
  std::vector<std::int32_t> free_;   // where residual_ may differ from 0
  std::vector<std::int32_t> moved_;  // where step_ may differ from 0
  std::vector<float> residual_;      // on the grid
  std::vector<float> step_;          // on the grid
  std::vector<double> collected_;    // preconditioned residual at free points
  std::vector<double> target_;       // pressure at free points after a whole step
  std::vector<double> most_;         // bound at free points
  std::span<const float> response_;  // of the last step, so much of which the potential lacks:
  double part_ = 0.0;
  std::vector<std::vector<std::int32_t>> found_;  // free points of parts of the grid
  double approach_ = 0.0;
  double mean_ = 0.0;           // potential of free points
  double length_ = 1.0;         // of the next step, in preconditioned residuals
  double plain_length_ = 1.0;   // the same in residuals
  double length_before_ = 1.0;  // that before the last preconditioned step
  int failures_ = 0;            // of preconditioned steps, since one led somewhere
  int plain_steps_ = 0;         // that are to come
  double curvature_ = 0.0;      // step·K step
  bool conjugate_ = false;
  bool plain_ = false;
  bool clipped_ = false;
};

}  // namespace stiction
