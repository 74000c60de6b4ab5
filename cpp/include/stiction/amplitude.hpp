// The amplitude of a profile: what it is measured by, and profiles scaled to one.
#pragma once

#include "stiction/array.hpp"

namespace stiction {

/// height: highest minus lowest point. mean_deviation: Ra. rms_deviation: Rq. The latter two about the mean.
enum class AmplitudeMeasure { height, mean_deviation, rms_deviation };

/// The same shape about a mean of zero, scaled so that its measure is `amplitude` [µm], into `scaled` of the same
/// length. Returns whether that is possible: a flat profile has no amplitude. Throws std::invalid_argument for lengths
/// that differ.
bool scale_to_amplitude(Values heights, double amplitude, AmplitudeMeasure measure, std::span<double> scaled);

}  // namespace stiction
