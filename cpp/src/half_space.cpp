#include "stiction/half_space.hpp"

#include "multiversion.hpp"
#include "stiction/near_inverse.hpp"
#include "stiction/pressure_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace stiction {
namespace {

// Points along an axis of the coarsest grid.
constexpr std::size_t fewest_points = 16;
// Points of a grid whose kernels are kept when nobody uses them.
constexpr std::size_t most_kept = std::size_t{1} << 20;
// Tolerance on coarser grids, whose own distance from the finest is larger.
constexpr double coarse_tolerance = 3e-3;
// Ratio of loads up to which an area's pressure at one is a good start at the other.
constexpr double near_load = 1.3;
// Iterations on the finest grid, where a hundred are many, and on coarser ones, whose solutions are only starts.
constexpr std::int64_t most_iterations = 2000;
constexpr std::int64_t most_coarse_iterations = 100;
// Evaluations in double precision before a solution is given up: round-off is the reason.
constexpr int most_certificates = 20;
// Deviation of displacements that should be equal, relative to the compliance, which is then right to 1e-7.
constexpr double compliance_tolerance = 1e-3;
// Share of that where only differences of displacements count, which no energy makes better.
constexpr double of_differences = 0.03;
// Points up to which their own matrix is solved, which transforms of the grid take longer than.
constexpr std::size_t most_among = 1024;
// Deviation of displacements, in those of a cell, below which they are those of an even load: round-off.
constexpr double even = 1e-9;
// Loads tried for one approach, where six are many; the ratio of two of them one after the other; and the least part of
// the way between two loads at which another one is tried.
constexpr int most_loads = 60;
constexpr double farthest_load = 30.0;
constexpr double least_part = 1e-3;

std::size_t halved(std::size_t points, bool periodic) {
  if (points < 2 * fewest_points) {
    return points;
  }
  const std::size_t half = (points + 1) / 2;
  return points % 2 == 0 || !periodic ? half : fast_length(half);
}

// How many points of a grid lie on one step of a coarser one; of free grids the next one has every second.
double step_between(std::size_t points, std::size_t coarser, bool periodic) {
  if (points == coarser) {
    return 1.0;
  }
  return periodic ? static_cast<double>(points) / static_cast<double>(coarser) : 2.0;
}

// Σ (value - about)^Exponent; in as many sums as make it fast.
template <int Exponent>
STICTION_INLINE double powers_about(const double* values, std::size_t size, double about) {
  std::array<double, 8> sums{};
  for (std::size_t i = 0; i < size; ++i) {
    const double away = values[i] - about;
    sums[i % sums.size()] += Exponent == 1 ? away : away * away;
  }
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

STICTION_MULTIVERSION
double sum_of(const double* values, std::size_t size) { return powers_about<1>(values, size, 0.0); }

STICTION_MULTIVERSION
double squares_about(const double* values, std::size_t size, double about) {
  return powers_about<2>(values, size, about);
}

double mean_of(Values values) { return sum_of(values.data(), values.size()) / static_cast<double>(values.size()); }

double deviation_of(Values values) {
  return std::sqrt(squares_about(values.data(), values.size(), mean_of(values)) / static_cast<double>(values.size()));
}

// Values along one axis, or whole rows of `width` of them, on a grid of as many points over the same length: straight
// lines between those that are there.
std::vector<double> resampled_along(Values values, std::size_t blocks, std::size_t have, std::size_t want,
                                    std::size_t width, bool periodic) {
  std::vector<double> result(blocks * want * width);
  const double ratio = static_cast<double>(have) / static_cast<double>(want);
  const bool coarser = have == 2 * want || (!periodic && have > want);
  const bool finer = want == 2 * have || (!periodic && want > have);
  for (std::size_t block = 0; block < blocks; ++block) {
    const double* from = values.data() + block * have * width;
    double* to = result.data() + block * want * width;
    if (width == 1 && finer) {  // most of the points of all grids
      for (std::size_t i = 0; i + 1 < have; ++i) {
        to[2 * i] = from[i];
        to[2 * i + 1] = from[i] + 0.5 * (from[i + 1] - from[i]);
      }
      to[2 * have - 2] = from[have - 1];
      if (want == 2 * have) {
        to[want - 1] = from[have - 1] + 0.5 * ((periodic ? from[0] : from[have - 1]) - from[have - 1]);
      }
      continue;
    }
    for (std::size_t i = 0; i < want; ++i, to += width) {
      std::size_t left = 2 * i;
      double part = 0.0;
      if (finer) {
        left = i / 2;
        part = i % 2 == 0 ? 0.0 : 0.5;
      } else if (!coarser) {
        const double place = static_cast<double>(i) * ratio;
        left = std::min(static_cast<std::size_t>(place), have - 1);
        part = place - static_cast<double>(left);
      }
      const std::size_t right = left + 1 < have ? left + 1 : (periodic ? 0 : left);
      for (std::size_t k = 0; k < width; ++k) {
        const double one = from[left * width + k];
        to[k] = part == 0.0 ? one : one + part * (from[right * width + k] - one);
      }
    }
  }
  return result;
}

std::vector<double> resampled(std::vector<double> values, const Grid& from, const Grid& to) {
  if (from.rows != to.rows) {
    values = resampled_along(values, 1, from.rows, to.rows, from.columns, from.periodic);
  }
  if (from.columns != to.columns) {
    values = resampled_along(values, to.rows, from.columns, to.columns, 1, from.periodic);
  }
  return values;
}

// A search and the kernel that it asks, begun from a pressure that is brought to a mean [GPa].
class Descent {
 public:
  Descent(const HalfSpaceGrids::Kernels& kernels, std::vector<double> start, double mean, Values bound,
          Workspace& workspace, const Crew& crew)
      : kernel_(*kernels.points),
        workspace_(workspace),
        crew_(crew),
        search_(std::move(start), mean * static_cast<double>(kernel_.grid().size()), bound, kernel_.grid().line),
        response_(kernel_.grid().size()) {
    if (kernels.blocks) {
      inverse_.emplace(kernel_.grid(), kernel_.stencil(), *kernels.blocks);
    }
  }

  PressureSearch& search() { return search_; }
  double balance() { return search_.balance(crew_); }

  // The potential; in single precision where it is certified later, or needs not be exact.
  void renew(Values gap, bool exact) {
    const Values pressure = search_.pressure();
    std::vector<double> potential = search_.take_potential();
    potential.resize(pressure.size());
    if (exact) {
      kernel_.displacement(pressure, potential, workspace_, crew_);
      std::transform(potential.begin(), potential.end(), gap.begin(), potential.begin(), std::plus<>());
    } else {
      const std::vector<float> single(pressure.begin(), pressure.end());
      kernel_.displacement(single, response_, workspace_, crew_);
      std::transform(response_.begin(), response_.end(), gap.begin(), potential.begin(), std::plus<>());
    }
    search_.restart(std::move(potential));
    responded_ = false;
  }

  // One step, after a balance.
  void iterate() {
    std::span<const float> residual = search_.residual(crew_);
    if (!search_.plain()) {
      if (inverse_) {
        residual = (*inverse_)(search_.free(), residual, workspace_, crew_);
      } else {
        preconditioned_.resize(response_.size());
        kernel_.stiffened(residual, preconditioned_, workspace_, crew_);
        residual = preconditioned_;
      }
    }
    const auto before = responded_ ? std::span<const float>(response_) : std::span<const float>();
    kernel_.displacement(search_.step(residual, before, crew_), response_, workspace_, crew_);
    responded_ = search_.advance(response_, crew_);
  }

 private:
  const ElasticKernel& kernel_;
  Workspace& workspace_;
  const Crew& crew_;
  PressureSearch search_;
  std::vector<float> response_;
  std::vector<float> preconditioned_;   // of lines
  std::optional<NearInverse> inverse_;  // of areas
  bool responded_ = false;
};

// The logarithm of an approach over the one wanted, less that of what is left to the one at which all points touch.
double excess_of(double approach, double wanted, double full) {
  if (approach >= full) {
    return std::numeric_limits<double>::infinity();
  }
  const double left = std::isinf(full) ? 0.0 : std::log((full - approach) / (full - wanted));
  return std::log(approach / wanted) - left;
}

STICTION_MULTIVERSION
double product(const double* left, const double* right, std::size_t size) {
  std::array<double, 8> sums{};
  std::size_t i = 0;
  for (; i + sums.size() <= size; i += sums.size()) {
    for (std::size_t lane = 0; lane < sums.size(); ++lane) {
      sums[lane] += left[i + lane] * right[i + lane];
    }
  }
  for (; i < size; ++i) {
    sums[0] += left[i] * right[i];
  }
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

// Pressures of some points under which each of them moves by 1, by conjugate gradients with their matrix; none where
// one is below 0, as round-off of contacts that are single points has it.
std::vector<double> under_one_displacement(Values influence, const Grid& grid, const std::vector<std::size_t>& points,
                                           const Crew& crew) {
  const std::size_t size = points.size();
  std::vector<double> matrix(size * size);
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      const auto away = [](std::size_t one, std::size_t other) { return one > other ? one - other : other - one; };
      const std::size_t rows = away(points[i] / grid.columns, points[j] / grid.columns);
      const std::size_t columns = away(points[i] % grid.columns, points[j] % grid.columns);
      matrix[i * size + j] = matrix[j * size + i] = influence[rows * grid.columns + columns];
    }
  }
  std::vector<double> pressure(size, 0.0);
  std::vector<double> residual(size, 1.0);
  std::vector<double> direction = residual;
  std::vector<double> response(size);
  auto square = static_cast<double>(size);
  const double enough = square * std::pow(compliance_tolerance, 3.0);
  for (std::size_t count = 0; count < 10 * size && square > enough; ++count) {
    crew.check();
    for (std::size_t i = 0; i < size; ++i) {
      response[i] = product(&matrix[i * size], direction.data(), size);
    }
    const double length = square / product(direction.data(), response.data(), size);
    for (std::size_t i = 0; i < size; ++i) {
      pressure[i] += length * direction[i];
      residual[i] -= length * response[i];
    }
    const double before = std::exchange(square, product(residual.data(), residual.data(), size));
    for (std::size_t i = 0; i < size; ++i) {
      direction[i] = residual[i] + square / before * direction[i];
    }
  }
  const bool presses = std::all_of(pressure.begin(), pressure.end(), [](double one) { return one >= 0.0; });
  return presses ? pressure : std::vector<double>();
}

}  // namespace

