"""roslibpy at work; a program of its own, as its reactor runs once. Each line is JSON."""

import json
import queue
import sys

import roslibpy

ANSWER_S = 30


def tell(**message):
    print(json.dumps(message), flush=True)


def messages(ros, name, kind, count, **options):
    """The first messages of a topic."""
    got: queue.SimpleQueue = queue.SimpleQueue()
    topic = roslibpy.Topic(ros, name, kind, **options)
    topic.subscribe(got.put)
    found = [got.get(timeout=ANSWER_S) for _ in range(count)]
    topic.unsubscribe()
    return found


def call(ros, name, kind, request=None):
    service = roslibpy.Service(ros, name, kind)
    try:
        return dict(service.call(roslibpy.ServiceRequest(request), timeout=ANSWER_S))
    except Exception as error:
        return str(error)


def drive(ros):
    """Drive until it moves; then be silent until it stands."""
    got: queue.SimpleQueue = queue.SimpleQueue()
    odom = roslibpy.Topic(ros, "/odom", "nav_msgs/Odometry", queue_length=100)
    odom.subscribe(got.put)
    wheels = roslibpy.Topic(ros, "/cmd_vel", "geometry_msgs/TwistStamped")
    speed = 0.0
    while speed < 0.05:
        wheels.publish(roslibpy.Message({"twist": {"linear": {"x": 0.1}, "angular": {"z": 0.5}}}))
        speed = got.get(timeout=ANSWER_S)["twist"]["twist"]["linear"]["x"]
    tell(moves=speed)
    while got.get(timeout=ANSWER_S)["twist"]["twist"]["linear"]["x"] > 0:
        pass
    tell(stands=True)


def main(url):
    ros = roslibpy.Ros(url)
    ros.run()
    topics = ros.get_topics()
    tell(topics=topics, kind=ros.get_topic_type("/scan"), services=ros.get_services())
    tell(time=dict(ros.get_time()))
    (scan,) = messages(ros, "/scan", "sensor_msgs/LaserScan", 1)
    tell(ranges=len(scan["ranges"]), frame=scan["header"]["frame_id"])
    (grid,) = messages(ros, "/map", "nav_msgs/OccupancyGrid", 1)
    tell(cells=len(grid["data"]), info=grid["info"])
    slow = messages(ros, "/odom", "nav_msgs/Odometry", 4, throttle_rate=300, queue_length=10)
    stamps = [one["header"]["stamp"] for one in slow]
    tell(throttled=[one["sec"] + one["nanosec"] / 1e9 for one in stamps])
    tell(update=call(ros, "/request_nomotion_update", "std_srvs/Empty"))
    tell(wrong=call(ros, "/set_initial_pose", "nav2_msgs/SetInitialPose", {"poze": 1}))
    wheels = roslibpy.Topic(ros, "/cmd_vel", "geometry_msgs/TwistStamped")
    wheels.publish(roslibpy.Message({"twist": {"linear": {"y": 1.0}}}))
    tell(after_refusal=call(ros, "/request_nomotion_update", "std_srvs/Empty"))
    drive(ros)
    ros.terminate()


main(*sys.argv[1:])
