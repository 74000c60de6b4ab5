#include "gsl.hpp"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace stiction::gsl {
namespace {

// On an error, GSL aborts the process unless its error handler is off. Exceptions cannot pass through C functions.
// NOLINTNEXTLINE(bugprone-throwing-static-initialization)
[[maybe_unused]] gsl_error_handler_t* const previous_handler = gsl_set_error_handler_off();

void check(int status, const char* message) {
  if (status != GSL_SUCCESS) {
    throw std::runtime_error(std::string(message) + ": " + gsl_strerror(status));
  }
}

}  // namespace

void solve_tridiagonal(double diagonal, double off_diagonal, Values right_side, std::span<double> solution) {
  const std::size_t size = right_side.size();
  const std::vector<double> diagonals(size, diagonal);
  const std::vector<double> off_diagonals(size - 1, off_diagonal);
  const auto d = gsl_vector_const_view_array(diagonals.data(), size);
  const auto e = gsl_vector_const_view_array(off_diagonals.data(), size - 1);
  const auto b = gsl_vector_const_view_array(right_side.data(), size);
  auto x = gsl_vector_view_array(solution.data(), size);
  check(gsl_linalg_solve_symm_tridiag(&d.vector, &e.vector, &b.vector, &x.vector), "tridiagonal system");
}

}  // namespace stiction::gsl
