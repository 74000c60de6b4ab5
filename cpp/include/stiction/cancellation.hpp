// Cancellation of a running calculation by the caller, for example after Ctrl-C.
#pragma once

#include <functional>
#include <utility>

namespace stiction {

/// Callback that cancels a calculation by throwing an exception, which the caller of the calculation receives.
/// The library calls the callback at least every few milliseconds.
class CancellationCheck {
 public:
  CancellationCheck() = default;
  explicit CancellationCheck(std::function<void()> callback) : callback_(std::move(callback)) {}

  /// Run the callback only in every 32nd call of this operator, because the callback may be slow.
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
