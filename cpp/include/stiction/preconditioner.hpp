// Preconditioner of the half-space solver for areas: approximate inverse of the elastic kernel on the free points.
#pragma once

#include "stiction/elastic_kernel.hpp"
#include "stiction/thread_pool.hpp"
#include "stiction/values.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace stiction {

/// Approximate inverse of the elastic kernel K: pressures that approximately cause given displacements.
///
/// A 3 x 3 stencil S describes the short-range elastic interaction of neighbouring free points.
/// A kernel K' on blocks of points describes the slowly varying displacement that distant points cause.
/// Bilinear weights P interpolate between the blocks and the points.
/// K is approximately S⁻¹ + P'K'P, where P' is the transpose of P, with the inverse S - SP'(K'⁻¹ + PSP')⁻¹PS.
/// The grid of blocks is periodic, so K'⁻¹ multiplies a displacement with the wavenumber k by E* |k| / 2.
/// K'⁻¹ + PSP' describes a half-space on an elastic foundation with the stiffness PSu, where u is 1 at each free point.
/// With the preconditioner, the number of solver iterations is almost independent of the grid size.
class Preconditioner {
 public:
  static constexpr std::size_t block_size = 16;

  struct Arrays {
    std::vector<float> result;
    std::vector<float> remainder;
  };

  /// Return the grid of blocks: a periodic grid with one point for each block of an area.
  static Grid block_grid(const Grid& area);

  /// Throws std::invalid_argument if the grid of the kernel is not `block_grid(area)`, or if the stencil is not 3 x 3.
  Preconditioner(const Grid& area, Values stencil, const ElasticKernel& blocks, Arrays arrays = {});

  /// Compute pressures [GPa] at the free points from displacements [µm] on the grid.
  /// The indices of the free points must be in increasing order.
  /// Displacements must be 0 at all points that are not free. Pressures at points that are not free are unspecified.
  /// The returned pressures are valid until the next call of this operator.
  std::span<const float> operator()(std::span<const std::int32_t> free_points, std::span<const float> displacements,
                                    Workspace& workspace, const ThreadPool& pool = ThreadPool());

  /// After `take_arrays`, the preconditioner must not be used.
  Arrays take_arrays() { return {std::move(result_), std::move(remainder_)}; }

 private:
  /// Apply the stencil to `values`, which repeat periodically beyond the edges of the grid.
  void apply_stencil(std::span<const std::int32_t> free_points, std::span<const float> values, const ThreadPool& pool);
  /// Multiply the stencil's results by the bilinear weights of the free points, and add up the products in each block.
  void sum_on_blocks(std::span<const std::int32_t> free_points, std::vector<float>& sums, const ThreadPool& pool);
  void update_foundation(std::span<const std::int32_t> free_points, const ThreadPool& pool);
  void solve_blocks(Workspace& workspace, const ThreadPool& pool);

  struct Interpolation {
    std::int32_t low;
    std::int32_t high;
    float fraction;  // weight of the block with the higher index
  };
  static std::vector<Interpolation> interpolation(std::size_t points, std::size_t blocks);

  std::size_t rows_;
  std::size_t columns_;
  std::array<float, 9> stencil_{};
  const ElasticKernel& blocks_;
  std::vector<Interpolation> along_y_;
  std::vector<Interpolation> along_x_;
  std::vector<float> result_;     // pressures on the grid, valid at free points only
  std::vector<float> remainder_;  // displacements minus their block interpolation; 0 at constrained points
  std::vector<float> foundation_;
  std::size_t foundation_points_ = 0;          // number of free points when the foundation stiffness was computed
  std::vector<std::vector<float>> task_sums_;  // block sums of each task
  std::vector<float> loads_;                   // loads on the blocks; all members below refer to blocks too
  std::vector<float> solution_;
  std::vector<float> preconditioned_;
  std::vector<float> direction_;
  std::vector<float> response_;
};

}  // namespace stiction
