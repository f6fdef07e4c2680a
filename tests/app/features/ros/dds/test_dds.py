"""The topics over DDS, told to and by a participant of another vendor's."""

import math
from itertools import count

import cv2
import numpy as np
import pytest
from dds_rig import BATTERY_V, PLAIN, STAMPED, decoded, rig_and_peer, stamped, twist
from journeys import KNOWN, RENEW
from mcap_ros2._dynamic import generate_dynamic
from ros_messages import topic

from app.engine.problems import CLIENTS_LOG
from app.features.navigation.messages import NavigateCommand
from app.features.ros.dds import route
from app.features.ros.encoding import motion, sensors
from app.features.ros.encoding.frames import header, pose, pose_with_covariance
from app.features.ros.encoding.navigation import CANCELED, EXECUTING, SUCCEEDED
from app.features.ros.message_types import new, to_cdr, type_hash
from app.features.ros.topics import TOPICS, topics
from app.messages.commands import SetPoseCommand
from app.messages.driving_commands import DriveCommand, StopCommand
from app.page.log_limit import MOST_LINES, limit_logs
from benchmarks.topics.fastdds import Peer, missing
from robot.geometry import Pose2
from robot.scan import evenly
from sim.simulated import PERIOD

pytestmark = pytest.mark.skipif(missing() is not None, reason=str(missing()))

LIVE = [one for one in TOPICS if one.live]
SENSOR_DATA = ("scan", "particle_cloud", "camera/image/compressed", "camera/camera_info")
"""Read with best effort, as RViz and nav2 read them."""
STATUS, FEEDBACK = "navigate_to_pose/_action/status", "navigate_to_pose/_action/feedback"
OF_A_GOAL = ("plan", STATUS, FEEDBACK)
"""Nothing comes of these while nobody sends the robot anywhere."""

GRAPH = "rmw_dds_common/msg/ParticipantEntitiesInfo"
GRAPH_DEFINITION = """Gid gid
NodeEntitiesInfo[] node_entities_info_seq
================================================================================
MSG: rmw_dds_common/Gid
uint8[16] data
================================================================================
MSG: rmw_dds_common/NodeEntitiesInfo
string<=256 node_namespace
string<=256 node_name
Gid[] reader_gid_seq
Gid[] writer_gid_seq
"""
FAR = "brickpose_test/msg/Feedback"
FAR_DEFINITION = """uint8[16] goal_id
geometry_msgs/PoseStamped current_pose
builtin_interfaces/Duration navigation_time
builtin_interfaces/Duration estimated_time_remaining
int16 number_of_recoveries
float32 distance_remaining
================================================================================
MSG: geometry_msgs/PoseStamped
std_msgs/Header header
geometry_msgs/Pose pose
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: geometry_msgs/Pose
geometry_msgs/Point position
geometry_msgs/Quaternion orientation
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
"""
"""nav2's feedback with its goal's number, as its IDL has it; the decoder refuses its name."""


@pytest.fixture(scope="module")
def both():
    """A robot and a peer that came late and reads everything."""
    with rig_and_peer(Peer) as (rig, peer):
        peer.read("ros_discovery_info", GRAPH, latched=True)
        for one in LIVE:
            quality = one.quality
            reliable = one.name not in SENSOR_DATA
            peer.read(f"rt/{one.name}", one.type, reliable=reliable, latched=quality.latched)
        peer.write("rt/cmd_vel", STAMPED)
        peer.write("rt/initialpose", "geometry_msgs/msg/PoseWithCovarianceStamped")
        peer.write("rt/goal_pose", "geometry_msgs/msg/PoseStamped")
        for name in ("rt/cmd_vel", "rt/initialpose", "rt/goal_pose"):
            peer.wait("matched", name)
        yield rig, peer


@pytest.fixture
def rig(both):
    return both[0]


@pytest.fixture
def peer(both):
    return both[1]


def tick(rig, header, stamp_of=lambda snapshot: snapshot.stamp):
    """The tick whose content has the stamp of a message; the message may be here before it."""
    wanted = header.stamp.sec * 10**9 + header.stamp.nanosec

    def has_it(snapshot):
        at = stamp_of(snapshot)
        return at is not None and rig.source.clock.ns(at) == wanted

    return rig.having(has_it)


def arrived(peer, name, **after):
    return decoded(peer.data(f"rt/{name}", **after), topic(name).type)


def xy(pose):
    return [pose.position.x, pose.position.y]


@pytest.mark.slow
@pytest.mark.parametrize("name", [one.name for one in LIVE if one.name not in OF_A_GOAL])
def test_every_topic_arrives_with_the_type_that_it_is_announced_with(rig, peer, name):
    arrived(peer, name)
    written = peer.wait("writer", f"rt/{name}")
    assert bytes.fromhex(written[4]) == f"typehash={type_hash(topic(name).type)};".encode()


