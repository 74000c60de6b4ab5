"""Test that interrupted members continue with the same bits, and that their progress is shown."""

import shutil
import time
from pathlib import Path

import numpy as np
import pytest
from stiction import run
from stiction.companions.height_scale import scale_study_heights
from stiction.mechanics import half_space
from stiction.mechanics.adhesion import AdhesionSolver
from stiction.mechanics.half_space_problem import ContactSolver
from stiction.mechanics.solution_record import SolutionRecord
from stiction.solve import executors, members_in_progress, runner
from stiction.solve.companion_study import CompanionStudy
from stiction.solve.member_solution import compute_member_arrays, solve_at_loads
from stiction.solve.members_in_progress import (
    IN_PROGRESS_DIRECTORY,
    MembersInProgress,
    find_members_in_progress,
    remove_stored_steps,
)
from stiction.solve.store import BLOCKS_DIRECTORY
from stiction.study.members import count_grid_points, get_first_pair
from support.generated_studies import SMALL_STUDY, assert_same_bits
from support.studies_of_files import create_study_from_files, write_maps, write_profiles

ADHESION = 'work_of_adhesion = "50 mJ/m^2"'
LOADS = 'load = ["0.5 mN", "1 mN", "2 mN", "4 mN"]'
FREE_TILT = 'tilt = "free"\nboundary = "free"'


@pytest.fixture
def study(request, tmp_path, monkeypatch):
    """Study of one position whose contact keys come from the test. Each load is stored immediately."""
    monkeypatch.setattr(members_in_progress, "STORAGE_INTERVAL", -1.0)
    monkeypatch.setattr(half_space, "MAX_POINTS_PER_STEP", 1)
    contact, is_areal = request.param
    spacing = write_maps(tmp_path, shape=(32, 32), rms=0.004) if is_areal else write_profiles(tmp_path, points=300)
    return create_study_from_files(
        tmp_path, "areas" if is_areal else "lines", spacing=spacing, members=1, contact=contact
    )


def estimate_iterations(_member):
    return 100.0


class InterruptedMethod:
    """Method of a class that raises `KeyboardInterrupt` after a given number of calls."""

    def __init__(self, monkeypatch, owner, name):
        self.num_calls, self.max_calls = 0, None
        original = getattr(owner, name)

        def count_or_interrupt(owner_instance, *arguments, **options):
            if self.max_calls is not None and self.num_calls >= self.max_calls:
                raise KeyboardInterrupt
            self.num_calls += 1
            return original(owner_instance, *arguments, **options)

        monkeypatch.setattr(owner, name, count_or_interrupt)


@pytest.mark.parametrize(
    ("study", "owner", "name", "calls_per_attempt"),
    [
        ((LOADS, True), ContactSolver, "contacts_at", 1),
        ((LOADS, False), ContactSolver, "contacts_at", 1),
        (('hardness = "5 GPa"\n' + LOADS, True), ContactSolver, "contacts_at", 1),
        ((FREE_TILT + "\n" + LOADS, True), ContactSolver, "at", 5),
        ((ADHESION + "\n" + LOADS, True), AdhesionSolver, "attraction_at_gap", 7),
        ((ADHESION, False), AdhesionSolver, "attraction_at_gap", 23),
    ],
    indirect=["study"],
    ids=["maps", "profiles", "hardness", "tilt", "adhesion", "adhesion of profiles"],
)
def test_interrupted_solution_of_a_pair_continues_with_bit_identical_results(
    study, owner, name, calls_per_attempt, tmp_path, monkeypatch
):
    interrupted_method = InterruptedMethod(monkeypatch, owner, name)
    expected = compute_member_arrays(study, 0)
    num_calls, interrupted_method.num_calls = interrupted_method.num_calls, 0
    num_attempts, counts = 0, []
    while True:
        num_attempts += 1
        interrupted_method.max_calls = interrupted_method.num_calls + calls_per_attempt
        record = MembersInProgress(study, tmp_path, estimate_iterations).add(0)
        try:
            arrays = compute_member_arrays(study, 0, record)
        except KeyboardInterrupt:
            counts.append(record.counter.count)
            assert num_attempts < num_calls
            continue
        break
    assert num_attempts > 2
    assert counts == sorted(counts)
    assert record.counter.count >= counts[-1] > 0
    assert arrays.keys() == expected.keys()
    for variable, values in expected.items():
        assert arrays[variable].tobytes() == values.tobytes(), variable
    remove_stored_steps(tmp_path)
    assert not (tmp_path / IN_PROGRESS_DIRECTORY).exists()


