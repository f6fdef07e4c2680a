"""Telemetry and commands as a client has them: a server in a process of its own, real sockets."""

import json
import re
from itertools import pairwise

import numpy as np
import pytest
import websockets
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from serving import ask, telemetry, until

from app.messages.telemetry import TelemetryMessage

pytestmark = pytest.mark.slow


def test_telemetry_comes_newest_first_and_is_valid(live):
    stamps = [TelemetryMessage.model_validate(telemetry(live)).stamp for _ in range(20)]
    assert all(later > earlier for earlier, later in pairwise(stamps))


def test_drive_is_answered_and_moves_the_robot(live):
    start = telemetry(live)
    assert ask(live, type="drive", v=0.2, omega=0, id=7) == pytest.approx(
        {"type": "ack", "id": 7, "stamp": start["stamp"]}, abs=1.0
    )
    moved = until(live, lambda t: abs(t["truth"]["x"] - start["truth"]["x"]) > 0.02)
    assert moved["twist"]["v"] > 0.05


def test_of_two_who_drive_the_first_has_the_drive_and_both_see_it(server, live):
    with server.live() as other:
        assert ask(other, type="drive", v=0.1, omega=0)["type"] == "ack"
        assert "take over" in ask(live, type="drive", v=0.1, omega=0)["message"]
        mine = until(other, lambda t: t["driver"]["name"])["driver"]
        assert (mine["mine"], mine["stopped"]) == (True, False)
        theirs = until(live, lambda t: t["driver"]["name"])["driver"]
        assert theirs == {**mine, "mine": False, "this_page": False}
        assert ask(live, type="take")["type"] == "ack"
        assert "take over" in ask(other, type="drive", v=0.1, omega=0)["message"]
        assert until(live, lambda t: t["driver"]["mine"])


def test_a_stop_holds_against_renewals_of_others(server, live):
    with server.live() as other:
        for _ in range(5):
            ask(other, type="drive", v=0.1, omega=0)
        until(live, lambda t: t["twist"]["v"] > 0)
        ask(live, type="stop")
        still = until(live, lambda t: t["twist"]["v"] == 0)
        while telemetry(live)["stamp"] < still["stamp"] + 1.5:
            assert "a stop holds" in ask(other, type="drive", v=0.1, omega=0)["message"]
            assert telemetry(live)["twist"]["v"] == 0
        assert telemetry(live)["driver"] == {
            "name": None,
            "mine": False,
            "this_page": False,
            "stopped": True,
        }
        ask(other, type="take")
        ask(other, type="drive", v=0.1, omega=0)
        until(live, lambda t: t["twist"]["v"] > 0)


def test_set_pose_and_place(live):
    ask(live, type="place", x=0.1, y=0.1, theta=1.0)
    placed = until(live, lambda t: abs(t["truth"]["x"] - 0.1) < 1e-6)
    assert placed["truth"]["theta"] == pytest.approx(1.0)
    ask(live, type="set_pose", x=0.1, y=0.1, theta=1.0, sd_xy=0.005, sd_theta=0.02)
    near = until(live, lambda t: t["estimate"] and abs(t["estimate"]["theta"] - 1.0) < 0.1)
    assert near["estimate"]["x"] == pytest.approx(0.1, abs=0.02)
    assert near["estimate"]["y"] == pytest.approx(0.1, abs=0.02)


def test_set_pose_takes_a_covariance(live):
    covariance = [4e-4, 0, 0, 0, 1e-4, 0, 0, 0, 1e-3]
    ask(live, type="pause")
    answer = ask(live, type="set_pose", x=0.1, y=0.1, theta=1.0, covariance=covariance)
    assert answer["type"] == "ack"
    told = until(live, lambda t: t["estimate"] and t["filter"]["updates"] == 0)["estimate"]
    assert told["covariance"][0] == pytest.approx(4e-4, rel=0.2)
    assert told["covariance"][4] == pytest.approx(1e-4, rel=0.2)
    ask(live, type="resume")


def test_the_filter_starts_from_twenty_thousand_poses(live):
    poses = np.random.default_rng(0).normal([0.1, -0.2, 0.5], [0.01, 0.01, 0.05], (20_000, 3))
    ask(live, type="pause")
    answer = ask(live, type="set_particles", poses=poses.tolist(), weights=[1e300] * 20_000)
    assert answer["type"] == "ack"
    now = until(live, lambda t: t["estimate"] and t["particles"]["count"] == 20_000)
    assert now["estimate"]["y"] == pytest.approx(-0.2, abs=0.01)
    ask(live, type="resume")
    ask(live, type="reset")


