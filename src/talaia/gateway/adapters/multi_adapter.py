"""One `Adapter` made of several: one for each connection of the site, and none ends another."""

from __future__ import annotations

import asyncio
import logging
import math
from typing import TYPE_CHECKING

from talaia.gateway.adapters.null_adapter import NullAdapter
from talaia.gateway.errors import AdapterLost
from talaia.gateway.ports import CommandOutcome, PacedAdapter
from talaia.gateway.tap_ports import GraphSource, TopicSource
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping

    from talaia.gateway.adapters.connectivity import DeviceReachability
    from talaia.gateway.ports import Adapter, ChannelReading, EventSink
    from talaia.gateway.tap_ports import TopicDefinition
    from talaia.gateway.velocity_demand import VelocityDemand
    from talaia.model.site import Device
    from talaia.wire.frames import Scalar

__all__ = ["AGAIN_S", "ConnectionStatus", "MultiAdapter"]

log = logging.getLogger(__name__)
# After a loss a connection is tried again so often.
AGAIN_S = 1.0


class ConnectionStatus:
    """A `AdapterStatus`: where one adapter says how its side stands. Any thread."""

    def __init__(
        self, name: str, loop: asyncio.AbstractEventLoop, reach: DeviceReachability
    ) -> None:
        """Speak for the connection of this name; `on_up` and `on_found` are set by who listens."""
        self.name = name  # Of the connection.
        self._loop = loop  # Adapters call from threads of their own; all is told on it.
        self._reach = reach
        # Set by `MultiAdapter` while it runs the adapter.
        self.on_up: Callable[[], None] = lambda: None
        # Set by who makes the adapter.
        self.on_found: Callable[[Mapping[str, Device]], None] = lambda _devices: None

    def up(self) -> None:
        """See `AdapterStatus.up`."""
        # A lambda: who listens is looked up when it is the loop's turn, not now.
        self._loop.call_soon_threadsafe(lambda: self.on_up())

    def device(self, device: str, *, there: bool, why: str = "", sure: bool = True) -> None:
        """See `AdapterStatus.device`."""
        self._loop.call_soon_threadsafe(
            lambda: self._reach.device(device, there=there, why=why, sure=sure)
        )

    def found(self, devices: Mapping[str, Device]) -> None:
        """See `AdapterStatus.found`."""
        self._loop.call_soon_threadsafe(lambda: self.on_found(devices))


