"""The thread that every part of the program uses which needs one."""

import logging
import threading

from robot.worker_thread import WorkerThread

PATIENCE = 10.0


def worker(work, **options):
    return WorkerThread("test worker", work, owner="a test", **{"patience": PATIENCE} | options)


def test_it_works_under_its_name_until_it_is_stopped():
    names = []

    def work(stopping):
        names.append(threading.current_thread().name)
        stopping.wait(PATIENCE)

    thread = worker(work)
    assert not thread.alive and thread.ident is None
    thread.start()
    assert thread.alive and thread.ident is not None
    assert thread.stop() and thread.stop()
    assert not thread.alive
    assert names == ["test worker"]
    assert thread.failure is None


def test_it_may_be_stopped_before_the_start():
    assert worker(lambda stopping: None).stop()


def test_work_that_waits_for_something_else_is_woken():
    bell = threading.Event()
    thread = worker(lambda stopping: bell.wait(PATIENCE), wake=bell.set)
    thread.start()
    assert thread.stop()


def test_a_thread_that_does_not_end_is_complained_about(caplog):
    leave = threading.Event()
    thread = worker(lambda stopping: leave.wait(PATIENCE), patience=0.01)
    thread.start()
    with caplog.at_level(logging.ERROR):
        assert not thread.stop()
    assert caplog.messages == ["the thread of a test did not end within 0.01 s"]
    leave.set()
    thread._thread.join(PATIENCE)


def test_its_own_work_may_stop_it():
    thread = worker(lambda stopping: ended.append(thread.stop()))
    ended = []
    thread.start()
    assert thread.stop()
    assert ended == [False]


def test_a_failure_is_kept_and_logged_once(caplog):
    thread = worker(lambda stopping: 1 / 0)
    thread.start()
    thread.join()
    assert isinstance(thread.failure, ZeroDivisionError)
    assert caplog.messages == ["a test failed"]
    assert caplog.records[0].exc_info[1] is thread.failure


def test_an_owner_that_wants_a_failure_gets_it_instead_of_the_log(caplog):
    failures = []
    thread = worker(lambda stopping: 1 / 0, report=failures.append)
    thread.start()
    thread.join()
    assert failures == [thread.failure]
    assert not caplog.messages
