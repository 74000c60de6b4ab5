// Local minima of a bicubic spline, such as the spline of the gap between two maps.
#pragma once

#include "stiction/array.hpp"
#include "stiction/bicubic.hpp"
#include "stiction/cancellation.hpp"

#include <vector>

namespace stiction {

/// Local minimum of a spline in one cell of a map.
struct Minimum {
  Index row;     ///< row of the first grid point of the cell
  Index column;  ///< column of the first grid point of the cell
  /// Position in the cell along x, in units of the grid spacing. The position is at least -1e-6 and below 1 - 1e-6.
  double u;
  double v;  ///< position in the cell along y, in units of the spacing
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

/// Find all minima of a spline in a range of cells, in the order of the cells, row by row.
/// `coefficients` are the coefficients of the spline (see natural_bicubic).
/// Minima above `max_value` [µm] and minima on the edge of the map are left out.
/// Valleys whose curvature is only round-off are left out.
/// A minimum within 1e-6 of the boundary between two cells belongs to the right or to the upper cell.
/// A minimum found at the edge of the range of cells may belong to a neighbouring cell outside the range.
///
/// The search is exhaustive. Each cell is divided until the spline in each part has no minimum or is convex.
/// The signs of the Bernstein coefficients can prove that the spline in a part of a cell has no minimum, or is convex.
/// In a part in which the spline is convex, Newton's method finds the only possible minimum.
/// The subdivision ends at 1/64 of the side of a cell.
/// Parts of a cell may then be undecided, for example where a minimum is about to vanish.
/// In an undecided part of a cell, Newton's method shows whether there is a minimum.
std::vector<Minimum> minima(const MatrixView& coefficients, const CellRange& range, double max_value,
                            const CancellationCheck& check_cancellation = {});

/// Evaluate a different spline at the position of a minimum, in the cell that contains this position.
Jet at_minimum(const MatrixView& coefficients, const Minimum& minimum);

bool is_same(const Minimum& first, const Minimum& second);

}  // namespace stiction
