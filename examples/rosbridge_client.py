"""Drive a running ``brickpose run`` as a robot of ROS, without ROS, over rosbridge.

python rosbridge_client.py ws://127.0.0.1:8080/rosbridge
"""

import json
import sys
import time

from websockets.sync.client import connect

POSE = {"topic": "/amcl_pose", "type": "geometry_msgs/msg/PoseWithCovarianceStamped"}
WHEELS = {"topic": "/cmd_vel", "type": "geometry_msgs/msg/TwistStamped"}

with connect(sys.argv[1] if len(sys.argv) > 1 else "ws://127.0.0.1:8080/rosbridge") as bridge:
    bridge.send(json.dumps({"op": "subscribe", **POSE}))
    bridge.send(json.dumps({"op": "advertise", **WHEELS}))
    for _ in range(20):
        twist = {"linear": {"x": 0.1}, "angular": {"z": 0.4}}
        bridge.send(json.dumps({"op": "publish", "topic": "/cmd_vel", "msg": {"twist": twist}}))
        time.sleep(0.1)  # a command holds for 0.3 s, then the robot stops
    message = json.loads(bridge.recv())
    print(message["topic"], message["msg"]["pose"]["pose"]["position"])
