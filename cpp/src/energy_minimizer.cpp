#include "stiction/energy_minimizer.hpp"

#include "multiversion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace stiction {
namespace {

// Largest change of a small gap per step, divided by the attraction range. Larger steps may skip equilibria.
constexpr double max_change_of_small_gap = 2.0;
constexpr double small_gap = 5.0;  // as a multiple of the attraction range
// The line search neglects the attraction at gaps that exceed this multiple of the attraction range.
constexpr double negligible_attraction_gap = 30.0;
// A line search first tries this fraction of a full step, and doubles the trial step until the energy increases.
constexpr double initial_step_fraction = 0.125;
// The line search ends when the energy's slope along the direction falls below this fraction of its initial value.
constexpr double max_slope_ratio = 0.05;
constexpr double max_step_length = 1e4;
constexpr int max_line_search_steps = 12;
constexpr double min_step_bracket_fraction = 0.02;  // smallest distance of a trial step from the ends of its bracket
// The net pressure is recomputed after this number of steps, before its single-precision changes add much round-off.
constexpr std::int64_t steps_per_recomputation = 20;
constexpr std::int64_t max_failed_descents = 3;
// The size of a task is constant, so that the round-off of sums does not depend on the number of threads.
constexpr std::size_t extended_values_per_task = std::size_t{1} << 15;
constexpr std::size_t stress_lanes = 16;  // number of partial sums, for vectorisation by the compiler

using Lanes = std::array<double, stress_lanes>;

double total(const Lanes& values) {
  double sum = 0.0;
  for (const double value : values) {
    sum += value;
  }
  return sum;
}

// `lane` selects a partial sum.
template <class Visit>
STICTION_INLINE void for_lanes(std::size_t size, const Visit& visit) {
  std::size_t i = 0;
  for (; i + stress_lanes <= size; i += stress_lanes) {
    for (std::size_t lane = 0; lane < stress_lanes; ++lane) {
      visit(i + lane, lane);
    }
  }
  for (std::size_t lane = 0; i + lane < size; ++lane) {
    visit(i + lane, lane);
  }
}

STICTION_MULTIVERSION
double copy_residual(const double* net_pressure, std::size_t size, float* __restrict residual) {
  Lanes sums{};
  for_lanes(size, [&](std::size_t i, std::size_t lane) {
    residual[i] = static_cast<float>(net_pressure[i]);
    sums[lane] += std::abs(net_pressure[i]);
  });
  return total(sums);
}

struct ResidualSums {
  double absolute_residual = 0.0;
  double pressure = 0.0;
  double attraction = 0.0;
  double net_pressure = 0.0;  // sum of the net pressures over the original grid

  void add(const ResidualSums& other) {
    absolute_residual += other.absolute_residual;
    pressure += other.pressure;
    attraction += other.attraction;
    net_pressure += other.net_pressure;
  }
};

// `sum` is the sum of the net pressure and the attraction [GPa] at a point.
STICTION_INLINE double contact_pressure(double gap, double sum, double hardness) {
  const double clipped = std::min(std::max(sum, 0.0), hardness);
  const double closed = gap < 0.0 ? hardness : clipped;
  return gap > 0.0 ? 0.0 : closed;
}

// Compute the residual (net pressure) + (attraction) - (contact pressure) [GPa] at each point of a row.
STICTION_MULTIVERSION
ResidualSums subtract_stresses(const double* net_pressure, const double* gap, const double* attraction, double hardness,
                               std::size_t size, float* __restrict residual) {
  Lanes residuals{};
  Lanes pressures{};
  Lanes attractions{};
  Lanes net_pressures{};
  for_lanes(size, [&](std::size_t i, std::size_t lane) {
    const double sum = net_pressure[i] + attraction[i];
    const double pressure = contact_pressure(gap[i], sum, hardness);
    residual[i] = static_cast<float>(sum - pressure);
    residuals[lane] += std::abs(sum - pressure);
    pressures[lane] += pressure;
    attractions[lane] += attraction[i];
    net_pressures[lane] += net_pressure[i];
  });
  return {total(residuals), total(pressures), total(attractions), total(net_pressures)};
}

struct Products {
  double first = 0.0;
  double second = 0.0;

