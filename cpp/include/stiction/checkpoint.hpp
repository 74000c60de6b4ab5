// How a long calculation is ended from outside, by Ctrl-C for one: the library asks now and then, and knows no more.
#pragma once

#include <functional>
#include <utility>

namespace stiction {

/// Called between the pieces of a calculation, each of which takes less than some milliseconds. What `ask` throws ends
/// the calculation and passes through it to the caller. An empty one never ends anything.
class Checkpoint {
 public:
  Checkpoint() = default;
  explicit Checkpoint(std::function<void()> ask) : ask_(std::move(ask)) {}

  /// `ask` is called at every so many pieces only, because to ask takes longer than some pieces.
  void operator()() const {
    if (ask_ && ++pieces_ % 32 == 0) {
      ask_();
    }
  }

 private:
  std::function<void()> ask_;
  mutable unsigned pieces_ = 0;
};

}  // namespace stiction