def test_a_scan_has_the_ranges_of_its_picture(rig, peer):
    message = arrived(peer, "scan")
    seen = tick(rig, message.header, sensors.scan_stamp).filter.line_scan.scan
    assert np.array_equal(message.ranges, seen.ranges.astype(np.float32))
    assert message.angle_min == pytest.approx(seen.bearings[0])
    assert message.header.frame_id == "base_scan"


def test_odometry_truth_and_estimate_are_those_of_their_ticks(rig, peer):
    odom = arrived(peer, "odom")
    at = tick(rig, odom.header).odom_from_robot
    assert xy(odom.pose.pose) == [at.x, at.y]
    truth = arrived(peer, "truth")
    at = tick(rig, truth.header).truth
    assert xy(truth.pose) == [at.x, at.y]
    pose = arrived(peer, "amcl_pose")
    estimate = tick(rig, pose.header, motion.estimate_stamp).estimate
    assert xy(pose.pose.pose) == [estimate.pose.x, estimate.pose.y]
    assert pose.pose.covariance[0] == estimate.covariance[0, 0]


def test_transforms_lead_from_the_map_to_the_camera(rig, peer):
    moving, fixed = arrived(peer, "tf").transforms, arrived(peer, "tf_static").transforms
    at = tick(rig, moving[0].header).odom_from_robot
    where = {one.child_frame_id: one.transform.translation for one in moving}
    assert [where["base_footprint"].x, where["base_footprint"].y] == [at.x, at.y]
    parents = {one.child_frame_id: one.header.frame_id for one in (*moving, *fixed)}
    frame, way = arrived(peer, "camera/camera_info").header.frame_id, []
    while frame in parents:
        frame = parents[frame]
        way.append(frame)
    assert way[-3:] == ["base_footprint", "odom", "map"]


def test_clouds_have_the_filters_poses_and_weights(rig, peer):
    cloud = arrived(peer, "particle_cloud")
    held = tick(rig, cloud.header).filter.cloud
    chosen = evenly(len(held.weights), 500)
    assert [xy(one.pose) for one in cloud.particles] == held.poses[chosen, :2].tolist()
    weights = held.weights[chosen] / held.weights[chosen].sum()
    assert [one.weight for one in cloud.particles] == pytest.approx(weights)
    poses = arrived(peer, "particlecloud")
    held = tick(rig, poses.header).filter.cloud
    assert [xy(one) for one in poses.poses] == held.poses[chosen, :2].tolist()


def test_the_map_has_the_fields_tape(rig, peer):
    message = arrived(peer, "map")
    grid = rig.program.field.occupancy(rig.source.settings.map_resolution)
    assert (message.info.height, message.info.width) == grid.data.shape
    assert np.array_equal(np.array(message.data), grid.data.ravel())
    assert xy(message.info.origin) == [grid.origin.x, grid.origin.y]


def test_joints_battery_and_description_are_the_robots(rig, peer):
    joints = arrived(peer, "joint_states")
    assert list(joints.position) == tick(rig, joints.header).reading.positions.tolist()
    assert joints.name == [one.name for one in rig.program.robot.spec.joints]
    assert arrived(peer, "battery_state").voltage == pytest.approx(BATTERY_V)
    assert arrived(peer, "robot_description").data == rig.program.robot.spec.urdf
    assert [one.name for one in arrived(peer, "diagnostics").status] == [
        "brickpose: program",
        "brickpose: robot",
        "brickpose: localization",
    ]


def test_a_picture_is_what_the_camera_saw_and_has_its_lens(rig, peer):
    picture = arrived(peer, "camera/image/compressed")
    image = cv2.imdecode(np.frombuffer(picture.data, np.uint8), cv2.IMREAD_UNCHANGED)
    seen = tick(rig, picture.header, sensors.picture_stamp).reading.frame.image
    assert np.abs(image.astype(float) - seen).mean() < 3
    lens = rig.program.robot.spec.lens
    info = arrived(peer, "camera/camera_info")
    assert (info.width, info.height, list(info.k)) == (
        lens.width,
        lens.height,
        lens.matrix.ravel().tolist(),
    )


def test_who_comes_late_gets_what_is_latched_and_the_same_of_it(rig, peer):
    arrived(peer, "map")
    with Peer(rig.domain) as late:
        for name in ("map", "tf_static", "robot_description", "amcl_pose"):
            late.read(f"rt/{name}", topic(name).type, latched=True)
        for name in ("map", "tf_static", "robot_description"):
            assert late.data(f"rt/{name}") == peer.data(f"rt/{name}")
        arrived(late, "amcl_pose")


