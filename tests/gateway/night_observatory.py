"""An observatory of numbers: what commands do to it, with delays and faults; for pure tests."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from talaia.gateway.night.arming import NightArming
from talaia.gateway.night.block_run import BlockParts
from talaia.gateway.night.executor import NightExecutor
from talaia.gateway.night.night_values import (
    NightChoice,
    NightCommand,
    NightEvent,
    NightView,
    ObservationChange,
    PartRun,
    PlanQuestion,
    StepAnswer,
)
from talaia.gateway.night.target_place import place_of_date
from talaia.model.interlocks.enclosure import ClosingOrder
from talaia.model.observing.requests import (
    Configuration,
    Constraints,
    Guiding,
    Request,
    RequestGroup,
    Urgency,
    Window,
)
from talaia.model.observing.targets import IcrsTarget
from talaia.model.units import astronomy
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import CommandPhase, Scalar

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.model.night_frames import NightFlats
    from talaia.model.observing.targets import Target
    from talaia.model.site import Site

SITE_FILE = Path(__file__).parents[2] / "examples" / "observatory" / "site.yaml"
# 2026-11-23 20:00 UTC: night at the example's place.
EVENING = 1_795_464_000.0
P = CommandPhase
EXPOSING = ("camera/expose", "camera/dark", "camera/bias", "camera/flat")
MOVING = (
    *("dome/open", "telescope/unpark", "telescope/goto", "telescope/goto_altaz"),
    *("telescope/track", "camera/expose"),
)
SAFE = ("telescope/park", "dome/close", "camera/abort", "camera/cooler", "camera/cool")


@cache
def example_site() -> Site:
    return load_site(SITE_FILE.read_text())


def request(
    name: str,
    *,
    frames: int = 3,
    seconds: float = 60.0,
    urgency: Urgency = Urgency.NORMAL,
    priority: float = 10.0,
    hours_east: float = 1.0,
    start: float = EVENING - 86_400.0,
    guiding: Guiding = Guiding.OPTIONAL,
    target: Target | None = None,
    constraints: Constraints = Constraints(),  # noqa: B008 - it is frozen
    **configuration: Any,
) -> RequestGroup:
    """Ask for frames of a place that is high in the evening, or of another target."""
    jd = astronomy.julian_day(EVENING)
    place = example_site().place
    assert place is not None
    ra = (astronomy.sidereal_hours(jd, place.longitude) + hours_east) % 24.0
    return RequestGroup(
        id=f"g-{name}",
        proposal="school",
        urgency=urgency,
        priority=priority,
        requests=(
            Request(
                id=name,
                target=target or IcrsTarget(name=name, ra=ra * 15.0 % 360.0, dec=42.0),
                constraints=constraints,
                configurations=(
                    Configuration(exposure=seconds, count=frames, guiding=guiding, **configuration),
                ),
                windows=(Window(start=start, end=EVENING + 86_400.0),),
            ),
        ),
    )


class PureObservatory:
    """Acts on commands after a while; a ledger says what was asked, and how things stood."""

    def __init__(
        self,
        *,
        arming: NightArming | None = None,
        parts: BlockParts | None = None,
        flats: NightFlats | None = None,
        order: ClosingOrder = ClosingOrder.MOUNT_FIRST,
        **night: Any,
    ) -> None:
        """Begin in the evening, closed and parked."""
        site = example_site()
        assert site.night is not None
        assert site.place is not None
        self.night = replace(site.night, flats=flats) if flats is not None else site.night
        self.night = replace(self.night, **night)
        self.executor = NightExecutor(
            night=self.night,
            enclosure=replace(site.enclosures["dome"], order=order),
            place=site.place,
            parts=parts if parts is not None else BlockParts(),
            arming=arming,
        )
        self.now, self.sun = 0.0, -30.0
        self.shutter, self.telescope = "closed", "parked"
        self.closing = self.barred = self.person = ""
        self.blind = self.mute_planner = False
        # It follows the sky; and the roof's guard, which is not the night's, is alive.
        self.tracks, self.guarded = False, True
        # Light of the sky on a flat (counts a second above the pedestal); none: nobody measures.
        self.skylight: Callable[[], float] | None = lambda: 2000.0
        # Of the sky, as measured; and what of it should be, and is not.
        self.clouds: float | None = None
        self.seeing: float | None = None
        self.unread: frozenset[str] = frozenset()
        # Of the stars in the next field that is centred.
        self.field_seeing: float | None = None
        # What the camera says of itself.
        self.binning, self.gain, self.angle = 1.0, 0.0, 0.0
        # Commands that fail, are refused or never end, by what becomes of them.
        self.faults: dict[str, CommandPhase | None] = {}
        # The planner has nothing before so long (s).
        self.idle_for = 60.0
        self.choice: Callable[[PlanQuestion], str] = lambda _question: ""
        self.durations = {"dome/open": 20.0, "dome/close": 20.0, "telescope/goto": 10.0}
        self.ledger: list[tuple[float, str, NightView]] = []
        # Of each command that was asked for, in order.
        self.args: list[Mapping[str, Scalar]] = []
        self.frames: list[str] = []
        self.events: list[NightEvent] = []
        # Of nights that have ended.
        self.summaries: list[NightEvent] = []
        self.changes: list[ObservationChange] = []
        self._pending: list[tuple[float, NightCommand]] = []
        self._later: list[tuple[float, Callable[[], None]]] = []

    @property
    def view(self) -> NightView:
        known = not self.blind
        return NightView(
            now=self.now,
            time=EVENING + self.now,
            sun=self.sun,
            closing=self.closing,
            barred=self.barred or self.closing,
            opened=self.shutter == "opened" if known else None,
            closed=self.shutter == "closed" if known else None,
            parked=self.telescope == "parked" if known else None,
            person=self.person,
            clouds=self.clouds,
            seeing=self.seeing,
            unread=self.unread,
            binning=self.binning if known else None,
            gain=self.gain if known else None,
            rotator=self.angle if known else None,
            tracking=self.tracks if known else None,
        )

    def ask(self, *groups: RequestGroup) -> None:
        self.executor.chooser.replace_requests(groups, {}, frozenset())

    def arm(self, until: float = 0.0) -> None:
        assert self.executor.arm_night("ada", until, self.view) == ""

    def pass_time(self, seconds: float, step: float = 1.0) -> None:
        ends = self.now + seconds
        while self.now < ends:
            self.turn()
            self.now += step

    def until(self, holds: Callable[[], bool], within: float = 3600.0) -> None:
        ends = self.now + within
        while not holds():
            assert self.now < ends, (self.executor.phase, self.executor.why, self.events[-3:])
            self.pass_time(1.0)

    def turn(self) -> None:
        """Let everything that is due happen once."""
        # The roof's guard, which is not the night's: it closes whatever the night does.
        if self.guarded and self.closing and self.shutter != "closed":
            self.telescope, self.shutter = "parked", "closed"
            self.tracks = False
        for due, command in [one for one in self._pending if one[0] <= self.now]:
            self._pending.remove((due, command))
            self._end(command)
        for action in self.executor.update_night(self.view):
            match action:
                case NightCommand():
                    self.ledger.append((self.now, action.command, self.view))
                    self.args.append(action.args)
                    self._begin(action)
                case PlanQuestion() if not self.mute_planner:
                    self.executor.chooser.take_choice(
                        NightChoice(
                            action.number, self.choice(action), EVENING + self.now + self.idle_for
                        )
                    )
                case NightEvent(kind="night_ended"):
                    self.summaries.append(action)
                case NightEvent():
                    self.events.append(action)
                case ObservationChange():
                    self.changes.append(action)
                case PartRun():
                    self.ledger.append((self.now, f"part/{action.part}", self.view))
                    phase = self.faults.get(f"part/{action.part}", P.SUCCEEDED)
                    if action.part == "centre" and self.field_seeing is not None:
                        self.seeing = self.field_seeing
                    if phase is not None:
                        self.executor.take_answer(StepAnswer(action.id, phase, "told"))
                case _:
                    pass

    def _begin(self, command: NightCommand) -> None:
        seconds = self.durations.get(command.command, 1.0)
        if command.command in EXPOSING:
            seconds = float(command.args["seconds"]) + 2.0
        if (self.barred or self.closing) and command.command in MOVING:
            self.executor.take_answer(StepAnswer(command.id, P.REFUSED, "Rain"))
            return
        if command.command == "camera/abort":
            self._pending = [one for one in self._pending if one[1].command not in EXPOSING]
        self._pending.append((self.now + seconds, command))

    def _end(self, command: NightCommand) -> None:
        phase = self.faults.get(command.command, P.SUCCEEDED)
        if phase is None:
            return
        if phase is P.SUCCEEDED:
            match command.command:
                case "dome/open":
                    self.shutter = "opened"
                case "dome/close":
                    self.shutter = "closed"
                case "telescope/unpark":
                    self.telescope = "idle"
                case "telescope/park":
                    self.telescope = "parked"
                    self.tracks = False
                case "telescope/goto" | "telescope/track":
                    self.tracks = True
                case "telescope/goto_altaz":
                    self.tracks = False
                case "camera/binning":
                    self.binning = float(command.args["factor"])
                case "camera/gain":
                    self.gain = float(command.args["gain"])
                case "rotator/goto":
                    self.angle = float(command.args["angle"])
                case "camera/expose":
                    self.frames.append(str(command.args["target"]))
        level = None
        if command.command == "camera/flat" and self.skylight is not None and self.night.flats:
            light = self.skylight() * float(command.args["seconds"])
            level = min(65_535.0, self.night.flats.pedestal + light)
        self.executor.take_answer(StepAnswer(command.id, phase, "its own words", level=level))

    def asked(self, command: str) -> list[float]:
        return [at for at, name, _ in self.ledger if name == command]


__all__ = ["EVENING", "MOVING", "SAFE", "PureObservatory", "place_of_date", "request"]
