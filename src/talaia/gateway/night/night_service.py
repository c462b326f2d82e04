"""Runs the executor of a night beside the devices: looks, asks, writes down, tells the hub.

Nothing here keeps a roof safe, and nothing that does waits for anything here: interlocks and the
roof's guard have their own time. Event loop only.

Long, because what the devices say, what the executor asks for and what the hub is told meet here.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from msgspec.structs import replace

from talaia.clock import SECOND
from talaia.gateway.commands.request_tasks import RequestTasks
from talaia.gateway.night.device_hold import NightHolds
from talaia.gateway.night.executor import NightExecutor
from talaia.gateway.night.frames.frame_files import FrameFiles
from talaia.gateway.night.night_calls import NightCalls
from talaia.gateway.night.night_commands import NightCommands
from talaia.gateway.night.night_readings import NightReadings
from talaia.gateway.night.night_store import NightStore
from talaia.gateway.night.night_values import (
    NightChoice,
    NightCommand,
    NightEvent,
    NightView,
    ObservationChange,
    PartRun,
    PlanQuestion,
)
from talaia.gateway.night.planning.charged_time import seconds_left
from talaia.gateway.night.planning.planner_process import PlannerProcess
from talaia.gateway.night.planning.planner_question import PlannerQuestion, PlannerSetup
from talaia.gateway.night.request_intake import RequestIntake
from talaia.model.night_section import NightLinkLoss
from talaia.wire.frames import (
    NightArmRequest,
    NightDisarmRequest,
    NightPhase,
    NightPlan,
    NightState,
    ObservationAck,
    RequestRevision,
    RequestSync,
)

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable
    from pathlib import Path

    from talaia.clock import Clock
    from talaia.gateway.actuation import Actuation
    from talaia.gateway.fits.frame_arrivals import FrameArrivals
    from talaia.gateway.night.imaging.night_star_devices import AskDevice
    from talaia.gateway.night.imaging.part_runs import PartRuns
    from talaia.gateway.night.night_values import NightAction, StepAnswer
    from talaia.gateway.night.planning.planner_process import NightPlanner
    from talaia.gateway.night.planning.planner_question import PlannerAnswer
    from talaia.gateway.night.request_intake import RequestSet
    from talaia.gateway.ports import EventSink
    from talaia.model.interlocks.enclosure import Place
    from talaia.model.night_section import NightSection
    from talaia.model.site import Site
    from talaia.wire.frames import FromGateway

__all__ = ["NightMessage", "NightService"]

log = logging.getLogger(__name__)
# Between two looks (s); interlocks look ten times a second.
LOOK_S = 0.25
NightMessage = NightArmRequest | NightDisarmRequest | RequestSync | ObservationAck


class NightService:
    """See the module.

    Attributes:
        planner: its process; to be run.
        calls: who is called when something failed.

    """

    def __init__(
        self,
        *,
        site: Site,
        night: NightSection,
        place: Place,
        clock: Clock,
        boot: str,
        folder: Path,
        actuation: Actuation,
        send: Callable[[FromGateway], None],
        events: EventSink,
        on_disk: Callable[[Callable[[], None]], Awaitable[None]],
        star_parts: Callable[[AskDevice], PartRuns],
        planner: Callable[[Callable[[PlannerAnswer], None]], NightPlanner] = PlannerProcess,
        arrivals: FrameArrivals | None = None,
    ) -> None:
        """Take up what an earlier run left.

        Args:
            site: the description.
            night: its section.
            place: where it is.
            clock: monotonic for spans, wall for the Sun and what people ask.
            boot: names this run; part of the commands' ids.
            folder: where its files are.
            actuation: who acts, and what may be done now.
            send: tells the hub.
            events: takes what is worth writing down.
            on_disk: runs a blocking write elsewhere, in order.
            star_parts: makes what looks at stars, by who asks devices for it.
            planner: makes who plans, by who takes the answers.
            arrivals: tells of files that are kept; none: nobody keeps any.

        Raises:
            SpoolError: a file of the night is damaged.

        """
        self._site, self._night, self._place, self._clock = site, night, place, clock
        self._actuation, self._send, self._events = actuation, send, events
        self._on_disk, self._store = on_disk, NightStore(folder)
        # What the hub handed over last; a night without a hub goes by these.
        self._requests = self._store.read_requests()
        # Each start has ids of its own: observations of one gateway are never told apart wrongly.
        self._book = self._store.read_book(f"{site.site}-{boot[:12]}")
        self.planner, self.calls = planner(self._take_plan), NightCalls()
        arming = self._written_arming = self._store.read_arming()
        self._intake, self._files = RequestIntake(), FrameFiles(arrivals, site)
        self._commands = NightCommands(actuation.commands, self._take_answer, self._files)
        self._holds = NightHolds(site, night, actuation.commands, clock)
        self._parts = star_parts(self._commands.make_asker(f"night-{boot}-part", self._holds))
        self._files.measure = self._parts.measure_level
        self._executor = NightExecutor(
            night=night,
            enclosure=site.enclosures[night.enclosure],
            place=place,
            parts=self._parts.block_parts(),
            id_prefix=f"night-{boot}",
            arming=arming,
        )
        self._readings = NightReadings(
            site=site, place=place, interlocks=actuation.interlocks, clock=clock
        )
        # Ends the wait for the next step.
        self._wake = asyncio.Event()
        self._tasks = RequestTasks(self._wake.set)
        # The hub of this link understands nights; an older one is told nothing of them.
        self._takes_night = False
        # What the hub was told last on this link: only what differs is sent.
        self._told: NightState | None = None
        self._plan: NightPlan | None = None
        # Ids of what was asked of it lately: each is done once.
        self._answers: dict[str, str] = {}
        for update in self._book.close_interrupted(self._now_s()):
            log.info("observation %s: %s", update.id, update.why)
        self._hand_over_requests()
        actuation.interlocks.attend_devices(self._attends)
        if arming.armed_by:
            self.planner.begin_process()

    # ── what the hub says ──

    def link_up(self, *, takes: bool) -> None:
        """Tell a new link how the night stands, and all that was not acknowledged."""
        self._takes_night = takes
        self._told = None
        if not takes:
            return
        self._send(RequestRevision(revision=self._requests.revision))
        self._send_state()
        if self._plan is not None:
            self._send(self._plan)
        for update in self._book.content.waiting:
            self._send(update)

    def handle_message(self, message: NightMessage) -> None:
        """Act on what the hub says of the night."""
        match message:
            case NightArmRequest() | NightDisarmRequest():
                if message.id in self._answers:
                    self._send_state(message.id, self._answers[message.id])
                else:
                    self._answers[message.id] = ""
                    self._tasks.spawn_task(self._arm(message))
            case RequestSync():
                whole = self._intake.take_piece(message)
                if whole is not None:
                    self._requests = whole
                    self._book.settle_requests(whole.groups)
                    self._hand_over_requests()
                    self._tasks.spawn_task(self._keep_requests())
                    self._tasks.spawn_task(self._keep_observations(()))
            case ObservationAck():
                if self._book.acknowledge_updates(message.number):
                    self._tasks.spawn_task(self._keep_observations(()))
        self._wake.set()

    async def _arm(self, asked: NightArmRequest | NightDisarmRequest) -> None:
        refused, view = "", self._view()
        if isinstance(asked, NightArmRequest):
            refused = self._executor.arm_night(asked.who, asked.until, view)
            kind, why = "night_armed", "until somebody disarms it"
            if asked.until:
                why = f"until {datetime.fromtimestamp(asked.until, UTC):%Y-%m-%d %H:%M} UTC"
        else:
            why = asked.why or f"disarmed by {asked.who}"
            self._executor.disarm_night(why, view)
            kind = "night_disarmed"
        if not refused and (problem := await self._keep_arming()):
            refused = problem
            if isinstance(asked, NightArmRequest):
                # What is not on disk does not survive a restart: it is not armed at all.
                self._executor.disarm_night(problem, self._view())
        good = not refused
        self._events.report_event(
            kind if good else f"{kind}_refused", refused or why, who=asked.who, good=good
        )
        if good:
            self.calls.clear_calls()
        if self._executor.arming.armed_by:
            self.planner.begin_process()
        self._answers[asked.id] = refused
        while len(self._answers) > 100:
            self._answers.pop(next(iter(self._answers)))
        self._send_state(asked.id, refused)
        self._wake.set()

    def _hand_over_requests(self) -> None:
        groups = self._requests.groups
        # Who pays for each request.
        self._payers = {one.id: group.proposal for group in groups for one in group.requests}
        self._hand_over_hours()
        self._executor.chooser.replace_requests(
            groups, self._book.frames_done(groups), self._book.ended
        )
        self.planner.take_setup(_planner_setup(self._place, self._night, self._requests))

    def _hand_over_hours(self) -> None:
        charged = self._book.charged_seconds()
        self._executor.chooser.take_hours(seconds_left(self._requests.proposals, charged))

    # ── the night ──

    async def run(self) -> None:
        """Look, and do what is due, until cancelled."""
        while True:
            self.look_once()
            self._wake.clear()
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(LOOK_S):
                    await self._wake.wait()

    @property
    def is_armed(self) -> bool:
        """Whether the night may begin by itself, or has not brought roof and telescope to rest."""
        arming = self._executor.arming
        return bool(arming.armed_by) or arming.opened

    def look_once(self) -> None:
        """Let the executor go on by how things stand now."""
        view = self._view()
        changes: list[ObservationChange] = []
        actions = self._executor.update_night(view)
        # Before anything is asked in its name: a hold of the night does not keep the night away.
        self._holds.update_holds(self._executor.phase, self._executor.arming.armed_by)
        for action in actions:
            self._carry_out(action, changes)
        if changes:
            self._tasks.spawn_task(self._keep_observations(tuple(changes)))
        if self._executor.arming != self._written_arming:
            self._tasks.spawn_task(self._keep_arming())
        if self._executor.night_state() != self._told:
            self._send_state()

    def _carry_out(self, action: NightAction, changes: list[ObservationChange]) -> None:
        match action:
            case NightCommand():
                self._parts.break_off()
                self._commands.begin_command(action, self._holds.who)
            case PartRun():
                self._parts.begin_part(action, self._take_answer)
            case PlanQuestion():
                self._ask_planner(action)
            case NightEvent():
                self._events.report_event(action.kind, action.message, good=action.good)
                self.calls.call_for(action)
            case ObservationChange():
                changes.append(action)
                self._parts.follow_change(action)

    def _take_answer(self, answer: StepAnswer) -> None:
        self._executor.take_answer(answer)
        self._wake.set()

    def _ask_planner(self, question: PlanQuestion) -> None:
        view, groups = self._view(), self._requests.groups
        self.planner.ask(
            PlannerQuestion(
                number=question.number,
                time=question.time,
                done=self._book.frames_done(groups),
                ended=tuple(sorted(self._book.ended)),
                held=self._executor.chooser.held_requests(),
                charged=self._book.charged_seconds(),
                seeing=view.seeing,
                clouds=view.clouds,
                unread=view.unread,
                parked=view.parked is True,
                park=view.pointing,
                focus=self._parts.focus_news(question.time),
            )
        )

    def _take_plan(self, answer: PlannerAnswer) -> None:
        self._executor.chooser.take_choice(
            NightChoice(answer.number, answer.request, answer.wait_until, answer.reason)
        )
        if answer.plan is not None:
            why_not, times = list(answer.why_not), self._night.times
            self._plan = NightPlan(plan=answer.plan, why_not=why_not, instrument=times)
            if self._takes_night:
                self._send(self._plan)
        self._wake.set()

    def _view(self) -> NightView:
        person = self._holds.person_at_work(self._clock.monotonic_ns())
        return self._readings.look_now(person, self._parts.latest_seeing())

    def _attends(self, device: str) -> bool:
        """Tell whether the night looks after a device while the hub is away."""
        acts = self._executor.phase not in {NightPhase.DISARMED, NightPhase.FAULT}
        goes_on = self._night.link_loss is NightLinkLoss.CONTINUE
        return acts and goes_on and device in self._holds.devices

    # ── disk and hub ──

    async def _keep_observations(self, changes: tuple[ObservationChange, ...]) -> None:
        time = self._now_s()
        # A frame's file is named with the change that counts the frame.
        files = self._files.take_names() if changes else []
        updates = [
            self._book.record_change(change, time, files if not number else (), self._payers)
            for number, change in enumerate(changes)
        ]
        self._hand_over_hours()
        # Encoded now: the book goes on changing while the disk is busy.
        if await self._write(self._store.book_writer(self._book), "what was observed"):
            self._book.write_whole()
        # On disk first: what the hub was told is never told otherwise by a later run.
        for update in updates:
            if self._takes_night:
                self._send(update)

    async def _keep_requests(self) -> None:
        requests = self._requests
        problem = await self._write(lambda: self._store.write_requests(requests), "what is asked")
        if not problem and self._takes_night:
            self._send(RequestRevision(revision=requests.revision))

    async def _keep_arming(self) -> str:
        arming = self._written_arming = self._executor.arming
        return await self._write(lambda: self._store.write_arming(arming), "who armed the night")

    async def _write(self, work: Callable[[], None], what: str) -> str:
        """Write; gives what is wrong, if so."""
        try:
            await self._on_disk(work)
        except OSError as error:
            problem = f"{what} cannot be written: {error}"
            self._events.report_event("night_not_written", problem)
            return problem
        return ""

    def _send_state(self, answer_to: str = "", refused: str = "") -> None:
        self._told = self._executor.night_state()
        if self._takes_night or answer_to:
            self._send(replace(self._told, answer_to=answer_to, refused=refused))

    def _now_s(self) -> float:
        return self._clock.wall_ns() / SECOND

    async def close(self) -> None:
        """Finish what is written; commands that run still will read as unknown."""
        await self._parts.close()
        await self._commands.close()
        await self._tasks.close()


def _planner_setup(place: Place, night: NightSection, requests: RequestSet) -> PlannerSetup:
    """Tell the planner what is asked, and of which telescope."""
    return PlannerSetup(
        latitude=place.latitude,
        longitude=place.longitude,
        elevation=place.elevation,
        instrument=night.times,
        pauses=night.pauses,
        proposals=requests.proposals,
        groups=requests.groups,
    )
