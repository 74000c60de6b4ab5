// Where two maps come nearest to each other: every local minimum of the spline of the gap between them.
#pragma once

#include "stiction/array.hpp"
#include "stiction/bicubic.hpp"
#include "stiction/checkpoint.hpp"

#include <vector>

namespace stiction {

/// A local minimum of a spline, in a cell of its map.
struct Minimum {
  Index row;     ///< of the cell's first point
  Index column;  ///< likewise
  double u;      ///< where in the cell along x, in spacings, from -1e-6 to below 1 - 1e-6
  double v;      ///< likewise along y
  Jet at;        ///< value and derivatives there; first ones are zero to round-off
};

/// Cells of a map: `rows` by `columns` of them from the one in `row` and `column` on.
struct Cells {
  Index row;
  Index column;
  Index rows;
  Index columns;
};

/// Every minimum [µm] at most `highest` of the spline with these coefficients (see natural_bicubic) in some cells, cell
/// by cell along x and then y. Minima on the edge of the map are none, nor is a valley's floor whose curvature is that
/// of round-off. One within 1e-6 of a side of its cell belongs to the cell of which that is the left or lower side,
/// which may be a neighbour of those that were asked for.
///
/// Nothing is missed by chance: a cell is divided until signs of its Bernstein coefficients say that there is no
/// minimum in a part, or that the spline is convex there, so that Newton's method finds the one it can have. What is
/// not decided in parts of 1/64 of a cell, as where a minimum is about to vanish, is left to Newton's method.
std::vector<Minimum> minima(const MatrixView& coefficients, const Cells& where, double highest,
                            const Checkpoint& checkpoint = {});

/// The spline of other heights at the place of a minimum: in the cell in which it truly lies.
Jet at_minimum(const MatrixView& coefficients, const Minimum& minimum);

/// Whether two minima of one cell are the same to round-off.
bool is_same(const Minimum& one, const Minimum& other);

}  // namespace stiction
