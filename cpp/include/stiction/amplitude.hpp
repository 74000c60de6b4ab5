// The amplitude of a profile: what it is measured by, and profiles scaled to one.
#pragma once

#include "stiction/array.hpp"

#include <string_view>

namespace stiction {

/// height: highest minus lowest point. ra, rq: mean absolute and root-mean-square deviation from the mean.
enum class AmplitudeMeasure { height, ra, rq };

/// By the words of results: "height", "Ra", "Rq". Throws std::invalid_argument for another.
AmplitudeMeasure amplitude_measure(std::string_view word);

/// The same shape about a mean of zero, scaled so that its measure is `amplitude` [µm], into `scaled` of the same
/// length. Returns whether that is possible: a flat profile has no amplitude. Throws std::invalid_argument for lengths
/// that differ.
bool scale_to_amplitude(Values heights, double amplitude, AmplitudeMeasure measure, std::span<double> scaled);

}  // namespace stiction
