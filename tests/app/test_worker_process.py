"""A process that does jobs: it may be ended at any moment, and keeps nobody waiting."""

import os
import random
import signal
import subprocess
import sys
import threading
from concurrent.futures import CancelledError, wait

import pytest
import worker_jobs
from places import HELPERS, ROOT

from app.worker_process import WorkerEndedError, WorkerProcess
from benchmarks.ends import ends

BOUND_S = 5.0
"""Time in which a program ends, whatever its workers do [s]."""

PROGRAM = """
import random, signal, sys, time
import worker_jobs
from app.worker_process import WorkerProcess

if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    chance = random.Random(int(sys.argv[1]))
    workers = [WorkerProcess() for _ in range(4)]
    for worker in workers:
        worker.submit(worker_jobs.megabytes, 1).result()
        for _ in range(50):
            worker.submit(worker_jobs.megabytes, 20)
    time.sleep(chance.uniform(0.0, 0.1))
    for worker in workers[:2]:
        worker.end()
    print("ready", flush=True)
    while True:  # a signal that comes just before one long sleep would not be seen until its end
        time.sleep(0.02)
"""


@pytest.fixture(scope="module")
def worker():
    with WorkerProcess() as process:
        yield process


def test_jobs_are_done_one_after_the_other(worker):
    futures = [worker.submit(worker_jobs.megabytes, number) for number in (3, 0, 1)]
    assert [len(future.result(30)) for future in futures] == [3_000_000, 0, 1_000_000]
    assert worker.submit(worker_jobs.process, None).result(30) == worker.pid != os.getpid()


def test_what_cannot_be_sent_is_the_jobs_error_and_the_next_is_done(worker):
    with pytest.raises(TypeError, match="required positional argument"):
        worker.submit(worker_jobs.fail_with_two_words, None).result(30)
    with pytest.raises((AttributeError, TypeError), match="pickle"):
        worker.submit(worker_jobs.nothing_to_send, None).result(30)
    with pytest.raises(AttributeError, match=r"pickle|local object"):  # by the version of Python
        worker.submit(lambda _: None, None)
    assert worker.submit(worker_jobs.megabytes, 0).result(30) == b""


def test_the_place_of_an_error_comes_along(worker):
    error = worker.submit(worker_jobs.refuse_three, (None, 3)).exception(30)
    assert str(error) == "three is none of mine"
    assert "worker_jobs.py" in error.__notes__[0]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_it_ends_at_any_moment_and_its_jobs_are_told(seed):
    """Often in the middle of a result: the rest of it is not waited for."""
    threads = set(threading.enumerate())
    process = WorkerProcess()
    process.submit(worker_jobs.megabytes, 0).result(30)
    futures = [process.submit(worker_jobs.megabytes, 20) for _ in range(20)]
    threading.Event().wait(random.Random(seed).uniform(0.0, 0.15))
    process.end()
    assert not wait(futures, BOUND_S).not_done
    process.end()
    for future in futures:
        if not future.cancelled() and future.exception() is not None:
            assert isinstance(future.exception(), WorkerEndedError)
    for thread in set(threading.enumerate()) - threads:
        thread.join(BOUND_S)
        assert not thread.is_alive()
    with pytest.raises(RuntimeError, match="was ended"):
        process.submit(worker_jobs.megabytes, 0)


def test_jobs_after_the_end_are_cancelled():
    process = WorkerProcess()
    futures = [process.submit(worker_jobs.megabytes, 20) for _ in range(20)]
    process.end()
    with pytest.raises((CancelledError, WorkerEndedError)):
        futures[-1].result(BOUND_S)


def test_a_process_that_was_killed_is_told_by_each_job():
    with WorkerProcess() as process:
        process.submit(worker_jobs.megabytes, 0).result(30)
        os.kill(process.pid, signal.SIGKILL)
        for _ in range(2):
            with pytest.raises(WorkerEndedError):
                process.submit(worker_jobs.megabytes, 1).result(BOUND_S)


@pytest.mark.real_time
@pytest.mark.parametrize("seed", range(4))
def test_a_program_ends_whatever_its_workers_do(seed, tmp_path):
    """Two of them were ended in the middle of a result, two others still send theirs."""
    script = tmp_path / "program.py"
    script.write_text(PROGRAM)
    with subprocess.Popen(
        [sys.executable, str(script), str(seed)],
        env=os.environ | {"PYTHONPATH": f"{HELPERS}:{ROOT}"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as program:
        try:
            assert program.stdout.readline() == "ready\n"
            program.send_signal(signal.SIGTERM)
            _, complaint = program.communicate(timeout=BOUND_S)
        finally:
            program.kill()
    assert (program.returncode, complaint) == (0, "")


@pytest.mark.real_time
def test_workers_at_real_work_are_ended_at_any_moment_and_leave_nothing():
    """Calibration, mapping, sweep and evaluation; ``bench ends`` does so with 200 workers."""
    seen = ends(8, seed=random.SystemRandom().randrange(2**16))
    assert seen.wrong == []
    assert sum(seen.kinds.values()) == 8
    assert max(seen.programs) < BOUND_S
