"""The observatory's servers as ROS 2 nodes, one for each device.

Requests use the types that come with every ROS 2: ``std_srvs/Trigger`` and ``SetBool``, and for
numbers ``rcl_interfaces/SetParametersAtomically``. That is the one standard service with named,
typed values and an answer of success and reason; a package of own types would have to be compiled
on every machine that is to call it. A service answers when what was asked has ended.

Long, because node, services, topics and clock of one server share its executor.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, NamedTuple

import rclpy
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParametersAtomically
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import Image, Temperature
from std_msgs.msg import Bool, Float64, String, UInt8, UInt8MultiArray
from std_srvs.srv import SetBool, Trigger

from talaia.sim.observatory.control_pipe import ControlPipe, act_on
from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.servers.base import Stamped

if TYPE_CHECKING:
    import threading
    from collections.abc import Callable
    from pathlib import Path

    from talaia.sim.observatory.request_log import RequestLog
    from talaia.sim.observatory.servers.base import Ask, ImageFrame, Server, Value

__all__ = ["Shells", "kind_of", "message_of", "values_of"]

# By the exact type: for Python a bool is an int.
KINDS = {bool: Bool, int: UInt8, float: Float64, str: String, Stamped: Temperature}
# A late subscriber gets the newest picture at once. Not so values: one that is kept for those who
# come later would look fresh to them however old it is.
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
STEP_S = 0.05
# In steps: all is published twice a second.
PUBLISH_EVERY = 10
# What the global server asks of the others.
NEEDED = [
    ("dome", "open"),
    ("dome", "close"),
    ("dome", "park"),
    ("dome", "stop"),
    ("telescope", "park"),
    ("telescope", "unpark"),
    ("telescope", "stop"),
    ("camera", "abort"),
]


def kind_of(value: Value) -> Any:  # noqa: ANN401 - ROS's packages are untyped
    """Give the message type for a value."""
    return KINDS[type(value)]


def message_of(value: Value) -> Any:  # noqa: ANN401
    """Give a value as its message."""
    if isinstance(value, Stamped):
        message = Temperature(temperature=value.value)
        message.header.stamp.sec = int(value.unix_s)
        message.header.stamp.nanosec = int(value.unix_s % 1.0 * 1e9)
        return message
    return kind_of(value)(data=value)


def values_of(request: Any, ask: Ask) -> dict[str, Value] | str:  # noqa: ANN401
    """Read the named values of a request; give what is wrong with them as a sentence.

    Arguments that are left out keep their examples' values only where those are texts.
    """
    values: dict[str, Value] = {}
    for parameter in request.parameters:
        name, value = parameter.name, parameter.value
        if name not in ask.arguments:
            return f"unknown argument {name!r}: expected {', '.join(ask.arguments)}"
        match value.type:
            case ParameterType.PARAMETER_DOUBLE:
                values[name] = value.double_value
            case ParameterType.PARAMETER_INTEGER:
                # Whoever writes 5 means 5.0.
                values[name] = float(value.integer_value)
            case ParameterType.PARAMETER_STRING:
                values[name] = value.string_value
            case ParameterType.PARAMETER_BOOL:
                values[name] = value.bool_value
            case _:
                return f"argument {name!r} has no value"
    for name, example in ask.arguments.items():
        if name not in values:
            if not isinstance(example, str):
                return f"the argument {name!r} is missing"
            values[name] = example
        # By the exact type: True is no number here.
        if type(values[name]) is not type(example):
            wanted = "a text" if isinstance(example, str) else "a number"
            return f"argument {name!r}: expected {wanted}"
    return values


class Shells:
    """All servers of one process.

    No executor: rclpy's calls a coroutine that waits (a service that answers later) over and over,
    and looks at every entity of every node at each turn. Here each entity is asked for what has
    come, twenty times a second, which costs a tenth of that.
    """

    def __init__(
        self,
        fits: Path | None,
        ledger: RequestLog,
        speed: float = 1.0,
        orders: ControlPipe | None = None,
    ) -> None:
        """Take where FITS files are kept, where it writes down, how fast time goes, and orders."""
        # The models' time goes so many times faster.
        self._speed = speed
        self._orders = orders or ControlPipe(None)
        self._fits = fits
        self._ledger = ledger
        self._shells: list[_Shell] = []
        # By device and service; only the global server asks others.
        self._clients: dict[tuple[str, str], Any] = {}
        # Requests to other servers that wait for an answer, by client and sequence number.
        self._asked: dict[tuple[str, str], dict[int, Ticket]] = {}

    def add_server(self, server: Server) -> None:
        """Make a node for a server."""
        shell = _Shell(server, self._fits, self._ledger)
        self._shells.append(shell)
        if server.name == "observatory":
            for device, what in NEEDED:
                self._clients[device, what] = shell.node.create_client(Trigger, f"/{device}/{what}")
                self._asked[device, what] = {}

    def call_server(self, device: str, what: str) -> Ticket:
        """Ask another server; how the global server moves all."""
        client = self._clients.get((device, what))
        if client is None or not client.service_is_ready():
            return Ticket.refused(f"/{device}/{what} is not there")
        ticket = Ticket()
        self._asked[device, what][client.handle.send_request(Trigger.Request())] = ticket
        return ticket

    def run(self, ended: threading.Event, started: Callable[[], None]) -> None:
        """Go on until ``ended``; ``started`` is called after the first round."""
        tick = 0
        before = due = time.monotonic()
        while not ended.is_set():
            now = time.monotonic()
            # A machine that slept does not make the models catch up.
            passed = min(now - before, 1.0) * self._speed
            self._hear_answers()
            for device, words in self._orders.read_orders():
                for shell in self._shells:
                    shell.obey_order(device, words)
            for shell in self._shells:
                shell.handle_requests()
                shell.step(passed, publish=tick % PUBLISH_EVERY == 0)
            before = now
            if tick == 0:
                started()
            tick += 1
            # Steps that were missed are not made up for in a burst.
            due = max(due + STEP_S, now)
            ended.wait(max(0.0, due - time.monotonic()))

    def _hear_answers(self) -> None:
        for key, waiting in self._asked.items():
            while waiting:
                header, answer = self._clients[key].handle.take_response(Trigger.Response)
                if header is None:
                    break
                ticket = waiting.pop(header.request_id.sequence_number, None)
                if ticket is not None:
                    ticket.end_with(answer.message, good=answer.success)

    def close(self) -> None:
        """Leave ROS."""
        for shell in self._shells:
            shell.node.destroy_node()


class _Waiting(NamedTuple):
    """A request that is under way: its ticket, and what sends the answer."""

    ticket: Ticket
    asked: str
    answer: Callable[[Ticket], None]


class _Shell:
    """One server as a node."""

    def __init__(self, server: Server, fits: Path | None, ledger: RequestLog) -> None:
        self._server = server
        self._fits = fits
        self._ledger = ledger
        self.node = rclpy.create_node(
            f"{server.name}_server", enable_rosout=False, start_parameter_services=False
        )
        # Requests of others whose end is still to be answered.
        self._waiting: list[_Waiting] = []
        # What was published last, by topic: all but numbers go out as soon as they change.
        self._said: dict[str, Value] = {}
        # How the hardware stood at the last entry of the ledger.
        self._truth = ""
        self._publishers = {
            name: self.node.create_publisher(kind_of(value), f"/{server.name}/{name}", 10)
            for name, value in server.topic_values().items()
        }
        self._pictures: Any = None
        self._files: Any = None
        if server.pictures:
            self._pictures = self.node.create_publisher(Image, f"/{server.name}/image", LATCHED)
        if server.name == "camera":
            self._files = self.node.create_publisher(UInt8MultiArray, "/camera/fits", LATCHED)
        # Each service with what takes its requests; asked by `handle_requests`.
        self._services: list[tuple[Any, Callable[[Any, Any], None]]] = []
        for name, trigger in server.triggers.items():
            self._offer_service(Trigger, name, _without_values(trigger))
        for name, switch in server.switches.items():
            self._offer_service(SetBool, name, _by_switch(switch))
        for name, ask in server.asks.items():
            self._offer_service(SetParametersAtomically, name, _by_name(ask.act))
        self._offer_liveness()
        # Each subscription with its type and who takes its values.
        self._ears: list[tuple[Any, Any, Callable[[Any], None]]] = []
        for topic, (kind, receive_request) in server.hears.items():
            self._subscribe_topic(topic, kind, receive_request)
        # Several faults may come between two rounds.
        self._subscribe_topic("/observatory/fault", str, self._apply_fault, depth=10)

    def _offer_service(
        self,
        kind: Any,  # noqa: ANN401
        name: str,
        act: Callable[[dict[str, Value]], Ticket],
    ) -> None:
        service = self.node.create_service(kind, f"/{self._server.name}/{name}", _unused_callback)

        def receive_request(request: Any, header: Any) -> None:  # noqa: ANN401
            def answer(ticket: Ticket) -> None:
                response = kind.Response()
                if kind is SetParametersAtomically:
                    response.result.successful = ticket.good
                    response.result.reason = ticket.message
                else:
                    response.success, response.message = ticket.good, ticket.message
                service.send_response(response, header)

            self._start_service_call(name, kind, request=request, act=act, answer=answer)

        self._services.append((service, receive_request))

    def _offer_liveness(self) -> None:
        """Answer what every node is asked to see whether it lives; there are no parameters."""
        service = self.node.create_service(
            GetParameters, f"/{self._server.name}_server/get_parameters", _unused_callback
        )

        def receive_request(request: Any, header: Any) -> None:  # noqa: ANN401
            unset = [ParameterValue() for _ in request.names]
            service.send_response(GetParameters.Response(values=unset), header)

        self._services.append((service, receive_request))

    def _start_service_call(
        self,
        name: str,
        kind: Any,  # noqa: ANN401
        *,
        request: Any,  # noqa: ANN401
        act: Callable[[dict[str, Value]], Ticket],
        answer: Callable[[Ticket], None],
    ) -> None:
        values: dict[str, Value] | str = {}
        if kind is SetBool:
            values = {"data": request.data}
        elif kind is SetParametersAtomically:
            values = values_of(request, self._server.asks[name])
        asked = name
        if isinstance(values, str):
            ticket = Ticket.refused(values)
        else:
            asked = " ".join([name, *(f"{value}" for value in values.values())])
            ticket = self._server.without_power() or act(values)
        device = self._server.name
        self._ledger.write_entry(
            device, asked, "answered" if ticket.ended else "asked", ticket.message, good=ticket.good
        )
        if ticket.ended:
            answer(ticket)
        else:
            self._waiting.append(_Waiting(ticket, asked, answer))

    def _subscribe_topic(
        self, topic: str, kind: type, receive_request: Callable[[Any], None], depth: int = 1
    ) -> None:
        ear = self.node.create_subscription(KINDS[kind], topic, _unused_callback, depth)
        self._ears.append((ear, KINDS[kind], receive_request))

    def _apply_fault(self, words: str) -> None:
        device, _, word = words.partition(" ")
        if device == self._server.name:
            problem = self._server.inject_fault(word)
            self._ledger.write_entry(device, word, "fault", problem)

    def obey_order(self, device: str, words: str) -> None:
        """Do what an order says, if it is this server's; see `orders`."""
        if device != self._server.name:
            return
        ticket = act_on(self._server, words)
        if ticket is None:
            self._apply_fault(f"{device} {words}")
            return
        asked = words.partition(" ")[2]
        said = ticket.message or "by hand"
        self._ledger.write_entry(device, asked, "by hand", said, good=ticket.good)

    def handle_requests(self) -> None:
        """Take what has come. A server that hangs leaves requests lying, and acts on them later."""
        for ear, kind, receive_request in self._ears:
            while (got := ear.handle.take_message(kind, False)) is not None:  # noqa: FBT003 - C++
                receive_request(got[0].data)
        if self._server.hanging:
            return
        for service, serve in self._services:
            while True:
                request, header = service.handle.service_take_request(service.srv_type.Request)
                if request is None:
                    break
                serve(request, header)

    def step(self, seconds: float, *, publish: bool) -> None:
        """Let time pass, answer what has ended, publish what is new."""
        self._server.pass_time(seconds, time.time())
        if self._server.truth != self._truth:
            self._truth = self._server.truth
            self._ledger.write_entry(self._server.name, "truth", "truth", self._truth)
        for asked, ticket in self._server.own_acts:
            self._ledger.write_entry(self._server.name, asked, "asked", "by itself: no heartbeat")
            # Nobody asked for it, so nobody is answered.
            self._waiting.append(_Waiting(ticket, asked, lambda _ticket: None))
        self._server.own_acts.clear()
        # Answers of a server that hangs wait as well.
        if self._server.hanging:
            return
        # A copy: the list gets shorter on the way.
        for waiting in [waiter for waiter in self._waiting if waiter.ticket.ended]:
            self._waiting.remove(waiting)
            ticket = waiting.ticket
            phase = "done" if ticket.good else "failed"
            self._ledger.write_entry(
                self._server.name, waiting.asked, phase, ticket.message, good=ticket.good
            )
            waiting.answer(ticket)
        if self._server.silent:
            return
        self._publish_values(everything=publish)
        self._publish_picture()

    def _publish_values(self, *, everything: bool) -> None:
        """Publish all twice a second, and what is no number as soon as it changes."""
        for name, value in self._server.topic_values().items():
            quick = not isinstance(value, float) and value != self._said.get(name)
            if everything or quick:
                self._said[name] = value
                self._publishers[name].publish(message_of(value))

    def _publish_picture(self) -> None:
        if self._pictures is None:
            return
        frame = self._server.take_frame(watched=self._pictures.get_subscription_count() > 0)
        if frame is None:
            return
        image = Image(
            height=frame.height, width=frame.width, encoding=frame.encoding, step=frame.step
        )
        image.header.stamp = self.node.get_clock().now().to_msg()
        image.header.frame_id = self._server.name
        # Given as an array it is taken whole; bytes would be looked at one by one.
        image.data.frombytes(frame.data)
        self._pictures.publish(image)
        if frame.file:
            self._publish_file(frame)

    def _publish_file(self, frame: ImageFrame) -> None:
        message = UInt8MultiArray()
        message.data.frombytes(frame.file)
        self._files.publish(message)
        if self._fits is not None:
            (self._fits / frame.name).write_bytes(frame.file)


def _without_values(act: Callable[[], Ticket]) -> Callable[[dict[str, Value]], Ticket]:
    return lambda _values: act()


def _by_switch(act: Callable[[bool], Ticket]) -> Callable[[dict[str, Value]], Ticket]:
    return lambda values: act(bool(values["data"]))


def _by_name(act: Callable[..., Ticket]) -> Callable[[dict[str, Value]], Ticket]:
    return lambda values: act(**values)


def _unused_callback(*_: object) -> None:
    """Stand where rclpy wants a callback; messages are taken by `handle_requests`."""
