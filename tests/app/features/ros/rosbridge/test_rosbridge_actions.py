"""Goals by actions of nav2: feedback, results with their codes, cancel, and what is refused."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest
from engine_runs import kinematic, run
from journeys import KNOWN, RENEW
from ros_messages import topic
from rosbridge_sessions import Client, bridge_of

from app.engine.snapshot import DrawnMap
from app.features.ros.encoding.frames import heading_of
from app.features.ros.message_types import to_cdr
from app.messages.commands import PauseCommand
from app.page.outlets import Outlets
from robot.geometry import Pose2
from sim.simulated import PERIOD

pytestmark = pytest.mark.slow

NAME = "/navigate_to_pose"
LONGEST_S = 60.0


def pose(x: float, y: float, frame="map", turn=None) -> dict:
    return {
        "header": {"frame_id": frame},
        "pose": {"position": {"x": x, "y": y}, "orientation": turn or {"w": 1.0}},
    }


class Floor:
    """A robot, and a client of its rosbridge; ticks go on as fast as the goal is watched."""

    def __init__(self) -> None:
        self.program = kinematic()
        self.outlets = Outlets(self.program)
        self.bridge = bridge_of(self.program)
        self.bridge.inbox.drivers = self.outlets.drivers
        self.bridge.inbox._put = self.outlets.carry_out
        self.program.engine.commands.put(KNOWN)
        run(self.program, 0.4)
        # Who drives goes by the robot's clock: ticks are not in step with the wall's.
        self.outlets.drivers._clock = lambda: self.program.engine.latest.get().stamp
        self.client = Client(self.bridge)

    def send(self, number: str, *goals: dict, action=NAME) -> list[dict]:
        args = {"pose": goals[0]} if action == NAME else {"poses": list(goals)}
        return self.client.ask(
            "send_action_goal", id=number, action=action, args=args, feedback=True,
            action_type="nav2_msgs/action/NavigateToPose",
        )  # fmt: skip

    def go(self, seconds: float = LONGEST_S, until: str = "action_result") -> list[dict]:
        """Drive on, in real time at most five times as fast, until a message comes."""
        told: list[dict] = []
        for _ in range(round(seconds / PERIOD)):
            # As the keeper of journeys does in real time.
            self.outlets.drivers.renew(self.client.session._driver, RENEW)
            self.program.engine.step()
            for goal in self.client.session._goals.values():
                goal._thread.wait(PERIOD / 5)  # it follows the real time
            told += self.client.got()
            if any(message["op"] == until for message in told):
                break
        return told


def result_in(told: list[dict]) -> dict:
    """The one result among what came; the other goal's feedback may have come besides."""
    (result,) = (message for message in told if message["op"] == "action_result")
    return result


@pytest.fixture
def floor() -> Iterator[Floor]:
    made = Floor()
    yield made
    made.client.session.close()
    made.outlets.close()
    made.program.engine._companions.close()


def test_a_goal_is_reached_with_feedback_and_succeeds(floor):
    assert floor.send("one", pose(0.25, 0.1)) == []
    told = floor.go()
    result = told[-1]
    assert result == {
        "op": "action_result", "id": "one", "action": NAME, "status": 4, "result": True,
        "values": {"error_code": 0, "error_msg": ""},
    }  # fmt: skip
    truth = floor.program.engine.latest.get().truth
    assert truth.distance_to(Pose2(0.25, 0.1)) < 0.003
    feedback = [message["values"] for message in told[:-1]]
    left = [values["distance_remaining"] for values in feedback]
    assert max(left) > 0.2
    assert left[-1] < 0.01
    last = feedback[-1]
    assert last["current_pose"]["header"]["frame_id"] == "map"
    assert last["current_pose"]["pose"]["position"]["x"] == pytest.approx(0.25, abs=0.01)
    assert last["number_of_recoveries"] == 0
    assert last["estimated_time_remaining"]["sec"] >= 0


def test_a_canceled_goal_says_so(floor):
    floor.send("one", pose(0.25, 0.1))
    floor.go(until="action_feedback")
    assert floor.client.ask("cancel_action_goal", id="one", action=NAME) == []
    result = floor.go()[-1]
    assert (result["status"], result["result"]) == (5, True)
    assert "nothing" not in floor.client.refused("cancel_action_goal", id="one", action=NAME)


def test_a_second_goal_takes_the_place_of_the_first(floor):
    floor.send("one", pose(0.25, 0.1))
    floor.go(until="action_feedback")
    floor.send("two", pose(-0.2, 0.1))
    first = result_in(floor.go())
    assert (first["id"], first["status"]) == ("one", 6)
    assert first["values"]["error_msg"] == "another goal took its place"
    second = result_in(floor.go())
    assert (second["id"], second["status"]) == ("two", 4)


