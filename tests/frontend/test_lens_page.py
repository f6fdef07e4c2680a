"""The lens's calibration by the running camera, as a page sees and works it."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import cv2
import httpx
import numpy as np
import pytest
import yaml
from apps import listening
from board_pictures import CHESSBOARD, lens_of, picture, poses
from camera_sources import until
from engine_runs import kinematic, run
from fastapi import FastAPI
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from app.engine.program import Program
from app.features.calibration.lens import desk
from app.features.calibration.lens.messages import LensMessage
from app.features.calibration.lens.routes import lens_router
from app.page.token_guard import TokenRequired
from app.page.tokens import Tokens
from app.settings.profile_files import before
from app.settings.profiles import own_profile
from robot.calibration.lens.sighting import Grey
from robot.description.profile import Profile, load_profile
from robot.interface import Frame
from robot.lens_files.reading import read_lens_file

pytestmark = pytest.mark.slow

BOARD = {"kind": "chessboard", "columns": 10, "rows": 7, "square": 0.025}
LENS = lens_of()
TOKENS = Tokens("drive-me", "watch-me")
ANSWER_S = 30.0


class Bench:
    """A page at a robot whose camera shows what the test wants."""

    def __init__(self, program: Program, socket: ClientConnection, address: str) -> None:
        self.program, self.socket, self.address = program, socket, address
        self.snapshot = run(program, 0.2)[-1]
        self.stamp = self.snapshot.stamp
        self.status: dict[str, Any] = {}

    def get(self, path: str) -> httpx.Response:
        return httpx.get(f"http://{self.address}{path}", timeout=ANSWER_S, trust_env=False)

    def ask(self, **request: Any) -> None:
        self.socket.send(json.dumps(request))

    def hear(self) -> dict[str, Any]:
        message: dict[str, Any] = json.loads(self.socket.recv(timeout=ANSWER_S))
        if message["type"] == "lens":
            self.status = message
        return message

    def until(self, condition) -> dict[str, Any]:
        while not (self.status and condition(self.status)):
            self.hear()
        return self.status

    def start(self, **board: Any) -> None:
        self.ask(type="start", board=BOARD | board)
        self.until(lambda status: status["board"] is not None and status["taken"] == 0)

    def show(self, image: Grey) -> dict[str, Any]:
        """Show a picture; what the page is told of it."""
        self.stamp += 0.25
        frame = Frame(self.stamp, image.copy())
        self.program.engine.latest.put(replace(self.snapshot, frame=frame))
        status = self.until(lambda status: (status["look"] or {}).get("stamp") == self.stamp)
        return status["look"]

    def hold(self, image: Grey) -> dict[str, Any]:
        """Hold a board still; what the page is told of it in the end."""
        self.show(image)
        return self.show(image)


def app_of(program: Program) -> FastAPI:
    app = FastAPI()
    app.include_router(lens_router(program))
    return app


def socket_at(address: str, token: str = "") -> ClientConnection:
    return connect(f"ws://{address}/api/lens?token={token}", proxy=None)


@contextmanager
def bench_of(program: Program) -> Iterator[Bench]:
    with listening(app_of(program)) as address, socket_at(address) as socket:
        yield Bench(program, socket, address)


@pytest.fixture(autouse=True)
def hurry(monkeypatch):
    monkeypatch.setattr(desk, "PERIOD_S", 0.01)


@pytest.fixture(scope="module")
def program() -> Program:
    return kinematic()


@pytest.fixture
def bench(program) -> Iterator[Bench]:
    with bench_of(program) as made:
        yield made


@pytest.fixture(scope="module")
def pictures() -> list[Grey]:
    rng = np.random.default_rng(4)
    return [picture(CHESSBOARD, place, rng) for place in poses(CHESSBOARD, LENS, 10, rng)]


def test_before_the_start_nothing_is_looked_for(bench, pictures):
    status = bench.hear()
    assert (status["board"], status["look"], status["taken"]) == (None, None, 0)
    assert status["bars"] == {"x": 0, "y": 0, "size": 0, "tilt": 0}
    bench.ask(type="calibrate")
    assert "start first" in bench.until(lambda status: status["problem"])["problem"]


def test_the_camera_of_a_robot_that_stands_does_not_rest_while_a_board_is_moved_before_it():
    program = kinematic()
    program.engine.audience.leave()
    with bench_of(program) as bench:
        bench.hear()
        assert program.engine.audience.rate == math.inf
    until(lambda: program.engine.audience.rate == 0)
    program.robot.close()


def test_a_board_that_is_held_still_is_taken_and_what_is_missing_changes(bench, pictures):
    bench.start()
    first = bench.show(pictures[0])
    assert (first["verdict"], first["words"]) == ("moving", "hold it still")
    assert len(first["corners"]) == 54
    asked = bench.status["next_steps"]
    assert bench.show(pictures[0])["verdict"] == "taken"
    assert bench.status["taken"] == 1 and len(bench.status["outlines"]) == 1
    assert any(any(row) for row in bench.status["parts"])
    assert bench.status["bars"]["tilt"] > 0 and bench.status["next_steps"] != asked


def test_a_picture_of_no_use_is_refused_with_the_reason(bench, pictures):
    bench.start()
    bench.hold(pictures[0])
    assert bench.show(pictures[0])["verdict"] == "known"
    soft = np.asarray(cv2.GaussianBlur(pictures[1], (0, 0), 4))
    assert bench.hold(soft)["words"].startswith("blurred")
    assert "in sight" in bench.hold(np.full((480, 640), 90, np.uint8))["words"]
    colours = cv2.cvtColor(pictures[1], cv2.COLOR_GRAY2BGR)
    assert bench.hold(np.asarray(colours))["verdict"] == "taken"
    assert bench.status["taken"] == 2


def test_bad_requests_are_told_and_change_nothing(bench):
    before_them = bench.hear()
    for request, words in {
        "": "EOF",
        "{": "EOF",
        '{"type": "dance"}': "'start', 'calibrate', 'save'",
        '{"type": "start"}': "board: Field required",
        '{"type": "start", "board": {"columns": 2}}': "valid is 3 to 40 along each side",
        '{"type": "start", "board": {"square": -1}}': "valid is 0.001 to 1 m",
        '{"type": "start", "board": {"kind": "dots"}}': "valid are chessboard, charuco",
        '{"type": "start", "board": {"colums": 9}}': "colums",
        '{"type": "save"}': "only a real robot has a profile",
        " " * 3000: "at most 2000 characters",
    }.items():
        bench.socket.send(request)
        answer = bench.hear()
        assert answer["type"] == "error" and words in answer["message"]
    assert bench.status == before_them


def test_too_few_pictures_give_no_lens_but_words(bench, pictures):
    bench.start()
    bench.hold(pictures[0])
    bench.ask(type="calibrate")
    status = bench.until(lambda status: status["problem"])
    assert status["problem"] == "1 pictures of 1 are of use; valid are 6 or more"
    assert status["calibrations"] == 0
    for path in ("/api/lens", "/api/lens/camera.yaml", "/api/lens/profile.toml"):
        assert bench.get(path).status_code == 404


def calibrate(bench: Bench, pictures: list[Grey]) -> LensMessage:
    bench.start()
    for grey in pictures:
        assert bench.hold(grey)["verdict"] == "taken"
    bench.ask(type="calibrate")
    bench.until(lambda status: status["busy"])
    bench.until(lambda status: not status["busy"])
    assert bench.status["calibrations"] == 1, bench.status["problem"]
    return LensMessage.model_validate_json(bench.get("/api/lens").text)


def test_the_lens_is_shown_and_can_be_taken_home(bench, pictures, tmp_path):
    shown = calibrate(bench, pictures)
    values = {each.name: each for each in shown.parameters}
    assert values["fx"].value == pytest.approx(LENS.matrix[0, 0], abs=3)
    assert 0 < values["fx"].interval < 10
    assert shown.model == "plumb_bob" and len(shown.ratings) == 3
    chosen = shown.ratings[0]
    assert chosen.own_px < chosen.held_out_px < 0.3
    assert len(shown.corners) == len(shown.errors) == 54 * shown.pictures
    assert np.hypot(*np.transpose(shown.errors)).mean() == pytest.approx(chosen.own_px, rel=0.3)

    answer = bench.get("/api/lens/camera.yaml")
    assert 'filename="camera.yaml"' in answer.headers["content-disposition"]
    (tmp_path / "camera.yaml").write_text(answer.text)
    lens = read_lens_file(tmp_path / "camera.yaml").lens
    assert lens.matrix[0, 0] == pytest.approx(values["fx"].value)
    assert yaml.safe_load(answer.text)["parameter_sd"]["fx"] > 0

    (tmp_path / "profile.toml").write_text(bench.get("/api/lens/profile.toml").text)
    profile = load_profile(tmp_path / "profile.toml")
    assert profile.lens is not None and profile.source == f"lens by {shown.pictures} pictures"
    spec = profile.applied_to(bench.program.robot.spec)
    assert spec.lens.matrix[0, 0] == pytest.approx(values["fx"].value)


def real(program: Program) -> Program:
    """The same, as if it were the real robot."""
    return replace(program, config=replace(program.config, robot="buildhat"))


def test_a_real_robots_profile_gets_the_lens_and_is_never_lost(
    program, pictures, tmp_path, monkeypatch
):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    program = real(program)
    robot = program.robot.spec.name
    path = own_profile(robot)
    path.parent.mkdir(parents=True)
    path.write_text("robot = 3\n")
    with bench_of(program) as bench:
        assert bench.hear()["profile"] == str(path)
        bench.ask(type="save")
        assert "calibrate first" in bench.until(lambda status: status["problem"])["problem"]
        calibrate(bench, pictures)
        assert not bench.status["saved"]

        bench.ask(type="save")
        assert "robot is missing" in bench.until(lambda status: status["problem"])["problem"]
        answer = bench.get("/api/lens/profile.toml")
        assert answer.status_code == 503 and "robot is missing" in answer.json()["detail"]
        assert path.read_text() == "robot = 3\n"

        path.write_text(Profile.unmeasured(robot, "a drive").to_toml())
        bench.ask(type="save")
        bench.until(lambda status: status["saved"])
    profile = load_profile(path)
    assert profile.source == "a drive; lens by 10 pictures"
    assert profile.lens is not None
    assert profile.lens.lens.matrix[0, 0] == pytest.approx(LENS.matrix[0, 0], abs=3)
    assert load_profile(before(path)).lens is None


def test_pages_work_one_calibration_together_and_it_outlives_them(program, pictures):
    with bench_of(program) as bench:
        bench.start()
        bench.hold(pictures[0])
        with socket_at(bench.address) as socket:
            other = Bench(program, socket, bench.address)
            assert other.hear()["taken"] == 1
            bench.socket.close()
            other.stamp = bench.stamp
            assert other.hold(pictures[1])["verdict"] == "taken"
        with socket_at(bench.address) as socket:
            assert json.loads(socket.recv(timeout=ANSWER_S))["taken"] == 2


def test_whoever_only_watches_may_not_calibrate(program):
    app = app_of(program)
    app.add_middleware(TokenRequired, tokens=TOKENS)
    with listening(app) as address:
        with socket_at(address, TOKENS.watch) as socket:
            assert "only watches" in json.loads(socket.recv(timeout=ANSWER_S))["message"]
            with pytest.raises(ConnectionClosed):
                socket.recv(timeout=ANSWER_S)
        with socket_at(address, TOKENS.drive) as socket:
            assert json.loads(socket.recv(timeout=ANSWER_S))["type"] == "lens"
        headers = {"accept": "text/html"}
        answer = httpx.get(f"http://{address}/lens", headers=headers, trust_env=False)
        assert answer.status_code == 401 and "asks for a token" in answer.text


def test_a_board_is_printed_or_refused_with_the_reason(bench):
    answer = bench.get("/api/board.pdf")
    assert answer.headers["content-type"] == "application/pdf"
    assert answer.content.startswith(b"%PDF") and b"10 x 7 squares" in answer.content
    for query, words in {
        "columns=50": "valid is 3 to 40 along each side",
        "paper=a9": "valid are a4, a3, letter",
        "square=0.05": "too large for a4",
        "square=nan": "valid is 0.001 to 1 m",
        "kind=aprilgrid&dictionary=apriltag_36h11": "a grid of tags is not printed",
        "kind=charuco&dictionary=x": "valid are 4x4_50",
    }.items():
        answer = bench.get(f"/api/board.pdf?{query}")
        assert answer.status_code == 404 and words in answer.json()["detail"]
