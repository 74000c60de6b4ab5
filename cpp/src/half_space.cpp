#include "stiction/half_space.hpp"

#include "chunk_sums.hpp"
#include "huge_pages.hpp"
#include "multiversion.hpp"
#include "stiction/dense_kernel.hpp"
#include "stiction/preconditioner.hpp"
#include "stiction/projected_cg.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace stiction {

struct SolverMemory {
  Workspace workspace;
  ProjectedCgSolver::Arrays cg;
  Preconditioner::Arrays preconditioner;
  std::vector<float> response;
  bool in_use = false;
};

namespace {

constexpr std::size_t min_points_per_axis = 16;
constexpr std::size_t max_influence_points = std::size_t{1} << 20;
// Error tolerance on coarser grids. A smaller tolerance would be useless, because the discretisation error is larger.
constexpr double coarse_tolerance = 3e-3;
// Largest ratio of two loads on an area for which the solver at one load starts from the pressures at the other load.
constexpr double max_load_ratio = 1.3;
constexpr std::int64_t max_iterations = 2000;
// On coarser grids, the solver may stop before it converges, because these solutions serve only as starting points.
constexpr std::int64_t max_coarse_iterations = 100;
constexpr int max_exact_evaluations = 20;
// Largest relative difference of displacements that should be equal. It causes a compliance error of about 1e-7.
constexpr double compliance_tolerance = 1e-3;
// If displacements differ by less than this fraction, negative pressures at fixed contact points are not solver errors.
constexpr double sign_tolerance = 1e-5;
// On free lines, `compliance_tolerance` is multiplied by this factor, because compliance errors are of first order.
constexpr double difference_tolerance = 0.03;
// Up to this number of contact points, a solution with a dense matrix is faster than one with transforms of the grid.
constexpr std::size_t max_dense_points = 1024;
// If few points can come into contact, a dense matrix is used to compute displacements at these points only.
// A dense matrix is faster than transforms of the grid if it has at most `max_matrix_ratio` elements per grid point.
// With `max_selected_points` points, the dense matrix of single-precision numbers occupies 16 MiB.
constexpr std::size_t max_matrix_ratio = 16;
constexpr std::size_t max_selected_points = 2048;
// Points are selected if (gap - smallest gap) is below this multiple of (approach - smallest gap).
constexpr double selection_approach_ratio = 1.1;
constexpr std::size_t points_per_task = std::size_t{1} << 16;
// Displacements count as equal if they differ by less than this fraction of the displacement of a single loaded cell.
constexpr double round_off = 1e-9;
constexpr int max_trial_loads = 60;
constexpr double max_trial_load_ratio = 30.0;
// Minimum distance of a trial load from both ends of its bracket, divided by the width of the bracket.
constexpr double min_load_bracket_fraction = 1e-3;

std::size_t coarsened(std::size_t points, bool periodic) {
  if (points < 2 * min_points_per_axis) {
    return points;
  }
  const std::size_t half = (points + 1) / 2;
  return points % 2 == 0 || !periodic ? half : fast_length(half);
}

double spacing_ratio(std::size_t points, std::size_t coarser, bool periodic) {
  if (points == coarser) {
    return 1.0;
  }
  return periodic ? static_cast<double>(points) / static_cast<double>(coarser) : 2.0;
}

template <int Exponent>
STICTION_INLINE double central_sum(const double* values, std::size_t size, double about) {
  std::array<double, 8> sums{};
  for (std::size_t i = 0; i < size; ++i) {
    const double deviation = values[i] - about;
    sums[i % sums.size()] += Exponent == 1 ? deviation : deviation * deviation;
  }
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

STICTION_MULTIVERSION
double sum_values(const double* values, std::size_t size) { return central_sum<1>(values, size, 0.0); }

STICTION_MULTIVERSION
double squared_deviations(const double* values, std::size_t size, double about) {
  return central_sum<2>(values, size, about);
}

double mean_value(Values values) {
  return sum_values(values.data(), values.size()) / static_cast<double>(values.size());
}

double standard_deviation(Values values) {
  return std::sqrt(squared_deviations(values.data(), values.size(), mean_value(values)) /
                   static_cast<double>(values.size()));
}

// A periodic grid and its coarser grid have the same length in µm.
// On free grids, the coarser grid consists of every second point of the finer grid.
double relative_spacing(std::size_t old_points, std::size_t new_points, bool periodic) {
  if (periodic || old_points == new_points) {
    return static_cast<double>(old_points) / static_cast<double>(new_points);
  }
  return old_points > new_points ? 2.0 : 0.5;
}

struct Position {
  std::size_t left = 0;
  double fraction = 0.0;

  Position(double position, std::size_t points)
      : left(std::min(static_cast<std::size_t>(position), points - 1)),
        fraction(position - static_cast<double>(left)) {}
};

std::size_t next_point(std::size_t point, std::size_t points, bool periodic) {
  return point + 1 < points ? point + 1 : (periodic ? 0 : point);
}

std::size_t previous_point(std::size_t point, std::size_t points, bool periodic) {
  return point > 0 ? point - 1 : (periodic ? points - 1 : point);
}

// Coarsen a gap along each row if `width` is 1, or along all columns together if `width` is the number of columns.
void coarsen_gap_along(Values gap, std::size_t blocks, std::size_t old_points, std::size_t new_points,
                       std::size_t width, bool periodic, std::vector<double>& result) {
  resize_on_huge_pages(result, blocks * new_points * width);
  const double step = relative_spacing(old_points, new_points, periodic);
  double* to = result.data();
  for (std::size_t block = 0; block < blocks; ++block) {
    const double* from = gap.data() + block * old_points * width;
    for (std::size_t i = 0; i < new_points; ++i, to += width) {
      const Position position(static_cast<double>(i) * step, old_points);
      const double* left = from + position.left * width;
      const double* right = from + next_point(position.left, old_points, periodic) * width;
      for (std::size_t k = 0; k < width; ++k) {
        to[k] = position.fraction == 0.0 ? left[k] : left[k] + position.fraction * (right[k] - left[k]);
      }
    }
  }
}

std::vector<double> coarsen_gap(Values gap, const Grid& from, const Grid& to, std::vector<double>& buffer) {
  std::vector<double> result;
  if (from.columns == to.columns) {
    coarsen_gap_along(gap, 1, from.rows, to.rows, from.columns, from.periodic, result);
    return result;
  }
  if (from.rows != to.rows) {
    coarsen_gap_along(gap, 1, from.rows, to.rows, from.columns, from.periodic, buffer);
    gap = buffer;
  }
  coarsen_gap_along(gap, to.rows, from.columns, to.columns, 1, from.periodic, result);
  return result;
}

// Near the edge of a contact, the squared pressure is proportional to the distance from the edge.
// If one of two neighbouring points is out of contact, the squared pressure is extrapolated from two points in contact.
// The extrapolated pressure reaches 0 no later than at the point that is out of contact.
STICTION_MULTIVERSION
void interpolate_pressure(const double* before, const double* left, const double* right, const double* after,
                          double fraction, std::size_t size, double* result) {
  for (std::size_t i = 0; i < size; ++i) {
    const double left_square = left[i] * left[i];
    const double right_square = right[i] * right[i];
    const double from_left = left_square - fraction * std::max(before[i] * before[i] - left_square, left_square);
    const double from_right =
        right_square - (1.0 - fraction) * std::max(after[i] * after[i] - right_square, right_square);
    const double extrapolated = std::sqrt(std::max(std::max(from_left, from_right), 0.0));
    const double interpolated = left[i] + fraction * (right[i] - left[i]);
    result[i] = (left[i] > 0.0) & (right[i] > 0.0) ? interpolated : extrapolated;
  }
}

void refine_row(std::span<const double> row, bool periodic, std::span<double> result, std::vector<double>& padded,
                std::vector<double>& midpoints) {
  const std::size_t columns = row.size();
  const std::size_t right = next_point(columns - 1, columns, periodic);
  padded.assign(1, row[previous_point(0, columns, periodic)]);
  padded.insert(padded.end(), row.begin(), row.end());
  padded.push_back(row[right]);
  padded.push_back(row[next_point(right, columns, periodic)]);
  const double step = relative_spacing(columns, result.size(), periodic);
  if (step == 0.5) {
    midpoints.resize(columns);
    interpolate_pressure(&padded[0], &padded[1], &padded[2], &padded[3], step, columns, midpoints.data());
    for (std::size_t j = 0; j < result.size(); ++j) {
      result[j] = j % 2 == 0 ? row[j / 2] : midpoints[j / 2];
    }
    return;
  }
  for (std::size_t j = 0; j < result.size(); ++j) {
    const Position position(static_cast<double>(j) * step, columns);
    const double* before = &padded[position.left];
    interpolate_pressure(before, before + 1, before + 2, before + 3, position.fraction, 1, &result[j]);
  }
}

std::vector<double> refine_pressure(Values pressure, const Grid& from, const Grid& to, std::vector<double>& buffer) {
  const std::size_t columns = from.columns;
  resize_on_huge_pages(buffer, to.rows * columns);
  const double step = relative_spacing(from.rows, to.rows, from.periodic);
  for (std::size_t i = 0; i < to.rows; ++i) {
    const Position position(static_cast<double>(i) * step, from.rows);
    const auto row = [&](std::size_t index) { return &pressure[index * columns]; };
    const std::size_t right = next_point(position.left, from.rows, from.periodic);
    interpolate_pressure(row(previous_point(position.left, from.rows, from.periodic)), row(position.left), row(right),
                         row(next_point(right, from.rows, from.periodic)), position.fraction, columns,
                         &buffer[i * columns]);
  }
  if (to.columns == columns) {
    return buffer;
  }
  std::vector<double> result;
  resize_on_huge_pages(result, to.size());
  std::vector<double> padded;
  std::vector<double> midpoints;
  for (std::size_t i = 0; i < to.rows; ++i) {
    refine_row(std::span(buffer).subspan(i * columns, columns), from.periodic,
               std::span(result).subspan(i * to.columns, to.columns), padded, midpoints);
  }
  return result;
}

bool is_above_zero(double value) { return value > 0.0; }

bool is_dense_kernel_faster(std::size_t num_points, const Grid& grid) {
  return num_points <= max_selected_points && num_points * num_points <= max_matrix_ratio * grid.size();
}

// Solver on one grid, which starts from the pressures `start` [GPa], scaled to the mean pressure `mean` [GPa].
// If `gap` is empty, the initial gap is 0 at all points.
// On a free area, a point whose initial gap exceeds the approach cannot come into contact.
// The potential of points that cannot come into contact is replaced by its lower bound, the initial gap.
// `influence` contains displacements due to a pressure on the first grid point. If it is empty, all points are used.
class LevelSolver {
 public:
  LevelSolver(const HalfSpaceGrids::Kernels& kernels, Values gap, std::vector<double> start, double mean, Values bound,
              Values influence, SolverMemory& memory, const ThreadPool& pool)
      : gap_(gap),
        bound_(bound),
        influence_(influence),
        kernel_(*kernels.points),
        memory_(memory),
        workspace_(memory.workspace),
        pool_(pool),
        cg_(std::move(start), mean * static_cast<double>(kernel_.grid().size()), bound, kernel_.grid().line,
            std::move(memory.cg)),
        response_(std::move(memory.response)) {
    resize_on_huge_pages(response_, kernel_.grid().size());
    std::fill(response_.begin(), response_.end(), 0.0F);
    if (kernels.blocks) {
      preconditioner_.emplace(kernel_.grid(), kernel_.stencil(), *kernels.blocks, std::move(memory.preconditioner));
    }
    for (std::size_t row = 0; row < kernel_.grid().rows && bound_.size() > 1; ++row) {
      const auto bounds = bound_.subspan(row * kernel_.grid().columns, kernel_.grid().columns);
      if (std::any_of(bounds.begin(), bounds.end(), is_above_zero)) {
        contact_rows_.push_back(row);
      }
    }
    if (!influence.empty()) {
      select_points(estimate_approach());
    }
  }

  ~LevelSolver() {
    memory_.cg = cg_.take_arrays();
    memory_.response = std::move(response_);
    if (preconditioner_) {
      memory_.preconditioner = preconditioner_->take_arrays();
    }
  }
  LevelSolver(const LevelSolver&) = delete;
  LevelSolver& operator=(const LevelSolver&) = delete;

  ProjectedCgSolver& cg() { return cg_; }
  // True if the potential was recomputed in double precision after the last step.
  bool is_exact() const { return is_exact_; }
  // True if the potential is known at all points with a pressure bound above 0. Each point must have its own bound.
  bool has_all_potentials() const { return !selected_points_ || selects_all_points_; }

  double update_free_points() {
    double error = cg_.update_free_points(pool_);
    while (selected_points_ && cg_.approach() > max_approach_) {
      select_points(cg_.approach());
      recompute_potential(false);
      error = cg_.update_free_points(pool_);
    }
    return error;
  }

  // `exact` requests double precision. Single precision is enough for an estimate that is recomputed later.
  void recompute_potential(bool exact) {
    const Values pressure = cg_.pressure();
    std::vector<double> potential = cg_.take_potential();
    resize_on_huge_pages(potential, pressure.size());
    const bool is_single = !selected_points_ && !exact;
    if (selected_points_) {
      std::fill(potential.begin(), potential.end(), 0.0);
      selected_points_->displacement(pressure, potential);
    } else if (exact) {
      kernel_.displacement(pressure, potential, workspace_, pool_, contact_rows_);
    } else {
      std::transform(pressure.begin(), pressure.end(), response_.begin(),
                     [](double value) { return static_cast<float>(value); });
      kernel_.displacement(response_, response_, workspace_, pool_, contact_rows_);
    }
    pool_.run_chunks(potential.size(), points_per_task, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const double displacement = is_single ? static_cast<double>(response_[i]) : potential[i];
        potential[i] = gap_.empty() ? displacement : displacement + gap_[i];
      }
    });
    cg_.restart(std::move(potential));
    has_response_ = false;
    is_exact_ = exact;
  }