def test_several_poses_are_passed(floor):
    floor.send("two", pose(0.15, 0.0), pose(0.15, 0.15), action="/navigate_through_poses")
    told = floor.go()
    remaining = {each["values"]["number_of_poses_remaining"] for each in told[:-1]}
    assert remaining == {2, 1}
    assert told[-1]["status"] == 4


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ({"pose": pose(0.5, 0.0)}, "on a wall"),
        ({"pose": pose(9.0, 0.0)}, "beyond the field"),
        ({"pose": pose(0.1, 0.0, frame="odom")}, "its frame is 'odom'; valid is 'map'"),
        ({"pose": pose(None, 0.0)}, "not finite"),
        ({"pose": pose(0.1, 0.0, turn={"x": 1.0, "w": 1.0})}, "leans"),
        ({"poze": 1}, "valid is an object"),
        (None, "valid is an object"),
    ],
)
def test_what_is_no_goal_is_rejected_and_the_robot_stands(floor, args, words):
    (result,) = floor.client.ask("send_action_goal", id="no", action=NAME, args=args)
    assert (result["op"], result["id"], result["result"]) == ("action_result", "no", False)
    assert result["status"] == 6
    assert words in result["values"]
    run(floor.program, 0.1)
    assert floor.program.engine.latest.get().mode == "idle"


@pytest.mark.parametrize("what", ["paused", "drawn"])
def test_while_nothing_tells_the_place_a_goal_is_rejected(floor, what):
    if what == "paused":
        floor.program.engine.commands.put(PauseCommand(type="pause"))
    else:
        grid = floor.program.field.occupancy(0.05)
        floor.program.engine.drawn.put(DrawnMap(1.0, grid, Pose2()))
    run(floor.program, 0.1)
    words = {"paused": "the filter is paused", "drawn": "a map is drawn"}[what]
    (result,) = floor.client.ask(
        "send_action_goal", id="no", action=NAME, args={"pose": pose(0.1, 0.0)}
    )
    assert (result["result"], result["status"]) == (False, 6)
    assert words in result["values"]
    told = floor.client.refused("publish", topic="/goal_pose", msg=pose(0.1, 0.0))
    assert words in told
    assert floor.program.engine.latest.get().mode == "idle"


def test_an_unknown_action_is_refused_with_those_that_there_are(floor):
    said = floor.client.refused("send_action_goal", id="x", action="/fly", args={})
    assert said.startswith("/fly is no action; valid are /navigate_to_pose")
    servers = floor.client.call("/rosapi/action_servers")[1]["action_servers"]
    assert servers == ["/navigate_to_pose", "/navigate_through_poses", "/follow_waypoints"]


def test_goal_pose_is_taken_as_a_topic(floor):
    assert floor.client.ask("publish", topic="/goal_pose", msg=pose(0.1, 0.1)) == []
    run(floor.program, 0.1)
    assert floor.program.engine.latest.get().mode == "navigate"
    assert "on a wall" in floor.client.refused("publish", topic="/goal_pose", msg=pose(0.5, 0))


def path_of(answer: dict) -> list[tuple[float, float]]:
    places = [each["pose"]["position"] for each in answer["plan"]["poses"]]
    return [(each["x"], each["y"]) for each in places]


def test_a_plan_is_told_and_nobody_drives(floor):
    goal = {"goal": pose(0.25, 0.1)}
    well, answer = floor.client.call("/compute_path_to_pose", goal)
    assert well
    path = path_of(answer)
    assert path[0] == pytest.approx((0, 0), abs=0.005)
    assert path[-1] == pytest.approx((0.25, 0.1), abs=1e-6)
    assert answer["plan"]["header"]["frame_id"] == "map"
    run(floor.program, 0.1)
    assert floor.program.engine.latest.get().mode == "idle"
    start = {**goal, "start": pose(-0.2, -0.2)}
    assert path_of(floor.client.call("/compute_path_to_pose", start)[1])[0] == (-0.2, -0.2)


@pytest.mark.parametrize(
    ("request_", "words"),
    [
        ({"goal": pose(0.5, 0.0)}, "on a wall"),
        ({"goal": pose(9.0, 0.0)}, "beyond the field"),
        ({"goal": pose(0.1, 0.0, frame="odom")}, "its frame is 'odom'; valid is 'map'"),
        ({"goal": pose(None, 0.0)}, "not finite"),
        ({"goal": pose(0.1, 0.0), "start": pose(9.0, 0.0)}, "the start"),
        ({"goal": pose(0.1, 0.0, turn={"x": 1.0, "w": 1.0})}, "leans"),
    ],
)
def test_what_has_no_plan_is_told(floor, request_, words):
    well, answer = floor.client.call("/compute_path_to_pose", request_)
    assert not well
    assert words in answer


def test_the_topic_plan_has_the_way(floor):
    plan = topic("plan")
    assert plan.stamp(floor.program.engine.latest.get()) is None
    floor.client.ask("publish", topic="/goal_pose", msg=pose(0.25, 0.1))
    floor.go(1.0)
    shown = floor.program.engine.latest.get()
    assert plan.stamp(shown) == shown.added["navigation"].planned
    message = plan.make(floor.bridge.inbox.source, shown)
    assert len(to_cdr(message, plan.type)) > 1000
    last = message.poses[-1].pose
    assert (last.position.x, last.position.y) == pytest.approx((0.25, 0.1), abs=0.002)
    # Each pose looks along the way.
    assert heading_of(last.orientation) == pytest.approx(math.atan2(0.1, 0.25), abs=0.05)


def test_a_client_that_leaves_stops_its_journey(floor):
    floor.send("one", pose(0.25, 0.1))
    floor.go(until="action_feedback")
    floor.client.session.close()
    run(floor.program, 0.06)
    assert floor.program.engine.latest.get().mode == "idle"