  void add(const Products& other) {
    first += other.first;
    second += other.second;
  }
};

STICTION_MULTIVERSION
Products products(const float* values, const float* first, const float* second, std::size_t size) {
  Lanes firsts{};
  Lanes seconds{};
  for_lanes(size, [&](std::size_t i, std::size_t lane) {
    firsts[lane] += static_cast<double>(values[i]) * static_cast<double>(first[i]);
    seconds[lane] += static_cast<double>(values[i]) * static_cast<double>(second[i]);
  });
  return {total(firsts), total(seconds)};
}

STICTION_MULTIVERSION
Products products(const float* values, const double* first, const float* second, std::size_t size) {
  Lanes firsts{};
  Lanes seconds{};
  for_lanes(size, [&](std::size_t i, std::size_t lane) {
    firsts[lane] += static_cast<double>(values[i]) * first[i];
    seconds[lane] += static_cast<double>(values[i]) * static_cast<double>(second[i]);
  });
  return {total(firsts), total(seconds)};
}

STICTION_MULTIVERSION
void negate(float* values, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) {
    values[i] = -values[i];
  }
}

STICTION_MULTIVERSION
void fix_contacts(const double* gap, const float* residual, std::size_t size, float* __restrict changes) {
  for (std::size_t i = 0; i < size; ++i) {
    const bool stays = (gap[i] == 0.0) & (residual[i] == 0.0F);
    changes[i] = stays ? 0.0F : changes[i];
  }
}

// Returns the scalar product of the updated `direction` and `residual`.
STICTION_MULTIVERSION
double add_direction(const float* descent, const float* residual, float factor, std::size_t size,
                     float* __restrict direction) {
  Lanes sums{};
  for_lanes(size, [&](std::size_t i, std::size_t lane) {
    direction[i] = descent[i] + factor * direction[i];
    sums[lane] += static_cast<double>(direction[i]) * static_cast<double>(residual[i]);
  });
  return total(sums);
}

struct Edges {
  double slope = 0.0;
  double max_change = 0.0;

  void add(const Edges& other) {
    slope += other.slope;
    max_change = std::max(max_change, other.max_change);
  }
};

// Returns the scalar product of the gap changes and the residual, and the largest |change| of a gap that is small.
STICTION_MULTIVERSION
Edges fix_edges(const double* gap, const float* residual, double largest_small_gap, float approach, std::size_t size,
                float* __restrict direction, float* __restrict displacement_change) {
  Lanes slopes{};
  std::array<float, stress_lanes> largest{};
  for_lanes(size, [&](std::size_t i, std::size_t lane) {
    const bool stays = (gap[i] == 0.0) & (direction[i] * residual[i] > 0.0F);
    const float change = stays ? 0.0F : direction[i];
    direction[i] = change;
    displacement_change[i] = change + approach;
    slopes[lane] += static_cast<double>(change) * static_cast<double>(residual[i]);
    largest[lane] = std::max(largest[lane], std::abs(gap[i]) < largest_small_gap ? std::abs(change) : 0.0F);
  });
  return {total(slopes), static_cast<double>(*std::max_element(largest.begin(), largest.end()))};
}

STICTION_MULTIVERSION
void add_multiple(const float* values, double factor, std::size_t size, double* __restrict sums) {
  for (std::size_t i = 0; i < size; ++i) {
    sums[i] += factor * static_cast<double>(values[i]);
  }
}

// If a gap would change its sign, it becomes 0, and `remainder` stores the overshoot. Returns whether any gap closed.
STICTION_MULTIVERSION
bool change_gaps(const float* direction, double step, bool yields, std::size_t size, double* __restrict gap,
                 float* __restrict remainder) {
  std::array<float, stress_lanes> largest{};
  for_lanes(size, [&](std::size_t i, std::size_t lane) {
    const double changed = gap[i] + step * static_cast<double>(direction[i]);
    const bool closes = yields ? gap[i] * changed < 0.0 : changed < 0.0;
    gap[i] = closes ? 0.0 : changed;
    remainder[i] = closes ? static_cast<float>(-changed) : 0.0F;
    largest[lane] = std::max(largest[lane], std::abs(remainder[i]));
  });
  return *std::max_element(largest.begin(), largest.end()) > 0.0F;
}