  // Compute one step. The caller must call `update_free_points` before each step.
  void iterate() {
    std::span<const float> residual = cg_.residual(pool_);
    if (!cg_.is_steepest_descent()) {
      if (preconditioner_) {
        const std::span<const float> displacements = residual;
        residual = (*preconditioner_)(cg_.free_points(), displacements, workspace_, pool_);
        if (cg_.hold_points_at_bounds(residual, pool_)) {
          residual = (*preconditioner_)(cg_.free_points(), displacements, workspace_, pool_);
        }
      } else {
        preconditioned_.resize(response_.size());
        kernel_.apply_stiffness(residual, preconditioned_, workspace_, pool_);
        residual = preconditioned_;
      }
    }
    const auto before = has_response_ ? std::span<const float>(response_) : std::span<const float>();
    const std::span<const float> step = cg_.step(residual, before, pool_);
    if (selected_points_) {
      pool_.check_cancellation();
      selected_points_->displacement(step, response_);
    } else {
      kernel_.displacement(step, response_, workspace_, pool_, contact_rows_);
    }
    has_response_ = cg_.advance(response_, pool_);
    is_exact_ = false;
  }

 private:
  double bound_at(std::size_t i) const { return bound_[bound_.size() == 1 ? 0 : i]; }

  // Find points that satisfy a condition. The search ends once a dense matrix of the found points would be too slow.
  template <class Condition>
  std::vector<std::size_t> find_points(Condition condition) const {
    std::vector<std::size_t> points;
    for (std::size_t i = 0; i < gap_.size() && is_dense_kernel_faster(points.size(), kernel_.grid()); ++i) {
      if (condition(i)) {
        points.push_back(i);
      }
    }
    return points;
  }

