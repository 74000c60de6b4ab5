// Types for indices and values of grid points: signed indices, double precision.
//
// Units: lengths in µm, forces in mN, pressures in GPa. 1 GPa = 1 mN/µm², so no conversion factors appear. Height is z.
// A profile lies along the x axis, in the plane y = 0.
//
// Headers without matrices include this file instead of array.hpp, because Eigen takes a long time to compile.
#pragma once

#include <cstddef>
#include <span>

namespace stiction {

using Index = std::ptrdiff_t;

/// Heights [µm] of a profile, or other values at the grid points of a profile.
using Values = std::span<const double>;

}  // namespace stiction
