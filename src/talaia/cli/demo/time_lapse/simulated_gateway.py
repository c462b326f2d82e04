"""What of a gateway decides and acts, on a simulated clock: real safety, real commands, real night.

Its link, its spool and its outbox stay in real time with who made it; see `HubSide`.
"""

from __future__ import annotations

import asyncio
import logging
from concurrent.futures import Executor, Future
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, ParamSpec, TypeVar

from msgspec.structs import replace

from talaia.clock import SECOND
from talaia.gateway.actuation import Actuation
from talaia.gateway.assembly.star_parts import make_star_parts
from talaia.gateway.fits.whole_files import WholeFiles
from talaia.gateway.night.night_service import NightService
from talaia.gateway.night.planning.planner_answers import PlannerAnswers
from talaia.gateway.safety.supervision import Heartbeats, Supervision
from talaia.wire.frames import (
    CommandCancel,
    CommandRequest,
    Event,
    NightArmRequest,
    NightDisarmRequest,
    NightPhase,
    NightState,
    ObservationAck,
    OverrideRequest,
    RequestSync,
)

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from talaia.cli.demo.in_process_observatory import InProcessObservatory
    from talaia.clock import Clock
    from talaia.gateway.fits.frame_arrivals import FrameArrivals
    from talaia.gateway.fits.outbox import ArchiveOutbox
    from talaia.gateway.night.planning.planner_question import (
        PlannerAnswer,
        PlannerQuestion,
        PlannerSetup,
    )
    from talaia.model.site import Site
    from talaia.wire.frames import FromGateway, FromHub

__all__ = ["HubSide", "SimulatedGateway"]

log = logging.getLogger(__name__)
_Args = ParamSpec("_Args")
_Result = TypeVar("_Result")


class HubSide(NamedTuple):
    """What lives in real time. Each may be used from any thread.

    Attributes:
        send: queues a message for the hub.
        outbox: keeps pictures until the hub has them.
        arrivals: hands a picture to whoever waits for it, on its way there.

    """

    send: Callable[[FromGateway], None]
    outbox: ArchiveOutbox
    arrivals: FrameArrivals


class _Here(Executor):
    """Works at once, on the caller's thread: while it does, simulated time stands."""

    def submit(
        self, fn: Callable[_Args, _Result], /, *args: _Args.args, **kwargs: _Args.kwargs
    ) -> Future[_Result]:
        future: Future[_Result] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:  # noqa: BLE001 - as a pool's thread keeps it
            future.set_exception(error)
        return future


class _PlannerHere:
    """A `NightPlanner` without a process of its own, for which simulated time would not wait."""

    def __init__(self, answered: Callable[[PlannerAnswer], None]) -> None:
        self._answered, self._answers = answered, PlannerAnswers()

    def take_setup(self, setup: PlannerSetup) -> None:
        self._answers.take_setup(setup)

    def ask(self, question: PlannerQuestion) -> None:
        loop = asyncio.get_running_loop()
        loop.call_soon(lambda: self._answered(self._answers.answer_question(question)))

    def begin_process(self) -> None:
        """There is none."""

    async def run(self) -> None:
        """There is nothing to keep."""


class _Output:
    """A `ControlOutput` and `EventSink` whose events have the simulated time."""

    def __init__(
        self, robot: InProcessObservatory, clock: Clock, send: Callable[[FromGateway], None]
    ) -> None:
        self.drive, self.stop = robot.drive, robot.stop
        self._clock, self.send = clock, send

    def record_event(self, kind: str, device: str, message: str, who: str, *, good: bool) -> None:
        time_us = self._clock.wall_ns() // 1000
        log.info("%s %s %s", kind, device, message)
        self.send(
            Event(
                kind=kind,
                device=device,
                message=message[:2000],
                who=who,
                time_us=time_us,
                good=good,
            )
        )

    def report_event(
        self, kind: str, message: str, *, device: str = "", who: str = "", good: bool = False
    ) -> None:
        self.record_event(kind, device, message, who, good=good)


