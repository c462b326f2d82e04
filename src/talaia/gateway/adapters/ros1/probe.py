"""Looks at a live ROS 1 graph: topics with their fields and rates, services, actions.

Listens only: it publishes nothing and calls nothing. Topics are heard raw through the adapter's
own process of the machine's Python; a service is asked for its type by the header that is
exchanged before any call. What a message holds is read from the definition that its publisher
sends with it, so that no package of the robot's is needed; a topic that is silent is asked of its
publisher, by the header before any message. Of a request only the packages of this machine can
tell. Parameters are read from the master.

Long, because listening and telling are two sides of what was heard.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import time
from typing import TYPE_CHECKING, Any

import msgspec

from talaia.gateway.adapters.message_fields import ReadableFields, shape_of
from talaia.gateway.adapters.named_sensors import NAMED_TYPES, names_in
from talaia.gateway.adapters.ros1.decode import decoder_of, full_name
from talaia.gateway.adapters.ros1.frames import ReceivedMessage
from talaia.gateway.adapters.ros1.master import RosMaster
from talaia.gateway.adapters.ros1.message_types import definition_of
from talaia.gateway.adapters.ros1.node import NodeProcess
from talaia.gateway.adapters.ros1.probed_parameters import find_parameters
from talaia.gateway.adapters.ros1.publications import ask_publisher
from talaia.gateway.errors import AdapterLost, FieldError
from talaia.model.connection import Ros1Connection
from talaia.model.discovery.probe_report import (
    FORMAT,
    ActionFound,
    FieldFound,
    Found,
    ServiceFound,
    TopicFound,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from talaia.gateway.adapters.ros1.frames import ReceivedFrame
    from talaia.gateway.adapters.ros1.master import GraphState

__all__ = ["DEFAULT_MASTER", "probe_graph"]

DEFAULT_MASTER = "http://localhost:11311"
PLUMBING = {"/rosout", "/rosout_agg", "/clock", "/statistics", "/diagnostics_agg"}
# What every node has.
PLUMBING_SERVICES = ("/get_loggers", "/set_logger_level")
ACTION_PARTS = ("goal", "cancel", "status", "feedback", "result")
STATUS = "actionlib_msgs/GoalStatusArray"
LOOK_AGAIN_S = 0.5
START_S = 15.0
DESCRIBE_S = 10.0
DEPTH = 50


class _Heard:
    """A topic that is listened to: how many came, when, the last one, and what they are."""

    def __init__(self, topic: str) -> None:
        self.topic = topic
        self.type = self.definition = self.problem = ""
        self.count = 0
        self.first_us = self.last_us = 0
        self.raw = b""
        self.names: dict[str, None] = {}
        self._decode: Callable[[bytes], object] | None = None
        self._latchings: set[bool] = set()

    @property
    def latched(self) -> bool:
        """Whether all publishers that were heard or asked keep their last message."""
        return self._latchings == {True}

    def learn_definition(self, type_name: str, definition: str, *, latched: bool) -> None:
        """Take what a publisher says its messages are."""
        self._latchings.add(latched)
        self.type, self.definition = type_name, definition
        try:
            self._decode = decoder_of(full_name(type_name), definition)
        except FieldError as error:
            self.problem = str(error)

    def count_message(self, heard: ReceivedMessage) -> None:
        self.first_us = self.first_us or heard.time_us
        self.last_us = heard.time_us
        self.count += 1
        self.raw = heard.raw
        kind = full_name(self.type) if self.type else ""
        if kind in NAMED_TYPES and len(self.names) < 500:
            with contextlib.suppress(FieldError):
                self.names |= dict.fromkeys(names_in(self.decode_message(), kind))

    def decode_message(self) -> object:
        """Decode the last message; none where none came.

        Raises:
            FieldError: it is not of its type.

        """
        return self._decode(self.raw) if self._decode is not None and self.count else None

    def message_rate(self) -> float:
        """Give messages a second, by their spacing; 0 where that is not known."""
        if self.count > 1 and self.last_us > self.first_us:
            return (self.count - 1) * 1e6 / (self.last_us - self.first_us)
        return 0.0


def probe_graph(uri: str, seconds: float, python: str = Ros1Connection().python) -> Found:
    """Join the graph, listen for so many seconds (s) and tell what is there.

    Args:
        uri: of the master.
        seconds: how long.
        python: the interpreter that has rospy.

    Raises:
        AdapterLost: no master answers, or there is no rospy.

    """
    return asyncio.run(_Look(RosMaster(uri), seconds, python).find_all())


class _Look:
    """One look at the graph."""

    def __init__(self, master: RosMaster, seconds: float, python: str) -> None:
        self._master, self._seconds = master, seconds
        self._settings = Ros1Connection(node=f"talaia_probe_{os.getpid()}", python=python)
        self._heard: list[_Heard] = []
        self._described: dict[tuple[str, str], str | None] = {}
        self._asked: set[tuple[str, str]] = set()
        # Set by the node's thread through the loop: something has changed.
        self._changed = asyncio.Event()
        self._name = self._ended = ""

    async def find_all(self) -> Found:
        loop = asyncio.get_running_loop()
        await loop.run_in_executor(None, self._master.check_master)

        def fail(why: str) -> None:
            self._ended = self._ended or why
            loop.call_soon_threadsafe(self._changed.set)

        def hear(frame: ReceivedFrame) -> None:
            if isinstance(frame, ReceivedMessage):
                self._heard[frame.topic].count_message(frame)
            elif isinstance(frame, dict):
                self._handle_message(frame)
                loop.call_soon_threadsafe(self._changed.set)

        node = NodeProcess(
            settings=self._settings,
            uri=self._master.uri,
            heard=hear,
            turned=lambda: None,
            failed=fail,
        )
        try:
            node.send_frame(node=self._settings.node, namespace="/")
            await self._wait_until(lambda: bool(self._name), START_S)
            if not self._name:
                raise AdapterLost("ROS 1 cannot be joined: its node does not begin")
            await self._listen_topics(node)
            system = await loop.run_in_executor(None, self._master.read_graph)
            await self._ask_silent(system)
            types = await loop.run_in_executor(None, self._master.read_types)
            sim_time = await loop.run_in_executor(
                None, self._master.read_parameter, "/use_sim_time"
            )
            kinds = {
                name: await loop.run_in_executor(None, self._master.service_type, name)
                for name in sorted(system.services)
                if not name.endswith(PLUMBING_SERVICES)
            }
            for heard in self._heard:
                types[heard.topic] = heard.type or types.get(heard.topic, "")
            nodes = await loop.run_in_executor(None, find_parameters, self._master, system)
            await self._describe(node, types, kinds)
        finally:
            node.hang_up()
            await loop.run_in_executor(None, node.wait_ended)
        found = self._describe_found(system, types, kinds)
        return msgspec.structs.replace(found, nodes=nodes, sim_time=sim_time == (True, True))

    async def _wait_until(self, holds: Callable[[], bool], seconds: float) -> None:
        """Wait until it holds, or so long (s).

        Raises:
            AdapterLost: the node has ended.

        """
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                while not holds() and not self._ended:
                    self._changed.clear()
                    await self._changed.wait()
        if self._ended:
            raise AdapterLost(f"ROS 1 cannot be joined: {self._ended}")

    # ── on the node's thread ──

    def _handle_message(self, said: dict[str, Any]) -> None:
        match said["op"]:
            case "ready":
                self._name = said["node"]
            case "type":
                heard = self._heard[said["topic"]]
                heard.learn_definition(said["type"], said["definition"], latched=said["latched"])
            case "described":
                self._described[said["what"], said["type"]] = said["definition"]
            case _:
                return

    # ── listening ──

    async def _listen_topics(self, node: NodeProcess) -> None:
        loop = asyncio.get_running_loop()
        until = time.monotonic() + self._seconds
        known: set[str] = set()
        while (left := until - time.monotonic()) > 0:
            system = await loop.run_in_executor(None, self._master.read_graph)
            for topic in sorted(system.published.keys() - known - PLUMBING):
                known.add(topic)
                self._heard.append(_Heard(topic))
                number = len(self._heard) - 1
                node.send_frame(op="listen", topic=number, name=topic, rate=0.0, deep=DEPTH)
            await self._wait_until(lambda: False, min(LOOK_AGAIN_S, left))

    async def _ask_silent(self, system: GraphState) -> None:
        """Ask the publishers of topics of which nothing came."""
        asked = [
            (heard, node)
            for heard in self._heard
            if not heard.type
            for node in sorted(system.published.get(heard.topic, ()))
        ]

        async def ask(heard: _Heard, node: str) -> None:
            try:
                told = await asyncio.to_thread(ask_publisher, self._master, node, heard.topic)
            except AdapterLost:
                # Whoever asks the master next says so.
                return
            if told is not None and told.definition:
                heard.learn_definition(told.type, told.definition, latched=told.latched)

        # Some nodes that the master knows may be gone, and their computers do not answer.
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(DESCRIBE_S), asyncio.TaskGroup() as group:
                for heard, node in asked:
                    group.create_task(ask(heard, node))

    async def _describe(
        self, node: NodeProcess, types: dict[str, str], kinds: dict[str, str]
    ) -> None:
        """Ask this machine's packages for what nobody has told yet."""
        silent = {types[topic.topic] for topic in self._heard if not topic.type}
        goals = {_goal_type(types.get(f"{name}/goal", "")) for name in _find_actions(types)}
        for what, wanted in (("msg", silent | goals), ("srv", set(kinds.values()))):
            for name in sorted(type_name for type_name in wanted if "/" in type_name):
                self._asked.add((what, name))
                node.send_frame(op="describe", what=what, type=name)
        await self._wait_until(lambda: self._asked <= self._described.keys(), DESCRIBE_S)

    # ── telling ──

    def _describe_found(
        self, system: GraphState, types: dict[str, str], kinds: dict[str, str]
    ) -> Found:
        actions = _find_actions(types)
        parts = {f"{name}/{part}" for name in actions for part in ACTION_PARTS}
        return Found(
            talaia_probe=FORMAT,
            protocol="ros1",
            where=f"ROS 1, master {self._master.uri}",
            seconds=self._seconds,
            master=self._master.uri,
            topics=tuple(self._describe_topics(system, types, parts)),
            services=tuple(self._describe_service(name, kind) for name, kind in kinds.items()),
            actions=tuple(self._describe_action(name, types[f"{name}/goal"]) for name in actions),
        )

    def _describe_topics(
        self, system: GraphState, types: dict[str, str], parts: set[str]
    ) -> Iterator[TopicFound]:
        heard = {topic.topic: topic for topic in self._heard}
        for topic in sorted({*system.published, *system.heard} - PLUMBING - parts):
            publishers = len(system.published.get(topic, ()))
            subscribers = len(system.heard.get(topic, frozenset()) - {self._name})
            kind = types.get(topic, "")
            if not kind or not (publishers or subscribers):
                continue
            one = heard.get(topic)
            shape, problem = (
                self._read_fields(one, kind) if one is not None else (ReadableFields((), ()), "")
            )
            yield TopicFound(
                topic=topic,
                type=full_name(kind),
                publishers=publishers,
                subscribers=subscribers,
                rate=round(one.message_rate(), 2) if one is not None else 0.0,
                latched=one is not None and one.latched,
                fields=shape.fields,
                names=tuple(sorted(one.names)) if one is not None else (),
                left_out=shape.left_out,
                stamped=shape.stamped,
                problem=problem,
            )

    def _read_fields(self, heard: _Heard, kind: str) -> tuple[ReadableFields, str]:
        if heard.problem:
            return ReadableFields((), ()), heard.problem
        text = heard.definition if heard.type else self._described.get(("msg", kind))
        if text is None:
            return ReadableFields(
                (), ()
            ), f"nothing came, and the type {kind} is not installed here"
        try:
            return _readable_fields(text, kind, heard.decode_message()), ""
        except FieldError as error:
            return ReadableFields((), ()), str(error)

    def _describe_service(self, name: str, kind: str) -> ServiceFound:
        if not kind:
            return ServiceFound(name, "", (), "it does not answer")
        package, _, short = kind.partition("/")
        fields, problem = self._read_request("srv", kind, f"{kind}Request")
        return ServiceFound(name, f"{package}/srv/{short}", fields, problem)

    def _describe_action(self, name: str, goal: str) -> ActionFound:
        package, _, short = goal.removesuffix("ActionGoal").partition("/")
        fields, problem = self._read_request("msg", _goal_type(goal), _goal_type(goal))
        return ActionFound(name, f"{package}/action/{short}", fields, problem)

    def _read_request(self, what: str, kind: str, named: str) -> tuple[tuple[FieldFound, ...], str]:
        """Read what a request or a goal holds; lists in it cannot be filled from a form."""
        text = self._described.get((what, kind))
        if text is None:
            package = kind.partition("/")[0]
            return (), f"the package {package} is not installed here; install it to call this"
        try:
            shape = _readable_fields(text, named, None)
        except FieldError as error:
            return (), str(error)
        lists = [field.split(":", 1)[0] for field in shape.left_out]
        fields = tuple(field for field in shape.fields if "[" not in field.path)
        return fields, f"its request holds lists ({', '.join(lists)})" if lists else ""


def _readable_fields(text: str, kind: str, message: object) -> ReadableFields:
    definition = definition_of(text, kind)
    return shape_of(
        kind=definition.kinds[kind],
        type_name=kind,
        find=definition.kinds.get,
        message=message,
        comment_of=definition.comment_of,
    )


def _find_actions(types: dict[str, str]) -> list[str]:
    """Find the names under which there is a status of goals and a topic that takes them."""
    names = (topic.removesuffix("/status") for topic, kind in types.items() if kind == STATUS)
    return sorted(name for name in names if types.get(f"{name}/goal", "").endswith("ActionGoal"))


def _goal_type(goal: str) -> str:
    """Give the type of what is asked inside an action's goal message."""
    return goal.removesuffix("ActionGoal") + "Goal" if goal else ""
