// Cancellation of a running calculation by the caller, for example after Ctrl-C.
#pragma once

#include <functional>
#include <utility>

namespace stiction {

/// Callback that can cancel a calculation by throwing.
/// The library calls the callback at least every few milliseconds, and passes its exception on to the caller.
/// A default-constructed check never cancels.
class CancellationCheck {
 public:
  CancellationCheck() = default;
  explicit CancellationCheck(std::function<void()> callback) : callback_(std::move(callback)) {}

  /// Run the callback in every 32nd call only, because the callback takes longer than some steps of a calculation.
  void operator()() const {
    if (callback_ && ++calls_ % 32 == 0) {
      callback_();
    }
  }

 private:
  std::function<void()> callback_;
  mutable unsigned calls_ = 0;
};

}  // namespace stiction