class SimulatedGateway:
    """One run. On a simulated event loop only.

    Attributes:
        phase: of the night, as it was told last.
        actuation: who acts.

    """

    def __init__(
        self,
        *,
        site: Site,
        clock: Clock,
        robot: InProcessObservatory,
        hub: HubSide,
        data: Path,
        boot: str,
        speed: float,
    ) -> None:
        """Take up what an earlier run left in ``data``; ``speed`` is told with the night's state.

        Raises:
            ValueError: the site has no night, or no place.
            SpoolError: a file of the night is damaged.

        """
        if site.night is None or site.place is None:
            raise ValueError(f"{site.site} does not observe by itself")
        self._hub, self._clock, self._speed = hub, clock, speed
        self.phase = NightPhase.DISARMED
        self._state: NightState | None = None
        output = _Output(robot, clock, self._send)
        self.actuation = Actuation(
            site=site,
            boot=boot,
            clock=clock,
            output=output,
            target=robot,
            readings=robot,
            data=data,
            on_disk=_write_here,
        )
        judged = self.actuation.interlocks
        beats = Heartbeats(site, judged, robot, output)
        self._supervision = Supervision(clock, lambda: judged.judged_ns, (), beats)
        self._service = NightService(
            site=site,
            night=site.night,
            place=site.place,
            clock=clock,
            boot=boot,
            folder=data / "night",
            actuation=self.actuation,
            send=self._send,
            events=output,
            on_disk=_write_here,
            star_parts=partial(
                make_star_parts,
                night=site.night,
                clock=clock,
                events=output,
                arrivals=hub.arrivals,
                judge=judged.conditions,
            ),
            planner=_PlannerHere,
            arrivals=hub.arrivals,
        )
        files = WholeFiles(
            folder=data / "taking",
            outbox=hub.outbox,
            events=output,
            clock=clock,
            disk=_Here(),
            site=site.name,
            place=site.place,
        )
        robot.picture_taken = lambda file: files.keep_file("camera", lambda: file)
        self._tasks: list[asyncio.Task[None]] = []

    def start(self) -> None:
        """Begin to guard and to observe."""
        runs = self.actuation.keep_written, self._supervision.run, self._service.run
        self._tasks = [asyncio.create_task(run()) for run in runs]
        self.actuation.timer.reset_timer()

    def link_up(self) -> None:
        """Tell a new link how all stands."""
        self.actuation.driving.link_up()
        self.actuation.commands.report_states()
        self._service.link_up(takes=True)

    def link_lost(self) -> None:
        """Keep what is to be told. No device is let go: the link is in another time."""
        self._service.link_up(takes=False)

    def handle_message(self, message: FromHub) -> None:
        """Act on what the hub says; what does not concern a night is passed over."""
        match message:
            case NightArmRequest() | NightDisarmRequest() | RequestSync() | ObservationAck():
                self._service.handle_message(message)
            case CommandRequest():
                asked = self.actuation.commands.handle_request(message)
                self.actuation.requests.spawn_task(asked)
            case CommandCancel():
                self.actuation.commands.cancel_command(message)
            case OverrideRequest():
                self.actuation.driving.override_interlock(message)
            case _:
                return
        self.actuation.timer.reset_timer()

    def repeat_state(self) -> None:
        """Tell once more how the night stands: its time has gone on."""
        if self._state is not None:
            self._send(replace(self._state, answer_to="", refused=""))

    def _send(self, message: FromGateway) -> None:
        if isinstance(message, NightState):
            self.phase = message.phase
            now = self._clock.wall_ns() / SECOND
            message = self._state = replace(message, site_time=now, speed=self._speed)
        self._hub.send(message)

    async def close(self) -> None:
        """End all of it."""
        self.actuation.timer.close()
        for task in reversed(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await self._service.close()
        await self.actuation.sequences.close()
        await self.actuation.requests.close()
        await self.actuation.commands.close()


async def _write_here(work: Callable[[], None]) -> None:
    work()
