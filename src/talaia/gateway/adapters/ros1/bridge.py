"""The node of the ROS 1 adapter. Run as a script by the Python that has rospy, 3.8 or later.

It imports nothing of talaia: the other Python has none of what that needs. Frames go over stdin
and stdout as `talaia.gateway.adapters.ros1.frames` says; what rospy prints goes to stderr. When
stdin ends, or says nothing for long while a velocity stands, it publishes the zeros it was given.
Long, because it must be one file.
"""

# ruff: noqa: ANN401 - rospy ships no types
from __future__ import annotations

import json
import os
import struct
import sys

# A script's own folder stands first, and would hide packages of the same names as our modules.
sys.path.pop(0)

import threading
import time
from typing import TYPE_CHECKING

import rospy
from roslib import message as ros_types  # type: ignore[import-not-found]

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any, BinaryIO

HEAD = struct.Struct("<IB")
STAMP = struct.Struct("<Hq")
JSON, MESSAGE = 0, 1
MAX_FRAME = 16 * 1024 * 1024
# A velocity stands no longer than this without a new one (s).
SILENCE_S = 0.5
MAX_CALLS = 32
# While it works through what it was told, it says so at most so often (s).
WORKING_EVERY_S = 0.25
PARAMETERS_EVERY_S = 1.0


class FrameWriter:
    """Writes whole frames; rospy calls from many threads."""

    def __init__(self, fd: int) -> None:
        """Take the pipe."""
        self._fd = fd
        self._turn = threading.Lock()

    def send(self, **what: Any) -> None:
        """Write a JSON frame."""
        self.write(JSON, json.dumps(what).encode())

    def write(self, kind: int, body: bytes) -> None:
        """Write a frame; ends the process when nobody reads any more."""
        data = memoryview(HEAD.pack(len(body) + 1, kind) + body)
        with self._turn:
            try:
                while data:
                    data = data[os.write(self._fd, data) :]
            except OSError:
                # The reader of stdin hears of it, too, and says the zeros.
                return


def fill(message: Any, fields: dict[str, Any]) -> Any:
    """Set fields by path; `ValueError` tells which does not fit."""
    for path, value in fields.items():
        steps = path.replace("[", ".[").split(".")
        try:
            at = message
            for step in steps[:-1]:
                at = at[int(step[1:-1])] if step.startswith("[") else getattr(at, step)
            last = steps[-1]
            if last.startswith("["):
                index = int(last[1:-1])
                at[index] = fitting(at[index], value)
            else:
                setattr(at, last, fitting(getattr(at, last), value))
        except (AttributeError, IndexError, TypeError, ValueError, OverflowError) as error:
            raise ValueError(f"field {path!r}: {error}") from error
    return message


def fitting(now: Any, value: Any) -> Any:
    """Give the value in the type that stands there now; never a silent cut."""
    if isinstance(now, bool):
        if not isinstance(value, bool):
            raise TypeError(f"expected true or false, found {value!r}")
        return value
    if isinstance(now, str):
        return value if isinstance(value, str) else str(value)
    if isinstance(value, str):
        raise TypeError(f"expected a number, found {value!r}")
    if isinstance(now, int):
        if int(value) != value:
            raise ValueError(f"expected a whole number, found {value!r}")
        return int(value)
    if isinstance(now, (rospy.Time, rospy.Duration)):
        return type(now).from_sec(float(value))
    return float(value)


def at_path(message: Any, path: str) -> float:
    """Read a number by path."""
    for step in path.replace("[", ".[").split("."):
        message = message[int(step[1:-1])] if step.startswith("[") else getattr(message, step)
    return float(message)


def class_of(name: str, find: Callable[[str], Any]) -> Any:
    """Import a type ``package/middle/Name``."""
    package, _, short = name.split("/")
    found = find(package + "/" + short)
    if found is None:
        raise LookupError(name)
    return found


