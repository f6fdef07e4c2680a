"""Workers that do jobs: processes of this machine, or of a cluster.

Jobs are independent and bring their own seeds, so neither the worker nor the order changes a
result. If a worker is killed, another worker repeats its job, and only that job.
"""

from __future__ import annotations

import re
import socket
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from app.engine.compiling.terminal import compile_first
from app.engine.plugging import plug_in, plugged
from app.feature_search import find_features
from app.settings.provenance import versions
from app.worker_process import WorkerEndedError, WorkerProcess, cores
from robot.errors import BrickPoseError
from robot.settings import SettingError

S = TypeVar("S")
T = TypeVar("T")

LOOK_S = 0.5
"""Longest wait for a job [s]: between waits Windows hears Ctrl-C, and not in them."""
PATIENCE = 10
"""Time that a cluster has to answer [s]."""
ATTEMPTS = 3
"""A job that ends its worker this many times is given up: the job itself is the cause."""


class WorkerError(BrickPoseError, RuntimeError):
    """The requested workers cannot do the work, or a job ended its worker."""


class Workers(Protocol):
    """Processes that do jobs."""

    @property
    def count(self) -> int:
        """Number of jobs done at a time."""
        ...

    def each(
        self, work: Callable[[S], T], jobs: Sequence[S]
    ) -> Iterator[tuple[int, T | Exception]]:
        """Do all jobs; yield the index and the result or error of each as soon as it is done.

        Args:
            work: a module-level function, as another process looks it up by name.
        """
        ...

    def close(self) -> None:
        """End what was started for the work; may be called twice."""
        ...


@dataclass(frozen=True)
class _WithFeatures(Generic[S, T]):
    """Work that another process does with the features of this one."""

    work: Callable[[S], T]
    left_out: tuple[str, ...]

    def __call__(self, job: S) -> T:
        if plugged().features.left_out != self.left_out:
            plug_in(find_features(self.left_out))
        return self.work(job)


class LocalWorkers:
    """Processes of this machine, each with one job at a time."""

    def __init__(self, count: int | None = None) -> None:
        """Use ``count`` processes, or one for each core that this program may use.

        Raises:
            SettingError: the count is less than one.
        """
        self._count = count if count is not None else cores()
        if self.count < 1:
            raise SettingError(f"{self.count} workers; valid is 1 or more")
        self._crews: list[WorkerProcess] = []

    @property
    def count(self) -> int:
        """Number of jobs done at a time."""
        return self._count

    def each(
        self, work: Callable[[S], T], jobs: Sequence[S]
    ) -> Iterator[tuple[int, T | Exception]]:
        """Do all jobs; yield the index and the result or error of each as soon as it is done."""
        left = deque((index, 1) for index in range(len(jobs)))
        work = _WithFeatures(work, plugged().features.left_out)
        if not self._crews:
            compile_first()  # else each of them would
        while len(self._crews) < min(self.count, len(jobs)):
            self._crews.append(WorkerProcess())
        idle = list(self._crews)
        busy: dict[Future[T], tuple[WorkerProcess, int, int]] = {}
        while left or busy:
            while left and idle:
                crew = idle.pop()
                index, attempt = left.popleft()
                busy[crew.submit(work, jobs[index])] = crew, index, attempt
            for done in wait(busy, LOOK_S, FIRST_COMPLETED).done:
                crew, index, attempt = busy.pop(done)
                result = _result(done)
                if isinstance(result, WorkerEndedError):
                    crew = self._replaced(crew)
                    if attempt < ATTEMPTS:
                        left.appendleft((index, attempt + 1))
                    else:
                        yield index, WorkerError(f"it ended its worker {ATTEMPTS} times")
                else:
                    yield index, result
                idle.append(crew)

    def close(self) -> None:
        """End the processes at once, even while they work; may be called twice."""
        crews, self._crews = self._crews, []
        for crew in crews:
            crew.end()

    def _replaced(self, crew: WorkerProcess) -> WorkerProcess:
        crew.end()
        self._crews[self._crews.index(crew)] = other = WorkerProcess()
        return other


