// What resembles the inverse of an area's kernel on the points that are free to move.
#pragma once

#include "stiction/array.hpp"
#include "stiction/crew.hpp"
#include "stiction/elastic_kernel.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace stiction {

/// Pressures of free points under which these move by about as much as is asked for.
///
/// Near a point they are those of a 3 x 3 stencil S on free points, as if no other contact were there. The rest of the
/// area moves it, too, and slowly from place to place: K' on blocks of points, which bilinear weights P lead to. So K
/// is about S⁻¹ + P'K'P, and its inverse S - SP'(K'⁻¹ + PSP')⁻¹PS. With K'⁻¹ = E*|k|/2, as on periodic blocks, the
/// system in brackets is a plate on springs, whose stiffness on each block is PS1; a few conjugate gradients answer it.
/// Iterations of a search then hardly depend on the number of points.
class NearInverse {
 public:
  /// Points along the sides of a block.
  static constexpr std::size_t side = 16;

  /// The blocks of an area, repeated beyond the edges.
  static Grid blocks_of(const Grid& area);

  /// Of an area's stencil and the kernel of its blocks, which must outlive it.
  /// Throws std::invalid_argument where the kernel is not on the blocks of the area, or a stencil is not 3 x 3.
  NearInverse(const Grid& area, Values stencil, const ElasticKernel& blocks);

  /// Pressures [GPa] at free points, which rise, for displacements [µm] on the grid, which are 0 at other points. Of
  /// other points the answer holds anything. It is good until the next one.
  std::span<const float> operator()(std::span<const std::int32_t> free, std::span<const float> moved,
                                    Workspace& workspace, const Crew& crew = Crew());

 private:
  /// Sums over each free point and those around it, over the edges too, of what lies on the grid.
  void sharpen(std::span<const std::int32_t> free, std::span<const float> values, const Crew& crew);
  void gather(std::span<const std::int32_t> free, std::vector<float>& sums, const Crew& crew);
  void renew_springs(std::span<const std::int32_t> free, const Crew& crew);
  void answer(Workspace& workspace, const Crew& crew);

  struct Part {  // of a point along an axis
    std::int32_t low;
    std::int32_t high;
    float part;  // of the higher block
  };
  static std::vector<Part> parts_of(std::size_t points, std::size_t blocks);

  std::size_t rows_;
  std::size_t columns_;
  std::array<float, 9> stencil_{};
  const ElasticKernel& blocks_;
  std::vector<Part> along_y_;
  std::vector<Part> along_x_;
  std::vector<float> result_;  // on the grid, of free points
  std::vector<float> rest_;    // on the grid, 0 where points are not free
  std::vector<float> springs_;
  std::size_t count_ = 0;                  // of points that springs are of
  std::vector<std::vector<float>> parts_;  // sums of some free points
  std::vector<float> loads_;               // on blocks, as all that follows
  std::vector<float> answer_;
  std::vector<float> preconditioned_;
  std::vector<float> direction_;
  std::vector<float> response_;
};

}  // namespace stiction
