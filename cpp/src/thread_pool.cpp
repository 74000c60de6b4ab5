#include "stiction/thread_pool.hpp"

#include <pthread.h>

#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace stiction {
namespace {

// Compiled by GCC 12, `std::condition_variable` would require GLIBCXX_3.4.30, which old Linux systems lack.
class Condition {
 public:
  Condition() = default;
  ~Condition() { pthread_cond_destroy(&condition_); }
  Condition(const Condition&) = delete;
  Condition& operator=(const Condition&) = delete;

  template <class Predicate>
  void wait(std::unique_lock<std::mutex>& lock, Predicate is_met) {
    while (!is_met()) {
      pthread_cond_wait(&condition_, lock.mutex()->native_handle());
    }
  }
  void notify_one() { pthread_cond_signal(&condition_); }
  void notify_all() { pthread_cond_broadcast(&condition_); }

 private:
  pthread_cond_t condition_ = PTHREAD_COND_INITIALIZER;
};

}  // namespace

// A round is one call of `run`. The call does not wait for threads that have not yet started a task of the round.
struct ThreadPool::Workers {
  using Work = std::function<void(std::size_t, std::size_t)>;

  struct Round {
    std::uint32_t number = 0;
    std::uint32_t tasks = 0;
    const Work* work = nullptr;
  };

  std::mutex mutex;
  Condition round_started;
  Condition round_finished;
  Round round;
  // Number of the round in the upper 32 bits, and number of the next task in the lower 32 bits.
  std::atomic<std::uint64_t> next_task{0};
  std::atomic<std::uint32_t> finished_tasks{0};
  std::atomic<bool> stopped{false};
  std::exception_ptr exception;
  bool shutting_down = false;
  std::vector<std::thread> threads;

  explicit Workers(std::size_t size) {
    threads.reserve(size);
    while (threads.size() < size && start_thread()) {
    }
  }

  ~Workers() {
    {
      const std::lock_guard lock(mutex);
      shutting_down = true;
    }
    round_started.notify_all();
    for (std::thread& thread : threads) {
      thread.join();
    }
  }

  // Returns whether the thread could be started. The system may limit the number of threads, so failure is no error.
  bool start_thread() {
    try {
      threads.emplace_back([this, thread = threads.size() + 1] { run(thread); });
      return true;
    } catch (const std::system_error&) {
      return false;
    } catch (const std::bad_alloc&) {
      return false;
    }
  }

  Round begin(std::size_t tasks, const Work& work) {
    {
      const std::lock_guard lock(mutex);
      round = {round.number + 1, static_cast<std::uint32_t>(tasks), &work};
      finished_tasks = 0;
      stopped = false;
      exception = nullptr;
      next_task = std::uint64_t{round.number} << 32;
    }
    round_started.notify_all();
    return round;
  }

  void run(std::size_t thread) {
    std::uint32_t last_round = 0;
    std::unique_lock lock(mutex);
    while (true) {
      round_started.wait(lock, [&] { return shutting_down || round.number != last_round; });
      if (shutting_down) {
        return;
      }
      const Round current = round;
      last_round = current.number;
      lock.unlock();
      run_tasks(current, thread, {});
      lock.lock();
    }
  }

  // Run tasks until none is left. After an exception, the remaining tasks are counted as finished, but not run.
  void run_tasks(const Round& current, std::size_t thread, const CancellationCheck& check_cancellation) {
    std::uint64_t ticket = next_task;
    while (ticket >> 32 == current.number && static_cast<std::uint32_t>(ticket) < current.tasks) {
      if (!next_task.compare_exchange_weak(ticket, ticket + 1)) {
        continue;
      }
      try {
        if (!stopped) {
          (*current.work)(static_cast<std::uint32_t>(ticket), thread);
          check_cancellation();
        }
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!exception) {
          exception = std::current_exception();
        }
        stopped = true;
      }
      if (++finished_tasks == current.tasks) {
        const std::lock_guard lock(mutex);
        round_finished.notify_one();
      }
      ticket = next_task;
    }
  }

  void finish(const Round& current) {
    std::unique_lock lock(mutex);
    round_finished.wait(lock, [&] { return finished_tasks == current.tasks; });
    if (exception) {
      std::rethrow_exception(std::exchange(exception, nullptr));
    }
  }
};

ThreadPool::ThreadPool(std::size_t threads, CancellationCheck check_cancellation)
    : cancellation_check_(std::move(check_cancellation)) {
  if (threads > 1) {
    workers_ = std::make_unique<Workers>(threads - 1);
  }
}

ThreadPool::~ThreadPool() = default;

std::size_t ThreadPool::threads() const { return workers_ ? workers_->threads.size() + 1 : 1; }

void ThreadPool::run(std::size_t tasks, const std::function<void(std::size_t, std::size_t)>& work) const {
  if (!workers_ || tasks <= 1) {
    for (std::size_t task = 0; task < tasks; ++task) {
      work(task, 0);
      cancellation_check_();
    }
    return;
  }
  const Workers::Round round = workers_->begin(tasks, work);
  workers_->run_tasks(round, 0, cancellation_check_);
  workers_->finish(round);
}

}  // namespace stiction
