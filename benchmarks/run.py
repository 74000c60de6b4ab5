"""Run benchmarks and print their tables. If all benchmarks are run, also write the documented table and plot."""

import argparse
from importlib import import_module
from pathlib import Path

BENCHMARK_DIRECTORY = Path(__file__).parent
BENCHMARK_NAMES = (
    "pair", "against", "areal", "half_space", "pair_of_maps", "growth", "cluster", "memory", "million", "report", "app",
)  # fmt: skip


def parse_names(arguments: list[str] | None = None) -> list[str]:
    """Return the benchmark names among the arguments, or an empty list if all benchmarks are requested."""
    parser = argparse.ArgumentParser(prog="./dev bench", description=__doc__)
    known_names = ", ".join(BENCHMARK_NAMES)
    parser.add_argument("name", nargs="*", help=f"benchmark to run, by default all of them: {known_names}")
    names: list[str] = parser.parse_args(arguments).name
    # Do not use `choices`, with which argparse of Python 3.11 rejects an empty list.
    if unknown_names := [name for name in names if name not in BENCHMARK_NAMES]:
        parser.error(f"{unknown_names[0]!r} is not among {known_names}")
    return names


def main() -> None:
    names, lines = parse_names(), []
    for name in names or BENCHMARK_NAMES:
        module = import_module(name)
        summary = (module.__doc__ or "").splitlines()[0]
        caption = f"**`./dev bench {name}`:** {summary[:1].lower()}{summary[1:]}"
        lines += [caption, "", "| quantity | result |", "|---|---|"]
        for question, answer in module.run_benchmark():
            print(f"{question:75s} {answer}", flush=True)
            lines.append(f"| {question} | {answer} |")
        lines.append("")
    if not names:
        (BENCHMARK_DIRECTORY.parent / "docs/generated/performance.md").write_text("\n".join(lines), encoding="utf-8")
        import_module("chart").draw_chart()


if __name__ == "__main__":
    main()
