// The amplitude of a profile: what it is measured by, and profiles scaled to one.
#pragma once

#include "stiction/array.hpp"

#include <array>
#include <limits>
#include <optional>
#include <string_view>

namespace stiction {

/// height: highest minus lowest point. ra, rq: mean absolute and root-mean-square deviation from the mean.
enum class AmplitudeMeasure { height, ra, rq };

/// By the words of results: "height", "Ra", "Rq". Throws std::invalid_argument for another.
AmplitudeMeasure amplitude_measure(std::string_view word);

/// Mean, lowest and highest point of a profile [µm].
struct Level {
  double mean;
  double lowest;
  double highest;
};

/// The level of a profile that comes in pieces, from left to right. Sums and extremes are kept for each of some lanes,
/// so that passes are wide, and the same whatever the pieces: each but the last is a whole number of lanes long.
class Levelling {
 public:
  static constexpr std::size_t lanes = 32;

  Levelling();
  void add(Values heights);
  Level level() const;

 private:
  std::size_t points_ = 0;
  std::array<double, lanes> sum_;
  std::array<double, lanes> lowest_;
  std::array<double, lanes> highest_;
};

/// How heights are scaled: their mean becomes zero, and what is left is multiplied by the factor.
struct Scaling {
  double mean;
  double factor;
};

/// That to a measure of `amplitude` [µm] of heights with this level; none for a flat profile, which has no amplitude.
std::optional<Scaling> scaling_to(double amplitude, AmplitudeMeasure measure, Values heights, const Level& level);

/// (height - mean) factor for each, into `scaled` of the same length.
void scale(Values heights, const Scaling& by, std::span<double> scaled);

/// The same shape about a mean of zero, scaled so that its measure is `amplitude` [µm], into `scaled` of the same
/// length. Returns whether that is possible: a flat profile has no amplitude. Throws std::invalid_argument for lengths
/// that differ.
bool scale_to_amplitude(Values heights, double amplitude, AmplitudeMeasure measure, std::span<double> scaled);

}  // namespace stiction
