"""A ROS 1 robot for the tests, as a process of the machine's own Python: JSON lines in and out.

Started as a script with a name for its node. It publishes what it is told and reports what it
hears, each with its own monotonic time (the same clock as the test's, on one machine).
"""

from __future__ import annotations

import json
import sys
import threading
import time

import actionlib
import rospy
from actionlib.msg import TestAction, TestFeedback, TestResult
from genpy.dynamic import generate_dynamic
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock, Log
from sensor_msgs.msg import CompressedImage, Image, LaserScan
from std_msgs.msg import Bool, Float64, String
from std_srvs.srv import SetBool, SetBoolResponse, Trigger, TriggerResponse

ODD = "Header header\nuint8[] flags\nfloat32[3] axes\nOther other\n"
ODD += "=" * 80 + "\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
ODD += "=" * 80 + "\nMSG: nowhere_msgs/Other\nstring word\n"


def say(**row: object) -> None:
    sys.stdout.write(json.dumps({"at": time.monotonic_ns(), **row}) + "\n")
    sys.stdout.flush()


class Peer:
    """The node and what it can be told."""

    def __init__(self) -> None:  # noqa: D107
        self.odd_kind = generate_dynamic("nowhere_msgs/Odd", ODD)["nowhere_msgs/Odd"]

        def make(topic: str, kind: type, **more: object) -> rospy.Publisher:
            return rospy.Publisher(topic, kind, queue_size=1000, **more)

        self.lines = make("/rosout", Log)
        self.clock = None
        self.number = make("/number", Float64)
        self.odom_ = make("/odom", Odometry)
        self.metric_ = make("/metric", String)
        self.mode_ = make("/mode", String, latch=True)
        self.scan_ = make("/scan", LaserScan)
        self.odd_ = make("/odd", self.odd_kind)
        # Of a type that no machine has, and nothing is ever said.
        self.kept = make("/kept", self.odd_kind, latch=True)
        self.image_ = make("/images", Image)
        self.jpeg_ = make("/images/compressed", CompressedImage)
        listen = rospy.Subscriber
        listen("/cmd_vel", Twist, lambda m: say(cmd=[m.linear.x, m.angular.z]))
        listen(
            "/cmd_vel_stamped",
            TwistStamped,
            lambda m: say(stamped=[m.twist.linear.x, m.header.stamp.to_sec()]),
        )
        listen("/control", String, lambda m: say(control=m.data))
        listen("/stop", Bool, lambda m: say(stop=m.data))
        listen("/horn", String, lambda m: say(horn=m.data))
        rospy.Service("/wander", SetBool, self.wander)
        rospy.Service("/fail", Trigger, self.fail)
        rospy.Service("/slow", Trigger, self.slow)
        self.server = actionlib.SimpleActionServer(
            "/count", TestAction, execute_cb=self.goal, auto_start=False
        )
        self.server.start()

    def wander(self, request: object) -> SetBoolResponse:
        say(wander=request.data)
        return SetBoolResponse(success=True, message="wandering")

    def fail(self, _request: object) -> TriggerResponse:
        return TriggerResponse(success=False, message="the wheel is off")

    def slow(self, _request: object) -> TriggerResponse:
        say(slow=True)
        # It has no answer for as long as it lives.
        rospy.spin()
        return TriggerResponse(success=True)

    def goal(self, goal: object) -> None:
        say(goal=goal.goal)
        for step in range(goal.goal):
            if self.server.is_preempt_requested():
                say(cancelled=goal.goal)
                self.server.set_preempted(TestResult(step), "stopped half way")
                return
            self.server.publish_feedback(TestFeedback(step))
            time.sleep(0.1)
        if goal.goal == 13:
            self.server.set_aborted(TestResult(0), "thirteen brings bad luck")
        else:
            self.server.set_succeeded(TestResult(goal.goal), "counted")

    # ── what the test may say ──

    def do_count(self, asked: dict) -> None:
        def run() -> None:
            for value in range(asked["from"], asked["to"]):
                self.number.publish(Float64(value))
                time.sleep(1.0 / asked["hz"])
            say(counted=asked["to"])

        threading.Thread(target=run, daemon=True).start()

    def do_log(self, asked: dict) -> None:
        """Write lines as rospy does, or, for a node that is named, as that one would."""
        for number in range(asked["count"]):
            text = asked["text"].format(number)
            if "node" in asked:
                self.lines.publish(Log(level=Log.ERROR, name=asked["node"], msg=text))
            else:
                {"info": rospy.loginfo, "error": rospy.logerr}[asked["level"]](text)

    def do_clock(self, asked: dict) -> None:
        """Say the time; who says it is a robot's simulator, and no other test's."""
        if self.clock is None:
            self.clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self.clock.publish(Clock(rospy.Time(asked["sec"])))

    def do_odom(self, asked: dict) -> None:
        message = Odometry()
        message.header.stamp = rospy.Time(asked.get("sec", 0))
        message.twist.twist.linear.x = asked["speed"]
        message.pose.pose.position.x = 1.5
        message.pose.pose.orientation.w = 1.0
        self.odom_.publish(message)

    def do_metric(self, asked: dict) -> None:
        self.metric_.publish(String(asked["text"]))

    def do_mode(self, asked: dict) -> None:
        self.mode_.publish(String(asked["text"]))

    def do_scan(self, asked: dict) -> None:
        self.scan_.publish(LaserScan(ranges=asked["ranges"]))

    def do_odd(self, asked: dict) -> None:
        message = self.odd_kind(flags=bytes(asked["flags"]), axes=[1.0, 2.0, 3.0])
        message.other.word = asked["word"]
        self.odd_.publish(message)

    def do_image(self, asked: dict) -> None:
        depth = 1 if asked["encoding"] == "mono8" else 3
        pixel = bytes([230, 20, 20][:depth])
        self.image_.publish(
            Image(
                width=64,
                height=48,
                step=64 * depth,
                encoding=asked["encoding"],
                data=pixel * (64 * 48),
            )
        )

    def do_jpeg(self, asked: dict) -> None:
        self.jpeg_.publish(CompressedImage(format="jpeg", data=bytes.fromhex(asked["hex"])))

    def do_listeners(self, asked: dict) -> None:
        """Say who listens to /number, or, where it is asked for, to each of all kinds."""
        kinds = [self.odom_, self.metric_, self.mode_, self.scan_, self.odd_]
        heard = [self.number, *(kinds if asked.get("to_all") else [])]
        say(listeners=min(each.get_num_connections() for each in heard))


def main() -> None:
    rospy.init_node(sys.argv[1], disable_signals=True)
    peer = Peer()
    say(ready=True)
    for line in sys.stdin:
        asked = json.loads(line)
        getattr(peer, "do_" + asked["do"])(asked)
    rospy.signal_shutdown("told so")


if __name__ == "__main__":
    main()
