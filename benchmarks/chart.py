"""Draw docs/images/performance.png: run times relative to stiction, from docs/generated/performance.md."""

import re
from pathlib import Path

import matplotlib as mpl
from stiction.views.style import MATPLOTLIB_STYLE, NOT_OPPOSING_CONTACT_COLOUR, PAGE_WIDTH, new_figure, save_figure

DOCS_DIRECTORY = Path(__file__).resolve().parents[1] / "docs"

RESULT_PATTERNS_BY_TASK = {
    "Pair of profiles: 150 000 points, 40 approaches": {"NumPy and SciPy": r"plain NumPy/SciPy program.*"},
    "Generation of 50 profiles of 150 000 points (Eq. 1)": {
        "NumPy, direct sum": r"direct sum in NumPy.*",
        "FINUFFT and BLAS": r"FINUFFT .* and a BLAS product.*",
    },
    "Profiles: 8192 points, stiction at 40 approaches, tamaas at one load": {
        "tamaas (elastic half-plane)": r"tamaas, one load of a profile.*"
    },
    "Height maps: 1024 × 1024 points, stiction at 40 approaches, tamaas at one load": {
        "tamaas (elastic half-space)": r"tamaas, one load at 1024 x 1024.*"
    },
    "Half-space: 512 × 512 points, one load, equal error": {
        "tamaas": r"512 x 512, mean pressure 0.03 .*",
        "aspher": r"512 x 512, mean pressure 0.03 .*",
    },
}
"""Programs that are compared with stiction, by task, with the table row that contains their relative run time."""


def parse_answers_by_question(table: str) -> dict[str, str]:
    rows = re.findall(r"^\| (.+?) \| (.+?) \|$", table, flags=re.MULTILINE)
    return {question.removeprefix("the "): answer for question, answer in rows}


def parse_relative_time(time_text: str, name: str) -> float | None:
    """Return the run time of a program relative to stiction from a table cell, or None if the cell has none."""
    if ";" in time_text or " s, " in time_text:
        result = re.search(rf"{name.split()[0]} .*?: ([0-9.]+) times", time_text)
        return float(result[1]) if result else None
    return float(time_text)


def collect_relative_times(table: str) -> dict[str, dict[str, float]]:
    texts_by_question = parse_answers_by_question(table)
    result: dict[str, dict[str, float]] = {}
    for task, patterns in RESULT_PATTERNS_BY_TASK.items():
        for name, pattern in patterns.items():
            time_text = next(
                (texts_by_question[item] for item in texts_by_question if re.fullmatch(pattern, item)), None
            )
            ratio = None if time_text is None else parse_relative_time(time_text, name)
            if ratio is not None:
                result.setdefault(task, {})[name] = ratio
    return result


def draw_chart() -> None:
    """Draw one group of bars per task; the first bar of each group is stiction."""
    ratios_by_task = collect_relative_times((DOCS_DIRECTORY / "generated/performance.md").read_text(encoding="utf-8"))
    with mpl.rc_context(MATPLOTLIB_STYLE):
        num_bars = sum(1 + len(group) for group in ratios_by_task.values())
        height = 3.2 * num_bars + 5.5 * len(ratios_by_task) + 11
        figure = new_figure(height, width=PAGE_WIDTH, layout=None)
        axes = figure.add_axes((0.2, 9 / height, 0.75, 1 - 10 / height))
        position, positions, names = 0.0, [], []
        for task, group in ratios_by_task.items():
            axes.text(0.7, position, task, va="center", fontsize=7, fontweight="bold")
            for name, ratio in {"stiction": 1.0, **group}.items():
                position -= 1
                positions.append(position)
                names.append(name)
                colour = NOT_OPPOSING_CONTACT_COLOUR if name == "stiction" else "0.65"
                axes.barh(position, ratio - 0.7, left=0.7, color=colour, height=0.75)
                text = f"{ratio:.2g} ×" if ratio < 100 else f"{ratio:.0f} ×"
                axes.text(1.1 * ratio, position, text, va="center", fontsize=6)
            position -= 1.7
        axes.set_xscale("log")
        axes.set_xlim(0.7, 3 * max(ratio for group in ratios_by_task.values() for ratio in group.values()))
        axes.set_ylim(position + 1.2, 0.9)
        axes.set_yticks(positions, labels=names)
        axes.tick_params(axis="y", length=0)
        axes.set_xlabel("run time divided by the run time of stiction (one thread)")
        for side in ("top", "right", "left"):
            axes.spines[side].set_visible(False)
        save_figure(figure, DOCS_DIRECTORY / "images/performance.png")


if __name__ == "__main__":
    draw_chart()
