"""An observatory, its gateway and a hub on one clock, for a night: real safety, real commands.

The gateway here is what decides and acts: interlocks, roof's guard, heartbeats, commands with their
journal on disk, the night with its files, the archive's outbox. Links and spools have their own
tests; the hub is a stand-in that acknowledges. The planner answers in this process, by the code
that its own process runs.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import itertools
from collections.abc import Awaitable, Callable
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any

from talaia.clock import SECOND, HandClock
from talaia.gateway.actuation import Actuation
from talaia.gateway.fits.frame_arrivals import FrameArrivals
from talaia.gateway.fits.outbox import ArchiveOutbox
from talaia.gateway.fits.whole_files import WholeFiles
from talaia.gateway.night.imaging.frame_reckoner import FrameReckoner
from talaia.gateway.night.imaging.part_runs import PartRuns
from talaia.gateway.night.night_service import NightService
from talaia.gateway.night.planning.planner_answers import PlannerAnswers
from talaia.gateway.night.planning.planner_question import (
    PlannerAnswer,
    PlannerQuestion,
    PlannerSetup,
)
from talaia.gateway.night.target_place import sun_altitude
from talaia.gateway.safety.supervision import Heartbeats, Supervision
from talaia.imaging.frame_tasks import measure_level
from talaia.model.observing.requests import Proposal, RequestGroup
from talaia.model.site import Site
from talaia.simulated_time import SimulatedLoop
from talaia.wire.frames import (
    CommandRequest,
    Event,
    NightArmRequest,
    NightPhase,
    NightPlan,
    NightState,
    ObservationAck,
    ObservationUpdate,
    RequestSync,
)

from .sky_robot import SkyRobot, Truth

# Of the simulator, and the least that time moves by: values are unknown after two of them.
STEP_S = 1.0
SCHOOL = Proposal(id="school", share=1.0, hours_allocated=100.0)


class Inline(Executor):
    """Works at once, on the caller's thread: disks are not what takes time here."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:  # noqa: BLE001 - as a pool's thread keeps it
            future.set_exception(error)
        return future


class ReckonerHere(FrameReckoner):
    """Reckons from pictures in this process: time stands meanwhile."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        return Inline().submit(fn, *args, **kwargs)


class PlannerHere:
    """The planner's answers without its process; ``dead``: it says nothing."""

    def __init__(self, answered: Callable[[PlannerAnswer], None]) -> None:
        """Know nothing yet."""
        self._answered, self._answers = answered, PlannerAnswers()
        self.dead = False

    def take_setup(self, setup: PlannerSetup) -> None:
        self._answers.take_setup(setup)

    def ask(self, question: PlannerQuestion) -> None:
        if not self.dead:
            loop = asyncio.get_running_loop()
            loop.call_soon(lambda: self._answered(self._answers.answer_question(question)))

    def begin_process(self) -> None: ...

    async def run(self) -> None: ...


class HubStandIn:
    """Takes what the gateway says, and acknowledges observations while it is there."""

    def __init__(self) -> None:
        """Be there."""
        self.there = True
        self.updates: dict[int, ObservationUpdate] = {}
        self.states: list[NightState] = []
        self.events: list[Event] = []
        self.plans: list[NightPlan] = []
        self.answer: Callable[[Any], None] = lambda _message: None

    def take(self, message: Any) -> None:
        if isinstance(message, Event):
            self.events.append(message)
        if isinstance(message, NightState):
            self.states.append(message)
        if isinstance(message, NightPlan):
            self.plans.append(message)
        if self.there and isinstance(message, ObservationUpdate):
            known = self.updates.setdefault(message.number, message)
            assert known == message, "an update was told otherwise"
            asyncio.get_running_loop().call_soon(self.answer, ObservationAck(number=message.number))


