"""One rosbridge client: what it asks becomes messages of a page, what it is told becomes its own.

Long, because each message of the protocol, both ways, has its few lines here in one place.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.first_completed import until_first
from talaia.hub.auth.tokens import new_token
from talaia.hub.clients.published_message import read_fields
from talaia.hub.clients.robot_names import RobotCall
from talaia.hub.clients.rosbridge.call_timeouts import CallTimeouts
from talaia.hub.clients.rosbridge.offer import RosbridgeOffer, make_rosbridge_offer
from talaia.hub.clients.rosbridge.output import RosbridgeOutput
from talaia.hub.clients.rosbridge.published_topics import PublishedTopics
from talaia.hub.clients.rosbridge.rosapi import ROSAPI, NoSuchThing, Rosapi
from talaia.hub.clients.rosbridge.topic_delivery import TopicDelivery
from talaia.hub.clients.rosbridge.wanted_topics import absolute_name
from talaia.wire.browser import (
    CommandUpdate,
    PageCommand,
    PageCommandCancel,
    RequestError,
    SessionEnded,
    SiteUpdate,
    StopUpdate,
    Values,
)
from talaia.wire.frames import CommandPhase
from talaia.wire.gateway_messages.field_types import Arguments, Scalar
from talaia.wire.nested_json import decode_nested
from talaia.wire.rosbridge import client_messages as said
from talaia.wire.rosbridge.codec import (
    MAX_ROSBRIDGE_FRAME,
    RosbridgeMistake,
    decode_rosbridge,
)
from talaia.wire.rosbridge.fragments import FragmentAssembly

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

    from talaia.clock import Clock
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.rosbridge.offer import RosService
    from talaia.hub.live.taps.tap_fanout import TapFanout
    from talaia.wire.browser import ToBrowser

__all__ = ["RosbridgeSession"]

# Calls and goals that wait for their end.
_MOST_CALLS = 100
_SET_PARAM = f"{ROSAPI}set_param"
_GOING_ON = frozenset({CommandPhase.ACCEPTED, CommandPhase.RUNNING})


class _Waiting(NamedTuple):
    """A call or goal that waits for its end; ``sets``: it sets a parameter by rosapi."""

    asked: said.RosbridgeCall | said.RosbridgeGoal
    device: str
    sets: bool = False


class RosbridgeSession:
    """See `ClientSession`."""

    def __init__(
        self, socket: WebSocket, connection: ClientConnection, *, taps: TapFanout, clock: Clock
    ) -> None:
        """Speak over ``socket``, which is accepted, for ``connection``."""
        self._socket = socket
        self._output = RosbridgeOutput(socket)
        self._connection = connection
        self._site = connection.live.name
        self._offer = RosbridgeOffer()
        # Of the description that is offered.
        self._edition = ""
        grants = connection.who.grants
        self._rosapi = Rosapi(connection.live, grants, taps=taps, clock=clock)
        self._topics = TopicDelivery(connection, self._output, taps=taps, clock=clock)
        self._fragments = FragmentAssembly(MAX_ROSBRIDGE_FRAME)
        self._published = PublishedTopics(connection, self._output, clock=clock)
        # By the command's or STOP's id; and by the client's id of a goal: the command's.
        self._waiting: dict[str, _Waiting] = {}
        self._goals: dict[str | int, str] = {}
        self._timeouts = CallTimeouts(self._expire_call)

    # ── from the client ──

    async def read_client(self) -> None:
        """Read until the client has gone; meanwhile send what it subscribed to."""
        self._update_offer()
        try:
            results = await until_first(
                self._read_socket(), self._topics.send_taps(), self._topics.send_throttled()
            )
        finally:
            self._topics.end_delivery()
            self._timeouts.end_all()
        for result in results:
            if isinstance(result, Exception):
                raise result

    async def _read_socket(self) -> None:
        while True:
            event = await self._socket.receive()
            if event["type"] == "websocket.disconnect":
                return
            text = event.get("text")
            if text is None:
                await self._output.tell_status("error", "messages are read as JSON in text frames")
            else:
                await self._receive_text(text)

    async def _receive_text(self, text: str) -> None:
        try:
            message = decode_rosbridge(text)
            if isinstance(message, said.RosbridgeFragment):
                whole = self._fragments.add_fragment(message)
                if whole is None:
                    return
                message = decode_rosbridge(whole)
        except RosbridgeMistake as mistake:
            await self._output.tell_status("error", mistake.problem, mistake.id)
            return
        await self._handle_message(message)

    async def _handle_message(self, message: said.RosbridgeMessage) -> None:
        match message:
            case said.RosbridgeSubscribe():
                topic = absolute_name(message.topic)
                kind = self._rosapi.current_graph(self._offer).topics.get(topic, "")
                await self._topics.add_subscription(message, kind)
            case said.RosbridgeUnsubscribe():
                await self._topics.remove_subscription(message)
            case said.RosbridgeAdvertise():
                await self._published.note_advertised(message, self._offer)
            case said.RosbridgeUnadvertise():
                self._published.forget_advertised(message)
            case said.RosbridgePublish():
                await self._published.publish_message(message, self._offer)
            case said.RosbridgeCall():
                await self._call_service(message)
            case said.RosbridgeGoal():
                await self._send_goal(message)
            case said.RosbridgeCancel():
                await self._cancel_goal(message)
            case said.RosbridgeLevel():
                self._output.set_level(message.level)
            case said.RosbridgeServe() | said.RosbridgeServeAction():
                why = "services and actions of clients are not called from here"
                await self._output.tell_status("error", why, message.id)
            case said.RosbridgeFragment():
                await self._output.tell_status("error", "a fragment in fragments", message.id)

    async def _call_service(self, message: said.RosbridgeCall) -> None:
        service = absolute_name(message.service)
        if service == _SET_PARAM:
            if why := self._set_parameter(message):
                await self._output.send_response(message, why, good=False)
            return
        if service.startswith(ROSAPI):
            try:
                args = _read_fields(bytes(message.args))
                found = await self._rosapi.answer_call(
                    service.removeprefix(ROSAPI), args, self._offer
                )
            except (NoSuchThing, ValueError) as error:
                await self._output.send_response(message, str(error), good=False)
            else:
                await self._output.send_response(message, found, good=True)
            return
        offered = self._offer.services.get(service)
        if offered is None:
            why = f"there is no service {message.service}"
        else:
            why = self._ask_command(offered, message)
        if why:
            await self._output.send_response(message, why, good=False)

    async def _send_goal(self, message: said.RosbridgeGoal) -> None:
        offered = self._offer.services.get(absolute_name(message.action))
        if offered is None or not offered.action:
            why = f"there is no action {message.action}"
        else:
            why = self._ask_command(offered, message)
        if why:
            await self._output.end_goal(message, why, CommandPhase.REFUSED)

    def _ask_command(
        self, offered: RosService, message: said.RosbridgeCall | said.RosbridgeGoal
    ) -> str:
        """Ask the hub for a command or STOP; say why not, if so."""
        if len(self._waiting) >= _MOST_CALLS:
            return f"at most {_MOST_CALLS} calls at once"
        if not offered.command and offered.robot is None:
            press, why = self._connection.press_stop(offered.device)
            if not why:
                self._waiting[press] = _Waiting(message, offered.device)
            return why
        try:
            call = _read_call(bytes(message.args), offered)
        except ValueError as error:
            return str(error)
        return self._ask_call(call, _Waiting(message, call.device))

    def _set_parameter(self, message: said.RosbridgeCall) -> str:
        """Ask for the command that sets a parameter; say why not, if so."""
        if len(self._waiting) >= _MOST_CALLS:
            return f"at most {_MOST_CALLS} calls at once"
        try:
            name, value = _read_setting(bytes(message.args))
        except ValueError as error:
            return str(error)
        if name in self._offer.parameters:
            return f"{name} is of the description and cannot be set"
        parameter = self._offer.robot_parameters.find(name)
        if parameter is None:
            return f"there is no parameter {name}"
        found = parameter.find_command(value)
        if isinstance(found, str):
            return f"{name}: {found}"
        return self._ask_call(found, _Waiting(message, found.device, sets=True))

    def _ask_call(self, call: RobotCall, waiting: _Waiting) -> str:
        """Ask the hub for a command; say why not, if so."""
        message, number = waiting.asked, new_token()
        # Before it is asked: its end may come at once.
        self._waiting[number] = waiting
        problem = self._connection.request(
            PageCommand(
                site=self._site,
                device=call.device,
                command=call.command,
                id=number,
                args=call.args,
            )
        )
        if problem is not None:
            del self._waiting[number]
            return problem.message
        if isinstance(message, said.RosbridgeCall):
            self._timeouts.start_call(number, message.timeout)
        elif message.id is not None:
            self._goals[message.id] = number
        return ""

    async def _expire_call(self, number: str, after_s: float) -> None:
        waiting = self._waiting.pop(number, None)
        if waiting is not None and isinstance(waiting.asked, said.RosbridgeCall):
            # It was sent to the robot, and nothing calls it back.
            why = f"no answer within {after_s:g} s; what was asked may still be done"
            await self._output.send_response(waiting.asked, why, good=False)

    async def _cancel_goal(self, message: said.RosbridgeCancel) -> None:
        number = self._goals.get(message.id) if message.id is not None else None
        if number is None:
            why = f"there is no goal {message.id} under way"
        else:
            device = self._waiting[number].device
            asked = PageCommandCancel(site=self._site, device=device, id=number)
            problem = self._connection.request(asked)
            why = "" if problem is None else problem.message
        if why:
            await self._output.tell_status("error", why, message.id)

    # ── to the client ──

    async def deliver_message(self, message: ToBrowser) -> None:
        """Write a message of the hub in the client's protocol, if it has one for it."""
        match message:
            case Values():
                await self._topics.deliver_values(message)
            case SiteUpdate() if message.site == self._site:
                if message.catalogue != self._edition:
                    self._update_offer()
            case CommandUpdate() if message.id in self._waiting:
                await self._follow_command(message)
            case CommandUpdate():
                await self._published.follow_command(message)
            case StopUpdate() if message.id in self._waiting and message.latched:
                waiting = self._waiting.pop(message.id).asked
                if isinstance(waiting, said.RosbridgeCall):
                    await self._output.send_response(
                        waiting, {"success": True, "message": "STOP is on"}, good=True
                    )
            case RequestError():
                await self._output.tell_status("error", message.message)
            case SessionEnded():
                await self._output.tell_status("error", message.reason)
            case _:
                pass

    async def warn_person(self, text: str) -> None:
        """Tell the client an error: by default it hears of nothing less."""
        await self._output.tell_status("error", text)

    async def close_client(self, code: int) -> None:
        """Close the socket."""
        await self._socket.close(code)

    def _update_offer(self) -> None:
        self._edition = self._connection.live.edition
        self._offer = make_rosbridge_offer(
            self._connection.description, self._connection.who.grants
        )
        self._topics.update_offer(self._offer)

    async def _follow_command(self, message: CommandUpdate) -> None:
        waiting = self._waiting[message.id]
        asked = waiting.asked
        if message.phase in _GOING_ON:
            if isinstance(asked, said.RosbridgeGoal) and asked.feedback:
                progress = {"progress": message.progress, "message": message.message}
                feedback = {"op": "action_feedback", "action": asked.action, "values": progress}
                await self._output.send_answer(feedback, asked)
            return
        del self._waiting[message.id]
        self._timeouts.end_call(message.id)
        text = message.message
        if isinstance(asked, said.RosbridgeGoal):
            if asked.id is not None:
                self._goals.pop(asked.id, None)
            await self._output.end_goal(asked, text, message.phase)
        elif message.phase is CommandPhase.SUCCEEDED:
            said_well = {"success": True, "message": text}
            if waiting.sets:
                said_well = {"successful": True, "reason": text}
            await self._output.send_response(asked, said_well, good=True)
        else:
            await self._output.send_response(asked, f"{message.phase.value}: {text}", good=False)


