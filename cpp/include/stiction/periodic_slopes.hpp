// Slopes of periodic maps, from Fourier transforms of their rows and columns.
#pragma once

#include "stiction/array.hpp"

namespace stiction {

/// Compute slopes along the rows (x) and, if there are several rows, along the columns (y). `spacing` is (Δx, Δy) [µm].
/// The slopes are exact for waves below the Nyquist limit, and 0 for waves at the Nyquist limit.
/// The round-off is about 1e-16 · (largest height)/(spacing).
void periodic_slopes(const MatrixView& heights, const Vector2& spacing, Eigen::Ref<Matrix> along_x,
                     Eigen::Ref<Matrix> along_y);

}  // namespace stiction
