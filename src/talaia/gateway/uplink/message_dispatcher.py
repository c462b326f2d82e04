"""Where the hub's messages are acted on."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from talaia.model.recording import Trigger
from talaia.wire.frames import (
    Ack,
    ChangeRequest,
    CommandCancel,
    CommandPhase,
    CommandRequest,
    DriveFrame,
    EnclosureState,
    Event,
    KeyframeRequest,
    LeaseForceRequest,
    LeaseRequest,
    OverrideRequest,
    ReconnectRequest,
    RecordingRequest,
    ResendRequest,
    ResetRequest,
    SightingReport,
    StopRequest,
    StreamSubscription,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

    from talaia.clock import Clock
    from talaia.gateway.actuation import Actuation
    from talaia.gateway.adapters.connectivity import DeviceReachability
    from talaia.gateway.detection.sighting_reports import DetectionReporter
    from talaia.gateway.ports import Adapter, CommandOutcome
    from talaia.gateway.recording.recorders import TriggeredRecorder
    from talaia.gateway.reload.requests import ChangeRequests
    from talaia.gateway.spool.spool_thread import SpoolThread
    from talaia.gateway.uplink.lanes import SendLanes
    from talaia.gateway.uplink.pictures import PictureUplink
    from talaia.wire.frames import FromGateway, FromHub, Welcome

__all__ = ["MessageDispatcher", "OutputRouter"]

log = logging.getLogger(__name__)
# What is noted, and what it means to who records.
_CAUSES = {"stop": Trigger.STOP, "interlock_locked": Trigger.INTERLOCK}


class OutputRouter:
    """Routes what is decided here: to the robot through the adapter, to the hub through lanes.

    A `ControlOutput` and an `EventSink`.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, clock: Clock, lanes: SendLanes) -> None:
        """Start without an adapter, as one that is away."""
        self._loop = loop
        self._clock = clock
        self._lanes = lanes
        self.adapter: Adapter | None = None
        self.tapes: TriggeredRecorder | None = None
        # Whether the hub of this link takes `EnclosureState`; others hear of enclosures here.
        self.takes_enclosures = False
        self.on_enclosure: Callable[[EnclosureState], None] = lambda _state: None

    def drive(self, device: str, linear: float, angular: float, key: str = "") -> None:
        """Publish a velocity."""
        if self.adapter is not None:
            self.adapter.drive(device, linear, angular, key)

    def stop(self, device: str, *, stopped: bool) -> None:
        """Publish on the STOP topic."""
        if self.adapter is not None:
            self.adapter.stop(device, stopped=stopped)

    def send(self, message: FromGateway) -> None:
        """Send to the hub."""
        if isinstance(message, EnclosureState):
            self.on_enclosure(message)
            if not self.takes_enclosures:
                return
        self._lanes.send(message)

    def note(self, kind: str, device: str, message: str, who: str, *, good: bool) -> None:
        """Write down, here and at the hub."""
        log.info("%s %s %s %s", kind, device, message, who)
        if self.tapes is not None and kind in _CAUSES:
            said = " ".join(filter(None, (message, f"({device})" if device else "")))
            self.tapes.trigger(_CAUSES[kind], said, who)
        time_us = self._clock.wall_ns() // 1000
        self._lanes.send(
            Event(
                kind=kind,
                device=device,
                message=message[:2000],
                who=who,
                time_us=time_us,
                good=good,
            )
        )

    def tell(
        self, kind: str, message: str, *, device: str = "", who: str = "", good: bool = False
    ) -> None:
        """Write down, from any thread."""
        event = Event(
            kind=kind,
            device=device,
            message=message[:2000],
            who=who,
            time_us=self._clock.wall_ns() // 1000,
            good=good,
        )
        self._loop.call_soon_threadsafe(self._lanes.send, event)