HalfSpaceGrids::HalfSpaceGrids(const Grid& finest, double effective_modulus)
    : levels_{finest}, effective_modulus_(effective_modulus) {
  while (true) {
    Grid grid = levels_.back();
    const std::size_t rows = grid.line ? 1 : halved(grid.rows, grid.periodic);
    const std::size_t columns = halved(grid.columns, grid.periodic);
    if (rows == grid.rows && columns == grid.columns) {
      break;
    }
    grid.spacing_y *= step_between(grid.rows, rows, grid.periodic);
    grid.spacing_x *= step_between(grid.columns, columns, grid.periodic);
    grid.rows = rows;
    grid.columns = columns;
    levels_.push_back(grid);
  }
  kernels_.resize(levels_.size());
}

HalfSpaceGrids::Kernels HalfSpaceGrids::kernels(std::size_t level, const Crew& crew) const {
  const std::lock_guard lock(mutex_);
  if (kernels_.at(level).points) {
    return kernels_[level];
  }
  const Grid& grid = levels_[level];
  Kernels kernels{std::make_shared<const ElasticKernel>(grid, effective_modulus_, crew), {}};
  if (!grid.line) {
    kernels.blocks = std::make_shared<const ElasticKernel>(NearInverse::blocks_of(grid), effective_modulus_, crew);
  }
  if (level == 0 || grid.size() <= most_kept) {
    kernels_[level] = kernels;
  }
  return kernels;
}

