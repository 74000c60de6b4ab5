#include "stiction/ellipse.hpp"

#include "text.hpp"

#include <cmath>
#include <stdexcept>

namespace stiction {
namespace {

// Complete elliptic integrals: K = π / (2 · mean), where `mean` is the arithmetic-geometric mean of 1 and k.
// `ratio` is (K - E) / (e² K), where e² = 1 - k² and k is the axis ratio. For a circle (k -> 1), `ratio` tends to 1/2.
// Source: Abramowitz & Stegun (1964), section 17.6.
struct Integrals {
  double mean;
  double ratio;
};

Integrals integrals(double k) {
  // `ratio` is Σ 2^(n-1) c_n² / e², with the means a_n, b_n and c_(n+1) = (a_n - b_n) / 2 = c_n² / (4 a_(n+1)).
  // The factor e² is cancelled in the first term of the series, which avoids 0/0 for circular contacts.
  double a = 0.5 * (1.0 + k);
  double b = std::sqrt(k);
  double square = 0.25 * (1.0 - k) * (1.0 - k);  // c_n²
  double term = 0.25 * (1.0 - k) / (1.0 + k);    // 2^(n-1) c_n² / e²
  double ratio = 0.5 + term;
  while (square > 1e-17 * a * a) {
    const double next = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = next;
    const double decay = square / (16.0 * a * a);  // c_(n+1)² / c_n²
    square *= decay;
    term *= 2.0 * decay;
    ratio += term;
  }
  return {a, ratio};
}

// d ln(shorter/longer) / d ln k
double log_slope(double k, double ratio) {
  const double e2 = (1.0 - k) * (1.0 + k);
  const double complement = 1.0 - ratio;
  if (e2 < 1e-4) {
    // For small eccentricity e, the slope is 1.5 to within about e². This error hardly slows Newton's method.
    return 1.5;
  }
  return 2.0 + ((k * k * ratio - complement) / e2 + ratio * complement) / (ratio * complement);
}

}  // namespace

Ellipse hertz_ellipse(double longer, double shorter) {
  if (!(shorter > 0.0) || !(longer >= shorter) || !std::isfinite(longer)) {
    throw std::invalid_argument("hertz_ellipse: radii must be positive and finite, with the longer radius first, got " +
                                format_number(longer) + " and " + format_number(shorter) + " µm");
  }
  const double target = shorter / longer;
  // Newton's method finds ln k, because ln(shorter radius / longer radius) is almost a linear function of ln k.
  double k = std::cbrt(target * target);
  Integrals values = integrals(k);
  for (int i = 0; i < 20; ++i) {
    const double error = std::log(k * k * values.ratio / ((1.0 - values.ratio) * target));
    const double step = -error / log_slope(k, values.ratio);
    k = std::fmin(1.0, k * std::exp(step));
    values = integrals(k);
    if (std::abs(step) < 1e-9) {
      break;  // the iteration converges quadratically, and near k = 1 cubically
    }
  }
  const double major = 2.0 * longer * values.ratio;
  return {major, 2.0 * shorter * (1.0 - values.ratio), major * values.mean * values.mean};
}

}  // namespace stiction
