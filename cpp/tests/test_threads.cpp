// The library keeps no state: what threads compute side by side is what one computes alone. The thread sanitizer runs
// this as well.
#include "stiction/amplitude.hpp"
#include "stiction/contact.hpp"
#include "stiction/harmonics.hpp"

#include <doctest/doctest.h>

#include <numbers>
#include <random>
#include <thread>
#include <vector>

namespace {

std::vector<double> profile(unsigned seed) {
  std::mt19937_64 random(seed);
  stiction::Matrix phases(8, 12);
  for (stiction::Index i = 0; i < phases.size(); ++i) {
    phases.data()[i] = 2.0 * std::numbers::pi * static_cast<double>(random() >> 11) * 0x1p-53;
  }
  const std::vector<double> weights = stiction::frequency_weights(1.2, phases.cols(), 1.5, 1.0);
  const stiction::Matrix row = Eigen::Map<const stiction::Matrix>(weights.data(), 1, phases.cols());
  const stiction::Matrix heights = stiction::harmonic_profiles(phases, row, {0.001, 5000, 1.0, 1.5, false});
  std::vector<double> scaled(5000);
  REQUIRE(stiction::scale_to_amplitude({heights.data(), 5000}, 0.1, stiction::AmplitudeMeasure::height, scaled));
  return scaled;
}

std::vector<double> pressed(unsigned seed) {
  const std::vector<double> approaches{0.001, 0.01, 0.03};
  stiction::ContactModel model{stiction::HertzSphere{10.0}};
  model.detection = seed % 2 == 0 ? stiction::Detection::cell : stiction::Detection::gap_minimum;
  const std::vector<double> upper = profile(seed);
  const std::vector<double> lower = profile(seed + 100);
  std::vector<double> result;
  for (const stiction::Sums& sums : stiction::press({upper, lower, 0.001}, approaches, model)) {
    result.insert(result.end(), {sums.normal_elastic, sums.tangential_elastic, sums.contact_area});
  }
  return result;
}

}  // namespace

TEST_CASE("threads side by side compute what one computes alone") {
  constexpr unsigned tasks = 8;
  // The threads come first, so that whatever is set up at first use is set up by several at once.
  std::vector<std::vector<double>> together(tasks);
  std::vector<std::thread> threads;
  for (unsigned task = 0; task < tasks; ++task) {
    threads.emplace_back([task, &together] { together[task] = pressed(task); });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  for (unsigned task = 0; task < tasks; ++task) {
    const std::vector<double> alone = pressed(task);
    CHECK(together[task] == alone);
    CHECK(alone.back() > 0.0);
  }
}
