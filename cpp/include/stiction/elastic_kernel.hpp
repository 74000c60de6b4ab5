// Displacement of an elastic half-space under pressures on a grid, and what resembles the inverse of that.
#pragma once

#include "stiction/array.hpp"
#include "stiction/crew.hpp"

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace stiction {

/// Points on the surface of a half-space [µm apart]: an area, or a line, which is one row and 1 µm thick.
struct Grid {
  std::size_t rows = 1;
  std::size_t columns = 1;
  double spacing_y = 1.0;
  double spacing_x = 1.0;
  bool line = true;
  bool periodic = false;  ///< whether all is repeated beyond the edges, where else there is nothing

  std::size_t size() const { return rows * columns; }
};

/// The least number from `points` on without other prime factors than 2, 3 and 5, of which transforms are fast.
std::size_t fast_length(std::size_t points);

/// Memory for one transform after the other of one calculation.
class Workspace {
 public:
  Workspace();
  ~Workspace();
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

 private:
  friend class ElasticKernel;
  struct Rooms;
  std::unique_ptr<Rooms> rooms_;
};

/// Displacement [µm] under pressures [GPa] on a grid, of a half-space of modulus E* [GPa] > 0.
///
/// Periodic: 2/(E*|k|) times each wave, 0 for k = 0. Free: that of uniformly loaded cells (Love 1929; Johnson, Contact
/// Mechanics (1985), eq. 3.25; on a line the logarithm), on a grid of twice the size. What resembles the inverse,
/// E*|k|/2, is periodic for both: that is half the transform, and ends that feel each other do no harm there.
class ElasticKernel {
 public:
  /// Throws std::invalid_argument where the grid has no points, spacings or a modulus are not above 0.
  ElasticKernel(const Grid& grid, double effective_modulus, const Crew& crew = Crew());
  ~ElasticKernel();
  ElasticKernel(const ElasticKernel&) = delete;
  ElasticKernel& operator=(const ElasticKernel&) = delete;

  const Grid& grid() const { return grid_; }

  /// In double precision, to round-off of the largest displacement.
  void displacement(Values pressure, std::span<double> moved, Workspace& workspace, const Crew& crew = Crew()) const;

  /// The same in single precision: of steps, which are small.
  void displacement(std::span<const float> pressure, std::span<float> moved, Workspace& workspace,
                    const Crew& crew = Crew()) const;

  /// E*|k|/2 times a residual of displacement.
  void stiffened(std::span<const float> residual, std::span<float> result, Workspace& workspace,
                 const Crew& crew = Crew()) const;

  /// Displacements under loads of a plate of that stiffness on even springs [GPa/µm]: (E*|k|/2 + springs)⁻¹.
  void softened(std::span<const float> loads, double springs, std::span<float> result, Workspace& workspace,
                const Crew& crew = Crew()) const;

  /// E*|k|/2 of a point on the 3 x 3 points around it, row by row, made so that their sum is small: of areas.
  const std::array<double, 9>& stencil() const { return stencil_; }

 private:
  struct Transforms;
  Grid grid_;
  std::array<double, 9> stencil_{};
  std::unique_ptr<Transforms> transforms_;
};

/// Root-mean-square deviation [µm/GPa] of displacements under an even pressure, which only a free grid has.
double even_deviation(const Grid& grid, double effective_modulus);

}  // namespace stiction
