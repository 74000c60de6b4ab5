"""Measure how time and memory increase with the numbers of points, fractal dimensions and approaches."""

from measure import measure_in_time_units, measure_peak_mebibytes
from stiction import Study, run
from stiction.solve.member_solution import compute_member_arrays

BASE_STUDY = Study.named("figure6").with_changes({"ensemble.repetitions": 1})


def measure_cost_per_pair(changes: dict[str, object], num_repeats: int = 3) -> float:
    study = BASE_STUDY.with_changes(changes)
    num_pairs = study.surfaces.fractal_dimensions().size
    return measure_in_time_units(lambda: compute_member_arrays(study, 0), num_repeats) / num_pairs


def run_study_of_figure_6() -> None:
    run(Study.named("figure6").with_changes({"ensemble.repetitions": 8}))


def run_ten_million_points() -> None:
    compute_member_arrays(BASE_STUDY.with_changes(make_study_changes(10_000_000)), 0)


def make_study_changes(num_points: int) -> dict[str, object]:
    return {
        "surfaces.points": num_points,
        "surfaces.extent": f"{num_points * 40 / 150_000:.6f} um",
        "surfaces.fractal_dimension": [1.3],
    }


def run_benchmark() -> list[tuple[str, str]]:
    point_counts = (10_000, 150_000, 1_000_000, 10_000_000)
    dimension_counts = (1, 5, 20, 50, 200)
    approach_counts = (1, 10, 40, 100, 400)
    costs_by_points = [
        measure_cost_per_pair(make_study_changes(n), 5 if n < 1e6 else 3) / n * 150_000 for n in point_counts
    ]
    dimension_range = {"start": 1.0, "stop": 1.7}
    costs_by_dimensions = [
        measure_cost_per_pair({"surfaces.fractal_dimension": [1.3] if n == 1 else dimension_range | {"count": n}})
        for n in dimension_counts
    ]
    costs_by_approaches = [
        measure_cost_per_pair(
            {"contact.approach": {"start": "40 nm" if n == 1 else "0.1 nm", "stop": "40 nm", "count": n}}
        )
        for n in approach_counts
    ]
    join_costs = "; ".join
    return [
        ("cost of a single pair by number of points, U per 150 000 points",
         join_costs(f"{n:.0e}: {cost:.1f}" for n, cost in zip(point_counts, costs_by_points, strict=True))),
        ("cost of a pair by number of dimensions, U",
         join_costs(f"{n}: {cost:.1f}" for n, cost in zip(dimension_counts, costs_by_dimensions, strict=True))),
        ("cost of a pair by number of approaches, U",
         join_costs(f"{n}: {cost:.1f}" for n, cost in zip(approach_counts, costs_by_approaches, strict=True))),
        ("peak memory of figure6 on two threads", f"{measure_peak_mebibytes(run_study_of_figure_6):.0f} MiB"),
        ("peak memory of a pair of profiles with ten million points each",
         f"{measure_peak_mebibytes(run_ten_million_points):.0f} MiB"),
    ]  # fmt: skip
