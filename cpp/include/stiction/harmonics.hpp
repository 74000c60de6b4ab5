// The Weierstrass-Mandelbrot sum of Hanaor, Gan & Einav, Tribol. Int. 93 (2016) 229, Eq. 1, on a uniform grid.
//
//     y(x) = Σ_n w_n G_n(x),   G_n(x) = Σ_m { cos φ_mn - cos[ (2π γ^(n-1) x / L) cos(π m / M) + φ_mn ] }
//
// The fractal dimension enters through the weights w_n alone, so one pass over the group profiles G_n serves any
// number of dimensions.
#pragma once

#include "stiction/amplitude.hpp"
#include "stiction/array.hpp"
#include "stiction/checkpoint.hpp"

#include <algorithm>
#include <vector>

namespace stiction {

/// What a sum of harmonics is evaluated on and which of them it keeps.
struct HarmonicGrid {
  double spacing;             ///< Δx [µm] > 0; point j lies at j Δx
  Index points;               ///< >= 1
  double length_scale = 1.0;  ///< L [µm] > 0, the longest wavelength
  double gamma = 1.5;         ///< ratio of successive frequencies, > 1
  bool band_limited = false;  ///< drop every harmonic (m, n) whose wave number exceeds π/Δx
};

/// Amplitudes w_n [µm], n = 1..frequencies: L^H ln γ γ^(-(n-1) H) for the Hurst exponent H [-].
/// H = 4 - 2D for a dimension D in the paper's measure, H = 2 - D in the textbooks'.
std::vector<double> frequency_weights(double hurst_exponent, Index frequencies, double gamma, double length_scale);

/// Σ_n weights(d, n) G_n(x_j) as row d, column j [µm], into the caller's array (rows of weights, points).
/// phases [rad] is (directions M, frequencies N), weights [µm] is (any number of rows, N).
/// Accuracy: the phase of a harmonic is a 64-bit fraction of a turn, which wraps exactly however many turns it makes,
/// so aliased harmonics are as good as the product of a long double wave number and the position. Returns the level of
/// each row, for which it would have to be read again. Throws std::invalid_argument for shapes that do not match,
/// values out of range and unresolvable phases.
std::vector<Level> harmonic_profiles(MatrixView phases, MatrixView weights, const HarmonicGrid& grid,
                                     Eigen::Ref<Matrix> profiles, const Checkpoint& checkpoint = {});

/// The same as a new array. Inline, because its memory is then the caller's own.
inline Matrix harmonic_profiles(MatrixView phases, MatrixView weights, const HarmonicGrid& grid) {
  Matrix profiles(weights.rows(), std::max<Index>(grid.points, 0));
  harmonic_profiles(phases, weights, grid, profiles);
  return profiles;
}

/// What an areal sum is evaluated on: point (i, j) lies at x = j Δx, y = i Δy.
struct HarmonicArea {
  double spacing_y;           ///< Δy [µm] > 0
  double spacing_x;           ///< Δx [µm] > 0
  double length_scale = 1.0;  ///< as for HarmonicGrid
  double gamma = 1.5;
  bool band_limited = false;  ///< drop every harmonic whose wave number along x or y exceeds π/Δx or π/Δy
};

/// The areal sum: that of Eq. 1 with the phases (2π γ^(n-1) / L) (x cos(π m/M) + y sin(π m/M)) + φ_mn and the weights
/// w_n [µm], one for each frequency, into heights [µm] (rows along y, columns along x). With cos(a + b) = cos a cos b -
/// sin a sin b each harmonic is two products of a row and a column. Accuracy and exceptions as `harmonic_profiles`.
void harmonic_surface(MatrixView phases, Values weights, const HarmonicArea& area, Eigen::Ref<Matrix> heights,
                      const Checkpoint& checkpoint = {});

}  // namespace stiction