// Return the first root of `function`, which must be negative at 0, or `max_argument` if no root lies below it.
template <class Function>
double find_first_root(const Function& function, double value_at_zero, double max_argument) {
  double left = 0.0;
  double left_value = value_at_zero;
  double right = initial_step_fraction * std::min(1.0, max_argument);
  double right_value = function(right);
  while (right_value <= 0.0) {
    if (right >= max_argument) {
      return max_argument;
    }
    left = right;
    left_value = right_value;
    right = std::min(2 * right, max_argument);
    right_value = function(right);
  }
  double root = right;
  for (int count = 0; count < max_line_search_steps; ++count) {
    const double width = right - left;
    root = right - right_value * width / (right_value - left_value);
    root = std::clamp(root, left + min_step_bracket_fraction * width, right - min_step_bracket_fraction * width);
    const double value = function(root);
    if (std::abs(value) <= max_slope_ratio * std::abs(value_at_zero)) {
      break;
    }
    (value > 0.0 ? right : left) = root;
    (value > 0.0 ? right_value : left_value) = value;
  }
  return root;
}

struct Sum {
  double value = 0.0;
  void add(const Sum& other) { value += other.value; }
};

}  // namespace

// Residual relative to the stresses, mean attraction [GPa], and error of the total load as a mean pressure [GPa].
struct EnergyMinimizer::Residual {
  double relative = 0.0;
  double mean_attraction = 0.0;
  double approach = 0.0;
};

struct EnergyMinimizer::Direction {
  double slope = 0.0;
  double max_change = 0.0;
};

EnergyMinimizer::EnergyMinimizer(Values gap, const Grid& grid, double effective_modulus,
                                 const AdhesiveInterface& interface, const ThreadPool& pool)
    : gap_(gap), grid_(grid), interface_(interface), kernel_(grid, effective_modulus, pool) {
  if (gap.size() != grid.size()) {
    throw std::invalid_argument("EnergyMinimizer: gap must have one value for each grid point");
  }
  if (!(interface.range > 0.0) || !(interface.hardness > 0.0)) {
    throw std::invalid_argument("EnergyMinimizer: range and hardness must be above 0");
  }
  displacement_.assign(kernel_.size(), 0.0);
  residual_.resize(kernel_.size());
  descent_.resize(kernel_.size());
  displacement_change_.resize(kernel_.size());
  pressure_change_.resize(kernel_.size());
  if (!grid.periodic) {
    for (std::size_t i = 0; i < grid_.size(); ++i) {
      displacement_[on_extended_grid(i)] = 1.0;
    }
    kernel_.pressure(displacement_, displacement_, workspace_, pool);
    for (std::size_t i = 0; i < grid_.size(); ++i) {
      uniform_stiffness_ += displacement_[on_extended_grid(i)];
    }
  }
}

std::size_t EnergyMinimizer::on_extended_grid(std::size_t point) const {
  return point / grid_.columns * kernel_.columns() + point % grid_.columns;
}

// Return the sum of `work(first, size, gap_index)` over all rows, in an order that does not depend on the threads.
// A row has `size` gaps. Its first point is `first` on the extended grid, and `gap_index` on the original grid.
template <class Sums, class Work>
Sums EnergyMinimizer::sum_rows(const ThreadPool& pool, const Work& work) const {
  const std::size_t rows_per_task = std::max<std::size_t>(extended_values_per_task / kernel_.columns(), 1);
  std::vector<Sums> task_sums((kernel_.rows() + rows_per_task - 1) / rows_per_task);
  pool.run_chunks(kernel_.rows(), rows_per_task, [&](std::size_t first, std::size_t last) {
    Sums& sums = task_sums[first / rows_per_task];
    for (std::size_t row = first; row < last; ++row) {
      const bool is_inside = row < grid_.rows;
      sums.add(work(row * kernel_.columns(), is_inside ? grid_.columns : 0, is_inside ? row * grid_.columns : 0));
    }
  });
  Sums all = task_sums[0];
  for (std::size_t task = 1; task < task_sums.size(); ++task) {
    all.add(task_sums[task]);
  }
  return all;
}

