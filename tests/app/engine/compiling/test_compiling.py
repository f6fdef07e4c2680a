"""All functions are compiled before a robot drives, by several processes, with progress."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import urlopen

import first_uses
import pytest
from apps import listening
from playwright.sync_api import expect
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from app.engine.compiling import compilation
from app.engine.compiling.compilation import Compilation
from app.engine.compiling.functions import FUNCTIONS, Compiled
from app.engine.compiling.terminal import compile_with_progress
from app.page.first_start import starting_app
from app.settings.config import ROOT, Config
from robot.compiled_code import CompileCache
from robot.compiling import _OwnDataFiles

pytestmark = pytest.mark.slow

FEW = tuple(FUNCTIONS[-3:])


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Three functions to compile, in this process; the names of those that were."""
    done: list[str] = []
    monkeypatch.setattr(compilation, "all_functions", lambda: FEW)
    monkeypatch.setattr(Compiled, "compile", lambda self: done.append(self.name))
    return done


def test_the_list_has_what_a_drive_with_each_filter_and_model_calls() -> None:
    command = [sys.executable, first_uses.__file__]
    ran = subprocess.run(command, cwd=ROOT, env=None, capture_output=True, text=True, check=True)
    drawn = {tuple(line.split("\t")) for line in ran.stdout.splitlines()}
    assert {(each.name, str(each.types)) for each in compilation.all_functions()} == drawn


def test_workers_compile_all_and_later_starts_know_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They find the functions of this checkout compiled; that they are asked is what counts."""
    monkeypatch.setattr(compilation, "all_functions", lambda: FEW)
    first, told = Compilation(CompileCache(tmp_path)), []
    assert first.needed and first.run(report=told.append)
    assert told == [1, 2, 3] and not first.needed
    assert not Compilation(CompileCache(tmp_path)).needed


def test_more_functions_are_compiled_again_and_fewer_are_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compilation, "all_functions", lambda: FEW[:2])
    Compilation(CompileCache(tmp_path)).mark()
    monkeypatch.setattr(compilation, "all_functions", lambda: FEW)
    assert Compilation(CompileCache(tmp_path)).needed
    Compilation(CompileCache(tmp_path)).mark()
    monkeypatch.setattr(compilation, "all_functions", lambda: FEW[:2])
    Compilation(CompileCache(tmp_path)).mark()
    monkeypatch.setattr(compilation, "all_functions", lambda: FEW)
    assert not Compilation(CompileCache(tmp_path)).needed


def test_it_stops_when_it_is_asked_to(tmp_path: Path, few: list[str]) -> None:
    stopped = Compilation(CompileCache(tmp_path))
    assert not stopped.run(stop=lambda: True)
    assert stopped.needed
    alone = Compilation(CompileCache(None, "the disk is full"))
    assert not alone.run(stop=lambda: len(few) == 2)
    assert (few, alone.done) == ([each.name for each in FEW[:2]], 2)


def test_without_a_folder_this_process_compiles_and_says_why(
    few: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    alone = Compilation(CompileCache(None, "the disk is full"))
    assert alone.needed and compile_with_progress(alone)
    assert few == [each.name for each in FEW]
    assert "the disk is full" in capsys.readouterr().out


def test_processes_that_compile_at_once_never_load_each_others_code(tmp_path: Path) -> None:
    """One writes its code after the other has replaced the list of files."""
    one, other = (_OwnDataFiles(str(tmp_path), "f-1.py311", "stamp") for _ in range(2))
    other._own = "other"
    late = one._data_name(1)
    other.save("float64", "code of the other")
    one._save_data(late, "code of the one")
    assert one.load("float64") == "code of the other"


def got(address: str) -> tuple[int, bytes]:
    try:
        with urlopen(f"http://{address}") as answer:
            return answer.status, answer.read()
    except HTTPError as error:
        return error.code, error.read()


def test_before_there_is_a_robot_the_page_and_its_health_are_there(tmp_path: Path) -> None:
    going = Compilation(CompileCache(tmp_path))
    going.done = 17
    with listening(starting_app(Config(), going, None)) as address:
        assert got(f"{address}/")[0] == 200
        status, answer = got(f"{address}/api/health")
        health = json.loads(answer)
        assert (status, health["status"]) == (200, "degraded")
        assert health["compiling"] == {"done": 17, "total": len(compilation.all_functions())}
        assert "17" in health["detail"]
        for path in ("camera.jpg", "api/state", "view/"):
            status, answer = got(f"{address}/{path}")
            assert (status, json.loads(answer)["detail"]) == (503, health["detail"])
        with pytest.raises(InvalidStatus, match="503"):
            connect(f"ws://{address}/api/live")


@pytest.mark.browser
def test_the_page_shows_how_far_it_is_where_the_picture_will_be(browser, tmp_path: Path) -> None:
    going = Compilation(CompileCache(tmp_path))
    with listening(starting_app(Config(), going, None)) as address:
        made = browser.new_page(locale="de")
        made.goto(f"http://{address}")
        going.done = 17
        bar = made.locator("#camera progress")
        expect(bar).to_be_visible()
        expect(bar).to_have_js_property("value", 17)
        expect(made.locator("#compiling-text")).to_contain_text("17 von")
        expect(made.locator("#camera-empty")).to_be_hidden()
        expect(made.locator("#robot-state")).to_have_text("kompiliert")
        expect(made.locator("#banner")).to_be_empty()
        made.close()
