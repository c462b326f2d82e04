"""The ROS 1 adapter: hears what the description names and tells the robot what it may be told.

rospy runs in a process of the machine's own Python (`rospy_bridge`), for it lives in no virtual
environment. Messages come raw with their definitions and are decoded here (`numbered_topics`), so
that any type can be read without its package; to say something, the package must be there.

rospy does not register anew when the master has begun anew. So the master is asked twice a second
whether it still knows our node (`node_signs`); if not, the node's process is ended (it says zeros
first) and the gateway begins again.
"""

from __future__ import annotations

import asyncio
import logging
import os
from typing import TYPE_CHECKING, Any

from talaia.gateway.adapters.ros1.endpoints import await_endpoints
from talaia.gateway.adapters.ros1.frames import ReceivedMessage, TappedPiece
from talaia.gateway.adapters.ros1.master import RosMaster
from talaia.gateway.adapters.ros1.node import NodeProcess
from talaia.gateway.adapters.ros1.node_calls import NodeCalls
from talaia.gateway.adapters.ros1.node_requests import command_frames, site_frames
from talaia.gateway.adapters.ros1.node_signs import NodeSigns
from talaia.gateway.adapters.ros1.numbered_topics import NumberedTopics
from talaia.gateway.adapters.ros1.presence import Ros1Presence
from talaia.gateway.adapters.ros1.robot_messages import RobotMessages
from talaia.gateway.adapters.ros1.taps import Ros1TopicSource
from talaia.gateway.adapters.unreadable_reports import UnreadableReports
from talaia.gateway.adapters.velocity import velocity_fields
from talaia.gateway.errors import TypeMissing
from talaia.gateway.ports import CommandOutcome
from talaia.gateway.video.worker import PictureWorker
from talaia.model.arguments import list_fields
from talaia.model.connection import Ros1Connection
from talaia.model.site import CommandKind
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.ros1.frames import ReceivedFrame
    from talaia.gateway.ports import AdapterContext, AdapterStatus, ChannelReading
    from talaia.gateway.tap_ports import TopicDefinition
    from talaia.gateway.velocity_demand import VelocityDemand
    from talaia.wire.frames import Scalar

__all__ = ["Ros1Adapter"]

log = logging.getLogger(__name__)
_DEFAULT_MASTER = "http://localhost:11311"


