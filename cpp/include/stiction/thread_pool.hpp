// Thread pool for the tasks of one calculation.
// OpenMP is not used, because tasks may throw, and because the calling thread checks for cancellation between tasks.
#pragma once

#include "stiction/cancellation.hpp"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>

namespace stiction {

/// Pool of at most `threads` threads, including the caller's thread. If `threads` is 1, no thread is started.
/// If the system cannot create all threads, the pool is smaller, but contains at least the caller's thread.
/// Results are bit-identical for any number of threads if no task depends on the thread that runs it.
/// Only one calculation may use a pool at a time.
class ThreadPool {
 public:
  explicit ThreadPool(std::size_t threads = 1, CancellationCheck check_cancellation = {});
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  std::size_t threads() const;

  /// Run `work(task, thread)` for each task, and return when all tasks are done.
  /// The calling thread is number 0 and checks for cancellation after each of its tasks.
  /// The first exception thrown by a task or by the cancellation check is rethrown.
  void run(std::size_t tasks, const std::function<void(std::size_t, std::size_t)>& work) const;

  /// Run `work(first, last)` on consecutive chunks of at most `chunk` indices.
  template <class Work>
  void run_chunks(std::size_t size, std::size_t chunk, const Work& work) const {
    run((size + chunk - 1) / chunk,
        [&](std::size_t task, std::size_t) { work(task * chunk, std::min((task + 1) * chunk, size)); });
  }

  void check_cancellation() const { cancellation_check_(); }

 private:
  struct Workers;
  CancellationCheck cancellation_check_;
  std::unique_ptr<Workers> workers_;  // null if the pool has only the calling thread
};

}  // namespace stiction
