"""The observatory's servers as ROS 1 services, by Debian's rospy. Standard library and rospy only.

ROS 1 has no standard service with numbers. A request with numbers is a Trigger whose values stand
on the parameter server (``/telescope/goto/ra``), as the command-line client writes them; or a
topic, for those who cannot set parameters: one number as Float64, two as the x and y of a Point.

Long, because one node's topics, services, requests and clock stand together.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import rosgraph
import rospy
from geometry_msgs.msg import Point
from sensor_msgs.msg import Image, Temperature
from std_msgs.msg import Bool, Float64, String, UInt8, UInt8MultiArray
from std_srvs.srv import SetBool, SetBoolResponse, Trigger, TriggerResponse

from talaia.sim.observatory.control_pipe import ControlPipe, act_on
from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.request_log import RequestLog
from talaia.sim.observatory.servers.base import Ask, Server, Stamped, Value
from talaia.sim.observatory.servers.catalog import make_server
from talaia.sim.observatory.servers.devices import DEVICES, ENCLOSURES, MONTSEC

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["main"]

# By the exact type: for Python a bool is an int.
KINDS = {bool: Bool, int: UInt8, float: Float64, str: String, Stamped: Temperature}
STEP_S = 0.05
# In steps: all is published twice a second.
PUBLISH_EVERY = 10


def main(argv: list[str]) -> int:
    """Run the servers until SIGINT or SIGTERM; see `run.main`."""
    parser = argparse.ArgumentParser("talaia sim observatory --ros1")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", action="append", choices=DEVICES)
    parser.add_argument("--fits", type=Path)
    parser.add_argument("--log", type=Path)
    parser.add_argument("--orders", type=Path)
    parser.add_argument("--speed", type=float, default=1.0)
    parser.add_argument("--longitude", type=float, default=MONTSEC.longitude)
    parser.add_argument("--enclosure", choices=ENCLOSURES, default=ENCLOSURES[0])
    options = parser.parse_args(argv)
    place = MONTSEC._replace(longitude=options.longitude)
    began = time.monotonic()
    ended = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        # rospy's own are off. The loop ends, and everything is closed in order.
        signal.signal(number, lambda *_: ended.set())
    names = options.only or list(DEVICES)
    if options.fits:
        options.fits.mkdir(parents=True, exist_ok=True)
    master = _start_master()
    try:
        name = f"{names[0]}_server" if len(names) == 1 else "observatory_servers"
        rospy.init_node(name, disable_signals=True, disable_rosout=True)
        ledger = RequestLog(options.log)
        shells = [
            _Shell(
                make_server(
                    name,
                    seed=options.seed,
                    unix_s=time.time(),
                    call=_call_service,
                    place=place,
                    roof=options.enclosure,
                ),
                options,
                ledger,
            )
            for name in names
        ]
        line = {
            "ready": True,
            "master": os.environ["ROS_MASTER_URI"],
            "pid": os.getpid(),
            "servers": names,
            "seconds": round(time.monotonic() - began, 2),
        }
        # Not before all services are up: whoever reads it calls them.
        print(json.dumps(line), flush=True)  # noqa: T201 - the one line whoever started us reads
        orders = ControlPipe(options.orders)
        _run_loop(shells, options.speed, ended, orders)
        orders.close()
        rospy.signal_shutdown("ended")
        ledger.close()
    finally:
        if master is not None:
            master.terminate()
            master.wait()
    return 0


def _start_master() -> subprocess.Popen[bytes] | None:
    """Start a master where none answers, for as long as we run."""
    uri = os.environ.setdefault("ROS_MASTER_URI", "http://localhost:11311")
    if rosgraph.is_master_online(uri):
        return None
    port = urlsplit(uri).port or 11311
    master = subprocess.Popen(  # noqa: S603 - Debian's own program, by its path
        ["/usr/bin/rosmaster", "--core", "-p", str(port)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    until = time.monotonic() + 15
    while not rosgraph.is_master_online(uri):
        if time.monotonic() > until or master.poll() is not None:
            master.terminate()
            sys.stderr.write(f"talaia sim: no ROS master could be started at {uri}\n")
            sys.exit(1)
        time.sleep(0.05)
    return master


def _make_message(value: Value) -> Any:  # noqa: ANN401 - rospy ships no types
    if not isinstance(value, Stamped):
        return KINDS[type(value)](value)
    message = Temperature(temperature=value.value)
    message.header.stamp = rospy.Time.from_sec(value.unix_s)
    return message


def _run_loop(
    shells: list[_Shell], speed: float, ended: threading.Event, orders: ControlPipe
) -> None:
    tick, before = 0, time.monotonic()
    while not ended.wait(STEP_S):
        now = time.monotonic()
        for device, words in orders.read_orders():
            for shell in shells:
                shell.obey_order(device, words)
        for shell in shells:
            # A machine that slept does not make the models catch up.
            shell.step(min(now - before, 1.0) * speed, publish=tick % PUBLISH_EVERY == 0)
        before, tick = now, tick + 1


def _call_service(device: str, what: str) -> Ticket:
    """Ask another server, in a thread: rospy waits for the answer."""
    ticket = Ticket()

    def ask() -> None:
        try:
            rospy.wait_for_service(f"/{device}/{what}", 2.0)
            answer = rospy.ServiceProxy(f"/{device}/{what}", Trigger)()
            ticket.end_with(answer.message, good=answer.success)
        except (rospy.ROSException, rospy.ServiceException) as error:
            ticket.end_with(str(error), good=False)

    # It may wait for a server that never comes, and keeps no process alive.
    threading.Thread(target=ask, daemon=True).start()
    return ticket


class _Shell:
    """One server's topics and services."""

    def __init__(self, server: Server, options: argparse.Namespace, ledger: RequestLog) -> None:
        self._server, self._fits, self._ledger = server, options.fits, ledger
        # rospy calls back from threads of its own; the server is touched under this lock only.
        self._lock = threading.RLock()
        # Notified after each step, for the threads that wait for the end of a request.
        self._moved = threading.Condition(self._lock)
        # What was published last, by topic: all but numbers go out as soon as they change.
        self._said: dict[str, Value] = {}
        # How the hardware stood at the last entry of the ledger.
        self._truth = ""
        name = server.name
        self._publishers = {
            topic: rospy.Publisher(f"/{name}/{topic}", KINDS[type(value)], queue_size=10)
            for topic, value in server.topic_values().items()
        }
        self._pictures = self._files = None
        if server.pictures:
            # Whoever comes later gets the newest picture at once.
            self._pictures = rospy.Publisher(f"/{name}/image", Image, queue_size=1, latch=True)
        if name == "camera":
            self._files = rospy.Publisher("/camera/fits", UInt8MultiArray, queue_size=1, latch=True)
        for service, trigger in server.triggers.items():
            rospy.Service(f"/{name}/{service}", Trigger, self._serve_trigger(service, trigger))
        for service, switch in server.switches.items():
            rospy.Service(f"/{name}/{service}", SetBool, self._serve_switch(service, switch))
        for service, ask in server.asks.items():
            rospy.Service(f"/{name}/{service}", Trigger, self._serve_ask(service, ask))
            self._listen_to_parameters(service, ask)
        for topic, (kind, take) in server.hears.items():
            self._subscribe_topic(topic, kind, take)
        rospy.Subscriber(
            "/observatory/fault", String, lambda message: self._apply_fault(message.data)
        )

    def _subscribe_topic(self, topic: str, kind: type, take: Callable[[Any], None]) -> None:
        def heard(message: Any) -> None:  # noqa: ANN401 - rospy ships no types
            with self._lock:
                take(message.data)

        rospy.Subscriber(topic, KINDS[kind], heard, queue_size=1)

    def _listen_to_parameters(self, name: str, ask: Ask) -> None:
        """Take a request with one or two numbers from a topic as well."""
        numbers = [
            argument for argument, value in ask.arguments.items() if isinstance(value, float)
        ]
        # A filter's name, and nothing else: there is no topic for that.
        if not numbers:
            return
        texts = {
            argument: value for argument, value in ask.arguments.items() if isinstance(value, str)
        }

        def heard(message: Any) -> None:  # noqa: ANN401 - rospy ships no types
            values = [message.data] if len(numbers) == 1 else [message.x, message.y]
            given = {**texts, **dict(zip(numbers, values, strict=True))}
            # A request may take minutes, and rospy's thread has to hear the next message.
            threading.Thread(
                target=self._end_of, args=(name, lambda: ask.act(**given)), daemon=True
            ).start()

        kind = Float64 if len(numbers) == 1 else Point
        rospy.Subscriber(f"/{self._server.name}/{name}", kind, heard, queue_size=1)

    def _apply_fault(self, words: str) -> None:
        device, _, word = words.partition(" ")
        if device == self._server.name:
            with self._lock:
                problem = self._server.inject_fault(word)
            self._ledger.write_entry(device, word, "fault", problem)

    def obey_order(self, device: str, words: str) -> None:
        """Do what an order says, if it is this server's; see `orders`."""
        if device != self._server.name:
            return
        with self._lock:
            ticket = act_on(self._server, words)
        if ticket is None:
            self._apply_fault(f"{device} {words}")
            return
        said = ticket.message or "by hand"
        self._ledger.write_entry(device, words.partition(" ")[2], "by hand", said, good=ticket.good)

    def _end_of(self, asked: str, act: Callable[[], Ticket]) -> Ticket:
        """Ask the model and wait until what was asked has ended. Each request has its thread."""
        name = self._server.name
        with self._moved:
            # A server that hangs takes no request up before the fault ends.
            while self._server.hanging:
                self._moved.wait(0.2)
            ticket = self._server.without_power() or act()
            phase = "answered" if ticket.ended else "asked"
            self._ledger.write_entry(name, asked, phase, ticket.message, good=ticket.good)
            if phase == "answered":
                return ticket
            # Waiting lets go of the lock, so that time can pass.
            while not ticket.ended or self._server.hanging:
                self._moved.wait(0.2)
        phase = "done" if ticket.good else "failed"
        self._ledger.write_entry(name, asked, phase, ticket.message, good=ticket.good)
        return ticket

    def _serve_trigger(self, name: str, act: Callable[[], Ticket]) -> Callable[[Any], Any]:
        def answer(_: object) -> object:
            ticket = self._end_of(name, act)
            return TriggerResponse(success=ticket.good, message=ticket.message)

        return answer

    def _serve_switch(self, name: str, act: Callable[[bool], Ticket]) -> Callable[[Any], Any]:
        def answer(request: Any) -> object:  # noqa: ANN401 - rospy ships no types
            ticket = self._end_of(f"{name} {request.data}", lambda: act(request.data))
            return SetBoolResponse(success=ticket.good, message=ticket.message)

        return answer

    def _serve_ask(self, name: str, ask: Ask) -> Callable[[Any], Any]:
        def answer(_: object) -> object:
            values, problem = self._read_parameters(name, ask)
            if problem:
                return TriggerResponse(success=False, message=problem)
            shown = " ".join([name, *(f"{value}" for value in values.values())])
            ticket = self._end_of(shown, lambda: ask.act(**values))
            return TriggerResponse(success=ticket.good, message=ticket.message)

        return answer

    def _read_parameters(self, name: str, ask: Ask) -> tuple[dict[str, Value], str]:
        """Take a request's values from the parameter server; each is used once."""
        values: dict[str, Value] = {}
        for argument, example in ask.arguments.items():
            key = f"/{self._server.name}/{name}/{argument}"
            try:
                found = rospy.get_param(key)
                rospy.delete_param(key)
            except KeyError:
                if not isinstance(example, str):
                    return {}, f"the parameter {key} is missing"
                found = example
            number = isinstance(found, (int, float)) and not isinstance(found, bool)
            if isinstance(example, str) != isinstance(found, str) or (
                isinstance(example, float) and not number
            ):
                wanted = "a text" if isinstance(example, str) else "a number"
                return {}, f"the parameter {key}: expected {wanted}"
            values[argument] = float(found) if number else found
        return values, ""

    def step(self, seconds: float, *, publish: bool) -> None:
        """Let time pass, wake those who wait, publish what is new."""
        with self._moved:
            self._server.pass_time(seconds, time.time())
            if self._server.truth != self._truth:
                self._truth = self._server.truth
                self._ledger.write_entry(self._server.name, "truth", "truth", self._truth)
            self._moved.notify_all()
            if self._server.silent:
                return
            topics = dict(self._server.topic_values())
            watched = self._pictures is not None and self._pictures.get_num_connections() > 0
            frame = self._server.take_frame(watched=watched) if self._pictures is not None else None
        # Outside the lock: requests do not wait for what is published.
        for name, value in topics.items():
            quick = not isinstance(value, float) and value != self._said.get(name)
            if publish or quick:
                self._said[name] = value
                self._publishers[name].publish(_make_message(value))
        if frame is None or self._pictures is None:
            return
        image = Image(
            height=frame.height, width=frame.width, encoding=frame.encoding, step=frame.step
        )
        image.header.stamp = rospy.Time.now()
        image.data = frame.data
        self._pictures.publish(image)
        if frame.file and self._files is not None:
            self._files.publish(UInt8MultiArray(data=frame.file))
            if self._fits is not None:
                (self._fits / frame.name).write_bytes(frame.file)