class RawSubscription:
    """A subscription by raw bytes, so that a type need not be known here."""

    def __init__(self, *, out: FrameWriter, number: int, name: str, rate: float, deep: int) -> None:
        """Subscribe; with ``rate`` (Hz) messages that come sooner are left."""
        self._out = out
        self._number, self._name = number, name
        self._period = 1.0 / rate if rate else 0.0
        self._due = 0.0
        self._known = ""
        self._subscriber = rospy.Subscriber(
            name,
            rospy.AnyMsg,
            self._forward,
            queue_size=deep,
            buff_size=MAX_FRAME,
            tcp_nodelay=True,
        )

    def _forward(self, message: Any) -> None:
        at_us = time.time_ns() // 1000
        if self._period:
            now = time.monotonic()
            if now < self._due:
                return
            self._due = max(self._due + self._period, now)
        header = message._connection_header  # noqa: SLF001 - rospy has no other way
        known = header.get("md5sum", "")
        if known != self._known:
            self._known = known
            kind, text = header.get("type", ""), header.get("message_definition", "")
            self._out.send(op="type", topic=self._number, type=kind, md5=known, definition=text)
        raw = message._buff  # noqa: SLF001
        if len(raw) + STAMP.size < MAX_FRAME:
            self._out.write(MESSAGE, STAMP.pack(self._number, at_us) + raw)
        else:
            problem = f"a message of {len(raw)} bytes is too large, and is left out"
            self._out.send(op="complaint", id=self._name, problem=problem)

    def close(self) -> None:
        """Unsubscribe."""
        self._subscriber.unregister()


class ZeroEndedPublisher:
    """A publication, and the zero that ends what it says."""

    def __init__(self, asked: dict[str, Any]) -> None:
        """Advertise."""
        kind = class_of(asked["type"], ros_types.get_message_class)
        self._kind = kind
        self._zero: dict[str, Any] | None = asked.get("zero")
        self._moving = False
        self._said = 0.0
        self._turn = threading.Lock()
        self.publisher = rospy.Publisher(
            asked["topic"],
            kind,
            queue_size=asked.get("deep", 1),
            latch=asked.get("latch", False),
            tcp_nodelay=True,
        )

    def publish_fields(self, fields: dict[str, Any]) -> None:
        """Publish a message with these fields."""
        message = fill(self._kind(), fields)
        with self._turn:
            self._moving = self._zero is not None and fields != self._zero
            self._said = time.monotonic()
            self.publisher.publish(message)

    def still(self, silence: float) -> None:
        """Say zero if something else stands and is older than this (s)."""
        with self._turn:
            if self._zero is not None and self._moving and time.monotonic() - self._said >= silence:
                self._moving = False
                self.publisher.publish(fill(self._kind(), self._zero))


