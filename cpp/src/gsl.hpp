// Interface to GSL, whose status codes become exceptions. Only this file and gsl.cpp use GSL.
#pragma once

#include "stiction/values.hpp"

namespace stiction::gsl {

/// Solve a linear system whose symmetric tridiagonal matrix has the same element everywhere on each diagonal.
/// `solution` must not alias `right_side`.
/// Throws std::runtime_error with GSL's error message if the system cannot be solved.
void solve_tridiagonal(double diagonal, double off_diagonal, Values right_side, std::span<double> solution);

}  // namespace stiction::gsl
