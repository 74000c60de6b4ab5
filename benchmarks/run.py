"""Run every benchmark, print its table, and write docs/generated/performance.md and docs/images/performance.png."""

import sys
from importlib import import_module
from pathlib import Path

BENCHMARK_FOLDER = Path(__file__).parent


def main() -> None:
    lines = []
    for name in sys.argv[1:] or (
        "pair",
        "against",
        "areal",
        "half_space",
        "pair_of_maps",
        "growth",
        "cluster",
        "memory",
        "million",
        "report",
        "app",
    ):
        module = import_module(name)
        lines += [f"**{(module.__doc__ or '').splitlines()[0]}**", "", "| | |", "|---|---|"]
        for question, answer in module.measure_rows():
            print(f"{question:75s} {answer}", flush=True)
            lines.append(f"| {question} | {answer} |")
        lines.append("")
    if len(sys.argv) == 1:
        (BENCHMARK_FOLDER.parent / "docs/generated/performance.md").write_text("\n".join(lines), encoding="utf-8")
        import_module("chart").draw()


if __name__ == "__main__":
    main()