class RospyBridge:
    """All of it, told what to do by the gateway."""

    def __init__(self, out: FrameWriter) -> None:
        """Start with nothing."""
        self._out = out
        self._topics: dict[int, RawSubscription] = {}
        self._voices: dict[str, ZeroEndedPublisher] = {}
        self._services: dict[str, tuple[Any, Any, str]] = {}
        self._actions: dict[str, tuple[Any, Any, dict[str, Any]]] = {}
        self._goals: dict[str, str] = {}
        self._sending = threading.RLock()
        self._parameters: list[str] = []
        self._problems: dict[str, str] = {}
        self._calls = threading.Semaphore(MAX_CALLS)
        self._ended = threading.Event()
        self._shown = 0.0

    # ── what the gateway may say ──

    def handle(self, asked: dict[str, Any]) -> None:
        """Act on one frame."""
        getattr(self, "on_" + asked["op"])(asked)
        # Each topic is a question to the master; where that is slow, pings wait behind many.
        if time.monotonic() - self._shown >= WORKING_EVERY_S:
            self._shown = time.monotonic()
            self._out.send(op="working")

    def on_ping(self, asked: dict[str, Any]) -> None:
        """Show that this process is alive."""
        self._out.send(op="pong", n=asked["n"])

    def on_listen(self, asked: dict[str, Any]) -> None:
        """Subscribe a topic under a number."""
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

    def on_voice(self, asked: dict[str, Any]) -> None:
        """Advertise under a name."""
        self._made(asked, lambda: self._voices.__setitem__(asked["id"], ZeroEndedPublisher(asked)))

    def on_say(self, asked: dict[str, Any]) -> None:
        """Publish what was advertised, without an answer."""
        voice = self._voices.get(asked["id"])
        if voice is not None:
            try:
                voice.publish_fields(asked["fields"])
            except (ValueError, rospy.ROSException, rospy.ROSSerializationException) as error:
                self._out.send(op="complaint", id=asked["id"], problem=str(error))

    def on_service(self, asked: dict[str, Any]) -> None:
        """Get ready to call a service."""

        def make() -> None:
            kind = class_of(asked["type"], ros_types.get_service_class)
            proxy = rospy.ServiceProxy(asked["name"], kind)
            self._services[asked["id"]] = (proxy, kind, asked["name"])

        self._made(asked, make)

    def on_action(self, asked: dict[str, Any]) -> None:
        """Get ready to send goals to an action."""

        def make() -> None:
            import actionlib  # type: ignore[import-not-found]

            package, middle, name = asked["type"].split("/")
            kind = class_of(package + "/" + middle + "/" + name + "Action", _message)
            goal = class_of(package + "/" + middle + "/" + name + "Goal", _message)
            client = actionlib.SimpleActionClient(asked["name"], kind)
            self._actions[asked["id"]] = (client, goal, asked)

        self._made(asked, make)

    def _made(self, asked: dict[str, Any], make: Callable[[], None]) -> None:
        self._problems.pop(asked["id"], None)
        try:
            make()
        except (LookupError, ImportError, ValueError, AttributeError) as error:
            self._problems[asked["id"]] = asked["type"]
            name, about = asked.get("name", asked.get("topic", "")), {"type": asked["type"]}
            self._out.send(op="missing", id=asked["id"], used_by=name, problem=str(error), **about)

    def on_parameters(self, asked: dict[str, Any]) -> None:
        """Tell the values of these from now on."""
        self._parameters = asked["names"]

    def on_describe(self, asked: dict[str, Any]) -> None:
        """Tell the definition of a message, or of a service's request; empty: not known here."""
        service = asked["what"] == "srv"
        find = ros_types.get_service_class if service else ros_types.get_message_class
        try:
            found = find(asked["type"])
            text = (found._request_class if service else found)._full_text  # noqa: SLF001
        except (AttributeError, ImportError, ValueError):
            text = None
        self._out.send(op="described", what=asked["what"], type=asked["type"], definition=text)

    # ── one-shot commands ──

    def on_act(self, asked: dict[str, Any]) -> None:
        """Begin a command; its end is told under its number."""
        name, call = asked["id"], asked["call"]
        if name in self._problems:
            self._end(call, "refused", f"its type {self._problems[name]} is not known here")
        elif name in self._services:
            self._begin(call, lambda: self._call(name, call, asked["fields"]))
        elif name in self._actions:
            self._begin(call, lambda: self._goal(name, call, asked["fields"]))
        elif name in self._voices:
            self._publish(name, call, asked["fields"])
        else:
            self._begin(call, lambda: self._set(call, asked))

    def _begin(self, call: int, work: Callable[[], None]) -> None:
        # rospy has no bound in time for a call, so each hangs in a thread of its own.
        if not self._calls.acquire(blocking=False):
            self._end(call, "refused", "too many calls wait for an answer")
            return

        def run() -> None:
            try:
                work()
            finally:
                self._calls.release()

        threading.Thread(target=run, daemon=True).start()

    def _end(self, call: int, phase: str, message: str = "", progress: float = 0.0) -> None:
        self._out.send(op="outcome", call=call, phase=phase, message=message, progress=progress)

    def _publish(self, name: str, call: int, fields: dict[str, Any]) -> None:
        voice = self._voices[name]
        try:
            if voice.publisher.get_num_connections() == 0:
                topic = voice.publisher.name
                self._end(call, "refused", "nobody on the robot listens to " + topic)
                return
            voice.publish_fields(fields)
        except (ValueError, rospy.ROSException, rospy.ROSSerializationException) as error:
            self._end(call, "refused", str(error))
            return
        self._end(call, "succeeded", "published")

    def _call(self, name: str, call: int, fields: dict[str, Any]) -> None:
        proxy, kind, service = self._services[name]
        try:
            request = fill(kind._request_class(), fields)  # noqa: SLF001 - genpy's own way
            rospy.wait_for_service(service, timeout=0.5)
        except ValueError as error:
            self._end(call, "refused", str(error))
            return
        except rospy.ROSException:
            self._end(call, "refused", f"the robot does not offer {service} now")
            return
        try:
            response = proxy.call(request)
        except rospy.ServiceException as error:
            # Refused by the server in its own words, or the connection broke under way.
            said = str(error)
            phase = "unknown" if "transport error" in said else "failed"
            self._end(call, "refused" if "unable to connect" in said else phase, said)
        except (rospy.ROSException, rospy.ROSSerializationException) as error:
            self._end(call, "failed", str(error))
        else:
            said = getattr(response, "message", "")
            good = getattr(response, "success", True) is not False
            words = said if isinstance(said, str) else ""
            if not good and not words:
                words = "the robot says it did not succeed"
            self._end(call, "succeeded" if good else "failed", words)

    def _goal(self, name: str, call: int, fields: dict[str, Any]) -> None:
        client, kind, asked = self._actions[name]
        try:
            goal = fill(kind(), fields)
        except ValueError as error:
            self._end(call, "refused", str(error))
            return
        if not client.wait_for_server(rospy.Duration(0.5)):
            self._end(call, "refused", f"the robot does not offer {asked['name']} now")
            return

        def fed(feedback: Any) -> None:
            progress = 0.0
            if asked["progress"]:
                try:
                    progress = at_path(feedback, asked["progress"]) / asked["progress_end"]
                except (AttributeError, IndexError, TypeError, ValueError):
                    progress = 0.0
            self._end(call, "running", "", min(1.0, max(0.0, progress)))

        def done(state: int, result: Any) -> None:
            self._goals.pop(name, None)
            words = client.get_goal_status_text() or getattr(result, "message", "")
            phases = {2: "cancelled", 3: "succeeded", 4: "failed", 5: "refused", 8: "cancelled"}
            message = words if isinstance(words, str) else ""
            self._end(call, phases.get(state, "unknown"), message)

        with self._sending:
            self._goals[name] = str(call)
            client.send_goal(goal, done_cb=done, feedback_cb=fed)

    def on_cancel(self, asked: dict[str, Any]) -> None:
        """End the goal of an action, if it is still this call's."""
        # The client knows the goal only after it has sent it; the robot may be faster.
        with self._sending:
            if self._goals.get(asked["id"]) == str(asked["call"]):
                self._actions[asked["id"]][0].cancel_goal()

    def _set(self, call: int, asked: dict[str, Any]) -> None:
        try:
            for field, value in asked["fields"].items():
                rospy.set_param(asked["target"].rstrip("/") + "/" + field, value)
        except (OSError, rospy.ROSException) as error:
            self._end(call, "unknown", str(error))
        else:
            self._end(call, "succeeded", "set")

    # ── what goes on by itself ──

    def watch(self) -> None:
        """End velocities that nobody renews, and read parameters."""
        due = 0.0
        while not self._ended.wait(0.05):
            for voice in list(self._voices.values()):
                voice.still(SILENCE_S)
            if self._parameters and time.monotonic() >= due:
                due = time.monotonic() + PARAMETERS_EVERY_S
                self._read_parameters()

    def _read_parameters(self) -> None:
        for number, name in enumerate(self._parameters):
            try:
                value = rospy.get_param(name)
            except (KeyError, OSError, rospy.ROSException):
                continue
            if isinstance(value, (bool, int, float, str)):
                at_us = time.time_ns() // 1000
                self._out.send(op="parameter", number=number, value=value, at=at_us)

    def end(self) -> None:
        """Say the zeros."""
        self._ended.set()
        for _ in range(3):
            for voice in self._voices.values():
                voice.still(0.0)
            time.sleep(0.02)


