// Summation over long arrays, with results that do not depend on the number of threads.
#pragma once

#include "stiction/thread_pool.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace stiction {

/// Return the sum of `work(first, last)` over chunks of consecutive indices below `count`.
/// `Sums::add` adds the results of all chunks, in an order that does not depend on the number of threads.
template <class Sums, class Work>
Sums sum_chunks(std::size_t count, std::size_t chunk_size, const ThreadPool& pool, const Work& work) {
  std::vector<Sums> chunk_sums(std::max<std::size_t>((count + chunk_size - 1) / chunk_size, 1));
  pool.run_chunks(count, chunk_size,
                  [&](std::size_t first, std::size_t last) { chunk_sums[first / chunk_size] = work(first, last); });
  Sums total = chunk_sums[0];
  for (std::size_t chunk = 1; chunk < chunk_sums.size(); ++chunk) {
    total.add(chunk_sums[chunk]);
  }
  return total;
}

}  // namespace stiction
