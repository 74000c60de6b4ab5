#include "stiction/projected_cg.hpp"

#include "chunk_sums.hpp"
#include "huge_pages.hpp"
#include "multiversion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace stiction {
namespace {

// After a step, the trial step length is multiplied by (optimal length) / (trial length), clipped to these limits.
constexpr double min_length_factor = 0.5;
constexpr double max_length_factor = 2.0;
constexpr double max_recovery_factor = 100.0;  // largest factor by which steps are lengthened after failed steps
constexpr int max_failed_steps = 6;
constexpr double failure_factor = 0.25;
// Largest load change at a free point in one step, divided by the load on all free points.
// Without this limit, trial lengths would grow in each step, because steps that end at a bound are too short.
constexpr double max_change_ratio = 1e3;
constexpr int max_newton_steps = 200;
constexpr std::size_t grid_sum_lanes = 8;
constexpr std::size_t grid_points_per_task = std::size_t{1} << 16;
constexpr std::size_t free_points_per_task = std::size_t{1} << 16;

STICTION_MULTIVERSION
void add_scaled(const float* response, std::size_t size, double factor, double* potential) {
  for (std::size_t i = 0; i < size; ++i) {
    potential[i] += factor * static_cast<double>(response[i]);
  }
}

// Mark free points: 0 < pressure < bound, or the gap at the point drives the pressure away from 0 or from the bound.
// A point without pressure is also free if its gap is NaN. Returns whether the block of points contains a free point.
STICTION_MULTIVERSION
bool mark_free(const double* pressure, const double* potential, const double* bound, std::size_t size, double approach,
               std::uint8_t* marks) {
  std::uint8_t any = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const double p = pressure[i];
    const double gap = potential[i] - approach;
    const bool loaded = p > 0.0;
    // The loop has no branches, because the processor would mispredict many of them.
    const bool is_free = (loaded & ((p < bound[i]) | (gap > 0.0))) | (!loaded & (bound[i] > 0.0) & !(gap >= 0.0));
    marks[i] = static_cast<std::uint8_t>(is_free);
    any |= marks[i];
  }
  return any != 0;
}

STICTION_MULTIVERSION
void write_line(float from, float slope, std::int32_t first, std::int32_t count, float* values) {
  for (std::int32_t j = 0; j < count; ++j) {
    values[j] = from + slope * static_cast<float>(first + j);
  }
}

struct Moments {
  double sum = 0.0;
  double moment = 0.0;  // Σ (index - first) · value
};

STICTION_MULTIVERSION
Moments moments(const float* values, std::int32_t first, std::int32_t count) {
  std::array<double, grid_sum_lanes> sums{};
  std::array<double, grid_sum_lanes> moments{};
  constexpr auto width = static_cast<std::int32_t>(grid_sum_lanes);
  const std::int32_t whole = count - count % width;
  for (std::int32_t j = 0; j < whole; j += width) {
    for (std::int32_t lane = 0; lane < width; ++lane) {
      const auto value = static_cast<double>(values[j + lane]);
      sums[static_cast<std::size_t>(lane)] += value;
      moments[static_cast<std::size_t>(lane)] += value * static_cast<double>(first + j + lane);
    }
  }
  for (std::int32_t j = whole; j < count; ++j) {
    const auto value = static_cast<double>(values[j]);
    sums[0] += value;
    moments[0] += value * static_cast<double>(first + j);
  }
  return {std::accumulate(sums.begin(), sums.end(), 0.0), std::accumulate(moments.begin(), moments.end(), 0.0)};
}

struct SplitLoad {
  double between = 0.0;   // load on points below their bound
  double at_bound = 0.0;  // load on points at their bound
};

STICTION_MULTIVERSION
SplitLoad split_load(const double* pressure, const double* bound, std::size_t size) {
  std::array<double, grid_sum_lanes> between{};
  std::array<double, grid_sum_lanes> at_bound{};
  for (std::size_t i = 0; i < size; ++i) {
    const bool below = pressure[i] < bound[i];
    between[i % grid_sum_lanes] += below ? pressure[i] : 0.0;
    at_bound[i % grid_sum_lanes] += below ? 0.0 : pressure[i];
  }
  return {std::accumulate(between.begin(), between.end(), 0.0), std::accumulate(at_bound.begin(), at_bound.end(), 0.0)};
}