class Ros1Adapter:
    """An `Adapter` for ROS 1. See `talaia.gateway.ports` for its promises.

    One node's process for each `run`: when that ends, in whatever way, the process has ended, too,
    and every call that was under way is told.
    """

    def __init__(
        self, scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
    ) -> None:
        """Take what is to be served and where things go; `run` joins ROS."""
        settings = scope.connection
        assert isinstance(settings, Ros1Connection)  # noqa: S101 - the catalog has seen to it
        self._settings = settings
        self._scope, self._status = scope, status
        self._clock, self._events = context.clock, context.events
        self._pictures, self._budget = context.pictures, context.budget
        self._unreadable = UnreadableReports(context.events)
        uri = settings.master or os.environ.get("ROS_MASTER_URI") or _DEFAULT_MASTER
        self._master = RosMaster(uri)
        self._robot = RobotMessages(settings, context)
        self._topics = NumberedTopics(scope, context, self._unreadable, self._robot)
        self._source = Ros1TopicSource(context.taps, self._master)
        self._calls = NodeCalls()
        # Cameras that somebody looks at, whether or not the node is there.
        self._watched: frozenset[str] = frozenset()
        # What was written down already: a type is missing for each command anew.
        self._complained: set[str] = set()
        # The node that may be told things; none before it has joined.
        self._node: NodeProcess | None = None
        # Devices that are being connected anew.
        self._reconnecting: set[asyncio.Task[None]] = set()

    # ── Adapter ──

    async def run(self) -> None:
        """See `Adapter.run`."""
        loop = asyncio.get_running_loop()
        # Before a process is started for nothing.
        await loop.run_in_executor(None, self._master.check_master)
        failed: asyncio.Future[str] = loop.create_future()
        signs = NodeSigns(self._master)
        worker = PictureWorker(self._pictures, self._clock, self._budget)
        worker.start()
        self._topics.number_topics(worker)

        def fail(why: str) -> None:
            loop.call_soon_threadsafe(_settle_future, failed, why)

        node = None
        beside: list[asyncio.Future[None]] = []
        try:
            node = NodeProcess(
                settings=self._settings,
                uri=self._master.uri,
                heard=lambda frame: self._read_frame(
                    frame, lambda said: loop.call_soon_threadsafe(self._on_frame, said, signs)
                ),
                turned=self._end_turn,
                failed=fail,
            )
            node.send_frame(node=self._settings.node, namespace=self._settings.namespace)
            name = await signs.wait_joined(failed)
            self._node = node
            self._describe_site(node)
            self._status.up()
            presence = Ros1Presence(self._scope, self._master, self._clock, self._on_presence)
            self._topics.write_arrivals(presence.heard_ns)
            beside = [
                asyncio.ensure_future(part) for part in (presence.run(), self._source.run(node))
            ]
            await signs.watch_node(node, name, failed)
        finally:
            self._node = None
            self._topics.write_arrivals(None)
            for part in beside:
                part.cancel()
            await asyncio.gather(*beside, return_exceptions=True)
            self._topics.latest.clear()
            self._calls.lose_all()
            if node is not None:
                node.hang_up()
                # Shielded: a gateway that ends must wait, too, until the zeros are said.
                await asyncio.shield(loop.run_in_executor(None, node.wait_ended))
            # Only now: the node's thread reads with both until it has ended.
            self._topics.forget_types()
            worker.close()

    def _on_presence(self, device: str, why: str, sure: bool) -> None:  # noqa: FBT001
        self._status.device(device, there=not why, why=why, sure=sure)

    def watch(self, streams: Collection[str]) -> None:
        """See `Adapter.watch`."""
        before, self._watched = self._watched, frozenset(streams)
        node = self._node
        if node is None:
            return
        for address, number in self._topics.streams.items():
            if address in self._watched and address not in before:
                self._listen(node, number)
            elif address in before and address not in self._watched:
                node.send_frame(op="leave", topic=number)

    def tap_topics(self, topics: frozenset[str]) -> None:
        """See `TopicSource.tap_topics`."""
        self._source.tap_topics(topics)

    def watch_graph(self, *, wanted: bool) -> None:
        """See `GraphSource.watch_graph`."""
        self._source.watch_graph(wanted=wanted)

    def define_type(self, type_name: str, done: Callable[[TopicDefinition | str], None]) -> None:
        """See `TopicSource.define_type`."""
        self._source.define_type(type_name, done)

    def latest(self, address: str) -> ChannelReading | None:
        """See `ReadingSource.latest`."""
        return self._topics.latest.get(address)

    def drive(self, device: str, demand: VelocityDemand, key: str = "") -> None:
        """See `CommandTarget.drive`."""
        described = self._scope.devices.get(device)
        if self._node is not None and described is not None and described.drive is not None:
            fields = velocity_fields(described.drive, demand, key)
            self._node.send_frame(op="say", id=f"drive {device}", fields=fields)

    def stop(self, device: str, *, stopped: bool) -> None:
        """See `CommandTarget.stop`."""
        if self._node is not None:
            # Without a STOP topic the node knows no such name, and does nothing.
            self._node.send_frame(op="say", id=f"stop {device}", fields={"data": stopped})

    def act(
        self,
        device: str,
        command: str,
        fields: dict[str, Scalar],
        done: Callable[[CommandOutcome], None],
    ) -> Callable[[], None] | None:
        """See `CommandTarget.act`."""
        node = self._node
        if node is None:
            done(CommandOutcome(CommandPhase.REFUSED, "the robot is not connected"))
            return None
        address, call = f"{device}/{command}", self._calls.begin_call(done)
        described = self._scope.devices[device].commands[command]
        with_lists = list_fields(described, fields)
        node.send_frame(op="act", id=address, call=call, fields=with_lists, target=described.target)
        # Of ROS 1's ways only actions can be ended early.
        if described.kind is not CommandKind.ACTION:
            return None
        return lambda: node.send_frame(op="cancel", id=address, call=call)

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """See `Adapter.reconnect`."""
        node, described = self._node, self._scope.devices.get(device)
        if node is None or described is None:
            done(CommandOutcome(CommandPhase.FAILED, "the robot's side cannot be reached now"))
            return
        topics = self._topics.device_topics(device, self._watched)
        for number in self._topics.device_numbers(device, self._watched):
            self._listen(node, number)
        for frame in command_frames(device, described):
            node.send_frame(**frame)
        commands = list(described.commands.values())
        task = asyncio.ensure_future(await_endpoints(self._master, topics, commands, done))
        # The loop itself keeps no task alive.
        self._reconnecting.add(task)
        task.add_done_callback(self._reconnecting.discard)

    # ── to the node ──

    def _describe_site(self, node: NodeProcess) -> None:
        """Tell a node that has just joined what to publish, call and listen to."""
        # Publications first: STOP and driving must not wait behind hundreds of topics, each of
        # which is a question to the master.
        for frame in site_frames(self._scope.devices):
            node.send_frame(**frame)
        for number in self._topics.standing_numbers():
            self._listen(node, number)
        for address in sorted(self._watched & self._topics.streams.keys()):
            self._listen(node, self._topics.streams[address])
        node.send_frame(op="parameters", names=self._topics.parameters)

    def _listen(self, node: NodeProcess, number: int) -> None:
        node.send_frame(**self._topics.listen_frame(number))

    # ── from the node, on its thread ──

    def _end_turn(self) -> None:
        self._topics.publish_samples()
        self._robot.tell_left_out()

    def _read_frame(
        self,
        frame: ReceivedFrame,
        pass_on: Callable[[dict[str, Any]], object],
    ) -> None:
        # Messages are read here, so that the event loop (driving, STOP) never waits for them.
        if isinstance(frame, ReceivedMessage):
            self._topics.read_message(frame)
        elif isinstance(frame, TappedPiece):
            self._source.read_piece(frame)
        elif frame["op"] in {"tapped_kind", "tap_problem"}:
            self._source.read_frame(frame)
        elif frame["op"] == "type":
            # Here, too: the messages behind it are of that type.
            self._topics.learn_type(frame)
        elif frame["op"] == "parameter":
            self._topics.read_parameter(frame)
        else:
            pass_on(frame)

    # ── from the node, on the event loop ──

    def _on_frame(self, frame: dict[str, Any], signs: NodeSigns) -> None:
        match frame["op"]:
            case "ready":
                signs.mark_ready(frame["node"])
            case "pong":
                signs.mark_answered()
            case "working":
                signs.mark_working()
            case "outcome":
                self._calls.report_outcome(frame)
            case "missing":
                self._report_missing(frame["type"], frame["used_by"])
            case "complaint":
                self._unreadable.report_once(frame["id"], frame["problem"])
            case _:
                log.debug("the node said %s", frame["op"])

    def _report_missing(self, type_name: str, used_by: str) -> None:
        problem = str(TypeMissing(type_name, used_by))
        if problem not in self._complained:
            self._complained.add(problem)
            log.warning("%s", problem)
            self._events.report_event("type_missing", problem)


def _settle_future(future: asyncio.Future[str], why: str) -> None:
    # The process's end may be told when nobody waits for it any more.
    if not future.done():
        future.set_result(why)
