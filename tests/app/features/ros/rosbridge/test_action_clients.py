"""Goals as the action clients of roslibjs and roslibpy send them, over real sockets."""

import json
import subprocess
import sys

import pytest
from node_peers import needs_node, run_node
from places import HELPERS
from serving import serving

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def server():
    with serving("--robot", "kinematic", "--map", "square", "--seed", "3") as running:
        yield running


@needs_node
def test_roslibjs_goals_are_reached_canceled_replaced_and_refused(server):
    lines = run_node("roslib_actions.mjs", f"ws://{server.address}/rosbridge")
    told = {name: value for line in lines for name, value in line.items()}
    assert told["reached"]["result"]
    assert told["reached"]["values"]["error_code"] == 0
    assert told["reached"]["feedback"] > 2
    assert "CANCELED" in told["canceled"]["words"].upper()
    assert "another goal took its place" in told["replaced"]["words"]
    assert "CANCELED" in told["second"]["words"].upper()
    assert "on a wall" in told["refused"]["words"]


def test_roslibpy_goals_are_reached_canceled_replaced_and_refused(server):
    pytest.importorskip("roslibpy")
    script = HELPERS / "roslibpy_actions.py"
    ended = subprocess.run(
        [sys.executable, str(script), f"ws://{server.address}/rosbridge"],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr[-2000:]
    told = {
        name: value
        for line in ended.stdout.splitlines()
        for name, value in json.loads(line).items()
    }
    assert {name: (one["result"], one["status"]) for name, one in told.items()} == {
        "reached": (True, 4),
        "canceled": (True, 5),
        "replaced": (True, 6),
        "second": (True, 5),
        "refused": (False, 6),
    }
    assert told["reached"]["feedback"] > 2
    assert told["replaced"]["values"]["error_msg"] == "another goal took its place"
    assert "on a wall" in told["refused"]["values"]
