// Cancellation of a running calculation by the caller, for example after Ctrl-C.
#pragma once

#include <functional>
#include <utility>

namespace stiction {

/// Callback that can cancel a calculation by throwing an exception.
/// The library calls the callback at least every few milliseconds.
/// The caller receives the exception that the callback throws.
/// A default-constructed CancellationCheck never cancels a calculation.
class CancellationCheck {
 public:
  CancellationCheck() = default;
  explicit CancellationCheck(std::function<void()> callback) : callback_(std::move(callback)) {}

  /// Run the callback only on every 32nd call of the operator, because the callback may take longer than a step.
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
