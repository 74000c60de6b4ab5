#include "stiction/preconditioner.hpp"

#include "huge_pages.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace stiction {
namespace {

// Conjugate gradients on blocks end after `max_block_steps`, or at the squared relative residual `block_tolerance`.
constexpr int max_block_steps = 5;
constexpr double block_tolerance = 1e-4;
// The foundation stiffness is computed again if the number of free points has changed by more than this fraction.
constexpr double max_foundation_change = 0.02;
constexpr std::size_t points_per_block_task = std::size_t{1} << 16;
constexpr std::size_t max_tasks = 8;

double product(const std::vector<float>& left, const std::vector<float>& right) {
  return std::inner_product(left.begin(), left.end(), right.begin(), 0.0, std::plus<>(),
                            [](float a, float b) { return static_cast<double>(a) * static_cast<double>(b); });
}

// Call `visit(point, row, column)` for each of some grid points, given by their indices in increasing order.
// The row is found by counting, because dividing an index by the number of columns would take longer than most visits.
template <class Visit>
void visit_points(std::span<const std::int32_t> points, std::size_t columns, Visit visit) {
  std::size_t row = points.empty() ? 0 : static_cast<std::size_t>(points[0]) / columns;
  for (const std::int32_t each : points) {
    const auto point = static_cast<std::size_t>(each);
    while (point >= (row + 1) * columns) {
      ++row;
    }
    visit(point, row, point - row * columns);
  }
}

}  // namespace

Grid Preconditioner::block_grid(const Grid& area) {
  Grid grid = area;
  grid.rows = (area.rows + block_size - 1) / block_size;
  grid.columns = (area.columns + block_size - 1) / block_size;
  grid.spacing_y *= static_cast<double>(block_size);
  grid.spacing_x *= static_cast<double>(block_size);
  grid.periodic = true;
  return grid;
}

Preconditioner::Preconditioner(const Grid& area, Values stencil, const ElasticKernel& blocks, Arrays arrays)
    : rows_(area.rows),
      columns_(area.columns),
      blocks_(blocks),
      result_(std::move(arrays.result)),
      remainder_(std::move(arrays.remainder)),
      foundation_(blocks.grid().size()) {
  resize_on_huge_pages(result_, area.size());
  resize_on_huge_pages(remainder_, area.size());
  std::fill(remainder_.begin(), remainder_.end(), 0.0F);
  const Grid grid = block_grid(area);
  if (area.line || stencil.size() != stencil_.size() || blocks.grid().rows != grid.rows ||
      blocks.grid().columns != grid.columns) {
    throw std::invalid_argument(
        "Preconditioner: the grid must be an area, the stencil 3 x 3 weights, and the kernel on the blocks of the "
        "area");
  }
  std::transform(stencil.begin(), stencil.end(), stencil_.begin(),
                 [](double weight) { return static_cast<float>(weight); });
  along_y_ = interpolation(rows_, grid.rows);
  along_x_ = interpolation(columns_, grid.columns);
}

std::vector<Preconditioner::Interpolation> Preconditioner::interpolation(std::size_t points, std::size_t blocks) {
  std::vector<Interpolation> weights(points);
  for (std::size_t i = 0; i < points; ++i) {
    const double position = (static_cast<double>(i) + 0.5) / static_cast<double>(block_size) - 0.5;
    const double low = std::floor(position);
    const auto last = static_cast<double>(blocks - 1);
    weights[i] = {static_cast<std::int32_t>(std::max(low, 0.0)), static_cast<std::int32_t>(std::min(low + 1.0, last)),
                  static_cast<float>(position - low)};
  }
  return weights;
}

std::span<const float> Preconditioner::operator()(std::span<const std::int32_t> free_points,
                                                  std::span<const float> displacements, Workspace& workspace,
                                                  const ThreadPool& pool) {
  if (displacements.size() != result_.size()) {
    throw std::invalid_argument("Preconditioner: displacements must have as many elements as the grid has points");
  }
  const auto size = static_cast<double>(free_points.size());
  if (foundation_points_ == 0 || std::abs(size - static_cast<double>(foundation_points_)) >
                                     max_foundation_change * static_cast<double>(foundation_points_)) {
    update_foundation(free_points, pool);
  }
  apply_stencil(free_points, displacements, pool);
  sum_on_blocks(free_points, loads_, pool);
  solve_blocks(workspace, pool);
  const std::size_t block_columns = blocks_.grid().columns;
  pool.run_chunks(free_points.size(), points_per_block_task, [&](std::size_t first, std::size_t last) {
    visit_points(free_points.subspan(first, last - first), columns_,
                 [&](std::size_t point, std::size_t row_index, std::size_t column) {
                   const Interpolation& y = along_y_[row_index];
                   const Interpolation& x = along_x_[column];
                   const auto along = [&](std::int32_t row) {
                     const float* values = solution_.data() + static_cast<std::size_t>(row) * block_columns;
                     return values[x.low] + x.fraction * (values[x.high] - values[x.low]);
                   };
                   const float low = along(y.low);
                   remainder_[point] = displacements[point] - (low + y.fraction * (along(y.high) - low));
                 });
  });
  apply_stencil(free_points, remainder_, pool);
  pool.run_chunks(free_points.size(), points_per_block_task, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      remainder_[static_cast<std::size_t>(free_points[k])] = 0.0F;
    }
  });
  return result_;
}