void EnergyMinimizer::check(const MinimizationState& state) const {
  const std::size_t direction_size = state.direction.empty() ? 0 : kernel_.size();
  if (state.gap.size() != grid_.size() || state.net_pressure.size() != kernel_.size() ||
      state.direction.size() != direction_size || state.residual.size() != direction_size) {
    throw std::invalid_argument("EnergyMinimizer: the state must belong to the same grid");
  }
}

double EnergyMinimizer::attraction(double gap) const {
  return gap > 0.0 ? interface_.max_attraction * std::exp(-gap / interface_.range) : interface_.max_attraction;
}

MinimizationState EnergyMinimizer::start(Values pressure, Values attraction, double load, const ThreadPool& pool) {
  if (pressure.size() != grid_.size() || attraction.size() != grid_.size()) {
    throw std::invalid_argument("EnergyMinimizer: pressure and attraction must have one value for each grid point");
  }
  MinimizationState state;
  state.net_pressure.assign(kernel_.size(), 0.0);
  for (std::size_t i = 0; i < grid_.size(); ++i) {
    state.net_pressure[on_extended_grid(i)] = pressure[i] - attraction[i];
  }
  kernel_.displacement(state.net_pressure, displacement_, workspace_, pool);
  state.gap.resize(grid_.size());
  double elastic_sum = 0.0;
  double elastic_count = 0.0;
  double yielded_sum = 0.0;
  double yielded_count = 0.0;
  for (std::size_t i = 0; i < grid_.size(); ++i) {
    state.gap[i] = gap_[i] + displacement_[on_extended_grid(i)];
    if (pressure[i] > 0.0) {
      const bool is_elastic = pressure[i] < interface_.hardness;
      (is_elastic ? elastic_sum : yielded_sum) += state.gap[i];
      (is_elastic ? elastic_count : yielded_count) += 1.0;
    }
  }
  if (elastic_count > 0.0) {
    state.approach = elastic_sum / elastic_count;
  } else if (yielded_count > 0.0) {
    state.approach = yielded_sum / yielded_count;
  } else {
    state.approach = *std::min_element(state.gap.begin(), state.gap.end());
  }
  for (std::size_t i = 0; i < grid_.size(); ++i) {
    const double gap = state.gap[i] - state.approach;
    const double closed_gap = pressure[i] < interface_.hardness ? 0.0 : std::min(gap, 0.0);
    state.gap[i] = pressure[i] > 0.0 ? closed_gap : std::max(gap, 0.0);
  }
  recompute_net_pressure(state, load, pool);
  return state;
}

MinimizationOutcome EnergyMinimizer::step(MinimizationState& state, double load, const MinimizationLimits& limits,
                                          const ThreadPool& pool) {
  check(state);
  const Residual residual = compute_residual(state, load, pool);
  if (load + residual.mean_attraction < limits.min_contact_load) {
    return MinimizationOutcome::separated;
  }
  const bool is_balanced = residual.relative <= limits.max_residual;
  if ((is_balanced || state.num_failed_descents > max_failed_descents) && state.recomputation_number == state.number) {
    return residual.relative <= limits.max_accepted_residual ? MinimizationOutcome::balanced
                                                             : MinimizationOutcome::stalled;
  }
  ++state.number;
  if (is_balanced || state.num_failed_descents > max_failed_descents) {
    recompute_net_pressure(state, load, pool);
    return MinimizationOutcome::unfinished;
  }
  const double slope = compute_conjugate_direction(state, residual.approach, pool);
  Direction direction = fix_contact_points(state, pool);
  direction.slope += state.approach_direction * residual.approach;
  if (direction.slope < 0.0) {
    state.num_failed_descents = 0;
    state.slope = slope;
    state.approach_residual = residual.approach;
    state.residual.resize(kernel_.size());
    state.residual.swap(residual_);
    change_state(state, find_step_length(state, direction, load, pool), load, pool);
    return MinimizationOutcome::unfinished;
  }
  ++state.num_failed_descents;
  state.direction.clear();
  state.residual.clear();
  recompute_net_pressure(state, load, pool);
  return MinimizationOutcome::unfinished;
}

