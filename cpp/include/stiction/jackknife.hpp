// Power sums of jackknife values, from which the interval of an ensemble mean at a given mean load is computed.
//
// Consider R repetitions of an ensemble at a load step at which their mean normal load is F.
// Leaving out one repetition with the value v changes the mean value by dv = (mean(v) - v) / (R - 1).
// Leaving out one repetition with the normal load n changes the mean load by dn = (F - n) / (R - 1).
// Let s = d mean(v) / d mean(n). Leaving out a repetition changes the mean value at the load F by dv - s dn.
// The logarithm of the mean value at the load F changes by ln(1 + dv / mean(v)) - s F / mean(v) ln(1 + dn / F).
#pragma once

#include "stiction/array.hpp"

#include <span>

namespace stiction {

/// View of several curves: the values of all repetitions at each load step. Values at one step are adjacent in memory.
struct CurveView {
  const double* values;
  Index curve_stride;  ///< number of values from one curve to the next; 0 if all curves share their values
  Index step_stride;   ///< number of values from one step to the next
};

/// Points on curves at which the mean load reaches a given load. All arrays have one element per point.
struct CurvePoints {
  std::span<const Index> curve;  ///< index of the curve
  std::span<const Index> step;   ///< index of the step at or after the point
  Values fraction;               ///< position between the previous step (0) and this step (1)
  Values load;                   ///< mean load at the point [mN]
  Values mean;                   ///< mean value at the point
  Values slope;                  ///< derivative of the mean value with respect to the mean load
};

inline constexpr Index jackknife_sum_rows = 10;

/// Write sums of powers and minima over the repetitions to `sums`, which has the shape (`jackknife_sum_rows`, points).
/// Rows 0 to 3: sums of c, c², c³ and c⁴, where c is the change of ln(mean value) if one repetition is left out.
/// Rows 4 to 7: sums of d, d², d³ and d⁴, where d is the change of the mean value if one repetition is left out.
/// The changes c and d are changes of the mean value at a constant mean load F.
/// Rows 8 and 9 contain the smallest relative change of the mean value (dv / mean(v)) and of the mean load (dn / F).
/// Values and loads are interpolated between load steps. Means are taken over `total_repetitions` (R) repetitions.
void jackknife_sums(const CurvePoints& points, const CurveView& loads, const CurveView& values, Index repetitions,
                    Index total_repetitions, Eigen::Ref<Matrix> sums);

}  // namespace stiction