@pytest.mark.parametrize("study", [(ADHESION, True)], indirect=True)
def test_interrupted_run_resumes_inside_a_partly_solved_pair(study, tmp_path, monkeypatch):
    expected = run(study).dataset
    interrupted_method = InterruptedMethod(monkeypatch, AdhesionSolver, "attraction_at_gap")
    run(study)
    num_calls, interrupted_method.num_calls, interrupted_method.max_calls = (
        interrupted_method.num_calls,
        0,
        interrupted_method.num_calls // 2,
    )
    directory = tmp_path / "result"
    with pytest.raises(KeyboardInterrupt):
        run(study, store=directory)
    assert find_members_in_progress(directory) == {0}
    assert list((directory / BLOCKS_DIRECTORY).iterdir()) == []
    interrupted_method.max_calls = None
    assert_same_bits(run(study, store=directory).dataset, expected)
    assert interrupted_method.num_calls < 1.2 * num_calls
    assert not (directory / IN_PROGRESS_DIRECTORY).exists()


@pytest.mark.parametrize("study", [(LOADS, True)], indirect=True)
def test_interrupted_companion_study_resumes_inside_a_partly_solved_pair(study, tmp_path, monkeypatch):
    interrupted_method = InterruptedMethod(monkeypatch, ContactSolver, "contacts_at")
    scaled_study = scale_study_heights(study, 2.0, "both").with_checksums()
    companion_study = CompanionStudy(scaled_study, tmp_path / "pair/height_scale/both-2")
    expected = run(scaled_study).dataset
    num_calls, interrupted_method.num_calls, interrupted_method.max_calls = (
        interrupted_method.num_calls,
        0,
        interrupted_method.num_calls // 2,
    )
    with executors.executor_or_thread_pool(None) as executor:
        with pytest.raises(KeyboardInterrupt):
            companion_study.complete(executor)
        assert find_members_in_progress(companion_study.directory) == {0}
        interrupted_method.max_calls = None
        assert_same_bits(companion_study.complete(executor).dataset, expected)
    assert interrupted_method.num_calls == num_calls
    assert not (companion_study.directory / IN_PROGRESS_DIRECTORY).exists()


@pytest.mark.parametrize("study", [(LOADS, True)], indirect=True)
def test_run_removes_stored_load_steps_of_a_pair_whose_block_is_complete(study, tmp_path, monkeypatch):
    directory = tmp_path / "result"
    monkeypatch.setattr(MembersInProgress, "remove", lambda *_: None)
    run(study, store=directory)
    assert find_members_in_progress(directory) == {0}
    monkeypatch.undo()
    run(study, store=directory)
    assert not (directory / IN_PROGRESS_DIRECTORY).exists()


@pytest.mark.parametrize("study", [(LOADS, True)], indirect=True)
def test_load_steps_are_computed_again_if_stored_steps_are_damaged_or_belong_to_another_study(
    study, tmp_path, monkeypatch
):
    expected = compute_member_arrays(study, 0)
    interrupted_method = InterruptedMethod(monkeypatch, ContactSolver, "contacts_at")
    compute_member_arrays(study, 0, MembersInProgress(study, tmp_path, estimate_iterations).add(0))
    (member_directory,) = (tmp_path / IN_PROGRESS_DIRECTORY).iterdir()
    paths = sorted(member_directory.iterdir())
    assert [path.name for path in paths] == [f"{number:05d}.npz" for number in range(4)]
    for damage, expected_calls in (
        (lambda: None, 0),
        (lambda: paths[2].write_bytes(paths[2].read_bytes()[:-40]), 2),
        (lambda: paths[0].unlink(), 4),
        (lambda: paths[1].write_bytes(b""), 3),
    ):
        damage()
        interrupted_method.num_calls = 0
        arrays = compute_member_arrays(study, 0, MembersInProgress(study, tmp_path, estimate_iterations).add(0))
        assert interrupted_method.num_calls == expected_calls
        assert all(arrays[name].tobytes() == values.tobytes() for name, values in expected.items())
    other_study = study.with_changes({"contact.effective_modulus": "90 GPa"})
    interrupted_method.num_calls = 0
    compute_member_arrays(other_study, 0, MembersInProgress(other_study, tmp_path, estimate_iterations).add(0))
    assert interrupted_method.num_calls == 4