void Preconditioner::update_foundation(std::span<const std::int32_t> free_points, const ThreadPool& pool) {
  for (const std::int32_t point : free_points) {
    remainder_[static_cast<std::size_t>(point)] = 1.0F;  // operator() replaces this value
  }
  apply_stencil(free_points, remainder_, pool);
  sum_on_blocks(free_points, foundation_, pool);
  foundation_points_ = free_points.size();
}

void Preconditioner::apply_stencil(std::span<const std::int32_t> free_points, std::span<const float> values,
                                   const ThreadPool& pool) {
  pool.run_chunks(free_points.size(), points_per_block_task, [&](std::size_t first, std::size_t last) {
    visit_points(
        free_points.subspan(first, last - first), columns_,
        [&](std::size_t point, std::size_t row, std::size_t column) {
          const std::size_t above = (row > 0 ? row : rows_) - 1;
          const std::size_t below = row + 1 < rows_ ? row + 1 : 0;
          const std::size_t left = (column > 0 ? column : columns_) - 1;
          const std::size_t right = column + 1 < columns_ ? column + 1 : 0;
          const auto across = [&](std::size_t source_row, const float* weights) {
            const float* row_values = values.data() + source_row * columns_;
            return weights[0] * row_values[left] + weights[1] * row_values[column] + weights[2] * row_values[right];
          };
          result_[point] = across(above, &stencil_[0]) + across(row, &stencil_[3]) + across(below, &stencil_[6]);
        });
  });
}

void Preconditioner::sum_on_blocks(std::span<const std::int32_t> free_points, std::vector<float>& sums,
                                   const ThreadPool& pool) {
  const std::size_t block_columns = blocks_.grid().columns;
  const std::size_t points_per_sum = std::max(points_per_block_task, free_points.size() / max_tasks + 1);
  task_sums_.resize(std::max<std::size_t>((free_points.size() + points_per_sum - 1) / points_per_sum, 1));
  pool.run(task_sums_.size(), [&](std::size_t task, std::size_t) {
    task_sums_[task].assign(blocks_.grid().size(), 0.0F);
    const std::size_t first = task * points_per_sum;
    const auto task_points =
        free_points.subspan(std::min(first, free_points.size()))
            .first(std::min(points_per_sum, free_points.size() - std::min(first, free_points.size())));
    visit_points(task_points, columns_, [&](std::size_t point, std::size_t row_index, std::size_t column) {
      const Interpolation& y = along_y_[row_index];
      const Interpolation& x = along_x_[column];
      const float high = y.fraction * result_[point];
      const auto add = [&](std::int32_t row, float value) {
        float* row_values = task_sums_[task].data() + static_cast<std::size_t>(row) * block_columns;
        row_values[x.low] += value - x.fraction * value;
        row_values[x.high] += x.fraction * value;
      };
      add(y.low, result_[point] - high);
      add(y.high, high);
    });
  });
  sums = task_sums_[0];
  for (std::size_t task = 1; task < task_sums_.size(); ++task) {
    std::transform(sums.begin(), sums.end(), task_sums_[task].begin(), sums.begin(), std::plus<>());
  }
}

// Solve the block system by conjugate gradients, preconditioned by a half-space on a uniform elastic foundation.
// The foundation stiffness is rounded to a power of two, so that few different spectral filters are needed.
void Preconditioner::solve_blocks(Workspace& workspace, const ThreadPool& pool) {
  const std::size_t size = loads_.size();
  const double mean = std::accumulate(foundation_.begin(), foundation_.end(), 0.0) / static_cast<double>(size);
  solution_.assign(size, 0.0F);
  if (!(mean > 0.0)) {
    return;
  }
  constexpr auto area = static_cast<float>(block_size * block_size);
  const double uniform_foundation = std::exp2(std::round(std::log2(mean / static_cast<double>(area))));
  preconditioned_.resize(size);
  direction_.assign(size, 0.0F);
  response_.resize(size);
  double previous_square = 0.0;
  double first_square = 0.0;
  for (int step = 0; step < max_block_steps; ++step) {
    blocks_.apply_foundation_compliance(loads_, uniform_foundation, preconditioned_, workspace, pool);
    const double square = product(loads_, preconditioned_);
    first_square = step == 0 ? square : first_square;
    if (!(square > block_tolerance * first_square)) {
      return;
    }
    const auto beta = static_cast<float>(step == 0 ? 0.0 : square / previous_square);
    previous_square = square;
    for (std::size_t i = 0; i < size; ++i) {
      direction_[i] = preconditioned_[i] + beta * direction_[i];
    }
    blocks_.apply_stiffness(direction_, response_, workspace, pool);
    for (std::size_t i = 0; i < size; ++i) {
      response_[i] = area * response_[i] + foundation_[i] * direction_[i];
    }
    const double curvature = product(direction_, response_);
    if (!(curvature > 0.0)) {
      return;
    }
    const auto length = static_cast<float>(square / curvature);
    for (std::size_t i = 0; i < size; ++i) {
      solution_[i] += length * direction_[i];
      loads_[i] -= length * response_[i];
    }
  }
}

}  // namespace stiction