def _read_fields(args: bytes) -> dict[str, object]:
    """Read the arguments of a rosapi call.

    Raises:
        ValueError: they are none.

    """
    try:
        read = decode_nested(args)
    except ValueError as error:
        raise ValueError(f"not the arguments of a call: {str(error)[:200]}") from error
    if not isinstance(read, dict | list | None):
        raise ValueError(f"not the arguments of a call: {repr(read)[:100]}")  # noqa: TRY004 - of what a client said
    # A list has them in their order; most have one.
    return (
        read if isinstance(read, dict) else {str(at): value for at, value in enumerate(read or ())}
    )


def _read_setting(args: bytes) -> tuple[str, object]:
    """Read which parameter is to be what: the value is JSON in a text.

    Raises:
        ValueError: it is none of it.

    """
    fields = _read_fields(args)
    name, value = [*fields.values(), None, None][:2]
    name, value = fields.get("name", name), fields.get("value", value)
    if not isinstance(name, str) or not isinstance(value, str):
        raise ValueError("expected the name of a parameter, and its value as JSON in a text")  # noqa: TRY004 - of what a client said
    try:
        return name[:500], decode_nested(value)
    except ValueError as error:
        raise ValueError(f"not JSON: {value[:100]!r}: {str(error)[:200]}") from error


def _read_call(args: bytes, offered: RosService) -> RobotCall:
    """Give the command that a call of a service or a goal of an action asks for.

    Raises:
        ValueError: there is none.

    """
    if offered.robot is None:
        read = _read_arguments(args, offered)
        return RobotCall(offered.device, offered.command, read)
    found = offered.robot.find_command(read_fields(args))
    if isinstance(found, str):
        raise ValueError(found)  # noqa: TRY004 - nothing of another type was given
    return found


def _read_arguments(args: bytes, offered: RosService) -> dict[str, Scalar]:
    """Read the arguments of a command: an object, or a list in the order of its fields.

    Raises:
        ValueError: they are none.

    """
    try:
        read = msgspec.json.decode(args, type=Arguments | list[Scalar] | None)
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise ValueError(f"not the arguments of a command: {str(error)[:200]}") from error
    if not isinstance(read, list):
        return read or {}
    if len(read) > len(offered.fields):
        raise ValueError(f"{len(read)} arguments are more than the {len(offered.fields)} there are")
    return {name: value for (name, _), value in zip(offered.fields, read, strict=False)}
