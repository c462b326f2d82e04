"""The ROS 2 adapter: hears what the description names and tells the robot what it may be told.

It joins the parts: `participant_number` and `waitset` (how ROS is joined, and the thread),
`subscriptions` and `listening` (what is heard), `services` and `actions` (commands), `motion`
(driving and STOP), `nodes` (what they are and say), and `presence` (who is there). Long, because
joining, serving and leaving share one node and must be read together.
"""

from __future__ import annotations

import asyncio
import logging
import os
from functools import partial
from typing import TYPE_CHECKING, Any

from talaia.gateway.adapters.ros2.system_ros.start import prepare_bridge

# isort: split
import rclpy
from rclpy.context import Context

from talaia.gateway.adapters.arrival_times import Arrivals
from talaia.gateway.adapters.presence import Deafness
from talaia.gateway.adapters.reconnection import ReconnectionAttempts
from talaia.gateway.adapters.ros2.graph_node import join_graph, pacer_of, wait_sets_of
from talaia.gateway.adapters.ros2.listening import Ros2Listening
from talaia.gateway.adapters.ros2.made_types.packageless_services import PackagelessServices
from talaia.gateway.adapters.ros2.motion import Ros2Motion
from talaia.gateway.adapters.ros2.nodes.robot_clock import RobotClock
from talaia.gateway.adapters.ros2.nodes.robot_nodes import RobotNodes
from talaia.gateway.adapters.ros2.participant_number import ParticipantNumber, domain_of
from talaia.gateway.adapters.ros2.presence import Ros2Presence
from talaia.gateway.adapters.ros2.rclpy_bridge.waitset import WaitThread
from talaia.gateway.adapters.ros2.services import Ros2Commands
from talaia.gateway.adapters.ros2.subscriptions import Ros2Subscriptions
from talaia.gateway.adapters.ros2.taps import Ros2TopicSource
from talaia.gateway.adapters.ros2.topic_types import TopicTypes
from talaia.gateway.adapters.ros2.type_definitions.robot_questions import RobotDescriptions
from talaia.gateway.adapters.topic_readers import SampleBuffer, TopicPlan, make_live_plans
from talaia.gateway.adapters.unreadable_reports import UnreadableReports
from talaia.gateway.errors import AdapterLost
from talaia.gateway.ports import CommandOutcome
from talaia.gateway.video.worker import PictureWorker
from talaia.model.connection import Ros2Connection
from talaia.shared_memory import remove_dead_segments_at_start
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.errors import TypeMissing
    from talaia.gateway.ports import (
        AdapterContext,
        AdapterStatus,
        ChannelReading,
    )
    from talaia.gateway.tap_ports import TopicDefinition
    from talaia.gateway.velocity_demand import VelocityDemand
    from talaia.wire.frames import Scalar

__all__ = ["Ros2Adapter"]

log = logging.getLogger(__name__)
# Turns of a quarter of a second: seldom enough to cost nothing, often enough for 20 s of memory.
MARK_EVERY = 16