def test_every_hypothesis_is_told_with_weight_and_covariance(live):
    ask(live, type="pause")
    ask(live, type="set_particles", poses=[[0.1, 0.1, 0]] * 3 + [[-0.2, 0.1, 1]])
    now = until(live, lambda t: t["filter"]["updates"] == 0 and t["estimate"])
    found = now["particles"]["hypotheses"]
    assert [one["weight"] for one in found] == pytest.approx([0.75, 0.25], abs=1e-3)
    assert (found[1]["x"], found[1]["theta"]) == pytest.approx((-0.2, 1.0), abs=0.02)
    assert [len(one["covariance"]) for one in found] == [9, 9]
    assert set(now["integrity"]) == {"state", "radius", "heading_bound", "alerts"}
    assert now["integrity"]["state"] != "certain"
    ask(live, type="resume")
    ask(live, type="reset")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "JSON"),
        ("{", "JSON"),
        ("[]", ""),
        ("null", ""),
        ('{"type": "fly", "id": 3}', "no feature here has the command 'fly'; valid are .*drive"),
        ('{"id": 3}', "type"),
        ('{"type": "drive", "v": 1}', "omega"),
        ('{"type": "drive", "v": NaN, "omega": 0}', "finite"),
        ('{"type": "drive", "v": 1e999, "omega": 0}', "finite"),
        ('{"type": "drive", "v": "fast", "omega": 0}', "v"),
        ('{"type": "drive", "v": true, "omega": 0}', "v: .*number"),
        ('{"type": "drive", "v": "1", "omega": 0}', "v: .*number"),
        ('{"type": "drive", "v": 1, "omega": 0, "speed": 3}', "speed"),
        ('{"type": "stop", "id": "\\ud800"}', "JSON"),
        ('{"type": "set_pose", "x": 5, "y": 0, "theta": 0}', "off the map"),
        ('{"type": "set_pose", "x": 0, "y": 0, "theta": 0, "sd_xy": -1}', "sd_xy"),
        ('{"type": "set_pose", "x": 0, "y": 0, "theta": 0, "covariance": [1, 2]}', "at least 9"),
        (
            '{"type": "set_pose", "x": 0, "y": 0, "theta": 0,'
            ' "covariance": [1, 2, 0, 2, 1, 0, 0, 0, 1]}',
            "not positive semi-definite",
        ),
        ('{"type": "set_particles", "poses": []}', "poses: .*at least 1"),
        ('{"type": "set_particles", "poses": [[0, 0, 0], [0, 9, 0]]}', "off the map"),
        ('{"type": "set_particles", "poses": [[0, 0, 0]], "weights": [0]}', "all weights are zero"),
        ('{"type": "place", "x": 0, "y": -9, "theta": 0}', "off the map"),
        ('{"type": "set_parameters", "values": {"sigma": 1}}', "valid are .*sigma_hit"),
        ('{"type": "set_parameters", "values": {"sigma_hit": 9}}', "valid is 0.0005 to 0.5"),
        ('{"type": "set_parameters", "values": {"min_particles": 1.5}}', "whole number"),
        ('{"type": "set_parameters", "values": {}}', "values"),
        ('{"type": "show", "layer": "ghosts", "visible": true}', "layer"),
        ("[" * 5000, ""),
        ('{"type": "stop", "id": "' + "x" * 70_000 + '"}', "at most"),
    ],
)
def test_a_wrong_command_is_refused_with_what_is_valid(live, text, told):
    live.send(text)
    assert re.search(told, until_error(live))
    assert telemetry(live)


def test_a_refused_command_keeps_its_id(live):
    assert ask(live, type="fly", id="abc")["id"] == "abc"


def test_a_binary_message_is_refused(live):
    live.send(b"\x00\xff")
    assert until_error(live)
    assert telemetry(live)


def until_error(live) -> str:
    while True:
        message = json.loads(live.recv(timeout=20))
        if message["type"] == "error":
            return message["message"]


TYPES = ["drive", "set_pose", "set_particles", "place", "set_parameters", "show"]
SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5)
COMMANDS = st.dictionaries(
    st.sampled_from(["v", "omega", "x", "y", "theta", "poses", "weights", "values", "id"]), SCALARS
).flatmap(
    lambda rest: st.sampled_from(
        ["drive", "set_pose", "set_particles", "place", "set_parameters", "show"]
    ).map(lambda kind: json.dumps({"type": kind, **rest}))
)


@settings(max_examples=80, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.text(max_size=50) | COMMANDS | st.lists(SCALARS).map(json.dumps))
def test_whatever_is_sent_is_answered(live, text):
    live.send(text)
    while json.loads(live.recv(timeout=20))["type"] not in ("ack", "error"):
        pass


def test_a_message_that_is_far_too_large_ends_that_viewer_only(server, live):
    with server.live() as hostile, pytest.raises(websockets.ConnectionClosed):
        hostile.send("x" * 3_000_000)
        while True:
            hostile.recv(timeout=20)
    assert telemetry(live)
