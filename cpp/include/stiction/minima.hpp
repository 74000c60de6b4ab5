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
/// Omits minima above `max_value` [µm] or on the edge of the map, and minima whose curvature is only round-off.
/// A minimum within 1e-6 of the boundary between two cells belongs to the right or to the upper cell.
/// A minimum found at the edge of the range of cells may belong to a neighbouring cell outside the range.
///
/// A cell is divided into parts until Bernstein coefficients show that each part is convex or contains no minimum.
/// The side of the smallest part is 1/64 of the cell's side.
/// Newton's method finds the minimum of each part that is convex or still undecided, if the part contains a minimum.
std::vector<Minimum> minima(const MatrixView& coefficients, const CellRange& range, double max_value,
                            const CancellationCheck& check_cancellation = {});

/// Evaluate the spline with `coefficients` on the same grid at the position of a minimum of another spline.
Jet at_minimum(const MatrixView& coefficients, const Minimum& minimum);

bool is_same(const Minimum& first, const Minimum& second);

}  // namespace stiction
