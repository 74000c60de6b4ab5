#include "stiction/thread_pool.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#if defined(__GLIBC__)
#include <dlfcn.h>
#include <pthread.h>

#include <cerrno>
#include <limits>

namespace {

std::atomic<int> creatable_threads{std::numeric_limits<int>::max()};

}  // namespace

// Replaces pthread_create of the C library, which `std::thread` calls, to limit the number of threads.
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*),
                              void* argument) {
  static const auto create = reinterpret_cast<decltype(&pthread_create)>(dlsym(RTLD_NEXT, "pthread_create"));
  return creatable_threads.fetch_sub(1) > 0 ? create(thread, attributes, start, argument) : EAGAIN;
}

TEST_CASE("thread pool: a pool works with the threads that the system can create") {
  for (const int count : {0, 1, 2}) {
    CAPTURE(count);
    creatable_threads = count;
    const stiction::ThreadPool pool(4);
    creatable_threads = std::numeric_limits<int>::max();
    CHECK(pool.threads() == static_cast<std::size_t>(count) + 1);
    std::vector<int> runs(100);
    pool.run(runs.size(), [&](std::size_t task, std::size_t thread) {
      CHECK(thread < pool.threads());
      ++runs[task];
    });
    CHECK(runs == std::vector<int>(100, 1));
  }
}
#endif

TEST_CASE("thread pool: the first of two exceptions is rethrown") {
  const stiction::ThreadPool pool(2);
  std::atomic<int> started{0};
  std::atomic<bool> thrown{false};
  std::string message;
  try {
    pool.run(2, [&](std::size_t, std::size_t) {
      const bool is_first = started++ == 0;
      while (started < 2 || (!is_first && !thrown)) {
        std::this_thread::yield();
      }
      if (!is_first) {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        throw std::runtime_error("second");
      }
      thrown = true;
      throw std::runtime_error("first");
    });
  } catch (const std::runtime_error& error) {
    message = error.what();
  }
  CHECK(message == "first");
}