double HalfSpaceGrids::even_deviation() const {
  const std::lock_guard lock(mutex_);
  if (!even_deviation_) {
    even_deviation_ = stiction::even_deviation(levels_[0], effective_modulus_);
  }
  return *even_deviation_;
}

std::span<const double> HalfSpaceGrids::influence(const Crew& crew) const {
  const std::size_t size = levels_[0].size();
  if (size > most_kept) {
    return {};
  }
  const auto finest = kernels(0, crew).points;
  const std::lock_guard lock(mutex_);
  if (influence_.empty()) {
    std::vector<double> first(size, 0.0);
    first[0] = 1.0;
    std::vector<double> moved(size);
    Workspace workspace;
    finest->displacement(first, moved, workspace, crew);
    influence_ = std::move(moved);
  }
  return influence_;
}

HalfSpaceSolver::HalfSpaceSolver(Values gap, std::shared_ptr<const HalfSpaceGrids> grids, Values bound,
                                 double tolerance, const Crew& crew)
    : gap_(gap), grids_(std::move(grids)), bound_(bound.begin(), bound.end()), tolerance_(tolerance) {
  const std::vector<Grid>& levels = grids_->levels();
  if (gap.size() != levels[0].size() || (bound.size() != 1 && bound.size() != gap.size())) {
    throw std::invalid_argument("HalfSpaceSolver: gap must be on the grid, bound one for all points or one for each");
  }
  if (!(tolerance > 0.0)) {
    throw std::invalid_argument("HalfSpaceSolver: tolerance must be above 0");
  }
  // Bounds that differ from point to point cannot be told from those of a coarser grid.
  for (std::size_t level = 1; level < levels.size() && bound_.size() == 1; ++level) {
    const Values finer = this->gap(level - 1);
    coarse_gaps_.push_back(resampled({finer.begin(), finer.end()}, levels[level - 1], levels[level]));
  }
  heights_scale_ = deviation_of(gap);
  pressure_scale_ = displacement_of_load(crew);
}

