// Example program that computes the load and the coefficient of static friction of two rough profiles.
#include <stiction/amplitude.hpp>
#include <stiction/asperity.hpp>
#include <stiction/contact.hpp>
#include <stiction/harmonics.hpp>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <vector>

namespace {

constexpr double spacing = 0.001;         // µm
constexpr stiction::Index points = 4000;  // 4 µm
const stiction::ContactModel model{stiction::HertzSphere{10.0}};

std::vector<double> fractal_profile(unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> phase(0.0, 2.0 * std::numbers::pi);
  const stiction::Matrix phases = stiction::Matrix::NullaryExpr(40, 16, [&] { return phase(random); });
  const std::vector<double> weights = stiction::frequency_weights(4.0 - 2.0 * 1.3, phases.cols(), 1.5, 1.0);
  const stiction::Matrix sum = stiction::harmonic_profiles(
      phases, Eigen::Map<const stiction::Matrix>(weights.data(), 1, phases.cols()), {spacing, points});
  std::vector<double> heights(points);
  stiction::scale_to_amplitude({sum.data(), heights.size()}, 0.1, stiction::AmplitudeMeasure::height, heights);
  return heights;
}

/// `sign` is +1 for a bump on the lower surface, and -1 for a bump on the upper surface.
std::vector<double> arc(double radius, double sign) {
  std::vector<double> heights(points);
  for (stiction::Index i = 0; i < points; ++i) {
    const double x = static_cast<double>(i - points / 2) * spacing;
    heights[static_cast<std::size_t>(i)] = sign * (std::sqrt(radius * radius - x * x) - radius);
  }
  return heights;
}

}  // namespace

int main() {
  const double mu0 = 0.4;
  const std::vector<double> approaches{0.005, 0.010, 0.020};
  const std::vector<double> above = fractal_profile(3);
  const std::vector<double> below = fractal_profile(13);
  const std::vector<stiction::Sums> sums = stiction::press({above, below, spacing}, approaches, model);
  for (std::size_t k = 0; k < approaches.size(); ++k) {
    std::printf("approach %g um: load %.4g mN, mu_s %.3f\n", approaches[k], stiction::normal_load(sums[k], mu0),
                stiction::friction_coefficient(sums[k], mu0));
  }

  // The two arcs touch at their apexes, so the overlap equals the approach, and F = 4/3 E* R^(1/2) overlap^(3/2).
  const std::vector<double> upper = arc(3.0, -1.0);
  const std::vector<double> lower = arc(6.0, +1.0);
  const double overlap = 0.002;
  const double load = stiction::press({upper, lower, spacing}, {&overlap, 1}, model).front().normal_elastic;
  const double hertz = 4.0 / 3.0 * 10.0 * std::sqrt(1.0 / (1.0 / 3.0 + 1.0 / 6.0)) * std::pow(overlap, 1.5);
  const double radius = stiction::asperities(lower, spacing, stiction::Side::lower).radius[points / 2];
  std::printf("two arcs: load %.6g mN, by Hertz %.6g mN; radius of the lower %.6g um\n", load, hertz, radius);
  return std::abs(load / hertz - 1.0) < 1e-6 && std::abs(radius / 6.0 - 1.0) < 1e-6 ? 0 : 1;
}
