#include "stiction/amplitude.hpp"

#include "multiversion.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

namespace stiction {
namespace {

// Sums and extremes are kept for each of these lanes, so that passes are wide and their result is the same on any
// width.
constexpr std::size_t lanes = 32;

struct Moments {
  double sum;
  double lowest;
  double highest;
};

STICTION_MULTIVERSION
Moments moments(const double* heights, std::size_t size) {
  double sum[lanes] = {};
  double lowest[lanes];
  double highest[lanes];
  std::fill_n(lowest, lanes, heights[0]);
  std::fill_n(highest, lanes, heights[0]);
  const auto take = [&](double height, std::size_t lane) {
    sum[lane] += height;
    lowest[lane] = height < lowest[lane] ? height : lowest[lane];
    highest[lane] = height > highest[lane] ? height : highest[lane];
  };
  std::size_t i = 0;
  for (; i + lanes <= size; i += lanes) {
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      take(heights[i + lane], lane);
    }
  }
  for (; i < size; ++i) {
    take(heights[i], i % lanes);
  }
  return {std::accumulate(sum, sum + lanes, 0.0), *std::min_element(lowest, lowest + lanes),
          *std::max_element(highest, highest + lanes)};
}

STICTION_MULTIVERSION
void scale(const double* heights, std::size_t size, double mean, double factor, double* scaled) {
  for (std::size_t i = 0; i < size; ++i) {
    scaled[i] = (heights[i] - mean) * factor;
  }
}

}  // namespace

AmplitudeMeasure amplitude_measure(std::string_view word) {
  if (word == "height") {
    return AmplitudeMeasure::height;
  }
  if (word == "Ra") {
    return AmplitudeMeasure::ra;
  }
  if (word == "Rq") {
    return AmplitudeMeasure::rq;
  }
  throw std::invalid_argument("amplitude measure is " + std::string(word) + ", must be height, Ra or Rq");
}

bool scale_to_amplitude(Values heights, double amplitude, AmplitudeMeasure measure, std::span<double> scaled) {
  if (scaled.size() != heights.size() || heights.empty()) {
    throw std::invalid_argument("scale_to_amplitude: scaled must be as long as heights, and not empty");
  }
  const auto [sum, lowest, highest] = moments(heights.data(), heights.size());
  const auto size = static_cast<double>(heights.size());
  const double mean = sum / size;
  double measured = highest - lowest;
  if (measure == AmplitudeMeasure::ra) {
    measured = std::accumulate(heights.begin(), heights.end(), 0.0,
                               [&](double total, double height) { return total + std::abs(height - mean); }) /
               size;
  } else if (measure == AmplitudeMeasure::rq) {
    measured = std::sqrt(
        std::accumulate(heights.begin(), heights.end(), 0.0,
                        [&](double total, double height) { return total + (height - mean) * (height - mean); }) /
        size);
  }
  if (!(highest > lowest) || !(measured > 0.0)) {
    return false;
  }
  scale(heights.data(), heights.size(), mean, amplitude / measured, scaled.data());
  return true;
}

}  // namespace stiction