// Root-mean-square deviation [µm/GPa] under an even pressure, or one in proportion to bounds of points.
double HalfSpaceSolver::displacement_of_load(const Crew& crew) const {
  const Grid& grid = grids_->levels()[0];
  const double of_a_cell =
      (grid.line ? grid.spacing_x : std::max(grid.spacing_x, grid.spacing_y)) / grids_->effective_modulus();
  if (bound_.size() > 1) {
    const double mean = mean_of(bound_);
    std::vector<double> load(bound_.size());
    std::transform(bound_.begin(), bound_.end(), load.begin(), [&](double bound) { return bound / mean; });
    std::vector<double> moved(load.size());
    Workspace workspace;
    grids_->kernels(0, crew).points->displacement(load, moved, workspace, crew);
    const double deviation = deviation_of(moved);
    if (!grid.periodic) {  // bounds under which all points of a flat move alike, to a tolerance
      return std::max(deviation, grids_->even_deviation());
    }
    return deviation > even * of_a_cell ? deviation : of_a_cell;
  }
  if (!grid.periodic) {
    return grids_->even_deviation();
  }
  return heights_scale_ == 0.0 ? of_a_cell : 0.0;
}

double HalfSpaceSolver::scale(double mean_pressure) const {
  return std::max(heights_scale_, pressure_scale_ * mean_pressure);
}

// Whether a solution at another load is the better start; on lines that of coarse grids is.
bool HalfSpaceSolver::is_near(Values near, double mean_pressure) const {
  if (near.empty()) {
    return false;
  }
  if (near.size() != gap_.size()) {
    throw std::invalid_argument("HalfSpaceSolver: near must be on the grid");
  }
  const double ratio = mean_pressure / mean_of(near);
  return bound_.size() > 1 || (!grids_->levels()[0].line && ratio >= 1 / near_load && ratio <= near_load);
}

