#include "stiction/half_space_contacts.hpp"

#include <algorithm>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace stiction {

std::vector<HalfSpaceContact> solve_contacts(const HalfSpaceSolver& solver, StepQuantity quantity, Values steps,
                                             Values near, double hardness, const ThreadPool& pool,
                                             const StepProgress& progress) {
  std::vector<HalfSpaceContact> contacts;
  contacts.reserve(steps.size());
  std::vector<double> previous;
  for (std::size_t step = 0; step < steps.size(); ++step) {
    const HalfSpaceProgress report =
        progress ? HalfSpaceProgress([&](std::int64_t iteration, double error) { progress(step, iteration, error); })
                 : HalfSpaceProgress();
    const Values start = step == 0 ? near : Values(previous);
    HalfSpaceSolution solution = quantity == StepQuantity::approach
                                     ? solver.at_approach(steps[step], start, pool, report)
                                     : solver.at(steps[step], start, pool, report);
    contacts.push_back({patches_of(solution.pressure, solver.grid(), hardness), solution.approach, solution.error,
                        solution.iterations});
    if (!(solution.error <= solver.tolerance())) {
      break;
    }
    previous = std::move(solution.pressure);
  }
  return contacts;
}

std::vector<FixedContactResponse> fixed_contact_responses(const HalfSpaceGrids& grids,
                                                          std::span<const std::span<const std::int64_t>> contacts,
                                                          Values uniform_displacement, const ThreadPool& pool) {
  const std::size_t size = grids.levels()[0].size();
  if (uniform_displacement.size() != size) {
    throw std::invalid_argument(
        "fixed_contact_responses: uniform_displacement must have one value for each grid point");
  }
  std::vector<FixedContactResponse> responses;
  responses.reserve(contacts.size());
  const auto in_contact = std::make_unique<bool[]>(size);
  const std::span<bool> marks(in_contact.get(), size);
  for (const std::span<const std::int64_t> points : contacts) {
    std::fill(marks.begin(), marks.end(), false);
    for (const std::int64_t point : points) {
      if (point < 0 || std::cmp_greater_equal(point, size)) {
        throw std::invalid_argument("fixed_contact_responses: points must be on the grid");
      }
      marks[static_cast<std::size_t>(point)] = true;
    }
    const LinearResponse response = linear_response(grids, marks, pool);
    responses.push_back({response.compliance, std::inner_product(response.pressure.begin(), response.pressure.end(),
                                                                 uniform_displacement.begin(), 0.0)});
  }
  return responses;
}

}  // namespace stiction
