"""Test runs on the workers of a Dask scheduler."""

import contextlib
import os
import signal

import pytest
from stiction import Study, run
from stiction.solve import executors, runner, store
from stiction.solve.executors import ClusterError
from stiction.study.values import StudyError
from support.generated_studies import assert_same_bits

distributed = pytest.importorskip("distributed")
# The package distributed closes its sockets and event loops late, so pytest would report resource warnings.
pytestmark = pytest.mark.filterwarnings("ignore")

STUDY = Study().with_changes(
    {
        "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.7, "count": 3},
        "surfaces.points": 5_000,
        "surfaces.extent": "5 um",
        "contact.approach.count": 5,
        "ensemble.repetitions": 40,
    }
)


@pytest.fixture(scope="module")
def scheduler():
    """Return the address of a Dask scheduler with two worker processes."""
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs="CRITICAL"
    ) as local_cluster:
        yield local_cluster.scheduler_address


def test_dask_workers_and_threads_give_bit_identical_results(scheduler, tmp_path, monkeypatch):
    expected = run(STUDY).dataset
    monkeypatch.setattr(runner, "write_block", lambda *_: pytest.fail("written by the process that hands out the work"))
    with executors.connect_to_cluster(scheduler) as executor:
        assert_same_bits(run(STUDY, executor=executor).dataset, expected)
        assert_same_bits(run(STUDY, executor=executor, store=tmp_path).dataset, expected)
    assert not list(tmp_path.rglob("*.partial"))


def test_tasks_of_a_killed_dask_worker_are_repeated_by_another_worker(scheduler, tmp_path, monkeypatch):
    study = STUDY.with_changes({"surfaces.fractal_dimension.count": 12})
    with (
        distributed.Client(scheduler, set_as_default=False) as client,
        executors.connect_to_cluster(scheduler) as executor,
    ):
        workers = list(client.run(os.getpid).values())

        def kill_worker(num_finished):
            """Kill a worker when the first block is finished."""
            if num_finished and workers:
                os.kill(workers.pop(), signal.SIGKILL)
                workers.clear()

        with monkeypatch.context() as monkeypatch_context:
            monkeypatch_context.setattr(runner, "progress_bar", lambda *_: contextlib.nullcontext(kill_worker))
            result = run(study, executor=executor, store=tmp_path).dataset
        assert not workers
    assert_same_bits(result, run(study).dataset)
    assert_same_bits(store.read(tmp_path), result)


def test_dask_worker_with_another_version_of_stiction_is_rejected(scheduler, monkeypatch):
    monkeypatch.setattr(runner, "__version__", "0.0.1")
    with (
        executors.connect_to_cluster(scheduler) as executor,
        pytest.raises(StudyError, match=r"the worker on .* has stiction .*, but the study was submitted with 0\.0\.1"),
    ):
        run(STUDY, executor=executor)


def test_dask_scheduler_that_does_not_answer_is_reported_with_its_address(monkeypatch):
    monkeypatch.setattr(executors, "CONNECTION_TIMEOUT", "1s")
    for address in ("tcp://127.0.0.1:1", "", "host", "tcp://host", "tcp://host:port", "file:///etc"):
        with (
            pytest.raises(ClusterError, match=address or "have the form tcp://host:8786"),
            executors.connect_to_cluster(address),
        ):
            pass


def test_dask_scheduler_without_workers_issues_a_warning():
    with distributed.LocalCluster(n_workers=0, dashboard_address=None, silence_logs="CRITICAL") as local_cluster:
        address = local_cluster.scheduler_address
        with (
            pytest.warns(UserWarning, match="has no workers yet; waiting for them"),
            executors.connect_to_cluster(address),
        ):
            pass
