// Displacements of an elastic half-space due to pressures on a grid, and spectral filters for preconditioning.
#pragma once

#include "stiction/thread_pool.hpp"
#include "stiction/values.hpp"

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace stiction {

/// Grid on the surface of a half-space: an area, or a line, which is a single row of cells that are 1 µm wide.
struct Grid {
  std::size_t rows = 1;
  std::size_t columns = 1;
  double spacing_y = 1.0;
  double spacing_x = 1.0;
  bool line = true;
  /// True if the grid repeats periodically. Otherwise, the half-space outside the grid is free of load.
  bool periodic = false;

  std::size_t size() const { return rows * columns; }
};

/// Return the smallest length >= `points` with only the prime factors 2, 3 and 5, for which FFTs are fast.
std::size_t fast_length(std::size_t points);

class Workspace {
 public:
  Workspace();
  ~Workspace();
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

 private:
  friend class ElasticKernel;
  friend class StiffnessKernel;
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
};

/// Displacements [µm] of the surface of a half-space with effective modulus E* [GPa] > 0 due to pressures [GPa].
///
/// On a periodic grid, the Fourier component of the pressures with wavenumber k is multiplied by 2/(E*|k|); 0 if k = 0.
/// On a free grid, the displacements due to uniformly loaded cells are added up on a grid of twice the size.
/// Sources: Love 1929; Johnson, Contact Mechanics (1985), eq. 3.25.
/// Even on a free grid, the stiffness E*|k|/2 is that of a periodic surface, so it serves only as a preconditioner.
class ElasticKernel {
 public:
  /// Throws std::invalid_argument if the grid is empty, or if a spacing or the modulus is not positive.
  ElasticKernel(const Grid& grid, double effective_modulus, const ThreadPool& pool = ThreadPool());
  ~ElasticKernel();
  ElasticKernel(const ElasticKernel&) = delete;
  ElasticKernel& operator=(const ElasticKernel&) = delete;

  const Grid& grid() const { return grid_; }

  /// `pressure` and `displacements` may be the same array.
  /// On 2D grids, displacements are computed and written only in the rows `rows` or, if `rows` is empty, in all rows.
  void displacement(Values pressure, std::span<double> displacements, Workspace& workspace,
                    const ThreadPool& pool = ThreadPool(), std::span<const std::size_t> rows = {}) const;

  void displacement(std::span<const float> pressure, std::span<float> displacements, Workspace& workspace,
                    const ThreadPool& pool = ThreadPool(), std::span<const std::size_t> rows = {}) const;

  /// Multiply each Fourier component of `values` by E*|k|/2, the stiffness of a half-space at the wavenumber k.
  void apply_stiffness(std::span<const float> values, std::span<float> result, Workspace& workspace,
                       const ThreadPool& pool = ThreadPool()) const;

  /// Multiply each Fourier component of `loads` by 1/(E*|k|/2 + foundation), where k is the component's wavenumber.
  /// `foundation` [GPa/µm] > 0 is the stiffness of a uniform elastic foundation.
  void apply_foundation_compliance(std::span<const float> loads, double foundation, std::span<float> result,
                                   Workspace& workspace, const ThreadPool& pool = ThreadPool()) const;

  /// Return, row by row, the nine weights of a 3 x 3 stencil that approximates the stiffness E*|k|/2 on an area.
  /// The weight of the central point is chosen so that the sum of all nine weights is a small positive number.
  const std::array<double, 9>& stencil() const { return stencil_; }

 private:
  struct Transforms;
  Grid grid_;
  std::array<double, 9> stencil_{};
  std::unique_ptr<Transforms> transforms_;
};

/// Pressures [GPa] that displace the surface of a half-space by given amounts [µm]: the inverse of ElasticKernel.
///
/// A free grid is extended by zero padding to a periodic grid, whose first rows and columns are the original grid.
/// If the pressure is 0 outside the original grid, displacements inside it are those of ElasticKernel plus a constant.
/// A periodic grid needs no zero padding. Displacing a periodic surface uniformly requires no pressure.
class StiffnessKernel {
 public:
  StiffnessKernel(const Grid& grid, double effective_modulus, const ThreadPool& pool = ThreadPool());
  ~StiffnessKernel();
  StiffnessKernel(const StiffnessKernel&) = delete;
  StiffnessKernel& operator=(const StiffnessKernel&) = delete;

  std::size_t rows() const;     ///< number of rows of the extended grid
  std::size_t columns() const;  ///< number of columns of the extended grid
  std::size_t size() const { return rows() * columns(); }

  /// Compute the pressures [GPa] that cause given displacements [µm]. Both arguments may be the same array.
  void pressure(Values displacements, std::span<double> pressures, Workspace& workspace,
                const ThreadPool& pool = ThreadPool()) const;

  void pressure(std::span<const float> displacements, std::span<float> pressures, Workspace& workspace,
                const ThreadPool& pool = ThreadPool()) const;

  void displacement(Values pressures, std::span<double> displacements, Workspace& workspace,
                    const ThreadPool& pool = ThreadPool()) const;

  /// Compute displacements [µm] from pressures [GPa]. Wavenumber 0 gets the largest compliance of all wavenumbers.
  void precondition(std::span<const float> pressures, std::span<float> displacements, Workspace& workspace,
                    const ThreadPool& pool = ThreadPool()) const;

 private:
  struct Transforms;
  std::unique_ptr<const Transforms> transforms_;
};

/// Return the standard deviation [µm/GPa] of displacements over the grid under uniform pressure; 0 if periodic.
double uniform_pressure_deviation(const Grid& grid, double effective_modulus);

}  // namespace stiction