STICTION_MULTIVERSION
void scale_below_bound(double* pressure, const double* bound, std::size_t size, double factor) {
  for (std::size_t i = 0; i < size; ++i) {
    const double scaled = pressure[i] * factor;
    pressure[i] = pressure[i] < bound[i] ? (scaled < bound[i] ? scaled : bound[i]) : pressure[i];
  }
}

struct ClippedSum {
  double sum = 0.0;
  double between = 0.0;  // number of pressures strictly between the bounds

  void add(const ClippedSum& other) {
    sum += other.sum;
    between += other.between;
  }
};

STICTION_MULTIVERSION
ClippedSum clipped_sum(const double* pressure, const double* bound, std::size_t size, double shift) {
  std::array<double, grid_sum_lanes> sums{};
  std::array<double, grid_sum_lanes> between{};
  std::size_t i = 0;
  for (; i + grid_sum_lanes <= size; i += grid_sum_lanes) {
    for (std::size_t lane = 0; lane < grid_sum_lanes; ++lane) {
      const double shifted = pressure[i + lane] - shift;
      const double positive = shifted > 0.0 ? shifted : 0.0;
      sums[lane] += positive < bound[i + lane] ? positive : bound[i + lane];
      between[lane] += shifted > 0.0 && shifted < bound[i + lane] ? 1.0 : 0.0;
    }
  }
  for (; i < size; ++i) {
    const double shifted = pressure[i] - shift;
    sums[0] += std::clamp(shifted, 0.0, bound[i]);
    between[0] += shifted > 0.0 && shifted < bound[i] ? 1.0 : 0.0;
  }
  return {std::accumulate(sums.begin(), sums.end(), 0.0), std::accumulate(between.begin(), between.end(), 0.0)};
}

std::size_t point(const std::vector<std::int32_t>& points, std::size_t k) {
  return static_cast<std::size_t>(points[k]);
}

// Return the shift for which the sum of all (pressure - shift), each clipped to [0, bound], has a given value.
// The sum is a decreasing, piecewise linear function of the shift. The equation is solved by bracketed Newton's method.
double shift_to_sum(std::span<const double> pressure, std::span<const double> bound, double sum,
                    const ThreadPool& pool) {
  double left = -std::numeric_limits<double>::infinity();
  double right = std::numeric_limits<double>::infinity();
  double shift = 0.0;
  for (int count = 0; count < max_newton_steps; ++count) {
    const ClippedSum current =
        sum_chunks<ClippedSum>(pressure.size(), free_points_per_task, pool, [&](std::size_t first, std::size_t last) {
          return clipped_sum(&pressure[first], &bound[first], last - first, shift);
        });
    const double excess = current.sum - sum;
    if (std::abs(excess) <= 1e-15 * sum) {
      return shift;
    }
    (excess > 0.0 ? left : right) = shift;
    double next = current.between > 0.0 ? shift + excess / current.between : left + 0.5 * (right - left);
    // The Newton step fails if every pressure is clipped and one end of the bracket is infinite.
    if (!std::isfinite(next)) {
      const auto [lowest, highest] = std::minmax_element(pressure.begin(), pressure.end());
      const double max_bound = *std::max_element(bound.begin(), bound.end());
      left = std::isfinite(left) ? left : *lowest - (std::isfinite(max_bound) ? max_bound : sum);
      right = std::isfinite(right) ? right : *highest;
      next = left + 0.5 * (right - left);
    } else if (!(next > left && next < right)) {
      next = left + 0.5 * (right - left);
    }
    if (next == shift) {
      return shift;
    }
    shift = next;
  }
  return shift;
}

}  // namespace

