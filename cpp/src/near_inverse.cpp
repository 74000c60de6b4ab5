#include "stiction/near_inverse.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <stdexcept>

namespace stiction {
namespace {

// Conjugate gradients for the blocks, and the square of their residual, over that at the beginning, that ends them.
constexpr int most_block_steps = 5;
constexpr double block_tolerance = 1e-4;
// Relative change of the number of free points up to which springs are kept.
constexpr double springs_kept = 0.02;
// Free points that one thread looks at.
constexpr std::size_t free_points_at_once = std::size_t{1} << 16;
// Sums over blocks that are made at once, and then added.
constexpr std::size_t most_sums = 8;

double product(const std::vector<float>& left, const std::vector<float>& right) {
  return std::inner_product(left.begin(), left.end(), right.begin(), 0.0, std::plus<>(), [](float one, float other) {
    return static_cast<double>(one) * static_cast<double>(other);
  });
}

}  // namespace

Grid NearInverse::blocks_of(const Grid& area) {
  Grid grid = area;
  grid.rows = (area.rows + side - 1) / side;
  grid.columns = (area.columns + side - 1) / side;
  grid.spacing_y *= static_cast<double>(side);
  grid.spacing_x *= static_cast<double>(side);
  grid.periodic = true;
  return grid;
}

NearInverse::NearInverse(const Grid& area, Values stencil, const ElasticKernel& blocks)
    : rows_(area.rows),
      columns_(area.columns),
      blocks_(blocks),
      result_(area.size()),
      rest_(area.size(), 0.0F),
      springs_(blocks.grid().size()) {
  const Grid grid = blocks_of(area);
  if (area.line || stencil.size() != stencil_.size() || blocks.grid().rows != grid.rows ||
      blocks.grid().columns != grid.columns) {
    throw std::invalid_argument("NearInverse: it is of an area, a stencil of 3 x 3 weights and a kernel of its blocks");
  }
  std::transform(stencil.begin(), stencil.end(), stencil_.begin(), [](double one) { return static_cast<float>(one); });
  along_y_ = parts_of(rows_, grid.rows);
  along_x_ = parts_of(columns_, grid.columns);
}

std::vector<NearInverse::Part> NearInverse::parts_of(std::size_t points, std::size_t blocks) {
  std::vector<Part> parts(points);
  for (std::size_t i = 0; i < points; ++i) {
    const double place = (static_cast<double>(i) + 0.5) / static_cast<double>(side) - 0.5;
    const double low = std::floor(place);
    const auto last = static_cast<double>(blocks - 1);
    parts[i] = {static_cast<std::int32_t>(std::max(low, 0.0)), static_cast<std::int32_t>(std::min(low + 1.0, last)),
                static_cast<float>(place - low)};
  }
  return parts;
}

std::span<const float> NearInverse::operator()(std::span<const std::int32_t> free, std::span<const float> moved,
                                               Workspace& workspace, const Crew& crew) {
  if (moved.size() != result_.size()) {
    throw std::invalid_argument("NearInverse: displacements must be on the grid");
  }
  const auto size = static_cast<double>(free.size());
  if (count_ == 0 || std::abs(size - static_cast<double>(count_)) > springs_kept * static_cast<double>(count_)) {
    renew_springs(free, crew);
  }
  sharpen(free, moved, crew);
  gather(free, loads_, crew);
  answer(workspace, crew);
  const std::size_t wide = blocks_.grid().columns;
  crew.in_parts(free.size(), free_points_at_once, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      const auto point = static_cast<std::size_t>(free[k]);
      const Part& y = along_y_[point / columns_];
      const Part& x = along_x_[point % columns_];
      const auto along = [&](std::int32_t row) {
        const float* values = answer_.data() + static_cast<std::size_t>(row) * wide;
        return values[x.low] + x.part * (values[x.high] - values[x.low]);
      };
      const float low = along(y.low);
      rest_[point] = moved[point] - (low + y.part * (along(y.high) - low));
    }
  });
  sharpen(free, rest_, crew);
  crew.in_parts(free.size(), free_points_at_once, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      rest_[static_cast<std::size_t>(free[k])] = 0.0F;
    }
  });
  return result_;
}

