// Cancellation of calls of the library by Ctrl-C. Python runs signal handlers only in the main thread.
#pragma once

#include "stiction/cancellation.hpp"

#include <pybind11/pybind11.h>

#include <chrono>

namespace stiction::python {

/// Return a cancellation check that runs Python's signal handlers at most ten times per second.
/// Outside the main thread, the check does nothing. The check acquires the GIL when it is called.
/// The caller of this function must hold the GIL.
inline CancellationCheck keyboard_interrupt_check() {
  namespace py = pybind11;
  const py::object thread = py::module_::import("threading");
  if (!thread.attr("current_thread")().is(thread.attr("main_thread")())) {
    return {};
  }
  using Clock = std::chrono::steady_clock;
  return CancellationCheck([last = Clock::now()]() mutable {
    const Clock::time_point now = Clock::now();
    if (now - last < std::chrono::milliseconds(100)) {
      return;
    }
    last = now;
    const py::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) {
      throw py::error_already_set();
    }
  });
}

}  // namespace stiction::python