class MessageDispatcher:
    """A `HubMessageHandler`: gives each message to whom it concerns."""

    def __init__(
        self,
        boot: str,
        acting: Actuation,
        keeper: SpoolThread,
        adapter: Adapter,
        voice: OutputRouter,
        lanes: SendLanes,
        reach: DeviceReachability,
        tapes: TriggeredRecorder | None,
        changing: ChangeRequests,
        pictures: PictureUplink,
        telling: DetectionReporter,
    ) -> None:
        """Take all who act, the voice that tells how it went, and the lanes to the hub."""
        self._pictures = pictures
        self._telling = telling
        self._reach = reach
        self._tapes = tapes
        self._changing = changing
        self._voice = voice
        self._lanes = lanes
        self._boot = boot
        self._control = acting.control
        self._pacer = acting.pacer
        self._commanding = acting.commanding
        self._keeper = keeper
        self._adapter = adapter
        self._tasks: set[asyncio.Task[None]] = set()
        self.linked = asyncio.Event()
        self.links = 0

    def link_up(self, welcome: Welcome) -> None:
        """Trim what the hub has, and tell it how things stand."""
        self.linked.set()
        self.links += 1
        # First, for it compares with what the hub had told before.
        self._keeper.unlearn(welcome.acked)
        if self._tapes is not None:
            self._lanes.send(self._tapes.state())
        self._keeper.ack(self._boot, welcome.acked)
        self._voice.takes_enclosures = EnclosureState.__struct_config__.tag in welcome.takes
        self._control.link_up()
        self._commanding.report()
        self._reach.report()
        self._changing.link_up()
        self._telling.link_up(takes=SightingReport.__struct_config__.tag in welcome.takes)
        self._pacer.touch()

    def link_lost(self) -> None:
        """End leases and holds; nobody looks at pictures any more."""
        if self.linked.is_set() and self._tapes is not None:
            self._tapes.trigger(Trigger.LINK_LOST, "the link to the hub was lost")
        self.linked.clear()
        self._control.link_lost()
        self._telling.link_lost()
        self._pacer.touch()
        self._pictures.watch((), {})
        self.look()

    def look(self) -> None:
        """Have the cameras read that somebody looks at, here or at the hub."""
        self._adapter.watch(self._pictures.watched())

    def handle(self, message: FromHub) -> None:
        """Act on one message. STOP and driving are done when this returns."""
        match message:
            case Ack():
                self._keeper.ack(message.boot, message.below)
                self._lanes.acks += 1
                return
            case ResendRequest():
                self._lanes.owe(message.boot, message.first, message.below)
                return
            case DriveFrame():
                self._control.drive(message)
            case StopRequest():
                latched = self._control.stop(message)
                if latched is not None:
                    self._spawn(self._control.keep_stop(message.device, latched))
            case LeaseRequest() | LeaseForceRequest():
                self._control.lease(message)
            case ResetRequest():
                self._spawn(self._control.reset(message))
            case CommandRequest():
                self._spawn(self._commanding.ask(message))
            case ChangeRequest():
                self._spawn(self._changing.ask(message))
            case CommandCancel():
                self._commanding.cancel(message)
            case OverrideRequest():
                self._control.override(message)
                return
            case StreamSubscription():
                self._pictures.watch(message.streams, message.forms, message.boxes)
                self.look()
            case KeyframeRequest():
                self._pictures.ask_key(message.stream, message.form)
            case ReconnectRequest():
                self._reconnect(message)
            case RecordingRequest():
                self._record(message)
            case _:
                log.debug("nothing to do for %s", type(message).__name__)
        self._pacer.touch()

    def _reconnect(self, asked: ReconnectRequest) -> None:
        def done(outcome: CommandOutcome) -> None:
            good = outcome.phase is CommandPhase.SUCCEEDED
            kind = "device reconnected" if good else "device not reconnected"
            self._voice.tell(kind, outcome.message, device=asked.device, who=asked.who, good=good)

        self._adapter.reconnect(asked.device, done)

    def _record(self, asked: RecordingRequest) -> None:
        if self._tapes is None:
            why = "the description says nothing of recording"
            self._voice.tell("recording_refused", why, who=asked.who)
        elif asked.alarm:
            self._tapes.trigger(Trigger.ALARM, asked.why, asked.who)
        elif asked.stream and self._tapes.films is None:
            why = "this gateway cannot film cameras; install talaia[camera] there"
            self._voice.tell("recording_refused", why, who=asked.who)
        elif asked.on:
            self._tapes.begin(asked.who, asked.why, asked.stream)
        else:
            self._tapes.end(asked.who, asked.stream)

    def _spawn(self, work: Coroutine[None, None, None]) -> None:
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._ended)

    def _ended(self, task: asyncio.Task[None]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and task.exception() is not None:
            log.error("a request failed", exc_info=task.exception())
        self._pacer.touch()

    async def close(self) -> None:
        """Finish what was begun."""
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await self._commanding.close()
