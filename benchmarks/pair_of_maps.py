"""Measure the processor time of `stiction pair` on two 512 x 512 maps, and the solver's fraction of it."""

import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from stiction import half_space, self_affine_surface, write_surface
from stiction.companions.onset import NUM_ONSET_MEMBERS_FOR_MAPS, compute_member_onset
from stiction.companions.resolution import CUTOFF_STUDY_DIRECTORY
from stiction.solve.store import open_stored_result
from stiction.study.members import read_measured_bodies
from stiction.study.study import Study

NUM_TIMING_ROUNDS = 3
COMMAND_ARGUMENTS = [
    "pair", "upper.npy", "lower.npy", "--effective-modulus", "100 GPa", "--hardness", "5 GPa", "--mu0", "0.2",
    "--tau0", "50 MPa", "--load", "1 MPa", "--load", "3 MPa", "--load", "10 MPa",
]  # fmt: skip
"""Command with 16 positions of 384 x 384 points, three loads, 12 directions, both rules, cutoffs, onset and figures."""


def write_scans(directory: Path) -> None:
    for side in ("upper", "lower"):
        surface = self_affine_surface(
            7, hurst_exponent=0.8, rms=0.06, shape=(512, 512), spacing=0.02, longest_wavelength=5.0, side=side
        )
        write_surface(surface, directory / f"{side}.npy")


def measure_command_times(directory: Path, output_name: str) -> tuple[float, float]:
    """Return the processor time and the wall time (s) of the command `stiction pair`."""
    usage_before, wall_start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    command = Path(sys.executable).with_name("stiction")
    subprocess.run(
        [command, *COMMAND_ARGUMENTS, "--output", output_name], cwd=directory, check=True, capture_output=True
    )
    wall_time, usage_after = time.perf_counter() - wall_start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage_after.ru_utime + usage_after.ru_stime - usage_before.ru_utime - usage_before.ru_stime, wall_time


def prepare_load_solver(study: Study) -> Callable[[], None]:
    """Return a function that solves prepared members at all loads, in a single direction."""
    contact, bodies = study.contact, read_measured_bodies(study)
    pairs = [
        bodies.member(member, float(wavelength)).pair
        for member in range(study.ensemble.repetitions) for wavelength in study.surfaces.cell_coordinates()["cut_off"]
    ]  # fmt: skip

    def solve_loads() -> None:
        for upper, lower in pairs:
            curve = half_space(
                upper, lower, contact.loading_steps(), effective_modulus=float(contact.effective_modulus),
                hardness=float(contact.hardness),
            )  # fmt: skip
            assert (curve.error <= 1e-6).all()

    return solve_loads


def compute_member_onsets(study: Study) -> None:
    load, mu0, tau0 = (float(item[0]) for item in (study.friction.load, study.friction.mu0, study.friction.tau0))
    for member in range(NUM_ONSET_MEMBERS_FOR_MAPS):
        onset = compute_member_onset(
            study, member, load=load, mu0=mu0, tau0=tau0, cut_off=study.surfaces.reported_cut_off()
        )
        assert onset is not None


def measure_processor_time(task: Callable[[], None]) -> float:
    start = time.process_time()
    task()
    return time.process_time() - start


def run_benchmark() -> list[tuple[str, str]]:
    with tempfile.TemporaryDirectory() as temporary_directory:
        directory = Path(temporary_directory)
        write_scans(directory)
        command_times = [measure_command_times(directory, "0")]
        study, cutoff_study = (
            open_stored_result(directory / "0" / subdirectory).study for subdirectory in ("", CUTOFF_STUDY_DIRECTORY)
        )
        tasks = prepare_load_solver(study), prepare_load_solver(cutoff_study), lambda: compute_member_onsets(study)
        # The first solution is not measured, because it imports modules and computes kernels.
        half_space(*read_measured_bodies(study).member(0, 0.0).pair, [0.1], effective_modulus=100.0)
        processor_times = []
        for round_index in range(NUM_TIMING_ROUNDS):
            processor_times.append([measure_processor_time(task) for task in tasks])
            command_times.append(measure_command_times(directory, str(round_index + 1)))
    command_time, wall_time = (statistics.median(column) for column in zip(*command_times[1:], strict=True))
    position_time, cutoff_time, onset_time = (
        statistics.median(column) for column in zip(*processor_times, strict=True)
    )
    return [
        ("stiction pair, two maps of 512 x 512: processor time, wall time", f"{command_time:.1f} s, {wall_time:.1f} s"),
        ("half-space solutions alone: positions, cutoffs", f"{position_time:.1f} s, {cutoff_time:.1f} s"),
        (f"onset of sliding of {NUM_ONSET_MEMBERS_FOR_MAPS} members", f"{onset_time:.1f} s"),
        (
            "time of the command relative to its solutions and onsets",
            f"{command_time / (position_time + cutoff_time + onset_time):.2f}",
        ),
    ]


if __name__ == "__main__":
    for question, answer in run_benchmark():
        print(f"{question:75s} {answer}", flush=True)
