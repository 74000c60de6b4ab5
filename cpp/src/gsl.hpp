// The only door to GSL: status codes become exceptions, nothing is thrown through GSL's own frames.
#pragma once

#include "stiction/array.hpp"

namespace stiction::gsl {

/// Solves the symmetric tridiagonal system with constant diagonal and off-diagonal; `solution` may not alias
/// `right_side`. Throws std::runtime_error with GSL's own words.
void solve_tridiagonal(double diagonal, double off_diagonal, Values right_side, std::span<double> solution);

}  // namespace stiction::gsl
