"""Looks at a robot behind a rosbridge server: topics with fields and rates, services, actions.

It listens, and asks rosapi what only reads. Pictures and clouds are not listened to: they would
cost the robot more than the look is worth.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from typing import TYPE_CHECKING

import msgspec
from websockets.exceptions import ConnectionClosed, WebSocketException

from talaia.gateway.adapters.message_fields import ReadableFields, shape_of
from talaia.gateway.adapters.named_sensors import NAMED_TYPES, names_in
from talaia.gateway.adapters.ros2.message_types import DefinedParts
from talaia.gateway.adapters.ros2.type_definitions.message_definition import BadDefinition
from talaia.gateway.adapters.rosbridge.credentials import read_credentials
from talaia.gateway.adapters.rosbridge.message_values import MessageSerializer
from talaia.gateway.adapters.rosbridge.probed_requests import ProbedRequests
from talaia.gateway.adapters.rosbridge.protocol import read_message, type_for, write_frame
from talaia.gateway.adapters.rosbridge.robot_definitions import find_definition
from talaia.gateway.adapters.rosbridge.server_connection import dial_server
from talaia.gateway.adapters.rosbridge.server_graph import TOPICS_SERVICE, read_nodes, read_topics
from talaia.gateway.adapters.rosbridge.server_questions import ServerQuestions, texts_of
from talaia.gateway.adapters.rosbridge.server_types import RAW_TYPES_SERVICE, long_name
from talaia.gateway.errors import AdapterLost, FieldError, SettingsError
from talaia.model.connection import RosbridgeConnection
from talaia.model.discovery.probe_report import TopicFound

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from websockets.asyncio.client import ClientConnection

    from talaia.gateway.tap_ports import GraphNode, ListedTopic
    from talaia.model.discovery.probe_report import Found

__all__ = ["probe_bridge"]

_MAX_FRAME = 16 * 1024 * 1024
# What carries ROS itself, and what the server publishes of itself.
_PLUMBING = frozenset(
    ("/rosout", "/rosout_agg", "/clock", "/statistics", "/diagnostics_agg", "/parameter_events")
) | {"/client_count", "/connected_clients"}
# Messages that are large: their fields are known without one, and nobody needs their rate.
_LARGE = frozenset(
    f"{package}/msg/{name}"
    for package, name in (
        ("sensor_msgs", "Image"),
        ("sensor_msgs", "CompressedImage"),
        ("sensor_msgs", "PointCloud2"),
        ("sensor_msgs", "PointCloud"),
        ("nav_msgs", "OccupancyGrid"),
        ("visualization_msgs", "MarkerArray"),
    )
)
# Of ROS 1's actions, which are topics there; see `RosbridgeRules`, which has no actions of ROS 1.
_STATUS = "actionlib_msgs/msg/GoalStatusArray"
_ACTION_PARTS = ("goal", "cancel", "status", "feedback", "result")
_MOST_NAMES = 500


class _Heard:
    """A topic that is listened to: how many came, when, and the last one."""

    def __init__(self, type_name: str) -> None:
        self._named = type_name in NAMED_TYPES
        self._type_name = type_name
        self._count = 0
        self._first = self._last = 0.0
        self.message: object = None
        self.names: set[str] = set()

    def count_message(self, message: object) -> None:
        # By our clock: most messages have no stamp, and a stamp may be wrong.
        self._last = time.monotonic()
        self._first = self._first or self._last
        self._count += 1
        self.message = message
        # Each message of such a topic may be another sensor's, so that one is not enough.
        if self._named and len(self.names) < _MOST_NAMES:
            with contextlib.suppress(FieldError):
                self.names |= set(names_in(message, self._type_name))

    def rate(self) -> float:
        """Give messages a second, by their spacing; 0 where that is not known."""
        if self._count > 1 and self._last > self._first:
            return round((self._count - 1) / (self._last - self._first), 2)
        return 0.0


def probe_bridge(asked: Found, folder: Path) -> Found:
    """Ask a server what there is, listen for ``asked.seconds`` (s) and tell it.

    Args:
        asked: where, and by what token; what was found is added to it.
        folder: that its files are named from.

    Raises:
        AdapterLost: no server answers, or it has no rosapi.

    """
    settings = RosbridgeConnection(url=asked.url, ca=asked.ca, token_file=asked.token_file)
    try:
        headers, tls = read_credentials(settings, folder)
    except SettingsError as error:
        raise AdapterLost(str(error)) from error

    async def visit_server() -> Found:
        async with dial_server(asked.url, headers, tls, max_size=_MAX_FRAME) as socket:
            return await _Look(socket, asked).find_all()

    try:
        return asyncio.run(visit_server())
    except (OSError, TimeoutError, WebSocketException, ConnectionClosed) as error:
        why = str(error) or type(error).__name__
        raise AdapterLost(f"no rosbridge server answers at {asked.url} ({why})") from error


class _Look:
    """One look at a server."""

    def __init__(self, socket: ClientConnection, asked: Found) -> None:
        self._socket = socket
        self._asked = asked
        self._questions = ServerQuestions(socket)
        self._heard: dict[str, _Heard] = {}
        self._texts: dict[str, str] = {}
        self._nodes: list[GraphNode] = []
        self._ros = 2

    async def find_all(self) -> Found:
        reading = asyncio.ensure_future(self._read_frames())
        looking = asyncio.ensure_future(self._ask_and_listen())
        try:
            await asyncio.wait([reading, looking], return_when=asyncio.FIRST_COMPLETED)
            # Whoever reads ends first only where the connection has.
            if not looking.done():
                reading.result()
                raise AdapterLost(f"the rosbridge server at {self._asked.url} hung up")
            return looking.result()
        finally:
            for part in (reading, looking):
                part.cancel()
            await asyncio.gather(reading, looking, return_exceptions=True)

    async def _read_frames(self) -> None:
        async for data in self._socket:
            try:
                said = read_message(data)
            except FieldError:
                # One frame that is none says nothing of the others.
                continue
            heard = self._heard.get(said.topic) if said.op == "publish" else None
            if heard is not None:
                heard.count_message(said.body)
            else:
                self._questions.take_answer(said)

    async def _ask_and_listen(self) -> Found:
        topics = await read_topics(self._questions)
        if isinstance(topics, str):
            raise AdapterLost(
                f"the rosbridge server at {self._asked.url} does not say what there is: "
                f"{TOPICS_SERVICE}: {topics}. Start rosapi beside it"
            )
        self._ros = await self._find_version()
        # All definitions in one answer: the server reads its files once.
        answer = await self._questions.ask_service(RAW_TYPES_SERVICE)
        types = [long_name(name) for name in texts_of(answer, "types")]
        self._texts = dict(zip(types, texts_of(answer, "typedefs_full_text"), strict=False))
        self._nodes = await read_nodes(self._questions) or []
        listed = {name: topic for name, topic in topics.items() if name not in _PLUMBING}
        await self._listen(listed)
        requests = ProbedRequests(self._questions, self._ros)
        services = await requests.find_services()
        # A description of ROS 1 behind a server has no actions.
        actions = await requests.find_actions() if self._ros == 2 else ()
        return msgspec.structs.replace(
            self._asked,
            where=f"ROS {self._ros}, rosbridge server {self._asked.url}",
            ros=self._ros,
            topics=tuple(self._describe_topics(listed)),
            services=services,
            actions=actions,
        )

    async def _find_version(self) -> int:
        answer = await self._questions.ask_service("/rosapi/get_ros_version")
        version = getattr(answer, "version", None)
        if version in (1, 2):
            return int(version)
        # Servers of ROS 1 often cannot say it, but write types in two parts.
        said = await self._questions.ask_service("/rosapi/topic_type", topic="/rosout")
        return 1 if getattr(said, "type", "").count("/") == 1 else 2

    async def _listen(self, listed: dict[str, ListedTopic]) -> None:
        for topic, found in listed.items():
            if self._counts(topic)[0] and found.type_name not in _LARGE:
                self._heard[topic] = _Heard(found.type_name)
                await self._send_topic_frame(
                    "subscribe", topic, type=type_for(found.type_name, self._ros)
                )
        # What comes is counted by who reads meanwhile.
        await asyncio.sleep(self._asked.seconds)
        for topic in self._heard:
            await self._send_topic_frame("unsubscribe", topic)

    async def _send_topic_frame(self, op: str, topic: str, **more: str) -> None:
        await self._socket.send(write_frame(op, id=f"probe {topic}", topic=topic, **more))

    def _counts(self, topic: str) -> tuple[int, int]:
        """Count who publishes a topic and who listens, without the server."""
        if not self._nodes:
            # Where nodes are not told, all that is listed may be published.
            return 1, 0
        others = [node for node in self._nodes if not _is_server(node)]
        return (
            sum(topic in node.publishes for node in others),
            sum(topic in node.subscribes for node in others),
        )

    # ── telling ──

    def _describe_topics(self, listed: dict[str, ListedTopic]) -> Iterator[TopicFound]:
        actions = {
            topic.removesuffix("/status")
            for topic, found in listed.items()
            if found.type_name == _STATUS
        }
        # They make sense only together, and nobody reads one as a signal.
        parts = {f"{name}/{part}" for name in actions for part in _ACTION_PARTS}
        for topic, found in sorted(listed.items()):
            publishers, subscribers = self._counts(topic)
            if topic in parts or not (publishers or subscribers):
                continue
            heard = self._heard.get(topic)
            shape, problem = self._read_fields(found.type_name, heard)
            yield TopicFound(
                topic=topic,
                type=found.type_name,
                publishers=publishers,
                subscribers=subscribers,
                rate=heard.rate() if heard is not None else 0.0,
                latched=found.latched,
                fields=shape.fields,
                names=tuple(sorted(heard.names)) if heard is not None else (),
                left_out=shape.left_out,
                stamped=shape.stamped,
                problem=problem,
            )

    def _read_fields(self, type_name: str, heard: _Heard | None) -> tuple[ReadableFields, str]:
        try:
            _, definition = find_definition(type_name, self._texts.get(type_name, ""), self._ros)
        except BadDefinition as error:
            return ReadableFields((), ()), str(error)
        # Read as bytes would be: so lists have their length, also those that came as base64.
        message, problem = None, ""
        if heard is not None and heard.message is not None:
            try:
                message = MessageSerializer(definition, self._ros).build_message(heard.message)
            except (FieldError, BadDefinition) as error:
                problem = f"a message that came is not a {type_name}: {error}"
        parts = DefinedParts(definition)
        return shape_of(
            kind=parts.kind_of_part(type_name),
            type_name=type_name.replace("/msg/", "/"),
            find=parts.kind_named,
            message=message,
            comment_of=parts.comment_of,
        ), problem


def _is_server(node: GraphNode) -> bool:
    """Tell the server and its rosapi from the robot's own nodes."""
    return "/connected_clients" in node.publishes or TOPICS_SERVICE in node.serves