ProjectedCgSolver::ProjectedCgSolver(std::vector<double> pressure, double total, Values bound, bool line, Arrays arrays)
    : pressure_(std::move(pressure)),
      potential_(std::move(arrays.potential)),
      total_(total),
      line_(line),
      residual_(std::move(arrays.residual)),
      step_(std::move(arrays.step)) {
  const std::size_t size = pressure_.size();
  potential_.clear();
  resize_on_huge_pages(residual_, size);
  resize_on_huge_pages(step_, size);
  std::fill(residual_.begin(), residual_.end(), 0.0F);
  std::fill(step_.begin(), step_.end(), 0.0F);
  if (size == 0 || size > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max())) {
    throw std::invalid_argument("ProjectedCgSolver: pressure must have at least 1 and fewer than 2^31 points");
  }
  if ((bound.size() != 1 && bound.size() != size) ||
      !std::all_of(bound.begin(), bound.end(), [](double value) { return value >= 0.0; })) {
    throw std::invalid_argument(
        "ProjectedCgSolver: bound must have one value or one for each point, and no value below 0");
  }
  if (bound.size() == size) {
    bounds_ = bound;
    can_touch_.resize((size + block - 1) / block);
    for (std::size_t i = 0; i < can_touch_.size(); ++i) {
      const auto bounds = bound.subspan(i * block, std::min(block, size - i * block));
      can_touch_[i] = static_cast<std::uint8_t>(
          std::any_of(bounds.begin(), bounds.end(), [](double value) { return value > 0.0; }));
    }
  }
  uniform_bound_.fill(bound[0]);
  const double max_total = bounds_.empty() ? uniform_bound_[0] * static_cast<double>(size)
                                           : std::accumulate(bounds_.begin(), bounds_.end(), 0.0);
  if (!(total > 0.0) || !(total < max_total)) {
    throw std::invalid_argument("ProjectedCgSolver: total must be positive and below the sum of the bounds");
  }
  // If the points under pressure cannot carry the total load within their bounds, points without pressure are included.
  const auto include = [&](std::size_t i) {
    stepped_points_.push_back(static_cast<std::int32_t>(i));
    target_.push_back(pressure_[i]);
    free_bounds_.push_back(bound_at(i));
  };
  for (std::size_t i = 0; i < size; ++i) {
    if (pressure_[i] > 0.0) {
      include(i);
    }
  }
  if (!(std::accumulate(free_bounds_.begin(), free_bounds_.end(), 0.0) > total)) {
    stepped_points_.clear();
    target_.clear();
    free_bounds_.clear();
    for (std::size_t i = 0; i < size; ++i) {
      include(i);
    }
  }
  const double shift = shift_to_sum(target_, free_bounds_, total, ThreadPool());
  for (std::size_t k = 0; k < stepped_points_.size(); ++k) {
    pressure_[static_cast<std::size_t>(stepped_points_[k])] = std::clamp(target_[k] - shift, 0.0, free_bounds_[k]);
  }
  rescale_to_total();
}

ProjectedCgSolver::Arrays ProjectedCgSolver::take_arrays() {
  return {std::move(potential_), std::move(residual_), std::move(step_)};
}

void ProjectedCgSolver::rescale_to_total() {
  const std::size_t size = pressure_.size();
  const auto bounds = [&](std::size_t first) { return bounds_.empty() ? uniform_bound_.data() : &bounds_[first]; };
  SplitLoad all;
  for (std::size_t first = 0; first < size; first += block) {
    const SplitLoad block_load = split_load(&pressure_[first], bounds(first), std::min(block, size - first));
    all.between += block_load.between;
    all.at_bound += block_load.at_bound;
  }
  const double factor = (total_ - all.at_bound) / all.between;
  if (all.between > 0.0 && factor > 0.0) {
    for (std::size_t first = 0; first < size; first += block) {
      scale_below_bound(&pressure_[first], bounds(first), std::min(block, size - first), factor);
    }
  }
}

void ProjectedCgSolver::check(std::span<const float> grid) const {
  if (grid.size() != pressure_.size()) {
    throw std::invalid_argument("ProjectedCgSolver: arrays must have as many points as the pressure");
  }
}

