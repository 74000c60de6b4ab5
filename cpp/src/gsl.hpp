// Interface to GSL. Only this file and gsl.cpp use GSL.
// Status codes of GSL are converted to exceptions, and no exception passes through GSL's stack frames.
#pragma once

#include "stiction/values.hpp"

namespace stiction::gsl {

/// Solve a symmetric tridiagonal system with constant diagonals: all elements of a diagonal are equal.
/// `solution` must not alias `right_side`. Throws std::runtime_error with GSL's message.
void solve_tridiagonal(double diagonal, double off_diagonal, Values right_side, std::span<double> solution);

}  // namespace stiction::gsl
