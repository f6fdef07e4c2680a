"""Send the robot of a running ``brickpose run`` to a place on the map, and wait until it is there.

python go_to.py 0.2 0.1 90 ws://127.0.0.1:8080/api/live
"""

import json
import math
import sys

from websockets.sync.client import connect

x, y, degrees = map(float, sys.argv[1:4])
with connect(sys.argv[4] if len(sys.argv) > 4 else "ws://127.0.0.1:8080/api/live") as live:
    goal = {"x": x, "y": y, "theta": math.radians(degrees)}
    live.send(json.dumps({"type": "navigate", "poses": [goal]}))
    state, sent = "planning", False
    for text in live:
        message = json.loads(text)
        if message["type"] == "error":
            sys.exit(message["message"])
        sent = sent or message["type"] == "ack"
        journey = message.get("navigation")
        if not sent or journey is None or journey["state"] == state:
            continue
        state = journey["state"]
        print(state, journey["reason"] or f"{journey['remaining_m']:.2f} m left")
        if state in ("arrived", "canceled", "failed"):
            break
