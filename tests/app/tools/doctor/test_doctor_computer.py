"""What ``brickpose doctor`` finds on a computer of any kind."""

from __future__ import annotations

import socket
from pathlib import Path

import numpy as np

from app.engine.compiling.compilation import Compilation
from app.settings.config import Config
from app.tools.doctor import computer
from app.tools.doctor.finding import OK, PROBLEM, WARNING
from robot.compiled_code import CompileCache
from robot.errors import PackageError


def test_an_old_python_is_a_problem() -> None:
    assert computer.python_version((3, 10, 12)).level == PROBLEM
    assert computer.python_version((3, 13, 0)).level == OK


def test_the_versions_here_are_those_that_were_tested() -> None:
    tested = computer.tested_versions(computer.CONSTRAINTS)
    assert tested["numpy"] == np.__version__
    assert computer.packages(tested).level == OK
    found = computer.packages(tested | {"numpy": "1.24.2"})
    assert (found.level, f"numpy {np.__version__} (1.24.2)" in found.message) == (WARNING, True)


def test_an_installation_without_the_list_of_versions_is_fine(tmp_path: Path) -> None:
    assert computer.packages(computer.tested_versions(tmp_path / "none.txt")).level == OK


def test_code_that_is_not_compiled_yet_is_a_warning(tmp_path: Path) -> None:
    kept = Compilation(CompileCache(tmp_path))
    assert "warm_up" in computer.compiled_code(kept).cure
    nowhere = computer.compiled_code(Compilation(CompileCache(None, "the disk is full")))
    assert (nowhere.level, "the disk is full" in nowhere.message) == (WARNING, True)
    kept.mark()
    assert computer.compiled_code(Compilation(CompileCache(tmp_path))).level == OK


def test_a_taken_web_port_is_a_warning() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        found = computer.web_port("127.0.0.1", taken.getsockname()[1])
    assert (found.level, "--port" in found.cure) == (WARNING, True)
    assert computer.web_port("127.0.0.1", 0).level == OK


def test_physics_is_missed_only_by_the_robot_that_needs_it(monkeypatch) -> None:
    def missing(engine: str = "auto") -> str:
        raise PackageError(f"no {engine}")

    monkeypatch.setattr(computer, "choose_engine", missing)
    robots = ("sim", "auto", "buildhat")
    levels = {robot: computer.simulator(robot, "auto").level for robot in robots}
    assert levels == {"sim": PROBLEM, "auto": WARNING, "buildhat": OK}


def test_without_a_robot_only_the_computer_is_looked_at() -> None:
    found = list(computer.check_computer(Config(robot="kinematic", port=0)))
    assert [one.level for one in found if one.level == PROBLEM] == []
    assert len(found) == 6
