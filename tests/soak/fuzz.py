"""Fuzz the interfaces with ten thousand inputs of each kind: only ValueErrors and messages are allowed."""

import argparse
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from stiction import run
from support import fuzzing


def fuzz(kind, count, seed, call):
    start, outcomes, findings = time.monotonic(), Counter(), 0
    for i in range(count):
        try:
            outcome = call(np.random.default_rng([seed, i]))
        except Exception:  # a finding, whatever it is
            findings += 1
            print(f"{kind}, seed {seed}, input {i}:\n{traceback.format_exc()}", flush=True)
        else:
            outcomes[type(outcome).__name__ if isinstance(outcome, Exception) else outcome] += 1
    took = time.monotonic() - start
    print(f"fuzzed: {count} {kind}, seed {seed}, {dict(outcomes)}, {findings} findings, {took:.0f} s", flush=True)
    return findings


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=int(time.time()))
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder, pristine = Path(name), Path(name) / "pristine"
        pristine.mkdir()
        run(fuzzing.small_study(), store=pristine)
        findings = fuzz("arrays", options.count, options.seed, fuzzing.fuzz_arrays)
        findings += fuzz("stores", options.count, options.seed, lambda r: fuzzing.fuzz_store(r, pristine, folder))
        findings += fuzz("study files", options.count, options.seed, lambda r: fuzzing.fuzz_study_file(r, folder))
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()