class MultiAdapter:
    """An `Adapter`. Used on the event loop only, but for `latest`."""

    def __init__(
        self,
        *,
        of: Mapping[str, str],
        adapters: Mapping[str, tuple[Adapter, ConnectionStatus]],
        reach: DeviceReachability,
        events: EventSink,
        again_s: float = AGAIN_S,
    ) -> None:
        """Join adapters.

        Args:
            of: by device: the name of its connection, or an empty one.
            adapters: by connection.
            reach: told when a connection is lost or back.
            events: told the same in words, once each.
            again_s: how long after a loss it is tried again, and again.

        """
        self._again_s = again_s  # After a loss; see `AGAIN_S`.
        self._of = of  # By device: its connection's name; replaced by `redescribe`.
        self._adapters = adapters  # By connection; replaced by `redescribe`.
        self._reach = reach
        self._events = events
        # Told of devices whose connection went away.
        self._loss_listeners: list[Callable[[Collection[str]], None]] = []
        # Told when it is back.
        self._return_listeners: list[Callable[[Collection[str]], None]] = []
        self._nobody = NullAdapter()  # Serves devices without a connection: it refuses everything.
        self._lost: set[str] = set()  # Connections whose loss was told, until they are up again.
        self._running: set[str] = set()  # Connections whose `run` is under way.
        self._streams: tuple[str, ...] = ()  # What is watched now, for adapters that come later.
        self._tapped: frozenset[str] = frozenset()  # Raw topics that are heard, likewise.
        self._graph_wanted = False  # Whether nodes are listed, likewise.
        self._watched: frozenset[str] = frozenset()  # Devices that somebody looks at, likewise.
        self._turn_s = math.inf  # What they say is read so often (s).
        # While `run` is under way; adapters are begun in it.
        self._group: asyncio.TaskGroup | None = None
        self._tasks: dict[str, asyncio.Task[None]] = {}  # By connection: what runs its adapter.
        # Cancelled, and still releasing what they hold.
        self._ending: set[asyncio.Task[None]] = set()

    def subscribe_losses(
        self,
        *,
        lost: Callable[[Collection[str]], None],
        back: Callable[[Collection[str]], None],
    ) -> None:
        """Call ``lost`` with the devices that go away with a connection, and ``back`` after it."""
        self._loss_listeners.append(lost)
        self._return_listeners.append(back)

    async def run(self) -> None:
        """Run all of them until cancelled; whichever is lost is begun again by itself.

        What an adapter raises beside `AdapterLost` ends all of them, and is raised.
        """
        try:
            async with asyncio.TaskGroup() as group:
                # So that it lasts also when there is none.
                group.create_task(asyncio.Event().wait())
                self._group = group
                for name in self._adapters:
                    self._begin_adapter(name)
        except BaseExceptionGroup as failed:
            # One error and no group of them: the caller names it.
            raise failed.exceptions[0] from failed
        finally:
            self._group = None

    def redescribe(
        self, of: Mapping[str, str], adapters: Mapping[str, tuple[Adapter, ConnectionStatus]]
    ) -> None:
        """Serve other devices, by adapters of which those that were here already go on.

        What has no place any more is ended. One that has taken another's place begins when that
        one has released everything.
        """
        before, self._adapters = self._adapters, adapters
        # By identity of adapter and status: a new pair stands for a connection that is described
        # anew.
        gone = [name for name, pair in before.items() if adapters.get(name) != pair]
        for name in gone:
            if name in adapters:
                # Told before it is begun anew, so that its old readings count for nothing
                # meanwhile.
                self._handle_lost(name, "its description has changed; connecting anew")
            else:
                self._lost.discard(name)
        self._of = of
        for name in [adapter for adapter in adapters if adapter in gone or adapter not in before]:
            self._begin_adapter(name)
        for name in [adapter for adapter in gone if adapter not in adapters]:
            if (task := self._tasks.pop(name, None)) is not None:
                task.cancel()
        # Each adapter is told again: which streams are its own may have changed.
        self.watch(self._streams)
        self.tap_topics(self._tapped)
        self.watch_graph(wanted=self._graph_wanted)
        self.watch_devices(self._watched, self._turn_s)

    def _begin_adapter(self, name: str) -> None:
        if self._group is None:
            return
        if (task := self._tasks.get(name)) is not None:
            task.cancel()
            self._ending.add(task)
        self._ending = {task for task in self._ending if not task.done()}
        before = tuple(self._ending)
        self._tasks[name] = self._group.create_task(
            self._keep_running(name, *self._adapters[name], before)
        )

    async def _keep_running(
        self,
        name: str,
        adapter: Adapter,
        post: ConnectionStatus,
        before: Collection[asyncio.Task[None]],
    ) -> None:
        # A port or a bus may be held by the one before: two at once would fight for it.
        if before:
            await asyncio.wait(before)
        post.on_up = lambda: self._handle_back(name)
        while True:
            self._running.add(name)
            try:
                # It returns only when cancelled; any other error ends all adapters.
                await adapter.run()
            except AdapterLost as error:
                self._handle_lost(name, str(error))
            finally:
                self._running.discard(name)
            await asyncio.sleep(self._again_s)

    def _handle_lost(self, name: str, why: str) -> None:
        # Each time, for the reason may be another; events and listeners are told once.
        devices = self._reach.mark_lost(name, why)
        if name not in self._lost:
            self._lost.add(name)
            log.warning("%s: %s; trying again every %g s", name, why, self._again_s)
            self._events.report_event("connection lost", f"{name}: {why}")
            for on_loss in self._loss_listeners:
                on_loss(devices)

    def _handle_back(self, name: str) -> None:
        # An `up` that was on its way while the adapter was lost, or one that never was away.
        if name not in self._running or name not in self._lost:
            return
        self._lost.discard(name)
        log.info("%s is back", name)
        self._events.report_event("connection back", name, good=True)
        devices = self._reach.mark_back(name)
        for on_return in self._return_listeners:
            on_return(devices)

    # ── to the one that serves the device ──

    def _adapter_for(self, device: str) -> Adapter:
        found = self._adapters.get(self._of.get(device, ""))
        return self._nobody if found is None else found[0]

    def watch(self, streams: Collection[str]) -> None:
        """See `Adapter.watch`."""
        self._streams = tuple(streams)
        for name, (adapter, _) in self._adapters.items():
            adapter.watch(
                [stream for stream in streams if self._of.get(stream.split("/", 1)[0]) == name]
            )

    def tap_topics(self, topics: frozenset[str]) -> None:
        """Have each connection hear those of these raw topics that it has; see `TopicSource`."""
        self._tapped = topics
        for adapter, _ in self._adapters.values():
            if isinstance(adapter, TopicSource):
                adapter.tap_topics(topics)

    def watch_graph(self, *, wanted: bool) -> None:
        """Have each connection list its nodes, or do so no more; see `GraphSource`."""
        self._graph_wanted = wanted
        for adapter, _ in self._adapters.values():
            if isinstance(adapter, GraphSource):
                adapter.watch_graph(wanted=wanted)

    def watch_devices(self, devices: frozenset[str], turn_s: float) -> None:
        """Read so often (s) the connections of these devices; see `PacedAdapter`."""
        self._watched, self._turn_s = devices, turn_s
        watched = {self._of.get(device) for device in devices}
        for name, (adapter, _) in self._adapters.items():
            if isinstance(adapter, PacedAdapter):
                adapter.shorten_turns(turn_s if name in watched else math.inf)

    def define_type(
        self, connection: str, type_name: str, done: Callable[[TopicDefinition | str], None]
    ) -> None:
        """See `TopicSource.define_type`; the type is of a topic of this connection."""
        adapter, _ = self._adapters.get(connection, (None, None))
        if isinstance(adapter, TopicSource):
            adapter.define_type(type_name, done)
        else:
            done(f"{connection} is not there any more")

    def latest(self, address: str) -> ChannelReading | None:
        """See `ReadingSource.latest`; what is not reached has none."""
        device = address.split("/", 1)[0]
        # Asked here: an adapter may still hold what a device said before it went.
        return (
            self._adapter_for(device).latest(address) if self._reach.still_counts(device) else None
        )

    def drive(self, device: str, demand: VelocityDemand, key: str = "") -> None:
        """See `CommandTarget.drive`."""
        self._adapter_for(device).drive(device, demand, key)

    def stop(self, device: str, *, stopped: bool) -> None:
        """See `CommandTarget.stop`."""
        self._adapter_for(device).stop(device, stopped=stopped)

    def act(
        self,
        device: str,
        command: str,
        fields: dict[str, Scalar],
        done: Callable[[CommandOutcome], None],
    ) -> Callable[[], None] | None:
        """See `CommandTarget.act`."""
        return self._adapter_for(device).act(device, command, fields, done)

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """See `Adapter.reconnect`."""
        if device not in self._of:
            done(CommandOutcome(CommandPhase.FAILED, "there is no such device at the robot now"))
            return
        self._adapter_for(device).reconnect(device, done)
