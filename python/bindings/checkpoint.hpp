// Ctrl-C ends what the library is doing: Python's signal handlers run between its pieces, in the main thread, where
// they alone may run.
#pragma once

#include "stiction/checkpoint.hpp"

#include <pybind11/pybind11.h>

#include <chrono>

namespace stiction::python {

/// To be made while the GIL is held. Its calls take it for themselves, at most ten times a second.
inline Checkpoint until_interrupted() {
  namespace py = pybind11;
  const py::object thread = py::module_::import("threading");
  if (!thread.attr("current_thread")().is(thread.attr("main_thread")())) {
    return {};
  }
  using Clock = std::chrono::steady_clock;
  return Checkpoint([last = Clock::now()]() mutable {
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