class Ros2Adapter:
    """An `Adapter` for ROS 2. See `talaia.gateway.ports` for its promises."""

    def __init__(
        self, scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
    ) -> None:
        """Take what is to be served and where things go; `run` joins ROS."""
        settings = scope.connection
        assert isinstance(settings, Ros2Connection)  # noqa: S101 - the catalog has seen to it
        self._scope, self._status = scope, status
        self._clock, self._events, self._pictures = context.clock, context.events, context.pictures
        self._samples, self._budget = context.samples, context.budget
        self._unreadable = UnreadableReports(context.events)
        self._domain = settings.domain if context.domain is None else context.domain
        self._node_name = settings.node
        self._definitions = context.folder / settings.definitions if settings.definitions else None
        self._raw, self._files, self._kept_log = context.raw, context.files, context.kept_log
        # Newest readings of guarded signals by address: written by the thread, read by the loop.
        self._latest: dict[str, ChannelReading] = {}
        # Samples of one turn of the wait set, until they go on as columns.
        self._gathered = SampleBuffer()
        # Without `use_sim_time` the messages' stamps are taken as they are.
        self._robot_clock = RobotClock(context.clock) if settings.use_sim_time else None
        self._shift_us = None if self._robot_clock is None else self._robot_clock.shift_us
        # They outlive a `run`: what is held back of a signal goes on when ROS is joined anew.
        self._plans = self._plans_of(scope)
        # Streams that somebody looks at; replaced whole, so both threads may read it.
        self._watched: frozenset[str] = frozenset()
        # Types that are not installed and have been reported, in the words of the report.
        self._missing: set[str] = set()
        # From here on: what belongs to one `run`, made by `_join`, None between two of them.
        self._listening: Ros2Listening | None = None
        self._motion: Ros2Motion | None = None
        self._commands: Ros2Commands | None = None
        self._nodes: RobotNodes | None = None
        self._presence: Ros2Presence | None = None
        self._descriptions: RobotDescriptions | None = None
        self._types: TopicTypes | None = None
        self._packageless: PackagelessServices | None = None
        self._thread: WaitThread | None = None
        self._worker: PictureWorker | None = None
        self._node: Any = None
        self._number = ParticipantNumber(None)
        # Counts looks at the graph, some four a second; what is dear is done at some of them.
        self._turn = 0
        self._rejoining = ReconnectionAttempts(self._clock)
        self._arrivals = Arrivals(self._clock.monotonic_ns())
        self._source = Ros2TopicSource(context.taps, self._clock, self._arrivals)
        # Outlives a `run`: joining anew is tried ever more seldom.
        self._deafness = Deafness()

    async def run(self) -> None:
        """See `Adapter.run`."""
        loop = asyncio.get_running_loop()
        failed: asyncio.Future[None] = loop.create_future()
        fail = partial(_fail_soon, loop, failed)
        remove_dead_segments_at_start()
        context = Context()
        try:
            await loop.run_in_executor(None, prepare_bridge)
            self._join(context, fail)
        except Exception as error:
            self._leave(context)
            raise AdapterLost(f"ROS 2 cannot be joined: {error}") from error
        self._status.up()
        try:
            await failed
        finally:
            await asyncio.shield(loop.run_in_executor(None, self._leave, context))

    def watch(self, streams: Collection[str]) -> None:
        """See `Adapter.watch`."""
        self._watched = frozenset(streams)
        if self._thread is not None:
            self._thread.run_soon(self._update_subscriptions)

    def shorten_turns(self, turn_s: float) -> None:
        """See `PacedAdapter.shorten_turns`."""
        self._source.shorten_turns(turn_s)

    def tap_topics(self, topics: frozenset[str]) -> None:
        """See `TopicSource.tap_topics`."""
        self._source.tap_topics(topics)

    def define_type(self, type_name: str, done: Callable[[TopicDefinition | str], None]) -> None:
        """See `TopicSource.define_type`."""
        self._source.define_type(type_name, done)

    def watch_graph(self, *, wanted: bool) -> None:
        """See `GraphSource.watch_graph`."""
        self._source.watch_graph(wanted=wanted)

    def redescribe(self, scope: ConnectionScope) -> None:
        """See `DescriptionFollower`."""
        if self._thread is None:
            # It is joined with the next `run`.
            self._scope, self._plans = scope, self._plans_of(scope)
        else:
            self._thread.run_soon(lambda: self._redescribe(scope))

    def latest(self, address: str) -> ChannelReading | None:
        """See `ReadingSource.latest`."""
        return self._latest.get(address)

    def drive(self, device: str, demand: VelocityDemand, key: str = "") -> None:
        """See `CommandTarget.drive`."""
        if self._motion is not None:
            self._motion.drive(device, demand, key)

    def stop(self, device: str, *, stopped: bool) -> None:
        """See `CommandTarget.stop`."""
        if self._motion is not None:
            self._motion.stop(device, stopped=stopped)

    def act(
        self,
        device: str,
        command: str,
        fields: dict[str, Scalar],
        done: Callable[[CommandOutcome], None],
    ) -> Callable[[], None] | None:
        """See `CommandTarget.act`."""
        thread, commands = self._thread, self._commands
        if thread is None or commands is None:
            done(Ros2Commands.away())
            return None
        return commands.begin(f"{device}/{command}", fields, done, thread.run_soon)

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """See `Adapter.reconnect`."""
        if (thread := self._thread) is None:
            done(CommandOutcome(CommandPhase.FAILED, "the robot's side cannot be reached now"))
        else:
            thread.run_soon(lambda: self._rejoin(device, done))

    # ── joining and leaving ──

    def _join(self, context: Any, fail: Callable[[BaseException], None]) -> None:  # noqa: ANN401
        self._number = ParticipantNumber(_fast_dds_domain(self._domain))
        with self._number.held():
            self._node = join_graph(self._node_name, context, self._domain)
        self._number.mark_used()
        thread = WaitThread(
            make_wait_set=wait_sets_of(context),
            guard=self._node.create_guard_condition(lambda: None).handle,
            after=self._after,
            idle=self._on_idle,
            failed=fail,
            paced=pacer_of(context),
        )
        heard_ns: dict[str, int] = {}
        self._worker = PictureWorker(self._pictures, self._clock, self._budget)
        self._packageless = PackagelessServices(
            node=self._node_name, domain=context.get_domain_id(), named=self._definitions
        )
        self._descriptions = RobotDescriptions(self._node, thread, self._clock)
        self._types = TopicTypes(
            named=self._definitions,
            descriptions=self._descriptions,
            soon=thread.run_soon,
            missing=self._tell_missing,
            mismatched=self._unreadable.report_once,
        )
        self._commands = Ros2Commands(
            scope=self._scope,
            node=self._node,
            thread=thread,
            missing=self._tell_missing,
            packageless=self._packageless,
            types=self._types,
        )
        self._nodes = RobotNodes(
            scope=self._scope,
            node=self._node,
            thread=thread,
            clock=self._clock,
            gathered=self._gathered,
            latest=self._latest,
            unreadable=self._unreadable,
            events=self._events,
            kept_log=self._kept_log,
            robot_clock=self._robot_clock,
        )
        self._presence = Ros2Presence(
            scope=self._scope,
            node=self._node,
            thread=thread,
            clock=self._clock,
            commands=self._commands,
            heard_ns=heard_ns,
            tell=self._on_presence,
            deafness=self._deafness,
            rejoin=lambda why: fail(AdapterLost(why)),
        )
        self._listening = Ros2Listening(
            scope=self._scope,
            plans=self._plans,
            subscriptions=Ros2Subscriptions(
                self._node, thread, self._types.class_for, self._unreadable.report_once
            ),
            types=self._types,
            clock=self._clock,
            gathered=self._gathered,
            heard_ns=heard_ns,
            arrivals=self._arrivals,
            unreadable=self._unreadable,
            worker=self._worker,
            files=self._files,
            raw=self._raw,
        )
        self._source.join(self._node, thread, self._types)
        self._motion = Ros2Motion(
            self._scope, self._node, thread, types=self._types, missing=self._tell_missing
        )
        self._worker.start()
        self._thread = thread
        thread.start()

    def _leave(self, context: Any) -> None:  # noqa: ANN401
        thread, self._thread = self._thread, None
        # First nobody publishes any more, then the thread ends, then the node goes.
        _close_part(self._motion)
        self._motion = self._commands = self._nodes = self._presence = None
        if thread is not None:
            thread.end()
        self._rejoining.end_attempts()
        _close_part(self._worker)
        self._source.leave()
        _close_part(self._types)
        _close_part(self._packageless)
        self._listening = self._types = self._descriptions = self._packageless = None
        self._latest.clear()
        if self._node is not None:
            self._node.destroy_node()
            self._node = None
        rclpy.try_shutdown(context=context)

    def _redescribe(self, scope: ConnectionScope) -> None:
        """Bring all in line with another scope; on the wait-set thread, between two turns."""
        before, self._scope = self._scope, scope
        self._plans = self._plans_of(scope)
        if self._listening is not None:
            self._listening.redescribe(scope, self._plans)
        for address in [key for key in self._latest if _moved(before, scope, key)]:
            del self._latest[address]
        if self._commands is not None:
            self._commands.redescribe(scope)
        if self._nodes is not None:
            self._nodes.redescribe(scope)
        if self._motion is not None:
            self._motion.redescribe(scope)
        self._update_subscriptions()

    def _plans_of(self, scope: ConnectionScope) -> list[TopicPlan]:
        return make_live_plans(scope, self._latest, self._unreadable, self._shift_us)

    def _tell_missing(self, error: TypeMissing) -> None:
        if str(error) not in self._missing:
            self._missing.add(str(error))
            log.warning("%s", error)
            self._events.report_event("type_missing", str(error))

    # ── on the wait-set thread ──

    def _after(self) -> bool:
        now_us = self._clock.wall_ns() // 1000
        held = False
        own = self._nodes.plans if self._nodes is not None else []
        for plan in (*self._plans, *own):
            if plan.thins:
                held = plan.take_due(now_us, self._gathered) or held
        if (columns := self._gathered.take_columns()) is not None:
            self._samples.put_samples(columns)
        self._arrivals.mark_awake(self._clock.monotonic_ns())
        return held

    def _on_idle(self) -> None:
        self._turn += 1
        if self._turn % MARK_EVERY == 0:
            self._number.mark_used()
        if self._nodes is not None and self._turn % 4 == 0:
            self._nodes.ask()
        if self._descriptions is not None:
            self._descriptions.ask_again()
        if self._turn % 2 == 0:
            self._update_subscriptions(everything=self._turn % 8 == 0)
            self._source.look_again()
            self._rejoining.report_finished()
        if self._presence is not None:
            self._presence.judge_devices()

    def _on_presence(self, device: str, why: str, sure: bool) -> None:  # noqa: FBT001
        self._status.device(device, there=not why, why=why, sure=sure)

    def _rejoin(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """Make a device's subscriptions and clients anew; its publishers of motion stay."""
        commands, listening = self._commands, self._listening
        if commands is None or listening is None or device not in self._scope.devices:
            done(CommandOutcome(CommandPhase.FAILED, "there is no such device at the robot now"))
            return
        wanted = listening.begin_anew(device)
        commands.rejoin(device)
        self._update_subscriptions()

        def absent() -> list[str]:
            return sorted(listening.name_unheard(wanted)) + commands.absent(device)

        count = len(wanted) + len(self._scope.devices[device].commands)
        self._rejoining.begin_attempt(count, absent, done)

    def _update_subscriptions(self, *, everything: bool = True) -> None:
        if self._listening is not None:
            self._listening.update(self._watched, everything=everything)


def _moved(before: ConnectionScope, after: ConnectionScope, address: str) -> bool:
    """Tell whether a signal's newest reading says nothing of what is described there now."""
    if address not in after.guarded:
        return True
    device, _, signal = address.partition("/")
    if device not in before.devices or device not in after.devices:
        return True
    was, now = before.devices[device].signals.get(signal), after.devices[device].signals[signal]
    return was is None or (was.source, was.type, was.scale) != (now.source, now.type, now.scale)


def _fast_dds_domain(described: int | None) -> int | None:
    """Give the domain's number where Fast DDS is in use, or None."""
    if not rclpy.get_rmw_implementation_identifier().startswith("rmw_fastrtps"):
        return None
    return domain_of(os.environ.get("ROS_DOMAIN_ID") if described is None else str(described))


def _fail_soon(
    loop: asyncio.AbstractEventLoop, future: asyncio.Future[None], error: BaseException
) -> None:
    loop.call_soon_threadsafe(_fail, future, error)


def _fail(future: asyncio.Future[None], error: BaseException) -> None:
    if future.done():
        return
    if not isinstance(error, AdapterLost):
        error = AdapterLost(f"ROS 2 was lost: {type(error).__name__}: {error}")
    future.set_exception(error)


def _close_part(part: Ros2Motion | PictureWorker | TopicTypes | PackagelessServices | None) -> None:
    """Close what may not have been made yet."""
    if part is not None:
        part.close()