class ClusterWorkers:
    """Workers of a Dask cluster, on any machines that have this program."""

    def __init__(self, address: str) -> None:
        """Connect to a scheduler, such as ``tcp://host:8786``.

        Raises:
            SettingError: the address is invalid.
            WorkerError: dask.distributed is not installed, no scheduler answers, it has no worker,
                or a worker has another version of this program.
        """
        try:
            from distributed import Client  # noqa: PLC0415 - an extra
        except ImportError as error:
            raise WorkerError(
                "a cluster needs dask.distributed: pip install 'brickpose[cluster]'"
            ) from error
        _check_reachable(address)
        try:
            self._client: Any = Client(address, timeout=PATIENCE, set_as_default=False)
            self._client.wait_for_workers(1, timeout=PATIENCE)
        except (OSError, ValueError) as error:
            raise WorkerError(f"no Dask scheduler with workers is at {address}: {error}") from error
        self._check_versions()

    @property
    def count(self) -> int:
        """Number of jobs done at a time, at present."""
        return max(int(sum(self._client.ncores().values())), 1)

    def each(
        self, work: Callable[[S], T], jobs: Sequence[S]
    ) -> Iterator[tuple[int, T | Exception]]:
        """Do all jobs; yield the index and the result or error of each as soon as it is done."""
        from distributed import as_completed  # noqa: PLC0415

        left = deque(enumerate(jobs))
        work = _WithFeatures(work, plugged().features.left_out)
        indices: dict[Any, int] = {}
        done_ones = as_completed(loop=self._client.loop)

        def submit_next() -> None:
            index, job = left.popleft()
            future = self._client.submit(work, job, pure=False)
            indices[future] = index
            done_ones.add(future)

        # Submit no more jobs than can run at a time, and fetch each result before submitting the
        # next job: then a worker that is killed holds no results of other jobs in its memory.
        while left and len(indices) < self.count:
            submit_next()
        while indices:
            done = next(done_ones)
            index = indices.pop(done)
            error = done.exception()
            result = done.result() if error is None else error
            done.release()
            while left and len(indices) < self.count:
                submit_next()
            yield index, result

    def close(self) -> None:
        """Leave the cluster; may be called twice."""
        self._client.close()

    def _check_versions(self) -> None:
        """Refuse workers with another program: their results would be taken for ours."""
        ours = versions()
        try:
            result = self._client.run(versions)
        except Exception as error:
            self.close()
            raise WorkerError(f"a worker of the cluster has not this program: {error}") from error
        for where, theirs in result.items():
            if theirs != ours:
                self.close()
                names = [name for name in ours if theirs.get(name) != ours[name]]
                other = ", ".join(
                    f"{name} {theirs.get(name)} (here {ours[name]})" for name in names
                )
                raise WorkerError(f"the worker {where} has {other}")


def workers(count: int | None, cluster: str | None) -> Workers:
    """Return the workers of a cluster, or ``count`` workers of this machine.

    Raises:
        SettingError: the count or the address is invalid.
        WorkerError: the cluster cannot be used.
    """
    return LocalWorkers(count) if cluster is None else ClusterWorkers(cluster)


def workers_from_options(given: Mapping[str, Any]) -> Workers:
    """Return the workers that the options ask for.

    Raises:
        SettingError: the options name both local workers and a cluster.
    """
    if "workers" in given and "cluster" in given:
        raise SettingError("--workers is for this machine; a cluster has as many as it has")
    return workers(given.get("workers"), given.get("cluster"))


def _check_reachable(address: str) -> None:
    """Check that a scheduler listens; a client would keep trying for a long time.

    Raises:
        SettingError: the address is invalid.
        WorkerError: nobody listens there.
    """
    parts = re.fullmatch(r"(?:(?:tcp|tls)://)?(\[[^]]+\]|[^:/\s]+):(\d{1,5})", address)
    if parts is None or not 0 < int(parts[2]) < 65536:
        raise SettingError(f"--cluster is {address!r}; valid is tcp://host:port")
    try:
        socket.create_connection((parts[1].strip("[]"), int(parts[2])), PATIENCE).close()
    except (OSError, UnicodeError) as error:
        raise WorkerError(f"no Dask scheduler answers at {address}: {error}") from error


def _result(done: Future[T]) -> T | Exception:
    try:
        return done.result()
    except Exception as error:
        return error