def test_what_is_read_with_best_effort_can_be_read_reliably(rig, peer):
    with Peer(rig.domain) as other:
        for name in SENSOR_DATA:
            other.read(f"rt/{name}", topic(name).type, reliable=True)
        for name in SENSOR_DATA:
            arrived(other, name)


def test_the_graph_has_one_node_with_these_readers_and_writers(rig, peer):
    told = generate_dynamic(GRAPH, GRAPH_DEFINITION)[GRAPH](peer.data("ros_discovery_info"))
    found = peer.wait("participant", bytes(told.gid.data).hex())
    assert bytes.fromhex(found[2]) == b"enclave=/;"
    (node,) = told.node_entities_info_seq
    assert (node.node_namespace, node.node_name) == ("/", "brickpose")
    seen = {"writer": set(), "reader": set()}
    for event in peer.events:
        if event[0] in seen and event[1].startswith("rt/") and event[3].startswith(found[1][:24]):
            seen[event[0]].add((event[1], event[3]))
    assert {topic for topic, _ in seen["writer"]} == {
        f"rt/{one.name}" for one in topics() if one.live
    }
    assert {topic for topic, _ in seen["reader"]} == {
        "rt/cmd_vel",
        "rt/goal_pose",
        "rt/initialpose",
    }
    for kind, gids in (("writer", node.writer_gid_seq), ("reader", node.reader_gid_seq)):
        assert {bytes(one.data).hex() for one in gids} == {gid for _, gid in seen[kind]}


def drives(snapshot):
    return snapshot.twist.v > 0


def stands(snapshot):
    return snapshot.twist.v == 0


def test_a_foreign_drive_moves_the_robot_and_silence_stops_it(rig, peer):
    begun = rig.until(drives, lambda: peer.send("rt/cmd_vel", stamped(rig.source, 0.1)))
    rig.until(lambda now: now.truth.x != begun.truth.x)
    last = rig.until(
        lambda now: any(isinstance(one, DriveCommand) for one in now.commands),
        lambda: peer.send("rt/cmd_vel", stamped(rig.source, 0.1)),
    )
    ended = rig.until(stands)
    assert ended.stamp - last.stamp < 1.0


@pytest.mark.parametrize(
    "wrong, words",
    [
        (lambda source: stamped(source, math.nan), "linear.x is nan"),
        (lambda source: stamped(source, 0.1, age=5.0), "s old"),
        (lambda source: stamped(source, 0.1, age=-5.0), "s ahead"),
    ],
    ids=["not a number", "old", "from the future"],
)
def test_a_wrong_drive_stops_the_robot_and_is_told(rig, peer, wrong, words):
    rig.until(drives, lambda: peer.send("rt/cmd_vel", stamped(rig.source, 0.1)))
    peer.send("rt/cmd_vel", wrong(rig.source))
    stopped = rig.until(lambda now: any(isinstance(one, StopCommand) for one in now.commands))
    assert stopped.twist.v == 0
    assert words in rig.route.refused


def test_damaged_bytes_move_nothing_and_are_survived(rig, peer):
    good = stamped(rig.source, 0.1)
    for wrong in (good[:30], good[:4] + b"\xff" * 40, good[:4]):
        peer.send("rt/cmd_vel", wrong)
    rig.until(drives, lambda: peer.send("rt/cmd_vel", stamped(rig.source, 0.1)))
    assert rig.route.failure is None


def test_a_peer_that_talks_nonsense_fills_no_log(rig, peer, caplog):
    limit_logs(CLIENTS_LOG.name)  # as the program does
    for _ in range(300):
        peer.send("rt/cmd_vel", stamped(rig.source, 0.1)[:20])
    rig.until(drives, lambda: peer.send("rt/cmd_vel", stamped(rig.source, 0.1)))
    written = [record for record in caplog.records if "DDS: " in record.getMessage()]
    assert 1 <= len(written) <= MOST_LINES


def test_a_problem_with_a_message_ends_when_it_is_over(rig, peer, monkeypatch):
    monkeypatch.setattr(route, "TROUBLE_S", 1.0)
    long = stamped(rig.source, 0.1) + bytes(60_000)
    rig.until(lambda now: rig.route.failure, lambda: peer.send("rt/cmd_vel", long))
    assert "bytes came; valid are up to" in rig.route.failure
    rig.until(lambda now: rig.route.failure is None)


def taken(rig, kind, send):
    """The command of a message that is sent anew each second until the robot takes it.

    A program that has found the robot may be found by it a second later, and no word before that
    arrives.
    """
    ticks, found = count(), []

    def has_it(now):
        found.extend(one for one in now.commands if isinstance(one, kind))
        return found

    rig.until(has_it, lambda: next(ticks) % round(1 / PERIOD) or send())
    return found[0]


