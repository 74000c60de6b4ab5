// Threads that share the parts of one calculation.
#pragma once

#include "stiction/checkpoint.hpp"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>

namespace stiction {

/// So many threads, the caller's among them, for as long as it lives; one alone starts none. Which thread does a part
/// must not matter to what comes out: then bits are the same for any number of threads. One calculation uses it at a
/// time.
class Crew {
 public:
  explicit Crew(std::size_t threads = 1, Checkpoint checkpoint = {});
  ~Crew();
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  std::size_t threads() const;

  /// `work(part, thread)` for each part from 0 on, and returns when all are done. Between parts of its own the caller's
  /// thread, number 0, passes the checkpoint. What a part or the checkpoint throws comes out of it.
  void each(std::size_t parts, const std::function<void(std::size_t, std::size_t)>& work) const;

  /// `work(first, last)` for parts of at most so many places.
  template <class Work>
  void in_parts(std::size_t count, std::size_t at_once, const Work& work) const {
    each((count + at_once - 1) / at_once,
         [&](std::size_t part, std::size_t) { work(part * at_once, std::min((part + 1) * at_once, count)); });
  }

  /// Passes the checkpoint.
  void check() const { checkpoint_(); }

 private:
  struct Threads;
  Checkpoint checkpoint_;
  std::unique_ptr<Threads> others_;  // none where the caller is alone
};

}  // namespace stiction
