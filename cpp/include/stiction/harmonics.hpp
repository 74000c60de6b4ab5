// Weierstrass-Mandelbrot profiles of Hanaor, Gan & Einav, Tribol. Int. 93 (2016) 229, Eq. 1, on a uniform grid.
//
//     y(x) = Σ_n w_n G_n(x),   G_n(x) = Σ_m { cos φ_mn - cos[ (2π γ^(n-1) x / L) cos(π m / M) + φ_mn ] }
//
// Only the weights w_n depend on the fractal dimension D, so the profiles G_n are computed once for all values of D.
#pragma once

#include "stiction/amplitude.hpp"
#include "stiction/array.hpp"
#include "stiction/cancellation.hpp"

#include <algorithm>
#include <vector>

namespace stiction {

struct HarmonicGrid {
  double spacing;             ///< Δx [µm] > 0; point j lies at j Δx
  Index points;               ///< number of points, at least 1
  double length_scale = 1.0;  ///< L [µm] > 0, the longest wavelength
  double gamma = 1.5;         ///< ratio of successive frequencies, > 1
  bool band_limited = false;  ///< true to omit harmonics (m, n) whose wavenumber exceeds π/Δx
};

/// Compute the amplitudes w_n [µm], n = 1..frequencies: L^H ln γ γ^(-(n-1) H) for the Hurst exponent H [-].
/// Hanaor, Gan & Einav define the fractal dimension D by H = 4 - 2D. The usual definition is H = 2 - D.
std::vector<double> frequency_weights(double hurst_exponent, Index frequencies, double gamma, double length_scale);

/// Write the sum Σ_n weights(d, n) G_n(x_j) [µm] to the element of `profiles` in row d and column j.
/// `phases` [rad] has the shape (directions M, frequencies N). `weights` [µm] has the shape (any number of rows, N).
/// The only error in the phase of a harmonic is the round-off of (wavenumber · position) in long double.
/// Throws std::invalid_argument if shapes differ, values are out of range, or a phase has too many turns to resolve.
std::vector<HeightStatistics> harmonic_profiles(MatrixView phases, MatrixView weights, const HarmonicGrid& grid,
                                                Eigen::Ref<Matrix> profiles,
                                                const CancellationCheck& check_cancellation = {});

/// Return the profiles of harmonics as a new array. The function is inline, so that the caller allocates the memory.
inline Matrix harmonic_profiles(MatrixView phases, MatrixView weights, const HarmonicGrid& grid) {
  Matrix profiles(weights.rows(), std::max<Index>(grid.points, 0));
  harmonic_profiles(phases, weights, grid, profiles);
  return profiles;
}

/// Grid of a surface, and harmonics whose sum is the surface. Grid point (i, j) is at x = j Δx, y = i Δy.
struct HarmonicArea {
  double spacing_y;           ///< Δy [µm] > 0
  double spacing_x;           ///< Δx [µm] > 0
  double length_scale = 1.0;  ///< longest wavelength L [µm] > 0
  double gamma = 1.5;
  bool band_limited = false;  ///< true to omit harmonics whose wavenumber along x or y exceeds π/Δx or π/Δy
};

/// Write a surface, the areal form of the profile of Eq. 1, to `heights` [µm] (rows along y, columns along x).
/// The phase of a harmonic is (2π γ^(n-1) / L) (x cos(π m/M) + y sin(π m/M)) + φ_mn.
void harmonic_surface(MatrixView phases, Values weights, const HarmonicArea& area, Eigen::Ref<Matrix> heights,
                      const CancellationCheck& check_cancellation = {});

}  // namespace stiction
