"""Limit on the number of threads that a test can start."""

import os
import threading

import pytest


def allow_one_new_thread(monkeypatch: pytest.MonkeyPatch) -> list[threading.Thread]:
    """Let four cores be usable, but only one new thread start. Return a list that will contain this thread."""
    start, started = threading.Thread.start, []

    def start_first(thread: threading.Thread) -> None:
        if started:
            raise RuntimeError("can't start new thread")
        started.append(thread)
        start(thread)

    monkeypatch.setattr(os, "sched_getaffinity", lambda _: range(4))
    monkeypatch.setattr(threading.Thread, "start", start_first)
    return started
