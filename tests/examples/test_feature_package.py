"""A stranger's package, ``examples/feature_package``: installed beside, used, and taken away."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from urllib.request import urlopen

import httpx
import pytest
from browsing import visit
from playwright.sync_api import expect
from serving import ROOT, ask, drive_until, serving, until
from websockets.sync.client import connect

PACKAGE = ROOT / "examples" / "feature_package"

pytestmark = pytest.mark.real_time


@pytest.fixture(scope="module")
def beside(tmp_path_factory) -> Path:
    """The folder where it is installed."""
    folder = tmp_path_factory.mktemp("installed")
    source = shutil.copytree(PACKAGE, tmp_path_factory.mktemp("source") / "package")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
    quiet = ["--no-deps", "--no-build-isolation", "--no-index"]
    subprocess.run([*pip, *quiet, "--target", folder, source], check=True, timeout=120)
    return folder


def brickpose(*words: str, beside: Path | None) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join(map(str, filter(None, (beside, ROOT))))
    return subprocess.run(
        [sys.executable, "-m", "app", *words], cwd=ROOT, text=True, capture_output=True,
        env=os.environ | {"PYTHONPATH": path}, timeout=60, check=False,
    )  # fmt: skip


def creep_until(live, condition):
    """Telemetry while it creeps, when a condition holds."""

    def creeping(now):
        live.send(json.dumps({"type": "creep"}))
        return condition(now)

    return until(live, creeping)


def test_it_adds_a_command_an_address_a_document_and_a_check(beside, monkeypatch, tmp_path):
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((str(beside), str(ROOT))))
    with serving("--robot", "kinematic") as server:
        with urlopen(f"{server.url}/api/tape_seen", timeout=10) as answer:
            seen = json.load(answer)
        assert 0 < seen["tape"] <= seen["rays"]
        done = brickpose("tape-seen", server.url, beside=beside)
        assert done.returncode == 0
        assert f" of {seen['rays']} rays meet tape" in done.stdout
        with urlopen(f"{server.url}/help/tape_seen.md", timeout=10) as answer:
            document = answer.read().decode()
        assert "How much tape is seen</h1>" in document
        assert '<a href="tape_seen.md" aria-current=page>How much tape is seen</a>' in document
        with server.live() as live:
            now = until(live, lambda now: now["values"]["tape_rays"])
            assert now["values"]["tape_rays"] <= seen["rays"]
            # It creeps ahead until the tape is 25 cm away.
            creep_until(live, lambda now: now["twist"]["v"] > 0)
            now = creep_until(live, lambda now: now["twist"]["v"] == 0)
            assert 0.2 < min(filter(None, now["scan"]["ranges"])) < 0.26
        with urlopen(f"{server.url}/openapi.json", timeout=10) as answer:
            assert "/api/tape_seen" in json.load(answer)["paths"]
    told = brickpose("doctor", "--robot", "kinematic", beside=beside).stdout
    (names,) = re.findall(r"ok       Features: (.*)", told)
    assert {"mapping", "navigation", "tape_seen"} <= set(names.split(", "))
    assert "Tape is looked for on 91 rays" in told
    (tmp_path / "mine.toml").write_text("[tape_seen]\nfewest_rays = 200\n")
    words = ("doctor", "--robot", "kinematic", "--config", str(tmp_path / "mine.toml"))
    assert "set scanner.rays to 200 or more" in brickpose(*words, beside=beside).stdout
    left_out = brickpose(*words, "--without", "tape_seen", beside=beside)
    assert "rays" not in left_out.stdout + left_out.stderr
    assert "tape-seen  " in brickpose("--help", beside=beside).stdout


def test_it_adds_a_sensor_model_with_which_the_robot_keeps_its_place(beside, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((str(beside), str(ROOT))))
    with serving("--robot", "kinematic") as server, server.live() as live:
        refused = ask(live, type="set_parameters", values={"laser_model_type": "no_tape"})
        assert "laser_model_type is 'no_tape'; valid are" in refused["message"]
        values = {"laser_model_type": "near_tape", "filter": "particles"}
        assert ask(live, type="set_parameters", values=values)["type"] == "ack"
        begin = until(live, lambda now: now["estimate"])["truth"]
        now = drive_until(live, 0.1, lambda now: now["truth"]["x"] > begin["x"] + 0.2)
        assert now["problems"] == []
        assert math.hypot(*(now["estimate"][one] - now["truth"][one] for one in "xy")) < 0.02
        parameters = httpx.get(f"{server.url}/api/parameters", trust_env=False).json()
        model = next(one for one in parameters if one["name"] == "laser_model_type")
        assert (model["value"], model["choices"][-1]) == ("near_tape", "near_tape")


@pytest.mark.browser
def test_it_adds_a_robot_a_topic_and_a_panel(beside, monkeypatch, browser):
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((str(beside), str(ROOT))))
    with serving("--robot", "ideal") as server:
        address = f"{server.url.replace('http', 'ws')}/rosbridge"
        with connect(address, proxy=None) as socket:
            socket.send(json.dumps({"op": "subscribe", "topic": "/tape_rays"}))
            heard = json.loads(socket.recv(timeout=20))
        assert (heard["op"], heard["topic"]) == ("publish", "/tape_rays")
        rays = heard["msg"]["data"]
        assert rays > 0
        with browser.new_context() as context:
            page = context.new_page()
            page.route("**/view/**", lambda route: route.fulfill(body="<p>no 3D here</p>"))
            visit(page, server.url)
            page.locator("#layout-open").click()
            page.locator("[data-panel=tape_seen-tape-rays]").click()
            page.keyboard.press("Escape")
            expect(page.locator("#tape_seen-tape-rays")).to_contain_text(
                re.compile(r"\d+ rays meet tape")
            )
            page.get_by_role("button", name="creep").click()
            page.wait_for_function("window.brickpose.telemetry.truth.x > 0.001")


def test_a_program_that_does_not_answer_is_told_in_a_line(beside):
    done = brickpose("tape-seen", "http://127.0.0.1:9", beside=beside)
    assert done.returncode == 1
    assert done.stderr.startswith("brickpose: ") and "Traceback" not in done.stderr


@pytest.mark.parametrize("how", ["left out", "taken away"])
def test_without_it_nothing_of_it_is_there(beside, how, monkeypatch):
    words = ["--without", "tape_seen"] if how == "left out" else []
    path = beside if how == "left out" else None
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(map(str, filter(None, (path, ROOT)))))
    with serving("--robot", "kinematic", *words) as server:
        for address in ("/api/tape_seen", "/help/tape_seen.md"):
            assert httpx.get(f"{server.url}{address}", trust_env=False).status_code == 404
    done = brickpose("tape-seen", *words, beside=path)
    assert done.returncode == 2
    assert "invalid choice: 'tape-seen'" in done.stderr
