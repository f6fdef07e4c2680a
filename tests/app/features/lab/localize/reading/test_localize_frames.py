"""Robots whose topics and frames have other names: by option, or what is there is listed."""

import pytest

from app.features.lab.localize.reading.bag import Bag
from app.features.lab.localize.reading.layout import BagNames, choose, find_layout
from app.features.lab.localize.reading.pairing import Pairing
from app.features.lab.localize.reading.sources import BagError
from benchmarks.lasers.laser_bags import LaserBag
from robot.geometry import Pose2
from robot.settings import SettingError

COUNT = 20
PLACE = Pose2(0.1, 0.0, 0.0)


def read(path, *names, laser_pose=None):
    with Bag(path) as bag:
        known = BagNames.of(*names) if names else BagNames()
        chosen = choose(bag, names=known)
        layout = find_layout(bag, chosen, laser_pose, known)
        return layout, list(Pairing(bag, chosen, layout).measurements())


def drive(bag, odom, base, laser, topic="/scan", tf="/tf", speed=0.5):
    for tick in range(COUNT):
        stamp = 1000 + 0.1 * tick
        bag.transform(stamp, odom, base, Pose2(speed * 0.1 * tick), topic=tf)
        bag.scan(stamp, [1.0, 1.0], first=0.0, step=0.1, frame=laser, topic=topic)


def test_a_namespace_that_the_lasers_driver_leaves_out_is_found(tmp_path):
    with LaserBag(tmp_path / "bag", "mcap") as bag:
        bag.transform(1000, "robot1/base_link", "robot1/laser", PLACE, topic="/tf_static")
        drive(bag, "robot1/odom", "robot1/base_link", "laser")
    layout, found = read(tmp_path / "bag")
    assert (layout.base_frame, layout.odom_frame) == ("robot1/base_link", "robot1/odom")
    assert "robot1/base_link to robot1/laser, taken for laser" in layout.pose_from
    assert len(found) == COUNT


def test_a_laser_without_transforms_is_placed_by_hand(tmp_path):
    with LaserBag(tmp_path / "bag", "mcap") as bag:
        drive(bag, "robot1/odom", "robot1/base_link", "laser")
    layout, found = read(tmp_path / "bag", laser_pose=PLACE)
    assert layout.base_frame == "robot1/base_link"
    assert found[-1].scan.robot_from_scan.x == pytest.approx(0.1)
    with pytest.raises(BagError, match=r"--laser-pose says where .*robot1/odom - robot1/base_link"):
        read(tmp_path / "bag")


@pytest.mark.parametrize("robot", ["robot1", "/robot2/"])
@pytest.mark.parametrize("own_topics", [True, False])
def test_of_two_robots_one_is_chosen_by_its_namespace(tmp_path, robot, own_topics):
    with LaserBag(tmp_path / "bag", "mcap") as bag:
        for name, speed in (("robot1", 0.5), ("robot2", 1.0)):
            tf = f"/{name}/tf" if own_topics else "/tf"
            bag.transform(1000, f"{name}/base", f"{name}/laser", PLACE, topic=f"{tf}_static")
            drive(bag, f"{name}/odom", f"{name}/base", "laser", f"/{name}/scan", tf, speed)
    with pytest.raises(SettingError, match=r"/robot1/scan, /robot2/scan; or by --namespace"):
        read(tmp_path / "bag")
    layout, found = read(tmp_path / "bag", None, None, robot)
    assert layout.odom_frame == f"{robot.strip('/')}/odom"
    speed = 0.5 if robot == "robot1" else 1.0
    assert found[-1].odom_from_robot.x == pytest.approx(speed * 0.1 * (COUNT - 1))


def test_frames_with_other_names_are_chosen_by_option(tmp_path):
    with LaserBag(tmp_path / "bag", "mcap") as bag:
        bag.transform(1000, "chassis", "laser", PLACE, topic="/tf_static")
        drive(bag, "wheels", "chassis", "laser")
    with pytest.raises(BagError, match=r"chassis - laser, wheels - chassis; --odom-frame"):
        read(tmp_path / "bag")
    layout, found = read(tmp_path / "bag", "/wheels", None, None)
    assert (layout.base_frame, len(found)) == ("chassis", COUNT)
    layout, found = read(tmp_path / "bag", "wheels", "chassis", None)
    assert len(found) == COUNT


def test_a_frame_of_gazebo_is_that_of_its_link(tmp_path):
    with LaserBag(tmp_path / "bag", "mcap") as bag:
        bag.transform(1000, "base_link", "rplidar_link", PLACE, topic="/tf_static")
        for tick in range(COUNT):
            bag.odometry(1000 + 0.1 * tick, Pose2(0.1 * tick))
            frame = "turtlebot4/rplidar_link/rplidar"
            bag.scan(1000 + 0.1 * tick, [1.0, 1.0], first=0.0, step=0.1, frame=frame)
    layout, _ = read(tmp_path / "bag")
    assert not layout.assumed
    assert layout.pose_from.endswith(
        "base_link to rplidar_link, taken for turtlebot4/rplidar_link/rplidar"
    )
