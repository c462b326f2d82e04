"""The services of ``/rosapi``, by which clients ask what there is, for one account."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.clock import SECOND
from talaia.hub.clients.robot_parameters import read_parameters
from talaia.hub.clients.rosbridge.node_names import NODE_QUESTIONS, NodeNames
from talaia.hub.clients.rosbridge.offer import RosbridgeOffer, full_type
from talaia.hub.clients.rosbridge.ros_types import describe_fields, describe_type
from talaia.hub.errors import TapRefused
from talaia.hub.live.taps.type_texts import MessageUnreadable, TypeText

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.clock import Clock
    from talaia.hub.auth.permissions import Grants
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.live.taps.tap_fanout import TapFanout
    from talaia.wire.frames import RobotGraph

__all__ = ["ROSAPI", "NoSuchThing", "RosGraph", "Rosapi"]

ROSAPI = "/rosapi/"
# Topics whose definitions are given at once.
_MOST_TEXTS = 200
_ANSWER_FIELDS = [("success", "bool"), ("message", "string")]


class NoSuchThing(Exception):
    """What was asked for is not there, or not for this account; a sentence for people."""


class RosGraph(NamedTuple):
    """Topics with their types, the offer beside them, and which of them may be tapped."""

    topics: dict[str, str]
    offer: RosbridgeOffer
    tapped: frozenset[str]


class Rosapi:
    """Answers one account at one site."""

    def __init__(self, live: LiveSite, grants: Grants, *, taps: TapFanout, clock: Clock) -> None:
        """List raw topics by ``taps``, as far as ``grants`` go."""
        self._live = live
        self._site = live.name
        self._grants = grants
        self._taps = taps
        self._clock = clock

    def current_graph(self, offer: RosbridgeOffer) -> RosGraph:
        """Give all topics that may be subscribed to, or published to, now."""
        driven = {topic: driven.type for topic, driven in offer.driven.items()}
        listened = {topic: robot.type for topic, robot in offer.listened.items()}
        tapped = {entry.topic: entry.type for entry in self._taps.topics(self._site, self._grants)}
        signals = {topic: signal.type for topic, signal in offer.signals.items()}
        return RosGraph({**driven, **listened, **tapped, **signals}, offer, frozenset(tapped))

    async def answer_call(
        self, service: str, args: Mapping[str, object], offer: RosbridgeOffer
    ) -> dict[str, object]:
        """Answer a call; ``service`` stands without ``/rosapi/``.

        Raises:
            NoSuchThing: there is no such service, or not what was asked about.

        """
        graph = self.current_graph(offer)
        name = str(next(iter(args.values()), ""))[:500]
        match service:
            case "get_time":
                seconds, rest = divmod(self._clock.wall_ns(), SECOND)
                # As ROS 1 and ROS 2 call them.
                both = {"sec": seconds, "nanosec": rest, "secs": seconds, "nsecs": rest}
                return {"time": both}
            case "get_ros_version":
                # Messages are as ROS 2 has them, whatever the robot speaks.
                return {"version": 2, "distro": (await self._robot_graph(offer)).distro}
            case "message_details":
                return {"typedefs": await self._describe_message(full_type(name), graph)}
            case "service_request_details" | "service_response_details":
                return {"typedefs": _service_details(service, name, offer)}
            case "topics_and_raw_types":
                return await self._raw_types(graph)
            case "delete_param":
                raise NoSuchThing("parameters cannot be deleted here")
            case "get_param_names":
                return {"names": [*offer.parameters, *offer.robot_parameters.listed(":")]}
            case "has_param":
                robots = offer.robot_parameters.find(name)
                return {"exists": name in offer.parameters or robots is not None}
            case "get_param":
                return self._read_parameter(name, args, offer)
            case _ if service in NODE_QUESTIONS:
                names = NodeNames(graph.topics, graph.tapped, offer, await self._robot_graph(offer))
                return names.answer_question(service, name)
            case _:
                return _answer_lookup(service, name, graph)

    async def _robot_graph(self, offer: RosbridgeOffer) -> RobotGraph:
        services = {name for name, of in offer.services.items() if of.robot is not None}
        return await self._taps.ask_graph(self._site, self._grants, services)

    async def _describe_message(self, kind: str, graph: RosGraph) -> list[dict[str, object]]:
        topic = next((topic for topic, of in graph.topics.items() if of == kind), None)
        try:
            if topic is None or topic not in graph.tapped:
                return describe_type(kind)
            schema = await self._taps.schema(self._site, topic, self._grants)
            text = TypeText(schema.type, schema.encoding, schema.definition)
            return describe_type(kind, text)
        except (MessageUnreadable, TapRefused) as error:
            raise NoSuchThing(str(error)) from error

    async def _raw_types(self, graph: RosGraph) -> dict[str, object]:
        topics = list(graph.topics)
        texts = await asyncio.gather(*map(self._text_of, topics[:_MOST_TEXTS]))
        return {
            "topics": topics,
            "types": [graph.topics[topic] for topic in topics],
            "typedefs_full_text": [*texts, *[""] * (len(topics) - len(texts))],
        }

    def _read_parameter(
        self, name: str, args: Mapping[str, object], offer: RosbridgeOffer
    ) -> dict[str, object]:
        value: object = offer.parameters.get(name)
        found = offer.robot_parameters.find(name)
        if value is None and found is not None:
            now_ns = self._clock.monotonic_ns()
            value = read_parameters(self._live, {name: found}, now_ns).get(name)
        why = ""
        if value is None:
            value = args.get("default_value", args.get("default", ""))
            why = "its value is not known now" if found else f"there is no parameter {name}"
        # Values are JSON in a text. The rest is ROS 2's; who knows it not gets the default.
        said = msgspec.json.encode(value).decode()
        return {"value": said, "successful": not why, "reason": why}

    async def _text_of(self, topic: str) -> str:
        try:
            return (await self._taps.schema(self._site, topic, self._grants)).definition
        except TapRefused:
            # Of a type that comes with ROS: whoever asks has it.
            return ""


def _answer_lookup(service: str, name: str, graph: RosGraph) -> dict[str, object]:
    """Answer what is only looked up."""
    topics, offer = graph.topics, graph.offer
    services = offer.services
    match service:
        case "topics":
            return {"topics": list(topics), "types": list(topics.values())}
        case "topics_for_type":
            return {"topics": [topic for topic, of in topics.items() if of == full_type(name)]}
        case "topic_type":
            return {"type": topics.get(name, "")}
        case "services":
            return {"services": list(services)}
        case "services_for_type":
            return {"services": [said for said, of in services.items() if of.type == name]}
        case "service_type":
            return {"type": services[name].type if name in services else ""}
        case "action_servers":
            return {"action_servers": [said for said, of in services.items() if of.action]}
        case _:
            raise NoSuchThing(f"there is no service {ROSAPI + service[:200]!r}")


def _service_details(service: str, kind: str, offer: RosbridgeOffer) -> list[dict[str, object]]:
    found = next((of for of in offer.services.values() if kind in {of.type, of.action_type}), None)
    if found is None:
        raise NoSuchThing(f"the type {kind[:200]!r} is not known")
    if service == "service_request_details":
        return describe_fields(f"{kind}_Request", list(found.fields))
    return describe_fields(f"{kind}_Response", _ANSWER_FIELDS)