HalfSpaceSolution HalfSpaceSolver::at(double mean_pressure, Values near, const Crew& crew,
                                      const HalfSpaceProgress& progress) const {
  Workspace workspace;
  if (is_near(near, mean_pressure)) {
    HalfSpaceSolution solution = finest({near.begin(), near.end()}, mean_pressure, workspace, crew, progress);
    if (solution.error <= tolerance_) {
      return solution;
    }
  }
  if (bound_.size() > 1) {
    return finest(bound_, mean_pressure, workspace, crew, progress);
  }
  const std::vector<Grid>& levels = grids_->levels();
  std::vector<double> start(levels.back().size(), mean_pressure);
  const double coarse = std::max(coarse_tolerance, tolerance_) * scale(mean_pressure);
  for (std::size_t level = levels.size() - 1; level > 0; --level) {
    start = on_level(level, std::move(start), mean_pressure, coarse, workspace, crew, {}).pressure;
    start = resampled(std::move(start), levels[level], levels[level - 1]);
  }
  return finest(std::move(start), mean_pressure, workspace, crew, progress);
}

// What is brought to 0 is the logarithm of approaches, by secants (Illinois) over that of the load; on periodic bodies,
// where all points touch at the mean gap, less that of what is left to it.
HalfSpaceSolution HalfSpaceSolver::at_approach(double approach, Values near, const Crew& crew,
                                               const HalfSpaceProgress& progress) const {
  const Grid& grid = grids_->levels()[0];
  const double full = grid.periodic ? mean_of(gap_) : std::numeric_limits<double>::infinity();
  // Two bodies as far apart as the grid is long, less than which any load is.
  const double along_x = grid.spacing_x * static_cast<double>(grid.columns);
  const double longest = grid.line ? along_x : std::max(along_x, grid.spacing_y * static_cast<double>(grid.rows));
  double pressure = near.empty() ? 0.1 * grids_->effective_modulus() * approach / longest : mean_of(near);
  struct End {
    double load;
    double excess;
  };
  std::array<std::optional<End>, 2> ends;  // below and above
  std::optional<bool> was_above;
  HalfSpaceSolution solution;
  double miss = 0.0;
  for (int count = 0; count < most_loads; ++count) {
    std::vector<double> before = std::move(solution.pressure);
    solution = at(pressure, count == 0 ? near : Values(before), crew, progress);
    miss = std::abs(solution.approach - approach) / scale(pressure);
    if (miss <= tolerance_ || !(solution.error <= tolerance_)) {
      break;
    }
    const double excess = excess_of(solution.approach, approach, full);
    const bool above = excess > 0.0;
    std::optional<End>& other = ends[above ? 0 : 1];
    if (was_above == above && other) {  // the other end has stayed twice
      other->excess *= 0.5;
    }
    ends[above ? 1 : 0] = End{std::log(pressure), excess};
    was_above = above;
    if (!other) {
      pressure *= std::exp(std::clamp(-2 * excess, -std::log(farthest_load), std::log(farthest_load)));
      continue;
    }
    const auto [left, below] = ends[0].value_or(End{});
    const auto [right, over] = ends[1].value_or(End{});
    const double part = std::isfinite(over) ? below / (below - over) : 0.5;
    pressure = std::exp(left + std::clamp(part, least_part, 1 - least_part) * (right - left));
  }
  solution.error = std::max(solution.error, miss);
  return solution;
}

HalfSpaceSolution HalfSpaceSolver::finest(std::vector<double> start, double mean_pressure, Workspace& workspace,
                                          const Crew& crew, const HalfSpaceProgress& progress) const {
  const double unit = scale(mean_pressure);
  HalfSpaceSolution solution =
      on_level(0, std::move(start), mean_pressure, tolerance_ * unit, workspace, crew, progress);
  solution.error = std::max(solution.error / unit, std::abs(mean_of(solution.pressure) / mean_pressure - 1.0));
  return solution;
}