double ProjectedCgSolver::update_free_points(const ThreadPool& pool) {
  if (potential_.size() != pressure_.size()) {
    throw std::logic_error("ProjectedCgSolver: restart must be called before update_free_points");
  }
  if (line_) {
    std::fill(residual_.begin(), residual_.end(), 0.0F);
  } else {
    pool.run_chunks(free_points_.size(), free_points_per_task, [&](std::size_t first, std::size_t last) {
      for (std::size_t k = first; k < last; ++k) {
        residual_[point(free_points_, k)] = 0.0F;
      }
    });
  }
  // `stepped_points_` contains every point whose pressure is above 0 and below its bound.
  const float* response = pending_fraction_ != 0.0 ? pending_response_.data() : residual_.data();
  const ClippedSum between = sum_chunks<ClippedSum>(
      stepped_points_.size(), free_points_per_task, pool, [&](std::size_t first, std::size_t last) {
        ClippedSum partial;
        for (std::size_t k = first; k < last; ++k) {
          const std::size_t i = point(stepped_points_, k);
          const double p = pressure_[i];
          const bool is_between = (p > 0.0) & (p < bound_at(i));  // not a branch, which would be mispredicted
          partial.sum += is_between ? potential_[i] + pending_fraction_ * static_cast<double>(response[i]) : 0.0;
          partial.between += is_between ? 1.0 : 0.0;
        }
        return partial;
      });
  if (between.between == 0.0) {
    add_pending_response(0, pressure_.size());
    pending_fraction_ = 0.0;
  }
  approach_ = between.between > 0.0 ? between.sum / between.between : approach_from_bounds();
  const std::size_t size = pressure_.size();
  task_free_points_.resize((size + grid_points_per_task - 1) / grid_points_per_task);
  pool.run(task_free_points_.size(), [&](std::size_t task, std::size_t) {
    task_free_points_[task].clear();
    find_free_points(task * grid_points_per_task, std::min((task + 1) * grid_points_per_task, size),
                     task_free_points_[task]);
  });
  pending_fraction_ = 0.0;
  free_points_.clear();
  for (const std::vector<std::int32_t>& free_points : task_free_points_) {
    free_points_.insert(free_points_.end(), free_points.begin(), free_points.end());
  }
  struct Gaps {
    double max_distance = 0.0;
    double sum = 0.0;

    void add(const Gaps& other) {
      max_distance = std::max(max_distance, other.max_distance);
      sum += other.sum;
    }
  };
  const Gaps gaps =
      sum_chunks<Gaps>(free_points_.size(), free_points_per_task, pool, [&](std::size_t first, std::size_t last) {
        Gaps partial;
        for (std::size_t k = first; k < last; ++k) {
          const double gap = potential_[point(free_points_, k)] - approach_;
          partial.max_distance = std::max(partial.max_distance, std::abs(gap));
          partial.sum += gap;
        }
        return partial;
      });
  mean_potential_ = approach_ + (free_points_.empty() ? 0.0 : gaps.sum / static_cast<double>(free_points_.size()));
  return std::isfinite(mean_potential_) ? gaps.max_distance : std::numeric_limits<double>::infinity();
}

void ProjectedCgSolver::add_pending_response(std::size_t first, std::size_t count) {
  if (pending_fraction_ != 0.0) {
    add_scaled(&pending_response_[first], count, pending_fraction_, &potential_[first]);
  }
}

void ProjectedCgSolver::find_free_points(std::size_t first, std::size_t last, std::vector<std::int32_t>& free_points) {
  std::array<std::int32_t, block> indices{};
  std::array<std::uint8_t, block> marks{};
  for (; first < last; first += block) {
    if (!can_touch_.empty() && can_touch_[first / block] == 0) {
      continue;
    }
    const std::size_t count = std::min(block, last - first);
    const double* bound = bounds_.empty() ? uniform_bound_.data() : &bounds_[first];
    add_pending_response(first, count);
    if (mark_free(&pressure_[first], &potential_[first], bound, count, approach_, marks.data())) {
      std::size_t count_free = 0;
      for (std::size_t from = 0; from < count; from += grid_sum_lanes) {
        std::uint64_t marked = 0;
        std::memcpy(&marked, &marks[from], sizeof(marked));
        if (marked == 0) {
          continue;
        }
        for (std::size_t i = from; i < std::min(from + grid_sum_lanes, count); ++i) {
          indices[count_free] = static_cast<std::int32_t>(first + i);
          count_free += marks[i];
        }
      }
      free_points.insert(free_points.end(), indices.begin(), indices.begin() + static_cast<std::ptrdiff_t>(count_free));
    }
  }
}

// Return an approach at which no point under pressure has a gap and no point without pressure overlaps.
// If no approach meets both conditions, return the mean of the largest loaded and the smallest unloaded potential.
double ProjectedCgSolver::approach_from_bounds() const {
  double max_loaded = -std::numeric_limits<double>::infinity();
  double min_unloaded = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < pressure_.size(); ++i) {
    if (pressure_[i] > 0.0) {
      max_loaded = std::max(max_loaded, potential_[i]);
    } else if (bound_at(i) > 0.0) {
      min_unloaded = std::min(min_unloaded, potential_[i]);
    }
  }
  return max_loaded <= min_unloaded ? max_loaded : min_unloaded + 0.5 * (max_loaded - min_unloaded);
}