void NearInverse::renew_springs(std::span<const std::int32_t> free, const Crew& crew) {
  for (const std::int32_t point : free) {
    rest_[static_cast<std::size_t>(point)] = 1.0F;  // until the answer takes its place
  }
  sharpen(free, rest_, crew);
  gather(free, springs_, crew);
  count_ = free.size();
}

void NearInverse::sharpen(std::span<const std::int32_t> free, std::span<const float> values, const Crew& crew) {
  crew.in_parts(free.size(), free_points_at_once, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      const auto point = static_cast<std::size_t>(free[k]);
      const std::size_t row = point / columns_;
      const std::size_t column = point % columns_;
      const std::size_t above = (row > 0 ? row : rows_) - 1;
      const std::size_t below = row + 1 < rows_ ? row + 1 : 0;
      const std::size_t left = (column > 0 ? column : columns_) - 1;
      const std::size_t right = column + 1 < columns_ ? column + 1 : 0;
      const auto across = [&](std::size_t at, const float* weights) {
        const float* line = values.data() + at * columns_;
        return weights[0] * line[left] + weights[1] * line[column] + weights[2] * line[right];
      };
      result_[point] = across(above, &stencil_[0]) + across(row, &stencil_[3]) + across(below, &stencil_[6]);
    }
  });
}

void NearInverse::gather(std::span<const std::int32_t> free, std::vector<float>& sums, const Crew& crew) {
  const std::size_t wide = blocks_.grid().columns;
  const std::size_t at_once = std::max(free_points_at_once, free.size() / most_sums + 1);
  parts_.resize(std::max<std::size_t>((free.size() + at_once - 1) / at_once, 1));
  crew.each(parts_.size(), [&](std::size_t part, std::size_t) {
    parts_[part].assign(blocks_.grid().size(), 0.0F);
    for (std::size_t k = part * at_once; k < std::min((part + 1) * at_once, free.size()); ++k) {
      const auto point = static_cast<std::size_t>(free[k]);
      const Part& y = along_y_[point / columns_];
      const Part& x = along_x_[point % columns_];
      const float high = y.part * result_[point];
      const auto add = [&](std::int32_t row, float value) {
        float* line = parts_[part].data() + static_cast<std::size_t>(row) * wide;
        line[x.low] += value - x.part * value;
        line[x.high] += x.part * value;
      };
      add(y.low, result_[point] - high);
      add(y.high, high);
    }
  });
  sums = parts_[0];
  for (std::size_t part = 1; part < parts_.size(); ++part) {
    std::transform(sums.begin(), sums.end(), parts_[part].begin(), sums.begin(), std::plus<>());
  }
}

// Preconditioned with even springs, of the next power of two to their mean so that few such plates are made.
void NearInverse::answer(Workspace& workspace, const Crew& crew) {
  const std::size_t size = loads_.size();
  const double mean = std::accumulate(springs_.begin(), springs_.end(), 0.0) / static_cast<double>(size);
  answer_.assign(size, 0.0F);
  if (!(mean > 0.0)) {
    return;
  }
  constexpr auto area = static_cast<float>(side * side);
  const double even = std::exp2(std::round(std::log2(mean / static_cast<double>(area))));
  preconditioned_.resize(size);
  direction_.assign(size, 0.0F);
  response_.resize(size);
  double before = 0.0;
  double first = 0.0;
  for (int step = 0; step < most_block_steps; ++step) {
    blocks_.softened(loads_, even, preconditioned_, workspace, crew);
    const double square = product(loads_, preconditioned_);
    first = step == 0 ? square : first;
    if (!(square > block_tolerance * first)) {
      return;
    }
    const auto beta = static_cast<float>(step == 0 ? 0.0 : square / before);
    before = square;
    for (std::size_t i = 0; i < size; ++i) {
      direction_[i] = preconditioned_[i] + beta * direction_[i];
    }
    blocks_.stiffened(direction_, response_, workspace, crew);
    for (std::size_t i = 0; i < size; ++i) {
      response_[i] = area * response_[i] + springs_[i] * direction_[i];
    }
    const double curvature = product(direction_, response_);
    if (!(curvature > 0.0)) {
      return;
    }
    const auto length = static_cast<float>(square / curvature);
    for (std::size_t i = 0; i < size; ++i) {
      answer_[i] += length * direction_[i];
      loads_[i] -= length * response_[i];
    }
  }
}

}  // namespace stiction