class Gateway:
    """One run of the gateway on a data folder; killed or ended."""

    def __init__(self, world: NightWorld, number: int) -> None:
        """Take up what an earlier run left, and begin."""
        site, clock, data = world.site, world.clock, world.data
        self._world, hub = world, world.hub
        night, place = site.night, site.place
        assert night is not None
        assert place is not None
        boot = f"boot{number:08d}"
        robot = world.robot

        class Output:
            drive, stop = robot.drive, robot.stop

            def send(self, message: Any) -> None:
                hub.take(message)

            def record_event(
                self, kind: str, device: str, message: str, who: str, *, good: bool
            ) -> None:
                hub.take(Event(kind=kind, device=device, message=message[:2000], who=who,
                               time_us=clock.wall_ns() // 1000, good=good))  # fmt: skip

            def report_event(
                self, kind: str, message: str, *, device: str = "", who: str = "",
                good: bool = False,
            ) -> None:  # fmt: skip
                self.record_event(kind, device, message, who, good=good)

        output, arrivals = Output(), FrameArrivals()
        self.actuation = Actuation(
            site=site, boot=boot, clock=clock, output=output, target=robot, readings=robot,
            data=data, on_disk=self._on_disk,
        )  # fmt: skip
        heartbeats = Heartbeats(site, self.actuation.interlocks, robot, output)
        judged = self.actuation.interlocks
        self._supervision = Supervision(clock, lambda: judged.judged_ns, (), heartbeats)
        parts = PartRuns(clock=clock, events=output, reckoner=ReckonerHere(), guider=world.guider)
        parts.add_level_meter(measure_level)
        self.service = NightService(
            site=site, night=night, place=place, clock=clock, boot=boot, folder=data / "night",
            actuation=self.actuation, send=hub.take, events=output, on_disk=self._on_disk,
            star_parts=lambda _ask: parts,
            planner=world.planner, arrivals=arrivals,
        )  # fmt: skip
        outbox = ArchiveOutbox(
            data / "outbox", 2**30, lambda: None, arrivals.notice_file, kept=arrivals.note_kept
        )
        files = WholeFiles(
            folder=data / "frames", outbox=outbox, events=output, clock=clock, disk=Inline(),
            site=site.name, place=place,
        )  # fmt: skip
        robot.picture_taken = lambda data: files.keep_file("camera", lambda: self._picture(data))
        self._tasks = [
            asyncio.ensure_future(run())
            for run in (self.actuation.keep_written, self._supervision.run, self.service.run)
        ]
        self.actuation.timer.reset_timer()
        robot.say_newest_picture()

    def _picture(self, data: bytes) -> bytes:
        if self._world.disk_full:
            self._world.refused.append(hash(data))
            raise OSError(errno.ENOSPC, "No space left on device")
        return data

    async def _on_disk(self, work: Callable[[], None]) -> None:
        if self._world.disk_full:
            raise OSError(errno.ENOSPC, "No space left on device")
        work()

    def link_up(self) -> None:
        self.actuation.interlocks.link_up(self._world.clock.monotonic_ns())
        self._world.hub.answer = self.service.handle_message
        self.service.link_up(takes=True)

    def link_lost(self) -> None:
        self._world.hub.answer = lambda _message: None
        self.service.link_up(takes=False)
        self.actuation.interlocks.link_lost(self._world.clock.monotonic_ns())

    async def kill(self) -> None:
        """End as a process that is killed: nothing is said, nothing more is written."""
        self._world.hub.answer = lambda _message: None
        self._world.robot.picture_taken = lambda _file: None
        self._world.robot.forget_askers()
        self.actuation.timer.close()
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        # Its own tasks are no more; what they would write now nobody writes.
        for task in asyncio.all_tasks() - {asyncio.current_task()} - self._world.own_tasks:
            task.cancel()
        await asyncio.sleep(0)


class NightWorld:
    """See the module.

    Attributes:
        truths: the hardware's own ledger, an entry for each step.

    """

    def __init__(
        self,
        *,
        site: Site,
        clock: HandClock,
        data: Path,
        seed: int,
        guider: Any = None,
        planner: type[PlannerHere] = PlannerHere,
    ) -> None:
        """Begin with everything at rest, and no gateway."""
        self.site, self.clock, self.data, self.guider = site, clock, data, guider
        self.planner = planner
        data.mkdir(parents=True, exist_ok=True)
        self.robot, self.hub = SkyRobot(site, clock, seed), HubStandIn()
        self.disk_full = False
        # Pictures that a full disk did not take, with the event that says so.
        self.refused: list[int] = []
        self.truths: list[Truth] = []
        self.gateway: Gateway | None = None
        self.own_tasks: set[asyncio.Task[Any] | None] = set()
        self._asked: set[asyncio.Task[None]] = set()
        self._numbers = itertools.count(1)
        self._starts = itertools.count(1)
        self._due: list[tuple[float, int, Callable[[], Awaitable[None] | None]]] = []

    # ── gateway and hub ──

    def start_gateway(self) -> None:
        self.robot.step()
        self.gateway = Gateway(self, next(self._starts))
        if self.hub.there:
            self.gateway.link_up()

    async def kill_gateway(self) -> None:
        if self.gateway is not None:
            gateway, self.gateway = self.gateway, None
            await gateway.kill()

    def mark_running(self) -> None:
        """Tell the gateway that it runs: its looks are a second apart, and no standstill."""
        if self.gateway is not None:
            judge = self.gateway.actuation.interlocks.conditions
            judge.mark_running(self.clock.monotonic_ns())

    def hub_away(self) -> None:
        self.hub.there = False
        if self.gateway is not None:
            self.gateway.link_lost()

    def hub_back(self) -> None:
        self.hub.there = True
        if self.gateway is not None:
            self.gateway.link_up()

    def ask(
        self,
        groups: list[RequestGroup],
        revision: int = 1,
        proposals: tuple[Proposal, ...] = (SCHOOL,),
    ) -> None:
        assert self.gateway is not None
        self.gateway.service.handle_message(
            RequestSync(revision=revision, proposals=list(proposals), groups=groups)
        )

    def arm(self, who: str = "ada") -> None:
        assert self.gateway is not None
        number = next(self._numbers)
        self.gateway.service.handle_message(NightArmRequest(id=f"arm-{number}", who=who))

    def command(self, address: str, args: dict[str, Any] | None = None, who: str = "grace") -> None:
        """Have a person ask for a command; who holds the device is interrupted."""
        if self.gateway is None:
            return
        device, _, name = address.partition("/")
        commands = self.gateway.actuation.commands
        holder = commands.holders.holder_against(device, who)
        ask = CommandRequest(
            id=f"person-{next(self._numbers)}", device=device, command=name, args=args or {},
            ttl_ms=5000.0, who=who, over=holder.id if holder is not None else "",
        )  # fmt: skip
        self._asked.add(task := asyncio.ensure_future(commands.handle_request(ask)))
        task.add_done_callback(self._asked.discard)

    @property
    def phase(self) -> NightPhase | None:
        return self.hub.states[-1].phase if self.hub.states else None

    @property
    def unix(self) -> float:
        return self.clock.wall_ns() / SECOND

    @property
    def sun(self) -> float:
        assert self.site.place is not None
        return sun_altitude(self.site.place, self.unix)

    # ── time ──

    def at(self, seconds: float, deed: Callable[[], Awaitable[None] | None]) -> None:
        """Do something so long after now (s)."""
        self._due.append((self.clock.monotonic_ns() / SECOND + seconds, len(self._due), deed))
        self._due.sort(key=lambda one: one[:2])

    async def turn(self) -> None:
        """Let one step pass."""
        # Of the simulated clock; a sleep that takes no time.
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(STEP_S):
                await asyncio.get_running_loop().create_future()
        self.robot.step()
        self.truths.append(self.robot.truth(self.sun))
        now = self.clock.monotonic_ns() / SECOND
        while self._due and self._due[0][0] <= now:
            _, _, deed = self._due.pop(0)
            if (doing := deed()) is not None:
                await doing

    async def until(self, holds: Callable[[], bool], within: float, what: str = "") -> None:
        ends = self.clock.monotonic_ns() / SECOND + within
        self.own_tasks.add(asyncio.current_task())
        while not holds():
            told = self.hub.states[-1:], self.hub.events[-6:], self.truths[-1:]
            assert self.clock.monotonic_ns() / SECOND < ends, (what, told)
            await self.turn()

    async def pass_time(self, seconds: float) -> None:
        ends = self.clock.monotonic_ns() / SECOND + seconds
        await self.until(lambda: self.clock.monotonic_ns() / SECOND >= ends, seconds + 60.0)

    def archived(self) -> list[bytes]:
        """Give the pictures that wait for the hub, without ours and theirs of the header."""
        return [path.read_bytes() for path in sorted((self.data / "outbox").glob("*.bin"))]


def live_through(make: Callable[[], NightWorld], live: Callable[[NightWorld], Any]) -> NightWorld:
    """Run a night on its own clock, as fast as it goes; what fails on the loop fails here."""
    world = make()
    with asyncio.Runner(loop_factory=lambda: SimulatedLoop(world.clock, STEP_S)) as runner:
        failed: list[str] = []
        runner.get_loop().set_exception_handler(lambda _loop, about: failed.append(str(about)))
        loop = runner.get_loop()
        assert isinstance(loop, SimulatedLoop)
        loop.passing = world.mark_running
        runner.run(live(world))
        assert failed == []
    return world
