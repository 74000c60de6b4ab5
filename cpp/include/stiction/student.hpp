// Student's t distribution, by which intervals of means are as wide as few values leave them.
#pragma once

namespace stiction {

/// The probability of a smaller t, with `freedom` > 0 degrees, which need not be whole. NaN for others.
double student_probability(double freedom, double t) noexcept;

/// The t below which a `probability` between 0 and 1 lies. NaN for others.
double student_quantile(double freedom, double probability) noexcept;

}  // namespace stiction