EnergyMinimizer::Residual EnergyMinimizer::compute_residual(const MinimizationState& state, double load,
                                                            const ThreadPool& pool) {
  const auto sums = sum_rows<ResidualSums>(pool, [&](std::size_t first, std::size_t size, std::size_t gap_index) {
    std::vector<double> attractions(size);
    const double* gap = state.gap.data() + gap_index;
    std::transform(gap, gap + size, attractions.begin(), [this](double value) { return attraction(value); });
    ResidualSums row_sums = subtract_stresses(&state.net_pressure[first], gap, attractions.data(), interface_.hardness,
                                              size, &residual_[first]);
    row_sums.absolute_residual += copy_residual(state.net_pressure.data() + first + size, kernel_.columns() - size,
                                                residual_.data() + first + size);
    return row_sums;
  });
  const auto points = static_cast<double>(grid_.size());
  Residual residual;
  residual.approach = grid_.periodic ? 0.0 : sums.net_pressure - load * points;
  residual.mean_attraction = sums.attraction / points;
  residual.relative = (sums.absolute_residual + std::abs(residual.approach)) / (sums.pressure + sums.attraction);
  return residual;
}

// The new search direction is conjugate to the previous one, unless a step along it would increase the energy.
// Returns the scalar product of the residual and the preconditioned residual.
double EnergyMinimizer::compute_conjugate_direction(MinimizationState& state, double approach_residual,
                                                    const ThreadPool& pool) {
  kernel_.precondition(residual_, descent_, workspace_, pool);
  const bool has_last_direction = !state.direction.empty() && state.slope != 0.0;
  const auto sums = sum_rows<Products>(pool, [&](std::size_t first, std::size_t size, std::size_t gap_index) {
    negate(&descent_[first], kernel_.columns());
    fix_contacts(state.gap.data() + gap_index, &residual_[first], size, &descent_[first]);
    return products(&descent_[first], &residual_[first],
                    has_last_direction ? &state.residual[first] : &residual_[first], kernel_.columns());
  });
  const double approach_descent = uniform_stiffness_ > 0.0 ? -approach_residual / uniform_stiffness_ : 0.0;
  const double slope = sums.first + approach_descent * approach_residual;
  if (has_last_direction) {
    const double change = slope - sums.second - approach_descent * state.approach_residual;
    const double factor = std::max(change / state.slope, 0.0);
    const auto sum = sum_rows<Sum>(pool, [&](std::size_t first, std::size_t size, std::size_t gap_index) {
      fix_contacts(state.gap.data() + gap_index, &residual_[first], size, &state.direction[first]);
      return Sum{add_direction(&descent_[first], &residual_[first], static_cast<float>(factor), kernel_.columns(),
                               &state.direction[first])};
    });
    state.approach_direction = approach_descent + factor * state.approach_direction;
    if (sum.value + state.approach_direction * approach_residual < 0.0) {
      return slope;
    }
  }
  state.direction = descent_;
  state.approach_direction = approach_descent;
  return slope;
}

// A gap of 0 stays 0 if the residual at its point has the same sign as the gap's change along the direction.
EnergyMinimizer::Direction EnergyMinimizer::fix_contact_points(MinimizationState& state, const ThreadPool& pool) {
  const auto edges = sum_rows<Edges>(pool, [&](std::size_t first, std::size_t size, std::size_t gap_index) {
    Edges row = fix_edges(state.gap.data() + gap_index, &residual_[first], small_gap * interface_.range,
                          static_cast<float>(state.approach_direction), size, &state.direction[first],
                          &displacement_change_[first]);
    const std::size_t rest = kernel_.columns() - size;
    const float* direction = state.direction.data() + first + size;
    std::copy_n(direction, rest, displacement_change_.data() + first + size);
    const float* residual = residual_.data() + first + size;
    row.slope += products(direction, residual, residual, rest).first;
    return row;
  });
  return {edges.slope, edges.max_change};
}

