#include "stiction/ellipse.hpp"

#include "text.hpp"

#include <cmath>
#include <stdexcept>

namespace stiction {
namespace {

// The arithmetic-geometric mean of 1 and k gives both integrals at once, with no difference of equal numbers in it:
// K = π / 2 mean and (K - E) / (e² K) = share, whose limits are 1/2 at k = 1, and 1 - 1/K at k = 0.
// Abramowitz & Stegun (1964), 17.6.
struct Integrals {
  double mean;
  double share;
};

Integrals integrals(double k) {
  // Σ 2^(n-1) c_n² / e², c_(n+1) = (a_n - b_n) / 2 = c_n² / 4 a_(n+1); c_1² / e² is written without e.
  double a = 0.5 * (1.0 + k);
  double b = std::sqrt(k);
  double square = 0.25 * (1.0 - k) * (1.0 - k);  // c_n²
  double term = 0.25 * (1.0 - k) / (1.0 + k);    // 2^(n-1) c_n² / e²
  double share = 0.5 + term;
  while (square > 1e-17 * a * a) {
    const double next = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = next;
    const double ratio = square / (16.0 * a * a);  // of c_(n+1)² to c_n²
    square *= ratio;
    term *= 2.0 * ratio;
    share += term;
  }
  return {a, share};
}

// Of ln(shorter / longer) by ln k.
double slope(double k, double share) {
  const double e2 = (1.0 - k) * (1.0 + k);
  const double rest = 1.0 - share;
  if (e2 < 1e-4) {
    return 1.5;  // its limit; what it lacks, some e², slows the iteration by nothing that counts
  }
  return 2.0 + ((k * k * share - rest) / e2 + share * rest) / (share * rest);
}

}  // namespace

Ellipse hertz_ellipse(double longer, double shorter) {
  if (!(shorter > 0.0) || !(longer >= shorter) || !std::isfinite(longer)) {
    throw std::invalid_argument("hertz_ellipse: radii are " + text(longer) + " and " + text(shorter) +
                                " µm, must be above 0 and finite, the longer first");
  }
  const double wanted = shorter / longer;
  // Newton's method on logarithms, between which the relation is nearly straight: its slope is 1.5 at k = 1 and 2 at 0.
  double k = std::cbrt(wanted * wanted);
  Integrals at = integrals(k);
  for (int i = 0; i < 20; ++i) {
    const double error = std::log(k * k * at.share / ((1.0 - at.share) * wanted));
    const double step = -error / slope(k, at.share);
    k = std::fmin(1.0, k * std::exp(step));
    at = integrals(k);
    if (std::abs(step) < 1e-9) {
      break;  // quadratic convergence, or of third order near k = 1
    }
  }
  const double major = 2.0 * longer * at.share;
  return {major, 2.0 * shorter * (1.0 - at.share), major * at.mean * at.mean};
}

}  // namespace stiction
