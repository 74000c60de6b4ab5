#include "stiction/crew.hpp"

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace stiction {

struct Crew::Threads {
  std::mutex mutex;
  std::condition_variable begun;
  std::condition_variable done;
  const std::function<void(std::size_t, std::size_t)>* work = nullptr;
  std::atomic<std::size_t> next{0};
  std::size_t parts = 0;
  std::size_t busy = 0;
  std::size_t rounds = 0;
  std::exception_ptr thrown;
  bool over = false;
  std::vector<std::thread> threads;

  explicit Threads(std::size_t count) {
    for (std::size_t thread = 1; thread <= count; ++thread) {
      threads.emplace_back([this, thread] { run(thread); });
    }
  }

  ~Threads() {
    {
      const std::lock_guard lock(mutex);
      over = true;
    }
    begun.notify_all();
    for (std::thread& thread : threads) {
      thread.join();
    }
  }

  void run(std::size_t thread) {
    std::size_t seen = 0;
    std::unique_lock lock(mutex);
    while (true) {
      begun.wait(lock, [&] { return over || rounds != seen; });
      if (over) {
        return;
      }
      seen = rounds;
      lock.unlock();
      share(thread, {});
      lock.lock();
      if (--busy == 0) {
        done.notify_one();
      }
    }
  }

  void share(std::size_t thread, const Checkpoint& checkpoint) {
    try {
      for (std::size_t part = next++; part < parts; part = next++) {
        (*work)(part, thread);
        checkpoint();
      }
    } catch (...) {
      next = parts;
      const std::lock_guard lock(mutex);
      thrown = std::current_exception();
    }
  }
};

Crew::Crew(std::size_t threads, Checkpoint checkpoint) : checkpoint_(std::move(checkpoint)) {
  if (threads > 1) {
    others_ = std::make_unique<Threads>(threads - 1);
  }
}

Crew::~Crew() = default;

std::size_t Crew::threads() const { return others_ ? others_->threads.size() + 1 : 1; }

void Crew::each(std::size_t parts, const std::function<void(std::size_t, std::size_t)>& work) const {
  if (!others_ || parts <= 1) {
    for (std::size_t part = 0; part < parts; ++part) {
      work(part, 0);
      checkpoint_();
    }
    return;
  }
  {
    const std::lock_guard lock(others_->mutex);
    others_->work = &work;
    others_->parts = parts;
    others_->next = 0;
    others_->busy = others_->threads.size();
    others_->thrown = nullptr;
    ++others_->rounds;
  }
  others_->begun.notify_all();
  others_->share(0, checkpoint_);
  std::unique_lock lock(others_->mutex);
  others_->done.wait(lock, [&] { return others_->busy == 0; });
  if (others_->thrown) {
    std::rethrow_exception(std::exchange(others_->thrown, nullptr));
  }
}

}  // namespace stiction