double EnergyMinimizer::find_step_length(const MinimizationState& state, const Direction& direction, double load,
                                         const ThreadPool& pool) {
  kernel_.pressure(displacement_change_, pressure_change_, workspace_, pool);
  const auto sums = sum_rows<Products>(pool, [&](std::size_t first, std::size_t, std::size_t) {
    return products(&displacement_change_[first], &state.net_pressure[first], &pressure_change_[first],
                    kernel_.columns());
  });
  const double total_load = grid_.periodic ? 0.0 : load * static_cast<double>(grid_.size());
  const double elastic_slope = sums.first - total_load * state.approach_direction;
  const double curvature = sums.second;
  attracted_gaps_.clear();
  attracted_gap_changes_.clear();
  for (std::size_t row = 0; row < grid_.rows; ++row) {
    const float* changes = &state.direction[row * kernel_.columns()];
    const double* gaps = &state.gap[row * grid_.columns];
    for (std::size_t column = 0; column < grid_.columns; ++column) {
      if (changes[column] != 0.0F && gaps[column] < negligible_attraction_gap * interface_.range) {
        attracted_gaps_.push_back(gaps[column]);
        attracted_gap_changes_.push_back(static_cast<double>(changes[column]));
      }
    }
  }
  const bool yields = std::isfinite(interface_.hardness);
  const auto energy_slope = [&](double step) {
    double sum = 0.0;
    for (std::size_t i = 0; i < attracted_gaps_.size(); ++i) {
      const double gap = attracted_gaps_[i];
      const double new_gap = gap + step * attracted_gap_changes_[i];
      double stress = attraction(new_gap);
      if (yields) {
        stress -= new_gap < 0.0 && gap <= 0.0 ? interface_.hardness : 0.0;
        stress = gap * new_gap < 0.0 ? 0.0 : stress;  // the step ends at a gap of 0
      }
      sum += stress * attracted_gap_changes_[i];
    }
    return elastic_slope + step * curvature + sum;
  };
  const double max_step =
      direction.max_change > 0.0
          ? std::min(max_change_of_small_gap * interface_.range / direction.max_change, max_step_length)
          : max_step_length;
  return find_first_root(energy_slope, direction.slope, max_step);
}

void EnergyMinimizer::change_state(MinimizationState& state, double step, double load, const ThreadPool& pool) {
  struct Closures {
    bool any = false;
    void add(const Closures& other) { any |= other.any; }
  };
  const auto closures = sum_rows<Closures>(pool, [&](std::size_t first, std::size_t size, std::size_t gap_index) {
    add_multiple(&pressure_change_[first], step, kernel_.columns(), &state.net_pressure[first]);
    const bool closes = change_gaps(&state.direction[first], step, std::isfinite(interface_.hardness), size,
                                    state.gap.data() + gap_index, &displacement_change_[first]);
    std::fill_n(displacement_change_.data() + first + size, kernel_.columns() - size, 0.0F);
    return Closures{closes};
  });
  state.approach += step * state.approach_direction;
  if (state.number % steps_per_recomputation == 0) {
    recompute_net_pressure(state, load, pool);
  } else if (closures.any) {
    kernel_.pressure(displacement_change_, pressure_change_, workspace_, pool);
    sum_rows<Closures>(pool, [&](std::size_t first, std::size_t, std::size_t) {
      add_multiple(&pressure_change_[first], 1.0, kernel_.columns(), &state.net_pressure[first]);
      return Closures{};
    });
  }
}

// On free grids, the displacements of points around the original grid are first computed from the stored net pressure.
void EnergyMinimizer::recompute_net_pressure(MinimizationState& state, double load, const ThreadPool& pool) {
  if (!grid_.periodic) {
    kernel_.displacement(state.net_pressure, displacement_, workspace_, pool);
  }
  for (std::size_t i = 0; i < grid_.size(); ++i) {
    displacement_[on_extended_grid(i)] = state.gap[i] - gap_[i] + state.approach;
  }
  kernel_.pressure(displacement_, state.net_pressure, workspace_, pool);
  if (grid_.periodic) {
    for (double& value : state.net_pressure) {
      value += load;
    }
  }
  state.recomputation_number = state.number;
}

AdhesiveStresses EnergyMinimizer::stresses(const MinimizationState& state) const {
  check(state);
  AdhesiveStresses result;
  result.pressure.resize(grid_.size());
  result.attraction.resize(grid_.size());
  for (std::size_t i = 0; i < grid_.size(); ++i) {
    result.attraction[i] = attraction(state.gap[i]);
    result.pressure[i] = contact_pressure(state.gap[i], state.net_pressure[on_extended_grid(i)] + result.attraction[i],
                                          interface_.hardness);
  }
  return result;
}

}  // namespace stiction