@pytest.mark.parametrize("study", [(LOADS, True)], indirect=True)
def test_small_maps_solved_for_several_loads_together_have_the_results_of_separate_solutions(
    study, tmp_path, monkeypatch
):
    expected = compute_member_arrays(study, 0)
    interrupted_method = InterruptedMethod(monkeypatch, ContactSolver, "contacts_at")
    for loads_per_step, num_steps in ((3, 2), (4, 1)):
        monkeypatch.setattr(half_space, "MAX_POINTS_PER_STEP", loads_per_step * count_grid_points(study))
        interrupted_method.num_calls = 0
        arrays = compute_member_arrays(study, 0)
        assert interrupted_method.num_calls == num_steps
        assert all(arrays[name].tobytes() == values.tobytes() for name, values in expected.items())


@pytest.mark.parametrize("study", [(LOADS, True)], indirect=True)
def test_solution_of_a_pair_is_computed_even_if_its_load_steps_cannot_be_stored(study, tmp_path):
    record = MembersInProgress(study, tmp_path / "missing", estimate_iterations).add(0)
    arrays = compute_member_arrays(study, 0, record)
    assert np.isfinite(arrays["normal_elastic"]).all()
    assert not (tmp_path / "missing").exists()


@pytest.mark.parametrize("study", [(LOADS, True)], indirect=True)
def test_progress_of_a_solution_rises_with_the_number_of_iterations(study):
    members = MembersInProgress(study, None, estimate_iterations)
    assert members.estimate_progress() == 0
    counters = [members.add(index).counter for index in range(2)]
    progress = []
    for _ in range(50):
        for counter in counters:
            counter.add(10)
        progress.append(members.estimate_progress())
    assert progress[0] == pytest.approx(0.2)
    assert (np.diff(progress) > 0).all()
    assert progress[-1] < 2
    members.remove(range(1))
    assert members.estimate_progress() == pytest.approx(0.75)


@pytest.mark.parametrize("study", [(LOADS, True)], indirect=True)
def test_progress_weights_members_by_their_expected_iterations(study):
    """Member 0 needs as many iterations as two others; three members are computed, at a third more than expected."""
    members = MembersInProgress(study, None, lambda member: 200.0 if member == 0 else 100.0, lambda: 400.0 / 3)
    counters = [members.add(index).counter for index in range(3)]
    counters[0].add(80)
    assert members.estimate_progress() == pytest.approx(1.5 * 0.4)
    counters[0].add(187)
    assert members.estimate_progress() < 1.5
    members.remove(range(1))
    assert 1 + members.estimate_progress() == pytest.approx(1.5)
    counters[1].add(40)
    assert 1 + members.estimate_progress() == pytest.approx(1.5 + 0.75 * 40 / 133.5)
    members.remove(range(1, 3))
    assert members.estimate_progress() == pytest.approx(0)


