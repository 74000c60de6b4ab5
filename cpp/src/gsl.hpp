// The only door to GSL: status codes become exceptions, nothing is thrown through GSL's own frames.
#pragma once

#include "stiction/array.hpp"

namespace stiction::gsl {

/// Solves the symmetric tridiagonal system with constant diagonal and off-diagonal; `solution` may not alias
/// `right_side`. Throws std::runtime_error with GSL's own words.
void solve_tridiagonal(double diagonal, double off_diagonal, Values right_side, std::span<double> solution);

/// Of Student's distribution, and the inverse of it; for arguments in range.
double student_probability(double freedom, double t) noexcept;
double student_quantile(double freedom, double probability) noexcept;

}  // namespace stiction::gsl
