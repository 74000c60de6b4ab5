// Sums over long arrays that are independent of the number of threads.
#pragma once

#include "stiction/thread_pool.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace stiction {

/// Return the sum of `work(first, last)` over chunks of the indices below `count`.
/// Chunk results are added in a fixed order, whatever the number of threads, by the function `add` of `Sums`.
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
