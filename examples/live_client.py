"""Drive a running ``brickpose run`` over its websocket, and print what it believes.

python live_client.py ws://127.0.0.1:8080/api/live
"""

import json
import sys

from websockets.sync.client import connect

with connect(sys.argv[1] if len(sys.argv) > 1 else "ws://127.0.0.1:8080/api/live") as live:
    start = None
    for text in live:
        message = json.loads(text)
        if message["type"] == "error":
            print(message["message"])
        if message["type"] != "telemetry":
            continue
        start = start or message["stamp"]
        if message["stamp"] > start + 3:
            break
        live.send(json.dumps({"type": "drive", "v": 0.1, "omega": 0.4}))
    print(message["integrity"]["state"], message["estimate"])