def send_goal(rig, peer, place):
    """The command of a goal that a foreign program sends."""
    message = new(
        "geometry_msgs/msg/PoseStamped", header=header(rig.source, 0.0, "map"), pose=pose(place)
    )
    data = to_cdr(message, "geometry_msgs/msg/PoseStamped")
    return taken(rig, NavigateCommand, lambda: peer.send("rt/goal_pose", data))


def test_a_told_pose_is_where_the_filter_then_looks(rig, peer):
    wanted = Pose2(0.3, 0.2, 0.5)
    message = new(
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        header=header(rig.source, 0.0, "map"),
        pose=pose_with_covariance(wanted, np.diag([1e-4, 1e-4, 1e-4])),
    )
    data = to_cdr(message, "geometry_msgs/msg/PoseWithCovarianceStamped")
    command = taken(rig, SetPoseCommand, lambda: peer.send("rt/initialpose", data))
    assert (command.x, command.y, command.theta) == pytest.approx((0.3, 0.2, 0.5))


def test_a_goal_of_a_foreign_program_sends_the_robot_there(rig, peer):
    (goal,) = send_goal(rig, peer, Pose2(0.1, 0.05, 0.5)).poses
    assert (goal.x, goal.y, goal.theta) == pytest.approx((0.1, 0.05, 0.5))
    rig.until(lambda now: now.added["navigation"].path is not None)
    last = arrived(peer, "plan").poses[-1].pose.position
    assert (last.x, last.y) == pytest.approx((0.1, 0.05), abs=0.002)


def number_of_goal(peer, code, after=0):
    """The number of the newest goal, as soon as it has a status."""

    def told(event):
        (status,) = decoded(bytes.fromhex(event[3]), topic(STATUS).type).status_list
        return status

    event = peer.wait("data", f"rt/{STATUS}", lambda event: told(event).status == code, after)
    return bytes(told(event).goal_info.goal_id.uuid)


def test_a_foreign_program_hears_how_far_its_goal_is_and_that_it_was_reached():
    with rig_and_peer(Peer) as (rig, peer):
        peer.read(f"rt/{STATUS}", topic(STATUS).type, latched=True)
        peer.read(f"rt/{FEEDBACK}", topic(FEEDBACK).type)
        peer.write("rt/goal_pose", "geometry_msgs/msg/PoseStamped")
        peer.wait("matched", "rt/goal_pose")
        rig.program.engine.commands.put(KNOWN)
        send_goal(rig, peer, Pose2(0.1, 0.05, 0.5))
        # In a whole program, the server renews it.
        rig.until(
            lambda now: getattr(now.added.get("navigation"), "state", "") == "arrived",
            lambda: rig.program.engine.commands.put(RENEW),
        )
        number = number_of_goal(peer, EXECUTING)
        far = generate_dynamic(FAR, FAR_DEFINITION)[FAR](peer.data(f"rt/{FEEDBACK}"))
        assert bytes(far.goal_id) == number
        assert far.number_of_recoveries == 0
        at = tick(rig, far.current_pose.header)
        assert xy(far.current_pose.pose) == [at.pose.x, at.pose.y]
        status = at.added["navigation"]
        assert far.distance_remaining == pytest.approx(status.remaining_m)
        left = far.estimated_time_remaining
        assert left.sec + left.nanosec / 1e9 == pytest.approx(status.remaining_s)
        assert number_of_goal(peer, SUCCEEDED) == number
        # Who comes late hears it, too.
        with Peer(rig.domain) as late:
            late.read(f"rt/{STATUS}", topic(STATUS).type, latched=True)
            assert number_of_goal(late, SUCCEEDED) == number


def test_a_foreign_program_ends_its_goal_by_a_drive_and_hears_that_it_was_canceled(rig, peer):
    before = len(peer.events)
    send_goal(rig, peer, Pose2(0.1, 0.05, 0.5))
    number = number_of_goal(peer, EXECUTING, before)
    peer.send("rt/cmd_vel", stamped(rig.source, 0.0))
    assert number_of_goal(peer, CANCELED, before) == number


def test_names_and_the_type_of_drives_are_a_matter_of_settings():
    with rig_and_peer(Peer, namespace="robot1", stamped_cmd_vel=False) as (rig, peer):
        peer.read("rt/robot1/scan", topic("scan").type, reliable=False)
        peer.read("ros_discovery_info", GRAPH, latched=True)
        peer.write("rt/robot1/cmd_vel", PLAIN)
        peer.wait("matched", "rt/robot1/cmd_vel")
        peer.data("rt/robot1/scan")
        rig.until(drives, lambda: peer.send("rt/robot1/cmd_vel", to_cdr(twist(0.1), PLAIN)))
        told = generate_dynamic(GRAPH, GRAPH_DEFINITION)[GRAPH](peer.data("ros_discovery_info"))
        assert told.node_entities_info_seq[0].node_namespace == "/robot1"
