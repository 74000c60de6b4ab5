import os
import signal
import threading
import time

import pytest
from stiction import Study, run
from stiction.mechanics.quantities import SUMS
from stiction.studies import cluster, runner
from stiction.studies.cluster import ClusterError
from stiction.studies.study import StudyError

distributed = pytest.importorskip("distributed")
# distributed leaves sockets and loops to the collector when its processes are killed.
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
def two_workers():
    with cluster.local(2) as executor:
        yield executor


@pytest.fixture(scope="module")
def by_threads():
    return run(STUDY)


def assert_same_bits(one, other):
    for name in SUMS:
        assert one[name].values.tobytes() == other[name].values.tobytes(), name


def test_processes_give_the_bits_of_threads(two_workers, by_threads):
    assert_same_bits(run(STUDY, executor=two_workers), by_threads)


def test_a_worker_that_dies_is_replaced(two_workers):
    study = STUDY.with_changes(
        {"ensemble.repetitions": 40, "surfaces.fractal_dimension.count": 12, "surfaces.points": 150_000}
    )
    client = distributed.get_client()
    before = set(client.run(os.getpid).values())
    progress = []

    def kill():
        while not any(client.has_what().values()) and not progress:
            time.sleep(0.01)
        os.kill(min(before), signal.SIGKILL)
        progress.append("killed")

    killer = threading.Thread(target=kill)
    killer.start()
    result = run(study, executor=two_workers)
    progress.append("finished")
    killer.join()
    assert progress == ["killed", "finished"]
    deadline = time.monotonic() + 30
    while len(set(client.run(os.getpid, on_error="ignore").values())) < 2 and time.monotonic() < deadline:
        time.sleep(0.1)
    after = set(client.run(os.getpid).values())
    assert min(before) not in after
    assert len(after) == 2
    assert_same_bits(result, run(study))


def test_a_worker_with_another_version_is_refused(two_workers, monkeypatch):
    monkeypatch.setattr(runner, "__version__", "0.0.1")
    with pytest.raises(StudyError, match=r"the worker on .* has stiction .*, and 0\.0\.1 asks for the study"):
        run(STUDY, executor=two_workers)


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
