"""roslibpy sends goals: reached, canceled, replaced, refused; a program of its own, as its reactor
runs once. Each line is JSON."""

import json
import queue
import sys

import roslibpy

ANSWER_S = 40


class Sent:
    """A goal, with what came of it."""

    def __init__(self, client, x, y):
        self.client = client
        self.feedback: queue.SimpleQueue = queue.SimpleQueue()
        self.ended: queue.SimpleQueue = queue.SimpleQueue()
        pose = {"position": {"x": x, "y": y}, "orientation": {"w": 1.0}}
        goal = roslibpy.Goal({"pose": {"header": {"frame_id": "map"}, "pose": pose}})
        self.id = client.send_goal(goal, self._result, self.feedback.put, self._refused)

    def _result(self, result):
        self.ended.put((True, result))

    def _refused(self, result):
        self.ended.put((False, result))

    def cancel(self):
        self.feedback.get(timeout=ANSWER_S)
        self.client.cancel_goal(self.id)

    def tell(self, name):
        well, result = self.ended.get(timeout=ANSWER_S)
        told = {"result": well, "status": int(result["status"].value), "values": result["values"]}
        print(json.dumps({name: told | {"feedback": self.feedback.qsize()}}), flush=True)


def main(url):
    ros = roslibpy.Ros(url)
    ros.run()
    client = roslibpy.ActionClient(ros, "/navigate_to_pose", "nav2_msgs/action/NavigateToPose")
    Sent(client, 0.12, 0.0).tell("reached")
    goal = Sent(client, -0.3, 0.25)
    goal.cancel()
    goal.tell("canceled")
    first = Sent(client, -0.3, 0.25)
    first.feedback.get(timeout=ANSWER_S)
    second = Sent(client, 0.3, 0.25)
    first.tell("replaced")
    second.cancel()
    second.tell("second")
    Sent(client, 0.5, 0.0).tell("refused")
    ros.terminate()


main(*sys.argv[1:])
