"""A program whose workers are started and ended while they do real work, until a signal ends it.

``python -m benchmarks.ended_program SEED STARTS`` prints a line for each worker, and then how its
ends went; ``benchmarks.ends`` runs and ends it.
"""

from __future__ import annotations

import json
import random
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, wait
from dataclasses import dataclass, replace
from pathlib import Path

from app.console import say
from app.engine.build import build_program
from app.engine.program import LocalProgram
from app.features.lab.calibrate.calibrated_robot import CalibratedRobot
from app.features.lab.calibrate.command import calibrate_by_driving
from app.features.lab.evaluation.experiment import Experiment, RunPair, drive_and_follow
from app.features.lab.sweep.points import Measured, follow_all, jobs_of
from app.interruption import Interrupted, interruptible
from app.messages.driving_commands import FigureEightCommand
from app.settings.config import Config
from app.worker_process import WorkerEndedError, WorkerProcess
from robot.calibration.drive_log import DriveRecorder
from robot.geometry import Pose2
from robot.mapping.mapper import Mapper
from robot.mapping.tape_map import TapeMap
from robot.scanning.tape import Tape
from sim.simulated import PERIOD

CALIBRATION_S, MAPPING_S = 12.0, 8.0
"""How long the robots drive, on their own clock [s]."""
JOBS = 20
"""Jobs that wait for each worker: it has always something to do."""
MOST_ALIVE = 3
LONGEST_WAIT_S = 2.5
"""Longest time from one start to the next [s]."""
AT_WORK = 0.3
"""Share of the starts after which the worker's first job is waited for: the others are younger."""
START_S = 60.0
"""Longest time to wait for it [s]."""
PATIENCE_S = 5.0
"""Longest time after which an ended worker is gone, and its jobs have been told [s]."""


def calibration(seed: int) -> CalibratedRobot:
    """Drive the calibration's programme, and solve it."""
    return calibrate_by_driving(_config(seed), CALIBRATION_S, None)


def mapping(seed: int) -> TapeMap:
    """Drive on the tape, and draw the map of it."""
    program = build_program(_config(seed))
    try:
        log = _driven(program)
    finally:
        program.robot.close()
    width = program.field.tape_width
    assert width is not None
    return Mapper(log.log, program.robot.spec, width, Pose2()).run()


def sweep(seed: int) -> dict[str, Measured]:
    """Follow one drive at two settings."""
    config = _config(seed)
    fewer = replace(config.localization.filter, max_particles=1000)
    other = replace(config, localization=replace(config.localization, filter=fewer))
    (job,) = jobs_of({"one": config, "other": other}, 0.5, ())
    return follow_all(job)


def evaluation(seed: int) -> RunPair:
    """Drive, and follow it with a known and with a wrong start."""
    (job,) = Experiment(_config(seed), ("kinematic",), seed, 1, 1).jobs()
    return drive_and_follow(job)


def _config(seed: int) -> Config:
    return Config(robot="kinematic", seed=seed)


def _driven(program: LocalProgram) -> DriveRecorder:
    tapes = tuple(Tape(tape.width) for tape in program.field.tape)[:1]
    log = DriveRecorder(program.robot.spec, program.config.scanner, tapes, calibrated=True)
    for _ in range(round(MAPPING_S / PERIOD)):
        program.engine.commands.put(FigureEightCommand(type="figure_eight"))
        log.add(program.engine.step().reading)
    return log


KINDS: dict[str, Callable[[int], object]] = {
    "calibration": calibration,
    "mapping": mapping,
    "sweep": sweep,
    "evaluation": evaluation,
}


@dataclass
class Work:
    """A worker, and what it was given to do."""

    kind: str
    worker: WorkerProcess
    jobs: list[Future[object]]

    @classmethod
    def begin(cls, kind: str, seed: int) -> Work:
        """Start a worker with jobs."""
        worker = WorkerProcess()
        return cls(kind, worker, [worker.submit(KINDS[kind], seed + i) for i in range(JOBS)])

    @property
    def done(self) -> int:
        """Number of jobs that are done."""
        return sum(job.done() for job in self.jobs)

    def failures(self) -> list[str]:
        """Return why jobs failed, other than by the worker's end."""
        done = [job for job in self.jobs if job.done() and not job.cancelled()]
        errors = [error for job in done if (error := job.exception()) is not None]
        return [repr(error) for error in errors if not isinstance(error, WorkerEndedError)]


def end(work: Work) -> dict[str, object]:
    """End a worker; return how that went."""
    done, began = work.done, time.monotonic()
    work.worker.end()
    untold = len(wait(work.jobs, PATIENCE_S).not_done)
    while Path(f"/proc/{work.worker.pid}").exists() and time.monotonic() < began + PATIENCE_S:
        time.sleep(0.001)
    return {
        "kind": work.kind,
        "done": done,
        "seconds": time.monotonic() - began,
        "left": Path(f"/proc/{work.worker.pid}").exists(),
        "untold": untold,
        "failures": work.failures(),
    }


def main() -> int:
    """Start and end workers, then wait for the signal with those that are left."""
    seed, starts = map(int, sys.argv[1:])
    chance = random.Random(seed)
    alive: list[Work] = []
    try:
        with interruptible():
            try:
                for number in range(starts):
                    alive.append(Work.begin(chance.choice(list(KINDS)), 100 * number))
                    say(json.dumps({"pid": alive[-1].worker.pid}))
                    if chance.random() < AT_WORK:
                        wait(alive[-1].jobs[:1], START_S)
                    time.sleep(chance.uniform(0.0, LONGEST_WAIT_S))
                    if len(alive) > MOST_ALIVE:
                        say(json.dumps(end(alive.pop(chance.randrange(len(alive))))))
                say(json.dumps({"alive": [work.kind for work in alive]}))
                threading.Event().wait()
            finally:
                # Half of the programs leave their workers to what ends them with the program.
                for work in alive if seed % 2 else []:
                    work.worker.end()
    except Interrupted as interrupted:
        return interrupted.code
    return 1


if __name__ == "__main__":
    sys.exit(main())