HalfSpaceSolution HalfSpaceSolver::on_level(std::size_t level, std::vector<double> start, double mean_pressure,
                                            double tolerance, Workspace& workspace, const Crew& crew,
                                            const HalfSpaceProgress& progress) const {
  const auto kernels = grids_->kernels(level, crew);
  const double factor = mean_pressure / mean_of(start);
  for (double& pressure : start) {
    pressure *= factor;
  }
  Descent descent(kernels, std::move(start), mean_pressure, bound_, workspace, crew);
  descent.renew(gap(level), false);
  const std::int64_t most = level == 0 ? most_iterations : most_coarse_iterations;
  bool exact = false;
  int certificates = 0;
  double error = 0.0;
  std::int64_t iterations = 0;
  while (true) {
    error = descent.balance();
    if (error <= tolerance || !std::isfinite(error)) {
      if (++certificates > most_certificates || exact || level > 0) {
        break;
      }
      descent.search().settle();
      descent.renew(gap(level), true);
      exact = true;
      continue;
    }
    if (iterations == most) {
      break;
    }
    descent.iterate();
    exact = false;
    ++iterations;
    if (progress) {
      progress(iterations, error / (tolerance / tolerance_));
    }
  }
  const double approach = descent.search().approach();
  return {descent.search().take_pressure(), approach, error, iterations};
}

LinearAnswer linear_answer(const HalfSpaceGrids& grids, std::span<const bool> free, const Crew& crew) {
  const Grid& grid = grids.levels()[0];
  if (free.size() != grid.size()) {
    throw std::invalid_argument("linear_answer: free must be on the grid");
  }
  std::vector<std::size_t> points;
  for (std::size_t i = 0; i < free.size(); ++i) {
    if (free[i]) {
      points.push_back(i);
    }
  }
  if (points.empty()) {
    throw std::invalid_argument("linear_answer: there must be a free point");
  }
  // Pressures of free points are above 0 everywhere, as charges are on a conductor. An even start is as good as any
  // that the pressures at hand give: at the edges, where those vanish, these are highest.
  std::vector<double> start(free.size(), 0.0);
  for (const std::size_t i : points) {
    start[i] = 1.0 / static_cast<double>(points.size());
  }
  if (grid.periodic && points.size() == free.size()) {
    return {0.0, std::move(start)};
  }
  const bool floats = grid.line && !grid.periodic;  // displacements have no zero, only differences
  if (!floats && points.size() <= most_among) {
    const Values influence = grids.influence(crew);
    if (!influence.empty()) {
      const std::vector<double> each = under_one_displacement(influence, grid, points, crew);
      if (!each.empty()) {
        const double sum = std::accumulate(each.begin(), each.end(), 0.0);
        for (std::size_t i = 0; i < points.size(); ++i) {
          start[points[i]] = each[i] / sum;
        }
        return {1.0 / sum, std::move(start)};
      }
    }
  }
  const auto kernels = grids.kernels(0, crew);
  std::vector<double> bound(free.size(), 0.0);
  for (const std::size_t i : points) {
    bound[i] = std::numeric_limits<double>::infinity();
  }
  const double mean = 1.0 / static_cast<double>(free.size());
  Workspace workspace;
  Descent descent(kernels, std::move(start), mean, bound, workspace, crew);
  // Single precision leaves 1e-7 of a displacement; on lines the differences that count are a small part of it.
  descent.renew(std::vector<double>(free.size(), 0.0), grid.line);
  for (std::int64_t i = 0; i < most_iterations; ++i) {
    const double error = descent.balance();
    const double unit = floats ? of_differences * mean * grids.even_deviation() : std::abs(descent.search().approach());
    if (error <= compliance_tolerance * unit) {
      break;
    }
    descent.iterate();
  }
  descent.balance();
  const double compliance = descent.search().work();
  return {compliance, descent.search().take_pressure()};
}

}  // namespace stiction