@pytest.mark.parametrize("study", [(LOADS, True)], indirect=True)
def test_solution_record_counts_the_iterations_of_each_stiffness_once(study, monkeypatch):
    """The study fixture limits each call of the core to one load, so that the stiffnesses are computed one by one."""
    record = SolutionRecord()
    curve = half_space.half_space(*get_first_pair(study), [0.5, 1.0], effective_modulus=100.0, record=record)
    num_iterations = record.counter.count
    stiffness = curve.stiffness
    assert record.counter.count == num_iterations + sum(round(count / 3) for count in curve.iterations)
    num_iterations = record.counter.count
    assert np.isfinite(curve.closure_stiffness).all()
    assert record.counter.count == num_iterations
    monkeypatch.setattr(half_space, "MAX_POINTS_PER_STEP", 2**22)
    curve = half_space.half_space(*get_first_pair(study), [0.5, 1.0], effective_modulus=100.0)
    assert curve.stiffness.tobytes() == stiffness.tobytes()


@pytest.mark.parametrize("study", [('hardness = "5 GPa"\nyield_exponent = 0.5\n' + LOADS, True)], indirect=True)
def test_solution_record_counts_the_iterations_of_the_elastic_area_and_both_stiffnesses(study, monkeypatch):
    def count(**options):
        record = SolutionRecord()
        values = solve_at_loads(study, *get_first_pair(study), record=record, **options)
        return record.counter.count, values

    count_at_loading, _ = count()
    count_of_all, values = count(computes_unloading=True, computes_elastic_area=True)
    assert np.isfinite(values["elastic_area"]).all()
    assert count_of_all > 1.7 * count_at_loading
    monkeypatch.setattr(half_space, "STIFFNESS_TO_SOLUTION_TIME_RATIO", 0.0)
    loading_stiffness_count = count_at_loading - count()[0]
    both_stiffness_count = count_of_all - count(computes_unloading=True, computes_elastic_area=True)[0]
    assert both_stiffness_count > loading_stiffness_count > 0


@pytest.mark.parametrize("study", [(LOADS, True)], indirect=True)
def test_progress_of_the_solution_of_a_pair_is_printed_without_a_terminal(study, monkeypatch, capfd):
    solve = ContactSolver.contacts_at

    def solve_slowly(*arguments, **options):
        solution = solve(*arguments, **options)
        time.sleep(0.2)
        return solution

    monkeypatch.setattr(ContactSolver, "contacts_at", solve_slowly)
    monkeypatch.setattr(executors, "PROGRESS_LINE_INTERVAL", 0.0)
    monkeypatch.setattr(runner, "PROGRESS_INTERVAL", 0.01)
    run(study, progress=True)
    lines = [line.removeprefix("progress: ") for line in capfd.readouterr().err.splitlines()]
    percentages = [float(line.split()[0].rstrip("%")) for line in lines]
    assert lines[-1].startswith("100.0% after ")
    assert percentages == sorted(percentages)
    assert any(0 < percentage < 100 for percentage in percentages)
    assert any(line.endswith(" left") for line in lines)


def test_key_of_stored_load_steps_changes_with_the_solver_code(tmp_path, monkeypatch):
    key = members_in_progress.compute_steps_key("study")
    modules = Path(members_in_progress.mechanics.__file__).parent
    shutil.copytree(modules, tmp_path / "mechanics", ignore=shutil.ignore_patterns("__pycache__"))
    with monkeypatch.context() as patch:
        patch.setattr(members_in_progress.mechanics, "__file__", str(tmp_path / "mechanics/__init__.py"))
        members_in_progress._hash_step_modules.cache_clear()
        assert members_in_progress.compute_steps_key("study") == key
        with (tmp_path / "mechanics/adhesion.py").open("a", encoding="utf-8") as file:
            file.write("# another way of solving\n")
        members_in_progress._hash_step_modules.cache_clear()
        assert members_in_progress.compute_steps_key("study") != key
    members_in_progress._hash_step_modules.cache_clear()


def test_iterations_of_a_member_are_estimated_once_for_all_displays_of_the_progress():
    estimated_members = []

    def record_estimate(member):
        estimated_members.append(member)
        return 100.0

    in_progress = MembersInProgress(SMALL_STUDY, None, record_estimate, lambda: 100.0)
    in_progress.add(0)
    assert in_progress.estimate_progress() == in_progress.estimate_progress() == 0
    in_progress.remove(range(1))
    assert estimated_members == [0]
