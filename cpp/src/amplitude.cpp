#include "stiction/amplitude.hpp"

#include "multiversion.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

namespace stiction {
namespace {

STICTION_MULTIVERSION
void take_heights(const double* heights, std::size_t size, double* sums, double* lowests, double* highests) {
  constexpr std::size_t lanes = Levelling::lanes;
  double sum[lanes];
  double lowest[lanes];
  double highest[lanes];
  std::copy_n(sums, lanes, sum);
  std::copy_n(lowests, lanes, lowest);
  std::copy_n(highests, lanes, highest);
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
  std::copy_n(sum, lanes, sums);
  std::copy_n(lowest, lanes, lowests);
  std::copy_n(highest, lanes, highests);
}

STICTION_MULTIVERSION
void scale_heights(const double* heights, std::size_t size, double mean, double factor, double* scaled) {
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

Levelling::Levelling() {
  sum_.fill(0.0);
  lowest_.fill(std::numeric_limits<double>::infinity());
  highest_.fill(-std::numeric_limits<double>::infinity());
}

void Levelling::add(Values heights) {
  take_heights(heights.data(), heights.size(), sum_.data(), lowest_.data(), highest_.data());
  points_ += heights.size();
}

Level Levelling::level() const {
  return {std::accumulate(sum_.begin(), sum_.end(), 0.0) / static_cast<double>(points_),
          *std::min_element(lowest_.begin(), lowest_.end()), *std::max_element(highest_.begin(), highest_.end())};
}

std::optional<Scaling> scaling_to(double amplitude, AmplitudeMeasure measure, Values heights, const Level& level) {
  const auto size = static_cast<double>(heights.size());
  const double mean = level.mean;
  double measured = level.highest - level.lowest;
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
  if (!(level.highest > level.lowest) || !(measured > 0.0)) {
    return std::nullopt;
  }
  return Scaling{mean, amplitude / measured};
}

void scale(Values heights, const Scaling& by, std::span<double> scaled) {
  scale_heights(heights.data(), heights.size(), by.mean, by.factor, scaled.data());
}

bool scale_to_amplitude(Values heights, double amplitude, AmplitudeMeasure measure, std::span<double> scaled) {
  if (scaled.size() != heights.size() || heights.empty()) {
    throw std::invalid_argument("scale_to_amplitude: scaled must be as long as heights, and not empty");
  }
  Levelling levelling;
  levelling.add(heights);
  const std::optional<Scaling> scaling = scaling_to(amplitude, measure, heights, levelling.level());
  if (scaling) {
    scale(heights, *scaling, scaled);
  }
  return scaling.has_value();
}

}  // namespace stiction
