"""Joins ROS 1 as a node and does as the gateway says until stdin ends.

Frames go over stdin and stdout; what rospy prints goes to stderr. When stdin ends, or says nothing
for long while a velocity stands, it publishes the zeros it was given.
"""

from __future__ import annotations

import os
import threading
import time
from typing import TYPE_CHECKING

import rospy

from .commands import CommandRunner
from .message_paths import message_class, service_class
from .pipe_frames import FrameWriter, read_frames
from .taps import TapRunner
from .topics import RawSubscription, ZeroEndedPublisher

if TYPE_CHECKING:
    from typing import Any

# A velocity stands no longer than this without a new one (s).
SILENCE_S = 0.5
_WATCH_EVERY_S = 0.05
# While it works through what it was told, it says so at most so often (s).
WORKING_EVERY_S = 0.25
PARAMETERS_EVERY_S = 1.0


class RospyBridge:
    """All of the node, told what to do by the gateway.

    Frames are handled one after the other on the main thread, by the method ``on_`` and their op.
    """

    def __init__(self, out: FrameWriter) -> None:
        """Start with nothing."""
        self._out = out
        # By the gateway's number of the topic.
        self._topics: dict[int, RawSubscription] = {}
        # By the name under which the gateway has it published. Also read by other threads.
        self._publishers: dict[str, ZeroEndedPublisher] = {}
        self._commands = CommandRunner(out, self._publishers)
        self._taps = TapRunner(out, self._hears)
        # Parameters whose values are told.
        self._parameters: list[str] = []
        self._ended = threading.Event()
        # When it was last shown that the main thread works (monotonic, s).
        self._shown = 0.0

    # ── what the gateway may say ──

    def handle_frame(self, asked: dict[str, Any]) -> None:
        """Act on one frame."""
        getattr(self, "on_" + asked["op"])(asked)
        # Each topic is a question to the master; where that is slow, pings wait behind many.
        if time.monotonic() - self._shown >= WORKING_EVERY_S:
            self._shown = time.monotonic()
            self._out.send_frame(op="working")

    def on_ping(self, asked: dict[str, Any]) -> None:
        """Show that this process is alive."""
        self._out.send_frame(op="pong", n=asked["n"])

    def on_listen(self, asked: dict[str, Any]) -> None:
        """Subscribe a topic under a number."""
        # Also to connect anew: who was subscribed under it is not any more.
        self.on_leave(asked)
        self._topics[asked["topic"]] = RawSubscription(
            out=self._out,
            number=asked["topic"],
            name=asked["name"],
            rate=asked.get("rate", 0.0),
            deep=asked["deep"],
        )

    def on_leave(self, asked: dict[str, Any]) -> None:
        """Unsubscribe it."""
        topic = self._topics.pop(asked["topic"], None)
        if topic is not None:
            topic.close()

    def on_tap(self, asked: dict[str, Any]) -> None:
        """Subscribe a topic for the hub, under a number of its own."""
        self._taps.order_tap(asked)

    def on_untap(self, asked: dict[str, Any]) -> None:
        """Unsubscribe it."""
        self._taps.order_tap(asked)

    def on_voice(self, asked: dict[str, Any]) -> None:
        """Advertise under a name."""

        def make() -> None:
            self._publishers[asked["id"]] = ZeroEndedPublisher(asked)

        self._commands.prepare_command(asked, make)

    def on_say(self, asked: dict[str, Any]) -> None:
        """Publish what was advertised, without an answer."""
        publisher = self._publishers.get(asked["id"])
        if publisher is not None:
            try:
                publisher.publish_fields(asked["fields"])
            except (ValueError, rospy.ROSException, rospy.ROSSerializationException) as error:
                self._out.send_frame(op="complaint", id=asked["id"], problem=str(error))

    def on_service(self, asked: dict[str, Any]) -> None:
        """Get ready to call a service."""
        self._commands.prepare_service(asked)

    def on_action(self, asked: dict[str, Any]) -> None:
        """Get ready to send goals to an action."""
        self._commands.prepare_action(asked)

    def on_act(self, asked: dict[str, Any]) -> None:
        """Begin a command; its end is told under its number."""
        self._commands.begin_command(asked)

    def on_cancel(self, asked: dict[str, Any]) -> None:
        """End the goal of an action."""
        self._commands.cancel_goal(asked)

    def on_parameters(self, asked: dict[str, Any]) -> None:
        """Tell the values of these from now on."""
        self._parameters = asked["names"]

    def on_describe(self, asked: dict[str, Any]) -> None:
        """Tell the definition of a message, or of a service's request; empty: not known here."""
        service = asked["what"] == "srv"
        find = service_class if service else message_class
        try:
            found = find(asked["type"])
            text = (found._request_class if service else found)._full_text  # noqa: SLF001
        except (AttributeError, ImportError, ValueError):
            # None has no such attribute: the package is not installed.
            text = None
        self._out.send_frame(
            op="described", what=asked["what"], type=asked["type"], definition=text
        )

    # ── what goes on by itself ──

    def start_threads(self) -> None:
        """Begin what goes on beside the gateway's frames."""
        threading.Thread(target=self.watch, daemon=True).start()
        self._taps.start_threads()

    def _hears(self, name: str) -> bool:
        # A copy: the main thread adds to it.
        return name in {topic.name for topic in list(self._topics.values())}

    def watch(self) -> None:
        """End velocities that nobody renews, and read parameters. On a thread of its own."""
        due = 0.0
        while not self._ended.wait(_WATCH_EVERY_S):
            # A copy: the main thread adds to it.
            for publisher in list(self._publishers.values()):
                publisher.end_silence(SILENCE_S)
            if self._parameters and time.monotonic() >= due:
                due = time.monotonic() + PARAMETERS_EVERY_S
                self._read_parameters()

    def _read_parameters(self) -> None:
        for number, name in enumerate(self._parameters):
            try:
                value = rospy.get_param(name)
            except (KeyError, OSError, rospy.ROSException):
                # Not set, or the master is away: the value grows old at the gateway.
                continue
            # A namespace comes as a map, and cannot be a signal.
            if _is_plain(value) or (isinstance(value, list) and all(map(_is_plain, value))):
                at_us = time.time_ns() // 1000
                self._out.send_frame(op="parameter", number=number, value=value, at=at_us)

    def publish_zeros(self) -> None:
        """Say the zeros, for the gateway is gone."""
        self._ended.set()
        # rospy sends on threads of its own, which need a moment before this process ends; and a
        # command's thread may still publish in between, hence again.
        for _ in range(3):
            for publisher in self._publishers.values():
                publisher.end_silence(0.0)
            time.sleep(0.02)


def _is_plain(value: object) -> bool:
    """Tell whether a value is one number, truth or text."""
    return isinstance(value, (bool, int, float, str))


def main() -> None:
    """Join ROS 1 as a node and do as the gateway says until stdin ends."""
    out = FrameWriter(os.dup(1))
    # Whatever prints must not spoil the frames.
    os.dup2(2, 1)
    pipe = os.fdopen(0, "rb")
    frames = read_frames(pipe)
    first = next(frames)
    # rospy reads it once, when the node begins.
    os.environ["ROS_NAMESPACE"] = first["namespace"]
    # Signals are the gateway's: it says the zeros first, also on Ctrl-C.
    rospy.init_node(first["node"], disable_signals=True, disable_rosout=True)
    out.send_frame(op="ready", node=rospy.get_name())
    bridge = RospyBridge(out)
    bridge.start_threads()
    try:
        for asked in frames:
            bridge.handle_frame(asked)
    finally:
        bridge.publish_zeros()
        # The master may be away, and then nobody unregisters.
        threading.Timer(1.0, lambda: os._exit(0)).start()
        rospy.signal_shutdown("the gateway ended")
        os._exit(0)
