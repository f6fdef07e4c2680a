"""One robot of a class, at a real JupyterHub: whose turn it is drives, the others watch."""

from __future__ import annotations

import json
from urllib.error import HTTPError

import pytest
from classes import needs_hub, running_class
from websockets.exceptions import ConnectionClosed

from benchmarks.classroom import StudentClient

pytestmark = [pytest.mark.slow, needs_hub]
PATH = "/services/robot/"


@pytest.fixture(scope="module")
def people(tmp_path_factory):
    """Ada, Bo and the teacher, at the shared robot."""
    words = ("--shared-robot", "kinematic", "--turn", "10")
    with running_class(tmp_path_factory.mktemp("class"), "Ada\nBo\n", *words) as served:
        made = [
            StudentClient(served.address, name, served.keys[name], PATH)
            for name in ("ada", "bo", "teacher")
        ]
        for each in made:
            each.open()
        yield made


def refusal(student: StudentClient) -> str:
    """What the robot says to who drives."""
    with student.socket("api/live?rate=5") as live:
        live.send(json.dumps({"type": "drive", "v": 0.1, "omega": 0.0, "id": 7}))
        while True:
            message = json.loads(live.recv(timeout=20.0))
            if message["type"] != "telemetry":
                return message.get("message", "")


def test_one_drives_after_the_other_and_the_teacher_hands_over(people):
    ada, bo, teacher = people
    assert "not your turn" in refusal(ada)
    assert ada.ask("queue", {"action": "join"})["driver"] == "ada"
    assert bo.ask("queue", {"action": "join"})["waiting"] == ["bo"]
    ada.move(20.0)
    assert "not your turn" in refusal(bo)
    with pytest.raises(HTTPError, match="403"):
        bo.ask("queue", {"action": "skip"})
    with ada.socket("api/live?rate=5") as live:
        assert teacher.ask("queue", {"action": "hand", "login": "bo"})["driver"] == "bo"
        # Nothing comes any more; a proxy may keep the end of the socket to itself.
        with pytest.raises((TimeoutError, ConnectionClosed)):
            while True:
                live.recv(timeout=5.0)
    bo.move(20.0)
    assert "not your turn" in refusal(ada)
    assert teacher.ask("queue", {"action": "end"})["ended"]
    assert "not your turn" in refusal(bo)