// Call `visit` for each run of constrained points, with the positions in `free_points_` of the points around the run.
// A run that wraps around the edge of the grid is passed as two segments.
template <class Visit>
void ProjectedCgSolver::for_each_constrained_run(Visit visit) const {
  const auto size = static_cast<std::int32_t>(pressure_.size());
  const std::size_t last = free_points_.size() - 1;
  for (std::size_t k = 0; k < last; ++k) {
    const std::int32_t count = free_points_[k + 1] - free_points_[k] - 1;
    if (count > 0) {
      visit(k, k + 1, count, std::array<Segment, 2>{{{free_points_[k] + 1, count, 0}, {0, 0, count}}});
    }
  }
  const std::int32_t after = size - free_points_[last] - 1;
  visit(last, std::size_t{0}, after + free_points_[0],
        std::array<Segment, 2>{{{free_points_[last] + 1, after, 0}, {0, free_points_[0], after}}});
}

std::span<const float> ProjectedCgSolver::residual(const ThreadPool& pool) {
  pool.run_chunks(free_points_.size(), free_points_per_task, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      const std::size_t i = point(free_points_, k);
      residual_[i] = static_cast<float>(mean_potential_ - potential_[i]);
    }
  });
  if (interpolates()) {
    for_each_constrained_run(
        [&](std::size_t left, std::size_t right, std::int32_t count, const std::array<Segment, 2>& segments) {
          const float from = residual_[static_cast<std::size_t>(free_points_[left])];
          const float slope =
              (residual_[static_cast<std::size_t>(free_points_[right])] - from) / static_cast<float>(count + 1);
          for (const Segment& segment : segments) {
            write_line(from, slope, segment.offset + 1, segment.count, residual_.data() + segment.first);
          }
        });
  }
  return residual_;
}

bool ProjectedCgSolver::hold_points_at_bounds(std::span<const float> preconditioned, const ThreadPool& pool) {
  check(preconditioned);
  if (line_) {
    throw std::logic_error("ProjectedCgSolver: hold_points_at_bounds requires an area");
  }
  struct Sums {
    double value = 0.0;
    double potential = 0.0;
    double held = 0.0;  // number of held points

    void add(const Sums& other) {
      value += other.value;
      potential += other.potential;
      held += other.held;
    }
  };
  const std::size_t size = free_points_.size();
  const Sums before = sum_chunks<Sums>(size, free_points_per_task, pool, [&](std::size_t first, std::size_t last) {
    Sums partial;
    for (std::size_t k = first; k < last; ++k) {
      partial.value += static_cast<double>(preconditioned[point(free_points_, k)]);
    }
    return partial;
  });
  const double mean = before.value / static_cast<double>(std::max<std::size_t>(size, 1));
  const auto is_held = [&](std::size_t i) {
    const double direction = static_cast<double>(preconditioned[i]) - mean;
    return ((pressure_[i] <= 0.0) & (direction < 0.0)) | ((pressure_[i] >= bound_at(i)) & (direction > 0.0));
  };
  const Sums after = sum_chunks<Sums>(size, free_points_per_task, pool, [&](std::size_t first, std::size_t last) {
    Sums partial;
    for (std::size_t k = first; k < last; ++k) {
      const std::size_t i = point(free_points_, k);
      const bool held = is_held(i);
      partial.potential += held ? 0.0 : potential_[i];
      partial.held += held ? 1.0 : 0.0;
    }
    return partial;
  });
  const auto remaining = static_cast<double>(size) - after.held;
  if (after.held == 0.0 || remaining == 0.0) {
    return false;
  }
  std::erase_if(free_points_, [&](std::int32_t each) {
    const auto i = static_cast<std::size_t>(each);
    const bool held = is_held(i);
    residual_[i] = held ? 0.0F : residual_[i];
    return held;
  });
  mean_potential_ = after.potential / remaining;
  residual(pool);
  return true;
}

