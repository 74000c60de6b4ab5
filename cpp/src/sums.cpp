#include "stiction/sums.hpp"

#include <limits>
#include <stdexcept>
#include <string>

namespace stiction {

Sliding sliding(std::string_view name) {
  if (name == "opposing") {
    return Sliding::opposing;
  }
  if (name == "all") {
    return Sliding::all;
  }
  throw std::invalid_argument(std::string("sliding must be opposing or all, got ").append(name));
}

double normal_load(const Sums& sums, double mu0, double tau0) {
  return sums.normal_elastic + mu0 * sums.normal_frictional + tau0 * sums.normal_adhesive;
}

double tangential_load(const Sums& sums, double mu0, double tau0) {
  return sums.tangential_elastic + mu0 * sums.tangential_frictional + tau0 * sums.tangential_adhesive;
}

Status status(const Sums& sums, double mu0, double tau0) {
  if (sums.contact_count == 0) {
    return Status::no_contact;
  }
  return normal_load(sums, mu0, tau0) > 0.0 ? Status::ok : Status::self_locked;
}

double friction_coefficient(const Sums& sums, double mu0, double tau0) {
  return status(sums, mu0, tau0) == Status::ok ? tangential_load(sums, mu0, tau0) / normal_load(sums, mu0, tau0)
                                               : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace stiction
