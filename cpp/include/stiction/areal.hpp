// Two maps pressed together: contacts are the local minima of the splined gap, each a Hertzian ellipse.
//
// x runs along the columns of a map and y along its rows; both maps share one grid. The approach [µm] is the
// displacement of the upper body towards the lower one, measured from the first touch of grid points. At a minimum of
// the gap both bodies have one slope, so a contact has one normal at every approach; how the normal turns as the bodies
// sink into each other is of second order in overlap over radius and left out.
//
// Of a contact whose ellipse the edge of the map cuts, what lies inside counts: Hertz's pressure integrated over it. So
// force and area of a contact grow with the approach, and that of a long valley is the part of it that is on the map.
//
// What round-off would decide is decided by rules that a turned, mirrored, swapped or lifted pair meets alike. In units
// of the spacing a bend or a slope is none that is below 2^-26 of the gap's range:
// - A minimum that does not bend upwards in every direction is a level valley or floor, and no contact, for it has no
//   lowest point. The grid points of a level floor count as minima of the grid without an answer.
// - A body that does not bend downwards is not hollow: flat in some direction or all, it counts as a summit.
// - What does not slope along the motion does not oppose it.
#pragma once

#include "stiction/array.hpp"
#include "stiction/checkpoint.hpp"
#include "stiction/contact.hpp"
#include "stiction/ellipse.hpp"
#include "stiction/encounter.hpp"
#include "stiction/sums.hpp"

#include <array>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

namespace stiction {

/// Two maps [µm] (rows, columns) on one grid.
struct SurfacePair {
  MatrixView upper;
  MatrixView lower;
  Vector2 spacing;  ///< of columns and of rows, (Δx, Δy) [µm]
};

/// How two bodies with slopes p meet whose gap has the Hessian `xx, xy, yy` [1/µm] there: the relative curvatures are
/// its eigenvalues over q = sqrt(1 + p²) in the metric I + p pᵀ of the tangent plane.
struct Meeting {
  Vector3 normal;  ///< from the lower to the upper body, (-p, 1)/q
  Radii radii;     ///< of the relative curvature, both > 0
  Vector3 along;   ///< unit vector of the tangent plane along which the radius is the larger one
};

/// For a positive definite Hessian.
Meeting meeting(const Vector2& slope, double xx, double xy, double yy);

/// A minimum of the gap, which touches at approaches above `gap`.
struct ArealCandidate {
  Index row;         ///< of the cell that owns it: that of its first point
  Index column;      ///< likewise
  Vector3 position;  ///< of the lower body there [µm]
  double gap;        ///< above first touch of grid points [µm]; may be somewhat below 0
  double room;       ///< overlap [µm] at which its elastic ellipse reaches the edge of the map
  Vector3 normal;
  Radii radii;
  Vector3 along;    ///< of the larger semi-axis
  Ellipse ellipse;  ///< elastic

  double overlap(double approach) const { return (approach - gap) * normal.z(); }
};

/// Candidates found once, for any number of presses up to an approach of `deepest`.
struct ArealCandidates {
  std::vector<ArealCandidate> all;  ///< cell by cell along x and then y
  std::vector<double> grid_minima;  ///< gaps [µm] of the points of which no neighbour is lower, increasing
  std::vector<double> unanswered;   ///< of those beside which the spline has no minimum: in none of the four cells
  double deepest;                   ///< [µm]
  Vector2 spacing;                  ///< of columns and of rows [µm]
  Index rows;                       ///< of the maps
  Index columns;                    ///< likewise
};

/// Heights that differ by less than this share of the largest are equal: what round-off in heights, in their difference
/// and in its spline may make of it.
inline constexpr double round_off_share = 0x1p-46;

/// Along a valley, a rise from one point to the next below this share of the gap's range is none: where a minimum lies
/// is then known to some 1e-8 of a spacing at best.
inline constexpr double level_share = 0x1p-26;

/// All with a gap of at most `deepest` [µm] >= 0. `convex` asks for both bodies to be summits, `signed_` only for a
/// minimum of the gap. Maps have equal shapes of at least 4 by 4 finite heights, and their gap is not the same
/// everywhere. Throws std::invalid_argument.
ArealCandidates candidates(const SurfacePair& pair, double deepest, Curvature curvature,
                           const Checkpoint& checkpoint = {});

/// `Sums`, and what only areas have. Lateral is the horizontal direction 90 degrees to the left of the motion.
struct ArealSums : Sums {
  double lateral_elastic = 0.0;     ///< -Σ F c·n, c being the lateral unit vector [mN]
  double lateral_frictional = 0.0;  ///< -Σ F c·t [mN] per unit mu0
  double lateral_adhesive = 0.0;    ///< -Σ A c·t [mN] per GPa of tau0
  double load_overlapping = 0.0;    ///< Σ F n_z of contacts whose ellipse overlaps another one [mN]
  double load_at_edge = 0.0;        ///< Σ F n_z of contacts whose ellipse the edge of the map cuts [mN]
  Index grid_minimum_count = 0;     ///< points within the approach of which no neighbour is lower
  Index unanswered_count = 0;       ///< of those, beside which the spline has no minimum
};

/// A member of `ArealSums` that is none of `Sums`.
struct ArealQuantity {
  std::string_view name;
  std::string_view unit;
  std::string_view words;
  std::variant<Index ArealSums::*, double ArealSums::*> member;
};

/// All of them.
inline constexpr std::array areal_quantities{
    ArealQuantity{"lateral_elastic", "mN", "lateral load of the elastic forces of sliding contacts",
                  &ArealSums::lateral_elastic},
    ArealQuantity{"lateral_frictional", "mN", "lateral load per unit mu0", &ArealSums::lateral_frictional},
    ArealQuantity{"lateral_adhesive", "mN/GPa", "lateral load per unit tau0", &ArealSums::lateral_adhesive},
    ArealQuantity{"load_overlapping", "mN", "normal load of contacts whose ellipse overlaps another one",
                  &ArealSums::load_overlapping},
    ArealQuantity{"load_at_edge", "mN", "normal load of contacts whose ellipse the edge of the map cuts",
                  &ArealSums::load_at_edge},
    ArealQuantity{"grid_minimum_count", "1", "number of grid points of which no neighbour is lower",
                  &ArealSums::grid_minimum_count},
    ArealQuantity{"unanswered_count", "1", "number of those beside which the spline has no minimum",
                  &ArealSums::unanswered_count},
};

/// Every contact at one approach [µm] >= 0, in the order of the candidates; `index` is row · columns + column.
std::vector<Contact> contacts(const ArealCandidates& found, double approach, const Law& law, const Vector2& direction);

/// The sums for every direction and, in it, every approach [µm] >= 0 and strictly increasing: (directions, approaches),
/// row by row. Directions are horizontal unit vectors. HertzSphere is taken on the ellipse, other laws of spheres
/// on the sphere of the mean radius; HertzCylinder is refused. Throws std::invalid_argument.
std::vector<ArealSums> press(const ArealCandidates& found, Values approaches, const Law& law,
                             std::span<const Vector2> directions, Sliding sliding, const Checkpoint& checkpoint = {});

/// The same in the one direction of a model, of which it takes the law and the sliding rule as well.
std::vector<ArealSums> press(const ArealCandidates& found, Values approaches, const ContactModel& model,
                             const Checkpoint& checkpoint = {});

}  // namespace stiction
