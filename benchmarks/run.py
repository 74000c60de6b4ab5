"""Run benchmarks and print their tables. A run of all benchmarks also writes the documented table and plot."""

import argparse
from importlib import import_module
from pathlib import Path

BENCHMARK_FOLDER = Path(__file__).parent
BENCHMARK_NAMES = (
    "pair", "against", "areal", "half_space", "pair_of_maps", "growth", "cluster", "memory", "million", "report", "app",
)  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(prog="./dev bench", description=__doc__)
    parser.add_argument("name", nargs="*", choices=BENCHMARK_NAMES, help="benchmark to run; by default all of them")
    names = parser.parse_args().name
    lines = []
    for name in names or BENCHMARK_NAMES:
        module = import_module(name)
        lines += [f"**{(module.__doc__ or '').splitlines()[0]}**", "", "| quantity | result |", "|---|---|"]
        for question, answer in module.benchmark_rows():
            print(f"{question:75s} {answer}", flush=True)
            lines.append(f"| {question} | {answer} |")
        lines.append("")
    if not names:
        (BENCHMARK_FOLDER.parent / "docs/generated/performance.md").write_text("\n".join(lines), encoding="utf-8")
        import_module("chart").draw_chart()


if __name__ == "__main__":
    main()
