// Contact of two height maps. Each contact is a Hertzian ellipse at a local minimum of the spline through the gap.
//
// The x axis points along a row of a map and the y axis along a column. Both maps have the same grid.
// The approach [µm] is the displacement of the upper surface towards the lower since the first contact of grid points.
// The contact normal stays constant as the overlap grows, because its rotation is of second order in overlap/radius.
//
// Round-off must not decide whether a nearly level minimum of the gap is a contact.
// The following rules make the result independent of rotating, mirroring, swapping or shifting the pair of maps:
// - A level valley or plateau of the gap (see `level_fraction`) has no single lowest point, so it is not a contact.
// - A grid point on a level plateau of the gap counts as a grid minimum, although the spline has no minimum there.
// - A point of a surface counts as a summit unless the surface is concave there in some direction. It may be level.
// - A contact whose slope along the motion is zero does not oppose the motion.
#pragma once

#include "stiction/array.hpp"
#include "stiction/asperity_pair.hpp"
#include "stiction/cancellation.hpp"
#include "stiction/contact.hpp"
#include "stiction/ellipse.hpp"
#include "stiction/sums.hpp"

#include <array>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

namespace stiction {

struct SurfacePair {
  MatrixView upper;
  MatrixView lower;
  Vector2 spacing;  ///< (Δx, Δy): distance between columns, and distance between rows [µm]
};

/// Contact normal, and principal radii of the gap, at a point where two surfaces have the same slope p.
struct ContactGeometry {
  Vector3 normal;  ///< unit vector from the lower to the upper surface, (-p, 1)/sqrt(1 + p²)
  Radii radii;     ///< principal radii of the relative curvature, both > 0
  Vector3 along;   ///< unit vector in the tangent plane, in the direction of the larger radius
};

/// Compute the contact geometry from the slope p and a positive definite Hessian matrix [1/µm] of the gap.
/// The principal curvatures are the eigenvalues of the Hessian matrix in the metric I + p pᵀ, divided by sqrt(1 + p²).
ContactGeometry contact_geometry(const Vector2& slope, double xx, double xy, double yy);

/// Local minimum of the gap. The surfaces touch at the minimum if the approach is larger than the member `gap`.
struct ArealCandidate {
  Index row;  ///< (row, column) is the first grid point of the cell that contains the minimum
  Index column;
  Vector3 position;  ///< position of the minimum on the lower surface [µm]
  /// Gap [µm] at the minimum for zero approach; negative if the spline dips below the smallest gap on the grid.
  double gap;
  double edge_overlap;  ///< overlap [µm] at which the contact ellipse of elastic bodies reaches the edge of the map
  Vector3 normal;
  Radii radii;
  Vector3 along;    ///< direction of the larger semi-axis of the ellipse
  Ellipse ellipse;  ///< contact ellipse of elastic bodies

  double overlap(double approach) const { return (approach - gap) * normal.z(); }
};

struct ArealCandidates {
  std::vector<ArealCandidate> all;  ///< candidates in the order of their cells, row by row
  /// Gaps [µm] at grid points where no neighbouring grid point has a smaller gap, in ascending order.
  std::vector<double> grid_minima;
  /// Gaps [µm] at grid minima whose four adjacent cells contain no minimum of the spline of the gap.
  std::vector<double> unanswered;
  double deepest;   ///< largest approach [µm] at which all contacts are candidates
  Vector2 spacing;  ///< distance between columns, and between rows, of the maps [µm]
  Index rows;
  Index columns;
};

/// Two heights count as equal if they differ by less than this fraction of the largest height of the map.
inline constexpr double round_off_fraction = 0x1p-46;

/// Derivatives of the gap per grid step [µm] count as zero up to this fraction of (largest gap - smallest gap).
inline constexpr double level_fraction = 0x1p-26;

/// Find all contact candidates with a gap of at most `deepest` (>= 0) [µm].
/// The curvature rule `convex` requires a summit of both surfaces; `signed_` requires only a minimum of the gap.
/// Throws std::invalid_argument unless the maps have equal shapes (>= 4 by 4), finite heights, and a gap that varies.
ArealCandidates candidates(const SurfacePair& pair, double deepest, Curvature curvature,
                           const CancellationCheck& check_cancellation = {});

/// Sums over the contacts of two maps. "Lateral" means the horizontal direction 90 degrees to the left of the motion.
struct ArealSums : Sums {
  double lateral_elastic = 0.0;     ///< -Σ F c·n [mN], where c is the lateral unit vector
  double lateral_frictional = 0.0;  ///< -Σ F c·t [mN] per unit mu0
  double lateral_adhesive = 0.0;    ///< -Σ A c·t [mN] per GPa of tau0
  double load_overlapping = 0.0;    ///< Σ F n_z [mN] of contacts whose ellipse overlaps another ellipse
  double load_at_edge = 0.0;        ///< Σ F n_z [mN] of contacts whose ellipse is cut by the edge of the map
  /// Number of grid minima: points whose gap is at most the approach, and at most the gap of every neighbour.
  Index grid_minimum_count = 0;
  /// Number of grid minima for which the spline of the gap has no minimum in the four adjacent cells.
  Index unanswered_count = 0;
};

struct ArealQuantity {
  std::string_view name;
  std::string_view unit;
  std::string_view description;
  std::variant<Index ArealSums::*, double ArealSums::*> member;
};

inline constexpr std::array areal_quantities{
    ArealQuantity{"lateral_elastic", "mN", "lateral load of the elastic forces of sliding contacts",
                  &ArealSums::lateral_elastic},
    ArealQuantity{"lateral_frictional", "mN", "lateral load per unit mu0", &ArealSums::lateral_frictional},
    ArealQuantity{"lateral_adhesive", "mN/GPa", "lateral load per unit tau0", &ArealSums::lateral_adhesive},
    ArealQuantity{"load_overlapping", "mN", "normal load of contacts whose ellipse overlaps another ellipse",
                  &ArealSums::load_overlapping},
    ArealQuantity{"load_at_edge", "mN", "normal load of contacts whose ellipse is cut by the edge of the map",
                  &ArealSums::load_at_edge},
    ArealQuantity{"grid_minimum_count", "1", "number of grid points without a lower neighbour",
                  &ArealSums::grid_minimum_count},
    ArealQuantity{"unanswered_count", "1", "number of grid minima without a spline minimum nearby",
                  &ArealSums::unanswered_count},
};

/// List the contacts at one approach (>= 0) [µm]. Contacts have the same order as their candidates.
/// The index of a contact is the index of its map cell: row · columns + column.
std::vector<Contact> contacts(const ArealCandidates& candidates, double approach, const Law& law,
                              const Vector2& direction);

/// Compute the contact sums for every direction and approach, ordered by direction, then by approach.
/// Approaches [µm] must be at least 0 and strictly increasing. Directions are horizontal unit vectors.
/// HertzSphere is applied to the contact ellipse, other laws to a sphere with the radius `Radii::mean`.
/// Throws std::invalid_argument for invalid arguments and for HertzCylinder.
std::vector<ArealSums> press(const ArealCandidates& candidates, Values approaches, const Law& law,
                             std::span<const Vector2> directions, Sliding sliding,
                             const CancellationCheck& check_cancellation = {});

std::vector<ArealSums> press(const ArealCandidates& candidates, Values approaches, const ContactModel& model,
                             const CancellationCheck& check_cancellation = {});

}  // namespace stiction
