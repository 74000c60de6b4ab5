// Test of reentrancy: concurrent threads must compute the same results as a single thread.
#include "stiction/amplitude.hpp"
#include "stiction/contact.hpp"
#include "stiction/harmonics.hpp"

#include <doctest/doctest.h>

#include <numbers>
#include <random>
#include <thread>
#include <vector>

namespace {

std::vector<double> random_profile(unsigned seed) {
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

std::vector<double> press_profiles(unsigned seed) {
  const std::vector<double> approaches{0.001, 0.01, 0.03};
  stiction::ContactModel model{stiction::HertzSphere{10.0}};
  model.detection = seed % 2 == 0 ? stiction::Detection::cell : stiction::Detection::gap_minimum;
  const std::vector<double> upper = random_profile(seed);
  const std::vector<double> lower = random_profile(seed + 100);
  std::vector<double> result;
  for (const stiction::Sums& sums : stiction::press({upper, lower, 0.001}, approaches, model)) {
    result.insert(result.end(), {sums.normal_elastic, sums.tangential_elastic, sums.contact_area});
  }
  return result;
}

}  // namespace

TEST_CASE("library: concurrent threads obtain the results of a single thread") {
  constexpr unsigned tasks = 8;
  // The concurrent threads run first, so that they compete for the initialisation of static variables.
  std::vector<std::vector<double>> together(tasks);
  std::vector<std::thread> threads;
  for (unsigned task = 0; task < tasks; ++task) {
    threads.emplace_back([task, &together] { together[task] = press_profiles(task); });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  for (unsigned task = 0; task < tasks; ++task) {
    const std::vector<double> alone = press_profiles(task);
    CHECK(together[task] == alone);
    CHECK(alone.back() > 0.0);
  }
}