void ProjectedCgSolver::restrict_to_free_points(std::span<const float> preconditioned) {
  preconditioned_.resize(free_points_.size());
  for (std::size_t k = 0; k < free_points_.size(); ++k) {
    preconditioned_[k] = static_cast<double>(preconditioned[static_cast<std::size_t>(free_points_[k])]);
  }
  if (interpolates()) {
    for_each_constrained_run([&](std::size_t left, std::size_t right, std::int32_t count,
                                 const std::array<Segment, 2>& segments) {
      Moments total;
      for (const Segment& segment : segments) {
        const Moments run_moments = moments(preconditioned.data() + segment.first, segment.offset + 1, segment.count);
        total.sum += run_moments.sum;
        total.moment += run_moments.moment;
      }
      total.moment /= static_cast<double>(count + 1);
      preconditioned_[left] += total.sum - total.moment;
      preconditioned_[right] += total.moment;
    });
  }
}

std::span<const float> ProjectedCgSolver::step(std::span<const float> preconditioned, std::span<const float> response,
                                               const ThreadPool& pool) {
  check(preconditioned);
  if (!response.empty()) {
    check(response);
  }
  const std::size_t size = free_points_.size();
  const auto count = static_cast<double>(std::max<std::size_t>(size, 1));
  restrict_to_free_points(preconditioned);
  conjugate_ = conjugate_ && !response.empty();
  struct Products {
    // In each step, the load changes of the free points must add up to 0, or errors would grow from step to step.
    double load = 0.0;
    double value = 0.0;
    double step = 0.0;
    double response = 0.0;
    double product = 0.0;

    void add(const Products& other) {
      load += other.load;
      value += other.value;
      step += other.step;
      response += other.response;
      product += other.product;
    }
  };
  target_.resize(size);
  free_bounds_.resize(size);
  const Products sums =
      sum_chunks<Products>(size, free_points_per_task, pool, [&](std::size_t first, std::size_t last) {
        Products partial;
        for (std::size_t k = first; k < last; ++k) {
          const std::size_t i = point(free_points_, k);
          const double value = preconditioned_[k];
          free_bounds_[k] = bound_at(i);
          partial.load += pressure_[i];
          partial.value += value;
          if (conjugate_) {
            partial.step += static_cast<double>(step_[i]);
            partial.response += static_cast<double>(response[i]);
            partial.product += value * static_cast<double>(response[i]);
          }
        }
        return partial;
      });
  const double mean = sums.value / count;
  const double mean_step = sums.step / count;
  double beta = conjugate_ ? std::max((mean * sums.response - sums.product) / curvature_, 0.0) : 0.0;
  previous_descent_length_ = descent_length_;
  struct Target {
    double slope = 0.0;
    double square = 0.0;
    double max_change = 0.0;
    bool clipped = false;

    void add(const Target& other) {
      slope += other.slope;
      square += other.square;
      max_change = std::max(max_change, other.max_change);
      clipped |= other.clipped;
    }
  };
  const auto compute_target = [&] {
    const double length = steepest_descent_ ? descent_length_ : step_length_;
    const Target all = sum_chunks<Target>(size, free_points_per_task, pool, [&](std::size_t first, std::size_t last) {
      Target partial;
      for (std::size_t k = first; k < last; ++k) {
        const std::size_t i = point(free_points_, k);
        const auto residual = static_cast<double>(residual_[i]);
        double direction = preconditioned_[k] - mean;
        if (beta > 0.0) {
          direction += beta * (static_cast<double>(step_[i]) - mean_step);
        }
        partial.slope += direction * residual;
        partial.square += residual * residual;
        partial.max_change = std::max(partial.max_change, std::abs(length * direction));
        target_[k] = pressure_[i] + length * direction;
        partial.clipped |= (target_[k] < 0.0) | (target_[k] > free_bounds_[k]);
      }
      return partial;
    });
    clipped_ = all.clipped;
    if (!steepest_descent_ && all.slope > 0.0 && all.square > 0.0) {
      descent_length_ = step_length_ * all.slope / all.square;
    }
    return all;
  };
  Target target = compute_target();
  if (!(target.slope > 0.0) && beta > 0.0) {
    beta = 0.0;
    target = compute_target();
  }
  if (sums.load > 0.0 && target.max_change > max_change_ratio * sums.load) {
    (steepest_descent_ ? descent_length_ : step_length_) *= max_change_ratio * sums.load / target.max_change;
    compute_target();
  }
  conjugate_ = beta > 0.0;
  const double shift = shift_to_sum(target_, free_bounds_, sums.load, pool);
  pool.run_chunks(stepped_points_.size(), free_points_per_task, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      step_[point(stepped_points_, k)] = 0.0F;
    }
  });
  stepped_points_ = free_points_;
  pool.run_chunks(size, free_points_per_task, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      const std::size_t i = point(free_points_, k);
      target_[k] = std::clamp(target_[k] - shift, 0.0, free_bounds_[k]);
      step_[i] = static_cast<float>(target_[k] - pressure_[i]);
    }
  });
  return step_;
}

