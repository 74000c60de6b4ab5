// Local minima of a bicubic spline, such as the spline of the gap between two maps.
#pragma once

#include "stiction/array.hpp"
#include "stiction/bicubic.hpp"
#include "stiction/cancellation.hpp"

#include <vector>

namespace stiction {

struct Minimum {
  Index row;  ///< (row, column) is the first grid point of the cell
  Index column;
  /// Position in the cell along x, in units of the grid spacing. The position is at least -1e-6 and below 1 - 1e-6.
  double u;
  double v;
  /// Value and derivatives of the spline at the minimum. The first derivatives are zero to within round-off.
  Jet at;
};

/// Range of cells of a map: `rows` by `columns` cells, starting at (`row`, `column`).
struct CellRange {
  Index row;
  Index column;
  Index rows;
  Index columns;
};

/// Find all minima of the spline with `coefficients` (see natural_bicubic) in a range of cells, row by row.
/// Minima above `max_value` [µm], on the edge of the map, or with a curvature that is only round-off are left out.
/// A minimum within 1e-6 of the boundary between two cells belongs to the right or to the upper cell.
/// A minimum found at the edge of the range of cells may belong to a neighbouring cell outside the range.
///
/// A cell is divided, down to 1/64 of its side, until Bernstein coefficients prove a part convex or without a minimum.
/// Newton's method finds the minimum, if there is one, of each part that is convex or still undecided.
std::vector<Minimum> minima(const MatrixView& coefficients, const CellRange& range, double max_value,
                            const CancellationCheck& check_cancellation = {});

/// Evaluate another spline, on the grid of the same map, at the position of a minimum.
Jet at_minimum(const MatrixView& coefficients, const Minimum& minimum);

bool is_same(const Minimum& first, const Minimum& second);

}  // namespace stiction
