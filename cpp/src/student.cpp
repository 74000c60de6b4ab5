#include "stiction/student.hpp"

#include "gsl.hpp"

#include <limits>

namespace stiction {

double student_probability(double freedom, double t) noexcept {
  return freedom > 0.0 ? gsl::student_probability(freedom, t) : std::numeric_limits<double>::quiet_NaN();
}

double student_quantile(double freedom, double probability) noexcept {
  const bool known = freedom > 0.0 && probability > 0.0 && probability < 1.0;
  return known ? gsl::student_quantile(freedom, probability) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace stiction