  // Estimate the approach [µm] as the mean potential of all points whose pressure lies between 0 and its bound.
  // Returns infinity if no pressure lies between 0 and its bound, or if too many points are under pressure.
  double estimate_approach() const {
    const Values pressure = cg_.pressure();
    const std::vector<std::size_t> loaded = find_points([&](std::size_t i) { return pressure[i] > 0.0; });
    if (!is_dense_kernel_faster(loaded.size(), kernel_.grid())) {
      return std::numeric_limits<double>::infinity();
    }
    std::vector<double> displacements(gap_.size());
    DenseKernel(influence_, kernel_.grid(), loaded).displacement(pressure, displacements);
    double sum = 0.0;
    std::size_t count = 0;
    for (const std::size_t i : loaded) {
      if (pressure[i] < bound_at(i)) {
        sum += displacements[i] + gap_[i];
        ++count;
      }
    }
    return count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::infinity();
  }

  // Select the points that may touch at a slightly larger approach. If there are too many, no points are selected.
  void select_points(double approach) {
    const double lowest_gap = *std::min_element(gap_.begin(), gap_.end());
    max_approach_ = std::max(approach, lowest_gap + selection_approach_ratio * (approach - lowest_gap));
    const Values pressure = cg_.pressure();
    std::vector<std::size_t> points =
        find_points([&](std::size_t i) { return pressure[i] > 0.0 || (gap_[i] < max_approach_ && bound_at(i) > 0.0); });
    selects_all_points_ = std::cmp_equal(points.size(), std::count_if(bound_.begin(), bound_.end(), is_above_zero));
    selected_points_.reset();
    if (is_dense_kernel_faster(points.size(), kernel_.grid())) {
      selected_points_ = std::make_unique<DenseKernel>(influence_, kernel_.grid(), std::move(points));
    }
    std::fill(response_.begin(), response_.end(), 0.0F);
  }