double ProjectedCgSolver::max_feasible_fraction() const {
  double fraction = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < stepped_points_.size(); ++k) {
    const std::size_t i = point(stepped_points_, k);
    const auto change = static_cast<double>(step_[i]);
    const double limit = change < 0.0 ? pressure_[i] : free_bounds_[k] - pressure_[i];
    fraction = change == 0.0 ? fraction : std::min(fraction, limit / std::abs(change));
  }
  return fraction;
}

bool ProjectedCgSolver::advance(std::span<const float> response, const ThreadPool& pool) {
  check(response);
  struct Energy {
    double descent = 0.0;
    double curvature = 0.0;

    void add(const Energy& other) {
      descent += other.descent;
      curvature += other.curvature;
    }
  };
  const Energy energy =
      sum_chunks<Energy>(stepped_points_.size(), free_points_per_task, pool, [&](std::size_t first, std::size_t last) {
        Energy partial;
        for (std::size_t k = first; k < last; ++k) {
          const std::size_t i = point(stepped_points_, k);
          const auto change = static_cast<double>(step_[i]);
          partial.descent += change * (mean_potential_ - potential_[i]);
          partial.curvature += change * static_cast<double>(response[i]);
        }
        return partial;
      });
  const double optimum = energy.descent / energy.curvature;
  if (!(energy.descent > 0.0) || !(energy.curvature > 0.0) || !std::isfinite(optimum)) {
    (steepest_descent_ ? descent_length_ : step_length_) *= failure_factor;
    if (!conjugate_ && !steepest_descent_) {
      steepest_descent_ = true;
      descent_length_ = previous_descent_length_;
      failed_steps_ = std::min(failed_steps_ + 1, max_failed_steps);
      descent_steps_left_ = 1 << failed_steps_;
    }
    conjugate_ = false;
    return false;
  }
  // A full step whose pressures are clipped at bounds is accepted if the energy decreases.
  // A shortened step would leave pressure at points at which the full step removes all pressure.
  const double fraction = clipped_
                              ? (optimum >= min_length_factor ? 1.0 : optimum)
                              : (optimum <= 1.0 ? optimum : std::min(optimum, std::max(max_feasible_fraction(), 1.0)));
  pool.run_chunks(stepped_points_.size(), free_points_per_task, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      const std::size_t i = point(stepped_points_, k);
      pressure_[i] = fraction == 1.0
                         ? target_[k]
                         : std::clamp(pressure_[i] + fraction * static_cast<double>(step_[i]), 0.0, free_bounds_[k]);
    }
  });
  pending_response_ = response;
  pending_fraction_ = fraction;
  if (steepest_descent_) {
    descent_length_ *= std::clamp(optimum, min_length_factor, max_recovery_factor);
    steepest_descent_ = --descent_steps_left_ > 0;
  } else {
    step_length_ *= std::clamp(optimum, min_length_factor, failed_steps_ > 0 ? max_recovery_factor : max_length_factor);
    failed_steps_ = conjugate_ ? failed_steps_ : 0;
  }
  curvature_ = energy.curvature;
  conjugate_ = true;
  return true;
}

double ProjectedCgSolver::pressure_dot_potential() const {
  return std::inner_product(pressure_.begin(), pressure_.end(), potential_.begin(), 0.0);
}

void ProjectedCgSolver::restart(std::vector<double> potential) {
  if (potential.size() != pressure_.size()) {
    throw std::invalid_argument("ProjectedCgSolver: potential must have as many points as the pressure");
  }
  potential_ = std::move(potential);
  pending_fraction_ = 0.0;
  conjugate_ = false;
}

}  // namespace stiction
