"""One Foxglove client: what it asks becomes messages of a page, what it is told becomes its own.

Long, because each message of the protocol, both ways, has its few lines here in one place.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia import __version__
from talaia.first_completed import until_first
from talaia.hub.auth.tokens import new_token
from talaia.hub.clients.foxglove.advertised import AdvertisedThings
from talaia.hub.clients.foxglove.asset_requests import AssetRequests
from talaia.hub.clients.foxglove.camera_channels import CameraChannels
from talaia.hub.clients.foxglove.client_graph import ClientGraph, robot_services
from talaia.hub.clients.foxglove.offer import make_foxglove_offer
from talaia.hub.clients.foxglove.parameter_requests import ParameterRequests
from talaia.hub.clients.foxglove.published_channels import PublishedChannels
from talaia.hub.clients.foxglove.schemas import encode_answer
from talaia.hub.clients.foxglove.signal_channels import SignalChannels
from talaia.hub.clients.foxglove.tapped_channels import TappedChannels
from talaia.hub.clients.published_message import read_fields
from talaia.hub.clients.robot_names import RobotCall
from talaia.wire.browser import (
    CommandUpdate,
    PageCommand,
    RequestError,
    SessionEnded,
    SiteUpdate,
    StopUpdate,
    Values,
)
from talaia.wire.errors import UnknownKind
from talaia.wire.foxglove import client_messages as said
from talaia.wire.foxglove.codec import (
    decode_client,
    encode_message_data,
    encode_server,
    encode_service_response,
    encode_time,
)
from talaia.wire.foxglove.server_messages import (
    ServerInfo,
    ServerStatus,
    ServiceCallFailure,
)
from talaia.wire.frames import CommandPhase
from talaia.wire.gateway_messages.field_types import Arguments

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

    from talaia.clock import Clock
    from talaia.hub.clients.client_cameras import ClientCameras
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.foxglove.offer import ServiceEntry
    from talaia.hub.live.assets.robot_assets import RobotAssets
    from talaia.hub.live.taps.tap_fanout import TapFanout
    from talaia.hub.live.taps.tapped import TappedMessage
    from talaia.wire.browser import ToBrowser
    from talaia.wire.foxglove.server_messages import ServerMessage

__all__ = ["FoxgloveSession"]

_CAPABILITIES = [
    "time",
    "clientPublish",
    "parameters",
    "parametersSubscribe",
    "services",
    "connectionGraph",
]
# In which velocities may be published; commands are called with JSON.
_ENCODINGS = ["json", "cdr"]
# The hub's time is told so often (s): a client whose own clock is wrong goes by it.
_TIME_EVERY_S = 0.1
# Of a status.
_WARNING, _ERROR = 1, 2
_LIVE = "this connection is live; put from= and to= into the address to play the past"
# Calls that wait for their end.
_MOST_CALLS = 100
# Phases of a command after which more comes.
_GOING_ON = frozenset({CommandPhase.ACCEPTED, CommandPhase.RUNNING})


class _WaitingCall(NamedTuple):
    """A call that waits for its end: of a service's number; ``robot``: of the robot's own."""

    service: int
    call: int
    robot: bool = False


class FoxgloveSession:
    """See `ClientSession`."""

    def __init__(
        self,
        socket: WebSocket,
        connection: ClientConnection,
        *,
        taps: TapFanout,
        cameras: ClientCameras,
        assets: RobotAssets,
        clock: Clock,
    ) -> None:
        """Speak over ``socket`` for ``connection``.

        Args:
            socket: is accepted.
            connection: asks the hub for it.
            taps: where raw topics come from.
            cameras: where pictures come from.
            assets: where files of robots come from.
            clock: whose time is told.

        """
        self._socket = socket
        self._connection = connection
        self._site = connection.live.name
        self._things = AdvertisedThings()
        self._tapped = TappedChannels(
            taps,
            self._site,
            connection.who.grants,
            changed=self._advertise_things,
            graph_changed=self._send_graph,
            deliver=self._deliver_topic,
            warn=self.warn_person,
        )
        self._cameras = CameraChannels(
            cameras,
            subscription_of=self._things.subscription_of,
            send=socket.send_bytes,
            warn=self.warn_person,
        )
        grants, site = connection.who.grants, self._site
        self._assets = AssetRequests(assets, site, grants, send=socket.send_bytes)
        self._clock = clock
        # By the robot's own name: the name of the channel.
        self._channel_of: dict[str, str] = {}
        # One offer is told whole before the next.
        self._advertising = asyncio.Lock()
        self._signals = SignalChannels(self._site, wants=self._things.has_subscription)
        self._published = PublishedChannels(connection, send_status=self._send_status, clock=clock)
        self._parameters = ParameterRequests(
            connection, send=self._send_json, warn=self._send_status, clock=clock
        )
        # By the command's or STOP's id.
        self._calls: dict[str, _WaitingCall] = {}
        # As it was told last; None while the client does not want it.
        self._graph: ClientGraph | None = None
        # Of the description that is advertised.
        self._edition = ""

    # ── from the client ──

    async def read_client(self) -> None:
        """Say who we are and what there is, then read until the client has gone."""
        await self._send_json(
            ServerInfo(
                name=f"Talaia {__version__}: {self._connection.description.name}",
                capabilities=[*_CAPABILITIES, *self._assets.capabilities],
                supported_encodings=_ENCODINGS,
                metadata={"site": self._site},
                session_id=new_token(),
            )
        )
        await self._advertise_things()
        try:
            for result in await until_first(
                self._read_frames(),
                self._tapped.serve_topics(),
                self._assets.serve_requests(),
                self._send_time(),
                self._parameters.serve_updates(),
            ):
                if isinstance(result, Exception):
                    raise result
        finally:
            # Whatever ended it: a topic that nobody takes is to rest on the robot.
            self._tapped.end_taps()
            self._cameras.end_views()

    async def _read_frames(self) -> None:
        while True:
            # Silence is no fault: a client that only listens says nothing for days.
            event = await self._socket.receive()
            if event["type"] == "websocket.disconnect":
                return
            data = event.get("bytes")
            try:
                message = decode_client(event.get("text", "") if data is None else data)
            except UnknownKind as error:
                await self._send_status(_WARNING, str(error))
                continue
            await self._handle_message(message)

    async def _handle_message(self, message: said.FoxgloveMessage) -> None:
        match message:
            case said.FoxgloveSubscribe():
                await self._subscribe_topics(message)
            case said.FoxgloveUnsubscribe():
                self._unsubscribe_topics(message)
            case said.FoxgloveAdvertise():
                await self._published.add_channels(message, self._things.offer)
            case said.FoxgloveUnadvertise():
                self._published.remove_channels(message)
            case said.FoxglovePublish():
                await self._published.publish_message(message, self._things.offer)
            case said.FoxgloveCall():
                await self._call_service(message)
            case said.FoxgloveGetParameters():
                await self._parameters.send_values(message.parameter_names, message.id)
            case said.FoxgloveSetParameters():
                await self._parameters.set_values(message)
            case said.FoxgloveSubscribeParameters():
                await self._parameters.subscribe(message.parameter_names)
            case said.FoxgloveUnsubscribeParameters():
                self._parameters.unsubscribe(message.parameter_names)
            case said.FoxgloveSubscribeGraph():
                self._graph = ClientGraph()
                self._tapped.follow_graph(wanted=True)
                await self._send_graph()
            case said.FoxgloveUnsubscribeGraph():
                self._graph = None
                self._tapped.follow_graph(wanted=False)
            case said.FoxgloveFetchAsset():
                await self._assets.fetch_asset(message)
            case said.FoxglovePlayback():
                await self._send_status(_WARNING, _LIVE)

    async def _send_time(self) -> None:
        while True:
            await self._socket.send_bytes(encode_time(self._clock.wall_ns()))
            await asyncio.sleep(_TIME_EVERY_S)

    async def _subscribe_topics(self, message: said.FoxgloveSubscribe) -> None:
        topics = []
        # What is wrong with one is no reason to refuse the others.
        for one in message.subscriptions:
            try:
                topics.append(self._things.subscribe_topic(one.id, one.channel_id))
            except ValueError as error:
                await self._send_status(_WARNING, str(error))
        # Signals go by the outbox of all connections; raw topics and pictures by their own.
        for topic in topics:
            offered = self._things.offer.topics.get(topic)
            if offered is not None and (why := self._tapped.subscribe_topic(offered.topic)):
                await self._send_status(_WARNING, why)
            camera = self._things.offer.cameras.get(topic)
            if camera is not None:
                self._cameras.subscribe_topic(topic, camera)
        for asked in self._signals.add_topics(topics):
            if (problem := self._connection.request(asked)) is not None:
                await self._send_status(_WARNING, problem.message)

    def _unsubscribe_topics(self, message: said.FoxgloveUnsubscribe) -> None:
        ended = (self._things.unsubscribe_topic(number) for number in message.subscription_ids)
        self._forget_topics([topic for topic in ended if topic is not None])

    def _forget_topics(self, topics: list[str]) -> None:
        for topic in topics:
            self._cameras.unsubscribe_topic(topic)
            for raw, channel in self._channel_of.items():
                if channel == topic:
                    self._tapped.unsubscribe_topic(raw)
        for asked in self._signals.remove_topics(topics):
            self._connection.request(asked)

    async def _call_service(self, message: said.FoxgloveCall) -> None:
        service = self._things.service(message.service_id)
        if service is None:
            why = f"there is no service {message.service_id}"
        elif len(self._calls) >= _MOST_CALLS:
            why = f"at most {_MOST_CALLS} calls at once"
        elif not service.command and service.robot is None:
            press, why = self._connection.press_stop(service.device)
            if not why:
                self._calls[press] = _WaitingCall(message.service_id, message.call_id)
        else:
            why = self._request_command(service, message)
        if why:
            await self._send_json(_call_failure(message.service_id, message.call_id, why))

    def _request_command(self, service: ServiceEntry, message: said.FoxgloveCall) -> str:
        call = _read_call(service, message)
        if isinstance(call, str):
            return call
        number = new_token()
        # Before it is asked: its end may come at once.
        waiting = _WaitingCall(message.service_id, message.call_id, service.robot is not None)
        self._calls[number] = waiting
        # Rights, arguments and units are looked at there and at the gateway.
        problem = self._connection.request(
            PageCommand(
                site=self._site,
                device=call.device,
                command=call.command,
                id=number,
                args=call.args,
            )
        )
        if problem is None:
            return ""
        del self._calls[number]
        return problem.message

    # ── to the client ──

    async def deliver_message(self, message: ToBrowser) -> None:
        """Write a message of the hub in the client's protocol, if it has one for it."""
        match message:
            case Values():
                await self._deliver_values(message)
            case SiteUpdate() if message.site == self._site:
                # The description is another one: what is there, and who sees it.
                if message.catalogue != self._edition:
                    await self._advertise_things()
            case CommandUpdate() if message.id in self._calls:
                if message.phase not in _GOING_ON:
                    await self._end_call(message)
            case CommandUpdate():
                if not await self._parameters.follow_command(message):
                    await self._published.follow_command(message)
            case StopUpdate() if message.id in self._calls and message.latched:
                await self._send_answer(message.id, "STOP is on")
            case RequestError():
                await self._send_status(_WARNING, message.message)
            case SessionEnded():
                await self._send_status(_ERROR, message.reason)
            case _:
                pass

    async def warn_person(self, text: str) -> None:
        """Show a warning in the client."""
        await self._send_status(_WARNING, text)

    async def close_client(self, code: int) -> None:
        """Close the socket."""
        await self._socket.close(code)

    async def _advertise_things(self) -> None:
        """Tell what there is now, and what is not there any more."""
        async with self._advertising:
            await self._advertise_now()

    async def _advertise_now(self) -> None:
        live = self._connection.live
        self._edition = live.edition
        offer = make_foxglove_offer(
            live.description, self._connection.who.grants, self._tapped.offered
        )
        change = self._things.update_offer(offer)
        # By the addresses of before.
        self._forget_topics(change.gone)
        self._signals.update_offer(offer)
        self._parameters.update_offer(offer)
        self._channel_of = {offered.topic: name for name, offered in offer.topics.items()}
        for message in change.messages:
            await self._send_json(message)
        await self._send_graph()

    async def _send_graph(self) -> None:
        """Tell who publishes, listens to and provides what, if that is wanted and is news."""
        if self._graph is not None:
            offer = self._things.offer
            if update := self._graph.update(offer, self._tapped.robot_graph(robot_services(offer))):
                await self._send_json(update)

    async def _deliver_topic(self, message: TappedMessage) -> None:
        channel = self._channel_of.get(message.topic, "")
        subscription = self._things.subscription_of(channel)
        if subscription is not None:
            time_ns = message.log_us * 1000
            await self._socket.send_bytes(encode_message_data(subscription, time_ns, message.data))

    async def _deliver_values(self, values: Values) -> None:
        for message in self._signals.read_messages(values):
            # It may have ended while another message was sent.
            subscription = self._things.subscription_of(message.topic)
            if subscription is not None:
                time_ns = message.time_us * 1000
                await self._socket.send_bytes(
                    encode_message_data(subscription, time_ns, message.data)
                )

    async def _end_call(self, message: CommandUpdate) -> None:
        if message.phase is CommandPhase.SUCCEEDED:
            await self._send_answer(message.id, message.message)
        else:
            said_why = f"{message.phase.value}: {message.message}"
            ended = self._calls.pop(message.id)
            await self._send_json(_call_failure(ended.service, ended.call, said_why))

    async def _send_answer(self, number: str, text: str) -> None:
        # Once: what comes of it later is told to pages.
        ended = self._calls.pop(number)
        if ended.robot:
            answer = msgspec.json.encode({"success": True, "message": text})
        else:
            answer = encode_answer(CommandPhase.SUCCEEDED.value, text)
        response = encode_service_response(ended.service, ended.call, "json", answer)
        await self._socket.send_bytes(response)

    async def _send_status(self, level: int, text: str) -> None:
        await self._send_json(ServerStatus(level=level, message=text))

    async def _send_json(self, message: ServerMessage) -> None:
        await self._socket.send_text(encode_server(message))


def _read_call(service: ServiceEntry, message: said.FoxgloveCall) -> RobotCall | str:
    """Give the command that is asked for, or say what is wrong with its arguments."""
    # CDR would need a type that the robot's request has and our commands have not.
    if message.encoding != "json":
        return f"arguments are read as json, not as {message.encoding[:100]!r}"
    try:
        if service.robot is not None:
            return service.robot.find_command(read_fields(message.data))
        args = msgspec.json.decode(message.data or b"{}", type=Arguments)
    except (ValueError, RecursionError) as error:
        return f"not the arguments of a command: {str(error)[:200]}"
    return RobotCall(service.device, service.command, args)


def _call_failure(service: int, call: int, why: str) -> ServiceCallFailure:
    # Clients show the reason beside the call.
    return ServiceCallFailure(service_id=service, call_id=call, message=why)
