"""What holds of all workers: all jobs are done, and a killed worker costs only its own job."""

import os
import select
import socket
import subprocess
import sys

import pytest
import worker_jobs
from distributed import LocalCluster
from places import HELPERS, ROOT

from app.engine.plugging import plug_in
from app.feature_search import find_features
from app.features.lab.workers import ClusterWorkers, LocalWorkers, WorkerError, workers
from app.settings import provenance
from robot.settings import SettingError

PARENT = """
import sys
import worker_jobs
from app.features.lab.workers import LocalWorkers

if __name__ == "__main__":
    for _, pid in LocalWorkers(1).each(worker_jobs.process, [0]):
        print(pid, flush=True)
    sys.stdin.read()
"""


@pytest.fixture(scope="module")
def local():
    crew = LocalWorkers(2)
    yield crew
    crew.close()


@pytest.fixture(scope="module")
def cluster():
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as many:
        crew = ClusterWorkers(many.scheduler_address)
        yield crew
        crew.close()


@pytest.fixture(params=["local", "cluster"])
def crew(request):
    return request.getfixturevalue(request.param)


def jobs(folder, count=6):
    return [(str(folder), number) for number in range(count)]


@pytest.mark.slow
def test_each_job_is_done_once(crew, tmp_path):
    assert dict(crew.each(worker_jobs.double, jobs(tmp_path))) == {n: 2 * n for n in range(6)}
    assert sorted(worker_jobs.begun(tmp_path)) == list(range(6))


def test_the_error_of_a_job_is_its_result_and_the_rest_goes_on(crew, tmp_path):
    done = dict(crew.each(worker_jobs.refuse_three, jobs(tmp_path)))
    error = done.pop(3)
    assert isinstance(error, ValueError)
    assert str(error) == "three is none of mine"
    assert done == {n: 2 * n for n in (0, 1, 2, 4, 5)}


def test_a_feature_that_is_left_out_is_left_out_by_workers_too(crew):
    """``evaluate --without NAME`` had it in all drives all the same."""
    try:
        plug_in(find_features(["own_shadow"]))
        ((_, names),) = crew.each(worker_jobs.active_features, [0])
        assert "own_shadow" not in names
        assert "plausibility" in names
        plug_in(find_features())
        ((_, names),) = crew.each(worker_jobs.active_features, [0])
        assert "own_shadow" in names
    finally:
        plug_in(find_features())


def test_a_killed_worker_loses_nothing_and_repeats_only_its_own_job(crew, tmp_path):
    done = dict(crew.each(worker_jobs.die_once_at_two, jobs(tmp_path)))
    assert done == {n: 2 * n for n in range(6)}
    begun = worker_jobs.begun(tmp_path)
    assert begun.count(2) == 2
    assert sorted(set(begun)) == list(range(6))
    assert len(begun) == 7


def test_a_job_that_always_ends_its_worker_is_given_up(tmp_path):
    crew = LocalWorkers(1)
    done = dict(crew.each(worker_jobs.die_at_two, jobs(tmp_path, 4)))
    crew.close()
    assert isinstance(done.pop(2), WorkerError)
    assert done == {0: 0, 1: 2, 3: 6}


def test_no_jobs_need_no_worker(crew):
    assert list(crew.each(worker_jobs.double, [])) == []


def test_they_are_closed_twice():
    crew = LocalWorkers(1)
    crew.close()
    crew.close()


def test_what_the_command_line_cannot_mean_is_refused():
    with pytest.raises(SettingError, match="0 workers; valid is 1 or more"):
        workers(0, None)
    with pytest.raises(SettingError, match="--cluster is 'nowhere'; valid is tcp://host:port"):
        workers(None, "nowhere")


def test_a_cluster_that_is_not_there_is_told():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    with pytest.raises(WorkerError, match="no Dask scheduler answers at tcp"):
        workers(None, address)


def test_a_cluster_with_another_version_of_the_program_is_refused(cluster, monkeypatch):
    address = cluster._client.scheduler.address
    monkeypatch.setattr(provenance, "LIBRARIES", (*provenance.LIBRARIES, "pytest"))
    with pytest.raises(WorkerError, match=r"has pytest None \(here [0-9.]+\)"):
        ClusterWorkers(address)


@pytest.mark.slow
def test_workers_end_with_the_one_that_started_them(tmp_path):
    """Also if that one is killed and can end nobody."""
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    with subprocess.Popen(
        [sys.executable, str(script)],
        env=os.environ | {"PYTHONPATH": f"{HELPERS}:{ROOT}"},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as parent:
        worker = int(parent.stdout.readline())
        parent.kill()
    ended = os.pidfd_open(worker) if is_alive(worker) else None
    if ended is not None:
        assert select.select([ended], [], [], 30)[0], "the worker lives on"
        os.close(ended)


def is_alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True