  Values gap_;
  Values bound_;
  Values influence_;
  const ElasticKernel& kernel_;
  SolverMemory& memory_;
  Workspace& workspace_;
  const ThreadPool& pool_;
  ProjectedCgSolver cg_;
  std::vector<float> response_;
  std::vector<float> preconditioned_;  // preconditioned residual on lines
  // Indices of grid rows that contain a pressure bound above 0. Potentials are computed only in these rows.
  // `contact_rows_` is empty if all points have the same bound.
  std::vector<std::size_t> contact_rows_;
  std::optional<Preconditioner> preconditioner_;
  std::unique_ptr<DenseKernel> selected_points_;  // kernel of the points that can come into contact, if they are few
  bool selects_all_points_ = false;               // true if all points with a bound above 0 are selected
  double max_approach_ = 0.0;                     // largest approach for which the selection is complete
  bool has_response_ = false;
  bool is_exact_ = false;
};

double log_excess(double approach, double target, double full_contact) {
  if (approach >= full_contact) {
    return std::numeric_limits<double>::infinity();
  }
  const double remaining =
      std::isinf(full_contact) ? 0.0 : std::log((full_contact - approach) / (full_contact - target));
  return std::log(approach / target) - remaining;
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

// Return the pressures [GPa] that displace all given points by 1 µm, computed by conjugate gradients.
// Returns an empty array if a pressure is negative, which round-off may cause at single-point contacts.
std::vector<double> solve_dense(Values influence, const Grid& grid, const std::vector<std::size_t>& points,
                                const ThreadPool& pool) {
  const std::size_t size = points.size();
  const std::vector<double> matrix = DenseKernel(influence, grid, points).matrix<double>();
  std::vector<double> pressure(size, 0.0);
  std::vector<double> residual(size, 1.0);
  std::vector<double> direction = residual;
  std::vector<double> response(size);
  auto square = static_cast<double>(size);
  const double tolerance = square * std::pow(compliance_tolerance, 3.0);
  for (std::size_t count = 0; count < 10 * size && square > tolerance; ++count) {
    pool.check_cancellation();
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
  const bool is_positive = std::all_of(pressure.begin(), pressure.end(), [](double value) { return value >= 0.0; });
  return is_positive ? pressure : std::vector<double>();
}

// Return the response of fixed contact points of an area, computed by preconditioned conjugate gradients.
// Unlike contact pressures, these pressures have no bounds in the iterations, because bounds would delay convergence.
// With bounds, the first step would remove the pressure at many points inside contacts, where it is far below the mean.
// Returns no response if a pressure is negative, which round-off may cause at single-point contacts.
std::optional<LinearResponse> respond_on_area(const HalfSpaceGrids& grids, const std::vector<std::size_t>& points,
                                              SolverMemory& memory, const ThreadPool& pool) {
  struct Sums {
    double potential = 0.0;
    double preconditioned = 0.0;
    double response = 0.0;
    double product = 0.0;
    double curvature = 0.0;
    double max_gap = 0.0;
    double min_pressure = 0.0;

    void add(const Sums& other) {
      potential += other.potential;
      preconditioned += other.preconditioned;
      response += other.response;
      product += other.product;
      curvature += other.curvature;
      max_gap = std::max(max_gap, other.max_gap);
      min_pressure = std::min(min_pressure, other.min_pressure);
    }
  };
  const auto sum_over_points = [&](const auto& add_point) {
    return sum_chunks<Sums>(points.size(), points_per_task, pool, [&](std::size_t first, std::size_t last) {
      Sums partial;
      for (std::size_t k = first; k < last; ++k) {
        add_point(points[k], partial);
      }
      return partial;
    });
  };
  const auto kernels = grids.kernels(0, pool);
  const Grid& grid = grids.levels()[0];
  const auto count = static_cast<double>(points.size());
  std::vector<std::int32_t> indices(points.size());
  std::vector<std::size_t> rows;
  for (std::size_t k = 0; k < points.size(); ++k) {
    indices[k] = static_cast<std::int32_t>(points[k]);
    if (rows.empty() || rows.back() != points[k] / grid.columns) {
      rows.push_back(points[k] / grid.columns);
    }
  }
  Preconditioner precondition(grid, kernels.points->stencil(), *kernels.blocks, std::move(memory.preconditioner));
  std::vector<double> pressure;
  resize_on_huge_pages(pressure, grid.size());
  std::vector<double>& potential = memory.cg.potential;
  std::vector<float>& residual = memory.cg.residual;
  std::vector<float>& direction = memory.cg.step;
  std::vector<float>& response = memory.response;
  resize_on_huge_pages(potential, grid.size());
  resize_on_huge_pages(response, grid.size());
  resize_on_huge_pages(residual, grid.size());
  resize_on_huge_pages(direction, grid.size());
  std::fill(residual.begin(), residual.end(), 0.0F);
  std::fill(direction.begin(), direction.end(), 0.0F);
  const auto displace = [&] { kernels.points->displacement(direction, response, memory.workspace, pool, rows); };
  // All points start with equal pressures, because large first steps would leave round-off in the pressures.
  // Pressures from the preconditioner displace points of wide contacts very unequally, so that steps would be large.
  for (const std::size_t i : points) {
    pressure[i] = 1.0 / count;
    direction[i] = static_cast<float>(pressure[i]);
  }
  displace();
  for (const std::size_t i : points) {
    potential[i] = static_cast<double>(response[i]);
  }
  std::optional<LinearResponse> result;
  double curvature = 0.0;
  for (std::int64_t iteration = 0; iteration < max_iterations; ++iteration) {
    const double mean =
        sum_over_points([&](std::size_t i, Sums& sums) { sums.potential += potential[i]; }).potential / count;
    const Sums errors = sum_over_points([&](std::size_t i, Sums& sums) {
      const double gap = mean - potential[i];
      residual[i] = static_cast<float>(gap);
      sums.max_gap = std::max(sums.max_gap, std::abs(gap));
      sums.min_pressure = std::min(sums.min_pressure, pressure[i]);
      sums.product += pressure[i] * potential[i];
    });
    const double relative_error = errors.max_gap / std::abs(mean);
    if (relative_error <= compliance_tolerance && errors.min_pressure >= 0.0) {
      result = LinearResponse{errors.product, std::move(pressure)};
      break;
    }
    if (!(relative_error > sign_tolerance)) {
      break;
    }
    const std::span<const float> preconditioned = precondition(indices, residual, memory.workspace, pool);
    const Sums before = sum_over_points([&](std::size_t i, Sums& sums) {
      const auto value = static_cast<double>(preconditioned[i]);
      sums.preconditioned += value;
      sums.response += static_cast<double>(response[i]);
      sums.product += value * static_cast<double>(response[i]);
    });
    const double shift = before.preconditioned / count;
    const double beta = iteration == 0 ? 0.0 : std::max((shift * before.response - before.product) / curvature, 0.0);
    // The pressure changes along a direction add up to 0, so that the total load remains 1.
    for (const std::size_t i : points) {
      const double previous = iteration == 0 ? 0.0 : static_cast<double>(direction[i]);
      direction[i] = static_cast<float>(static_cast<double>(preconditioned[i]) - shift + beta * previous);
    }
    displace();
    const Sums step = sum_over_points([&](std::size_t i, Sums& sums) {
      const auto change = static_cast<double>(direction[i]);
      sums.product += change * static_cast<double>(residual[i]);
      sums.curvature += change * static_cast<double>(response[i]);
    });
    curvature = step.curvature;
    const double length = step.product / curvature;
    if (!(curvature > 0.0) || !std::isfinite(length)) {
      break;
    }
    for (const std::size_t i : points) {
      pressure[i] += length * static_cast<double>(direction[i]);
      potential[i] += length * static_cast<double>(response[i]);
    }
  }
  memory.preconditioner = precondition.take_arrays();
  return result;
}

}  // namespace

HalfSpaceGrids::HalfSpaceGrids(const Grid& finest, double effective_modulus)
    : levels_{finest}, effective_modulus_(effective_modulus) {
  while (true) {
    Grid grid = levels_.back();
    const std::size_t rows = grid.line ? 1 : coarsened(grid.rows, grid.periodic);
    const std::size_t columns = coarsened(grid.columns, grid.periodic);
    if (rows == grid.rows && columns == grid.columns) {
      break;
    }
    grid.spacing_y *= spacing_ratio(grid.rows, rows, grid.periodic);
    grid.spacing_x *= spacing_ratio(grid.columns, columns, grid.periodic);
    grid.rows = rows;
    grid.columns = columns;
    levels_.push_back(grid);
  }
  kernels_.resize(levels_.size());
}

HalfSpaceGrids::Kernels HalfSpaceGrids::kernels(std::size_t level, const ThreadPool& pool) const {
  const std::lock_guard lock(mutex_);
  if (kernels_.at(level).points) {
    return kernels_[level];
  }
  const Grid& grid = levels_[level];
  Kernels kernels{std::make_shared<const ElasticKernel>(grid, effective_modulus_, pool), {}};
  if (!grid.line) {
    kernels.blocks = std::make_shared<const ElasticKernel>(Preconditioner::block_grid(grid), effective_modulus_, pool);
  }
  kernels_[level] = kernels;
  return kernels;
}

HalfSpaceGrids::BorrowedMemory HalfSpaceGrids::borrow_memory() const {
  const std::lock_guard lock(mutex_);
  auto memory = std::find_if(memories_.begin(), memories_.end(), [](const auto& each) { return !each->in_use; });
  if (memory == memories_.end()) {
    memory = memories_.insert(memory, std::make_shared<SolverMemory>());
  }
  (*memory)->in_use = true;
  return {memory->get(), {this}};
}

void HalfSpaceGrids::ReturnMemory::operator()(SolverMemory* memory) const {
  const std::lock_guard lock(grids->mutex_);
  memory->in_use = false;
}

void HalfSpaceGrids::displacement(Values pressure, std::span<double> displacements, const ThreadPool& pool) const {
  const auto memory = borrow_memory();
  kernels(0, pool).points->displacement(pressure, displacements, memory->workspace, pool);
}

double HalfSpaceGrids::uniform_pressure_deviation() const {
  const std::lock_guard lock(mutex_);
  if (!uniform_pressure_deviation_) {
    uniform_pressure_deviation_ = stiction::uniform_pressure_deviation(levels_[0], effective_modulus_);
  }
  return *uniform_pressure_deviation_;
}

std::span<const double> HalfSpaceGrids::influence(const ThreadPool& pool) const {
  const std::size_t size = levels_[0].size();
  if (size > max_influence_points) {
    return {};
  }
  const auto finest = kernels(0, pool).points;
  const std::lock_guard lock(mutex_);
  if (influence_.empty()) {
    std::vector<double> values(size, 0.0);
    values[0] = 1.0;
    Workspace workspace;
    finest->displacement(values, values, workspace, pool);
    influence_ = std::move(values);
  }
  return influence_;
}

HalfSpaceSolver::HalfSpaceSolver(Values gap, std::shared_ptr<const HalfSpaceGrids> grids, Values bound,
                                 double tolerance, const ThreadPool& pool)
    : gap_(gap), grids_(std::move(grids)), bound_(bound.begin(), bound.end()), tolerance_(tolerance) {
  const std::vector<Grid>& levels = grids_->levels();
  if (gap.size() != levels[0].size() || (bound.size() != 1 && bound.size() != gap.size())) {
    throw std::invalid_argument(
        "HalfSpaceSolver: gap must have one value for each grid point, and bound one value or one for each grid point");
  }
  if (!(tolerance > 0.0)) {
    throw std::invalid_argument("HalfSpaceSolver: tolerance must be above 0");
  }
  // Coarser grids are used only if all points have the same pressure bound.
  const auto memory = grids_->borrow_memory();
  for (std::size_t level = 1; level < levels.size() && bound_.size() == 1; ++level) {
    coarse_gaps_.push_back(coarsen_gap(this->gap(level - 1), levels[level - 1], levels[level], memory->cg.potential));
  }
  gap_scale_ = standard_deviation(gap);
  displacement_scale_ = unit_load_deviation(pool);
}

// Return the standard deviation of the displacements over the grid, divided by the mean pressure [µm/GPa].
// The pressures are uniform or, if each point has its own pressure bound, proportional to the bounds.
double HalfSpaceSolver::unit_load_deviation(const ThreadPool& pool) const {
  const Grid& grid = grids_->levels()[0];
  const double cell_displacement =
      (grid.line ? grid.spacing_x : std::max(grid.spacing_x, grid.spacing_y)) / grids_->effective_modulus();
  if (bound_.size() > 1) {
    const double mean = mean_value(bound_);
    const auto memory = grids_->borrow_memory();
    std::vector<double>& values = memory->cg.potential;
    values.resize(bound_.size());
    std::transform(bound_.begin(), bound_.end(), values.begin(), [&](double bound) { return bound / mean; });
    grids_->kernels(0, pool).points->displacement(values, values, memory->workspace, pool);
    const double deviation = standard_deviation(values);
    // On a periodic grid, `deviation` is only round-off if the pressures displace all points equally.
    if (!grid.periodic) {
      return std::max(deviation, grids_->uniform_pressure_deviation());
    }
    return deviation > round_off * cell_displacement ? deviation : cell_displacement;
  }
  if (!grid.periodic) {
    return grids_->uniform_pressure_deviation();
  }
  return gap_scale_ == 0.0 ? cell_displacement : 0.0;
}

double HalfSpaceSolver::scale(double mean_pressure) const {
  return std::max(gap_scale_, displacement_scale_ * mean_pressure);
}

// If each point has its own bound, the solver starts from `near`, because coarser grids require a common bound.
// On lines with one bound for all points, the solver always starts from a coarser grid instead of `near`.
bool HalfSpaceSolver::is_good_start(Values near, double mean_pressure) const {
  if (near.empty()) {
    return false;
  }
  if (near.size() != gap_.size()) {
    throw std::invalid_argument("HalfSpaceSolver: near must have one value for each grid point");
  }
  const double ratio = mean_pressure / mean_value(near);
  return bound_.size() > 1 || (!grids_->levels()[0].line && ratio >= 1 / max_load_ratio && ratio <= max_load_ratio);
}

HalfSpaceSolution HalfSpaceSolver::at(double mean_pressure, Values near, const ThreadPool& pool,
                                      const HalfSpaceProgress& progress) const {
  const auto memory = grids_->borrow_memory();
  if (is_good_start(near, mean_pressure)) {
    HalfSpaceSolution solution = solve_finest({near.begin(), near.end()}, mean_pressure, *memory, pool, progress);
    if (solution.error <= tolerance_) {
      return solution;
    }
  }
  if (bound_.size() > 1) {
    return solve_finest(bound_, mean_pressure, *memory, pool, progress);
  }
  const std::vector<Grid>& levels = grids_->levels();
  std::vector<double> start(levels.back().size(), mean_pressure);
  const double coarse = std::max(coarse_tolerance, tolerance_) * scale(mean_pressure);
  for (std::size_t level = levels.size() - 1; level > 0; --level) {
    start = solve_level(level, std::move(start), mean_pressure, coarse, *memory, pool, {}).pressure;
    start = refine_pressure(start, levels[level], levels[level - 1], memory->cg.potential);
  }
  return solve_finest(std::move(start), mean_pressure, *memory, pool, progress);
}

// Find the root of `log_excess` as a function of ln(load) by the Illinois algorithm, a secant method with a bracket.
// Periodic surfaces are in full contact if the approach is at least the mean gap.
HalfSpaceSolution HalfSpaceSolver::at_approach(double approach, Values near, const ThreadPool& pool,
                                               const HalfSpaceProgress& progress) const {
  const Grid& grid = grids_->levels()[0];
  const double full_contact = grid.periodic ? mean_value(gap_) : std::numeric_limits<double>::infinity();
  // The mean pressure is at most about E* approach / length, the mean pressure of a contact as large as the grid.
  const double along_x = grid.spacing_x * static_cast<double>(grid.columns);
  const double length = grid.line ? along_x : std::max(along_x, grid.spacing_y * static_cast<double>(grid.rows));
  double pressure = near.empty() ? 0.1 * grids_->effective_modulus() * approach / length : mean_value(near);
  struct End {
    double load;
    double excess;
  };
  std::array<std::optional<End>, 2> ends;  // trial loads with an approach below and above the target
  std::optional<bool> previous_above;
  HalfSpaceSolution solution;
  double miss = 0.0;
  for (int count = 0; count < max_trial_loads; ++count) {
    std::vector<double> previous = std::move(solution.pressure);
    solution = at(pressure, count == 0 ? near : Values(previous), pool, progress);
    miss = std::abs(solution.approach - approach) / scale(pressure);
    if (miss <= tolerance_ || !(solution.error <= tolerance_)) {
      break;
    }
    const double excess = log_excess(solution.approach, approach, full_contact);
    const bool above = excess > 0.0;
    std::optional<End>& other = ends[above ? 0 : 1];
    if (previous_above == above && other) {
      other->excess *= 0.5;
    }
    ends[above ? 1 : 0] = End{std::log(pressure), excess};
    previous_above = above;
    if (!other) {
      pressure *= std::exp(std::clamp(-2 * excess, -std::log(max_trial_load_ratio), std::log(max_trial_load_ratio)));
      continue;
    }
    const auto [left, below] = ends[0].value_or(End{});
    const auto [right, over] = ends[1].value_or(End{});
    const double fraction = std::isfinite(over) ? below / (below - over) : 0.5;
    pressure = std::exp(left + std::clamp(fraction, min_load_bracket_fraction, 1 - min_load_bracket_fraction) *
                                   (right - left));
  }
  solution.error = std::max(solution.error, miss);
  return solution;
}

HalfSpaceSolution HalfSpaceSolver::solve_finest(std::vector<double> start, double mean_pressure, SolverMemory& memory,
                                                const ThreadPool& pool, const HalfSpaceProgress& progress) const {
  const double length_unit = scale(mean_pressure);
  HalfSpaceSolution solution =
      solve_level(0, std::move(start), mean_pressure, tolerance_ * length_unit, memory, pool, progress);
  solution.error =
      std::max(solution.error / length_unit, std::abs(mean_value(solution.pressure) / mean_pressure - 1.0));
  return solution;
}

HalfSpaceSolution HalfSpaceSolver::solve_level(std::size_t level, std::vector<double> start, double mean_pressure,
                                               double tolerance, SolverMemory& memory, const ThreadPool& pool,
                                               const HalfSpaceProgress& progress) const {
  const auto kernels = grids_->kernels(level, pool);
  const double factor = mean_pressure / mean_value(start);
  for (double& pressure : start) {
    pressure *= factor;
  }
  // On coarser grids, transforms are as fast as dense matrices.
  const Grid& grid = grids_->levels()[level];
  const auto num_loaded = std::count_if(start.begin(), start.end(), is_above_zero);
  const bool selects_points =
      level == 0 && !grid.line && !grid.periodic && is_dense_kernel_faster(static_cast<std::size_t>(num_loaded), grid);
  const Values influence = selects_points ? grids_->influence(pool) : Values();
  LevelSolver solver(kernels, gap(level), std::move(start), mean_pressure, bound_, influence, memory, pool);
  solver.recompute_potential(false);
  const std::int64_t max_steps = level == 0 ? max_iterations : max_coarse_iterations;
  int exact_evaluations = 0;
  double error = 0.0;
  std::int64_t iterations = 0;
  while (true) {
    error = solver.update_free_points();
    if (error <= tolerance || !std::isfinite(error)) {
      if (++exact_evaluations > max_exact_evaluations || solver.is_exact() || level > 0) {
        break;
      }
      solver.cg().rescale_to_total();
      solver.recompute_potential(true);
      continue;
    }
    if (iterations == max_steps) {
      break;
    }
    solver.iterate();
    ++iterations;
    if (progress) {
      progress(iterations, error / (tolerance / tolerance_));
    }
  }
  const double approach = solver.cg().approach();
  HalfSpaceSolution solution{solver.cg().take_pressure(), approach, error, iterations, {}};
  if (bound_.size() > 1 && solver.is_exact() && solver.has_all_potentials()) {
    const Values potential = solver.cg().potential();
    for (std::size_t i = 0; i < potential.size(); ++i) {
      if (bound_[i] > 0.0) {
        solution.potential.push_back(potential[i]);
      }
    }
  }
  return solution;
}

LinearResponse linear_response(const HalfSpaceGrids& grids, std::span<const bool> in_contact, const ThreadPool& pool) {
  const Grid& grid = grids.levels()[0];
  if (in_contact.size() != grid.size()) {
    throw std::invalid_argument("linear_response: in_contact must have one value for each grid point");
  }
  std::vector<std::size_t> points;
  for (std::size_t i = 0; i < in_contact.size(); ++i) {
    if (in_contact[i]) {
      points.push_back(i);
    }
  }
  if (points.empty()) {
    throw std::invalid_argument("linear_response: in_contact must contain at least one point");
  }
  // Pressures that displace all contact points equally are largest at the contact edges, like charges on a conductor.
  // Uniform pressure is therefore a better start for such pressures than contact pressures, which are 0 at the edges.
  std::vector<double> start(in_contact.size(), 0.0);
  for (const std::size_t i : points) {
    start[i] = 1.0 / static_cast<double>(points.size());
  }
  if (grid.periodic && points.size() == in_contact.size()) {
    return {0.0, std::move(start)};
  }
  const bool only_differences = grid.line && !grid.periodic;
  if (!only_differences && points.size() <= max_dense_points) {
    const Values influence = grids.influence(pool);
    if (!influence.empty()) {
      const std::vector<double> dense = solve_dense(influence, grid, points, pool);
      if (!dense.empty()) {
        const double sum = std::accumulate(dense.begin(), dense.end(), 0.0);
        for (std::size_t i = 0; i < points.size(); ++i) {
          start[points[i]] = dense[i] / sum;
        }
        return {1.0 / sum, std::move(start)};
      }
    }
  }
  const auto memory = grids.borrow_memory();
  if (!grid.line) {
    if (std::optional<LinearResponse> response = respond_on_area(grids, points, *memory, pool)) {
      return *std::move(response);
    }
  }
  const auto kernels = grids.kernels(0, pool);
  std::vector<double> bound(in_contact.size(), 0.0);
  for (const std::size_t i : points) {
    bound[i] = std::numeric_limits<double>::infinity();
  }
  const double mean = 1.0 / static_cast<double>(in_contact.size());
  LevelSolver solver(kernels, {}, std::move(start), mean, bound, {}, *memory, pool);
  // On lines, differences between displacements are too small for single precision, which resolves 1e-7 of a number.
  solver.recompute_potential(grid.line);
  for (std::int64_t i = 0; i < max_iterations; ++i) {
    const double error = solver.update_free_points();
    const double length_unit = only_differences ? difference_tolerance * mean * grids.uniform_pressure_deviation()
                                                : std::abs(solver.cg().approach());
    if (error <= compliance_tolerance * length_unit) {
      break;
    }
    solver.iterate();
  }
  solver.update_free_points();
  const double compliance = solver.cg().pressure_dot_potential();
  return {compliance, solver.cg().take_pressure()};
}

}  // namespace stiction
