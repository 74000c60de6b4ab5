import os
import signal
import threading

import pytest
from stiction import Study, run
from stiction.mechanics.quantities import SUMS
from stiction.studies import cluster, runner
from stiction.studies.cluster import ClusterError
from stiction.studies.study_text import StudyError

distributed = pytest.importorskip("distributed")
# distributed leaves sockets and loops to the collector.
pytestmark = pytest.mark.filterwarnings("ignore")

STUDY = Study().with_changes(
    {
        "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.7, "count": 3},
        "surfaces.points": 20_000,
        "surfaces.extent": "5 um",
        "contact.approach.count": 5,
        "ensemble.repetitions": 12,
    }
)


@pytest.fixture(scope="module")
def scheduler():
    """A scheduler of two worker processes, as somebody else has started it."""
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs="CRITICAL"
    ) as running:
        yield running.scheduler_address


def test_workers_of_a_scheduler_give_the_bits_of_threads(scheduler):
    with cluster.connected(scheduler) as executor:
        result = run(STUDY, executor=executor)
    undisturbed = run(STUDY)
    for name in SUMS:
        assert result[name].values.tobytes() == undisturbed[name].values.tobytes(), name


def test_what_a_worker_was_computing_when_it_died_is_computed_again(scheduler):
    study = STUDY.with_changes({"ensemble.repetitions": 40, "surfaces.fractal_dimension.count": 12})
    with distributed.Client(scheduler, set_as_default=False) as client, cluster.connected(scheduler) as executor:
        victim = min(client.run(os.getpid).values())
        killer = threading.Timer(0.5, os.kill, (victim, signal.SIGKILL))
        killer.start()
        result = run(study, executor=executor)
        killer.join()
        undisturbed = run(study)
    for name in SUMS:
        assert result[name].values.tobytes() == undisturbed[name].values.tobytes(), name


def test_a_worker_with_another_version_is_refused(scheduler, monkeypatch):
    monkeypatch.setattr(runner, "__version__", "0.0.1")
    with (
        cluster.connected(scheduler) as executor,
        pytest.raises(StudyError, match=r"the worker on .* has stiction .*, and 0\.0\.1 asks for the study"),
    ):
        run(STUDY, executor=executor)


def test_a_scheduler_that_is_not_there_is_said_so(monkeypatch):
    monkeypatch.setattr(cluster, "PATIENCE", "1s")
    with (
        pytest.raises(ClusterError, match=r"no Dask scheduler answers at 'tcp://127\.0\.0\.1:1'"),
        cluster.connected("tcp://127.0.0.1:1"),
    ):
        pass
    for address in ("", "host", "tcp://host", "tcp://host:port", "tcp://host:99999999", "file:///etc"):
        with pytest.raises(ClusterError, match="such as tcp://host:8786"), cluster.connected(address):
            pass