def _message(name: str) -> Any:
    return ros_types.get_message_class(name)


def frames(pipe: BinaryIO) -> Any:
    """Read JSON frames until the pipe ends."""
    while True:
        head = pipe.read(HEAD.size)
        if len(head) < HEAD.size:
            return
        size, _ = HEAD.unpack(head)
        if not 1 <= size <= MAX_FRAME:
            return
        body = pipe.read(size - 1)
        if len(body) < size - 1:
            return
        yield json.loads(body.decode())


def main() -> None:
    """Join ROS 1 as a node and do as the gateway says until stdin ends."""
    out = FrameWriter(os.dup(1))
    # Whatever prints must not spoil the frames.
    os.dup2(2, 1)
    pipe = os.fdopen(0, "rb")
    asking = frames(pipe)
    first = next(asking)
    os.environ["ROS_NAMESPACE"] = first["namespace"]
    rospy.init_node(first["node"], disable_signals=True, disable_rosout=True)
    out.send(op="ready", node=rospy.get_name())
    bridge = RospyBridge(out)
    threading.Thread(target=bridge.watch, daemon=True).start()
    try:
        for asked in asking:
            bridge.handle(asked)
    finally:
        bridge.end()
        # The master may be away, and then nobody unregisters.
        threading.Timer(1.0, lambda: os._exit(0)).start()
        rospy.signal_shutdown("the gateway ended")
        os._exit(0)


if __name__ == "__main__":
    main()
