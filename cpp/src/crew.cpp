#include "stiction/crew.hpp"

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace stiction {

// A round is the parts of one call. Nobody waits for a thread that has taken no part: one that wakes up late finds the
// round over, and waits for the next.
struct Crew::Threads {
  using Work = std::function<void(std::size_t, std::size_t)>;

  struct Round {
    std::uint32_t number = 0;
    std::uint32_t parts = 0;
    const Work* work = nullptr;
  };

  std::mutex mutex;
  std::condition_variable begun;
  std::condition_variable done;
  Round round;
  std::atomic<std::uint64_t> next{0};  // number of a round, in the upper half, and its next part
  std::atomic<std::uint32_t> finished{0};
  std::atomic<bool> stopped{false};
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

  Round begin(std::size_t parts, const Work& work) {
    {
      const std::lock_guard lock(mutex);
      round = {round.number + 1, static_cast<std::uint32_t>(parts), &work};
      finished = 0;
      stopped = false;
      thrown = nullptr;
      next = std::uint64_t{round.number} << 32;
    }
    begun.notify_all();
    return round;
  }

  void run(std::size_t thread) {
    std::uint32_t seen = 0;
    std::unique_lock lock(mutex);
    while (true) {
      begun.wait(lock, [&] { return over || round.number != seen; });
      if (over) {
        return;
      }
      const Round now = round;
      seen = now.number;
      lock.unlock();
      share(now, thread, {});
      lock.lock();
    }
  }

  // Takes parts of a round while there are any; after an exception they are only counted.
  void share(const Round& now, std::size_t thread, const Checkpoint& checkpoint) {
    std::uint64_t place = next;
    while (place >> 32 == now.number && static_cast<std::uint32_t>(place) < now.parts) {
      if (!next.compare_exchange_weak(place, place + 1)) {
        continue;
      }
      try {
        if (!stopped) {
          (*now.work)(static_cast<std::uint32_t>(place), thread);
          checkpoint();
        }
      } catch (...) {
        const std::lock_guard lock(mutex);
        thrown = std::current_exception();
        stopped = true;
      }
      if (++finished == now.parts) {
        const std::lock_guard lock(mutex);
        done.notify_one();
      }
      place = next;
    }
  }

  void end(const Round& now) {
    std::unique_lock lock(mutex);
    done.wait(lock, [&] { return finished == now.parts; });
    if (thrown) {
      std::rethrow_exception(std::exchange(thrown, nullptr));
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
  const Threads::Round round = others_->begin(parts, work);
  others_->share(round, 0, checkpoint_);
  others_->end(round);
}

}  // namespace stiction
