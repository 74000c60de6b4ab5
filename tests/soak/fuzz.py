"""Call functions and commands with random inputs, 10 000 of each kind by default, and report tracebacks."""

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


def fuzz(kind, count, seed, fuzz_once):
    start, outcomes, findings = time.monotonic(), Counter(), 0
    for i in range(count):
        try:
            outcome = fuzz_once(np.random.default_rng([seed, i]))
        except Exception:
            findings += 1
            print(f"{kind}, seed {seed}, input {i}:\n{traceback.format_exc()}", flush=True)
        else:
            outcomes[type(outcome).__name__ if isinstance(outcome, Exception) else outcome] += 1
    elapsed = time.monotonic() - start
    print(f"fuzzed: {count} {kind}, seed {seed}, {dict(outcomes)}, {findings} findings, {elapsed:.0f} s", flush=True)
    return findings


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=int(time.time()))
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        directory, stored_result = Path(name), Path(name) / "pristine"
        stored_result.mkdir()
        run(fuzzing.small_fuzz_study(), store=stored_result)
        findings = fuzz("arrays", options.count, options.seed, fuzzing.fuzz_numeric_function)
        findings += fuzz(
            "stores", options.count, options.seed, lambda r: fuzzing.fuzz_stored_result(r, stored_result, directory)
        )
        findings += fuzz("study files", options.count, options.seed, lambda r: fuzzing.fuzz_study_file(r, directory))
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()
