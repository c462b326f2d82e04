"""Commands: arguments, phases, and that an id is acted on at most once."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import given, strategies as st
from msgspec.structs import replace
from patience import PATIENCE_S

from talaia.clock import SECOND, HandClock
from talaia.gateway.commands.command_book import FINAL, CommandBook
from talaia.gateway.commands.command_guard import CommandGuard
from talaia.gateway.commands.command_journal import CommandJournal
from talaia.gateway.commands.command_sequences import SequenceRunner
from talaia.gateway.commands.command_service import CommandService
from talaia.gateway.commands.journal_writer import JournalWriter
from talaia.gateway.disk_trouble import DiskTrouble
from talaia.gateway.ports import CommandOutcome
from talaia.gateway.safety.dome_following import Hold
from talaia.model.arguments import fields_of
from talaia.model.interlocks.enclosure import Enclosure
from talaia.model.interlocks.interlock import Step
from talaia.model.site import Argument, ArgumentType, Command
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import CommandCancel, CommandPhase, CommandRequest, CommandState

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

pytestmark = pytest.mark.pure

P = CommandPhase
SITE = load_site(
    """
talaia: 1
site: s
name: S
ros2: {}
devices:
  dome:
    name: Dome
    commands:
      open: {name: Open, target: /open, type: std_srvs/srv/Trigger, timeout: 0.05}
      turn: {name: Turn, target: /turn, type: std_srvs/srv/Trigger, timeout: 60}
"""
)
UNDER_A_ROOF = replace(
    SITE,
    enclosures={"dome": Enclosure(name="D", unsafe=(), closed=(), close=Step(command="dome/open"))},
)
SLEW = Command(
    name="Slew",
    target="/slew",
    type="p/srv/Slew",
    fixed={"mode": 3},
    arguments={
        "alt": Argument(type=ArgumentType.NUMBER, field="to.alt", minimum=0, maximum=90),
        "steps": Argument(type=ArgumentType.INTEGER, field="steps", default=1),
        "quick": Argument(type=ArgumentType.BOOLEAN, field="quick", default=False),
        "note": Argument(type=ArgumentType.TEXT, field="note", max_length=5, default=""),
    },
)


def test_fields_come_from_fixed_values_arguments_and_defaults() -> None:
    assert fields_of(SLEW, {"alt": 45}) == {
        "mode": 3, "to.alt": 45.0, "steps": 1, "quick": False, "note": "",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("args", "said"),
    [
        ({}, "missing"),
        ({"alt": 91}, "above"),
        ({"alt": -0.1}, "below"),
        ({"alt": float("nan")}, "finite"),
        ({"alt": float("inf")}, "finite"),
        ({"alt": 10**400}, "finite"),
        ({"alt": True}, "expected a number"),
        ({"alt": "45"}, "expected a number"),
        ({"alt": 1, "steps": 1.5}, "whole number"),
        ({"alt": 1, "steps": True}, "whole number"),
        ({"alt": 1, "quick": 1}, "true or false"),
        ({"alt": 1, "note": "too long"}, "at most 5"),
        ({"alt": 1, "mode": 4}, "no argument 'mode'"),
    ],
)
def test_argument_that_does_not_fit_is_said(args: dict, said: str) -> None:
    problem = fields_of(SLEW, args)
    assert isinstance(problem, str)
    assert said in problem


def state(phase: CommandPhase, command_id: str = "i") -> CommandState:
    return CommandState(id=command_id, device="dome", command="open", phase=phase)


@given(st.lists(st.sampled_from(list(P)), max_size=20))
def test_end_is_final_whatever_comes_after_it(steps: list[CommandPhase]) -> None:
    book = CommandBook()
    assert book.enter_command(state(P.ACCEPTED))
    ended = None
    for phase in steps:
        moved = book.move_command(command_id="i", phase=phase)
        if ended is not None:
            assert moved is None
            assert book.find_state("i").phase is ended
        elif moved is not None and phase in FINAL:
            ended = phase
        assert not book.enter_command(state(P.ACCEPTED))


def test_what_had_not_ended_before_a_restart_is_unknown() -> None:
    book = CommandBook([state(P.ACCEPTED, "a"), state(P.ACCEPTED, "b"), state(P.SUCCEEDED, "b")])
    assert book.find_state("a").phase is P.UNKNOWN
    assert book.find_state("b").phase is P.SUCCEEDED
    assert [each.id for each in book.interrupted] == ["a"]
    assert not book.enter_command(state(P.ACCEPTED, "a"))


def test_book_forgets_the_oldest_ended_ones_only() -> None:
    book = CommandBook()
    book.KEPT = 10
    book.enter_command(state(P.ACCEPTED, "runs"))
    for number in range(30):
        book.enter_command(state(P.REFUSED, str(number)))
    assert len(book.all_states()) == 10
    assert book.find_state("runs") is not None


class Dome:
    """A robot that does as the test says."""

    def __init__(self) -> None:  # noqa: D107
        self.asked: list[str] = []
        self.answer: CommandOutcome | None = CommandOutcome(P.SUCCEEDED, "open")

    def act(self, device: str, command: str, fields: dict, done: Callable) -> None:
        self.asked.append(f"{device}/{command}")
        if self.answer is not None:
            done(self.answer)


class Bench(CommandGuard):
    """Commanding with its robot, clock and what it said."""

    def __init__(self, folder: Path, output: Any = None) -> None:  # noqa: D107
        self.clock = HandClock()
        self.dome = Dome()
        self.said: list[CommandState] = []
        self.disk: Callable[[], None] = lambda: None
        self.barred = ""
        self.held: Hold | None = None
        self.commanding = CommandService(
            site=SITE,
            clock=self.clock,
            target=self.dome,
            guard=self,
            writer=JournalWriter(
                CommandJournal(folder / "c.jsonl"), self.on_disk, DiskTrouble(output)
            ),
            send=self.say,
        )
        self.changed = asyncio.Event()

    def refusal_reason(self, device: str, command: str, args: dict) -> str:
        return self.barred

    def hold_for(self, device: str, command: str) -> Hold | None:
        return self.held

    def say(self, each: CommandState) -> None:
        self.said.append(each)
        self.changed.set()

    async def on_disk(self, work: Callable[[], None]) -> None:
        self.disk()
        work()

    async def ask(self, command_id: str = "i", ttl_ms: float = 5000) -> None:
        await self.commanding.handle_request(
            CommandRequest(id=command_id, device="dome", command="open", ttl_ms=ttl_ms, who="Ada")
        )

    async def says(self, words: str) -> CommandState:
        async with asyncio.timeout(PATIENCE_S):
            while not self.said or words not in self.said[-1].message:
                self.changed.clear()
                await self.changed.wait()
        return self.said[-1]

    async def ended(self) -> CommandState:
        async with asyncio.timeout(PATIENCE_S):
            while not self.said or self.said[-1].phase not in FINAL:
                self.changed.clear()
                await self.changed.wait()
        return self.said[-1]


async def test_command_goes_through_its_phases(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    await bench.ask()
    assert (await bench.ended()).message == "open"
    assert [each.phase for each in bench.said] == [P.ACCEPTED, P.RUNNING, P.SUCCEEDED]
    await bench.commanding.close()


async def test_accepted_is_on_disk_before_the_robot_is_asked(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    asked_at_write: list[int] = []
    bench.disk = lambda: asked_at_write.append(len(bench.dome.asked))
    await bench.ask()
    await bench.ended()
    assert asked_at_write[0] == 0
    await bench.commanding.close()


async def test_same_id_acts_once_and_is_answered_each_time(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    await asyncio.gather(bench.ask(), bench.ask(), bench.ask())
    await bench.ended()
    await bench.ask()
    assert bench.dome.asked == ["dome/open"]
    assert bench.said[-1].phase is P.SUCCEEDED
    await bench.commanding.close()


async def test_crash_after_accepted_reads_as_unknown_and_is_not_done_again(
    tmp_path: Path,
) -> None:
    bench = Bench(tmp_path)
    bench.dome.answer = None
    await bench.ask()
    await bench.commanding.close()
    later = Bench(tmp_path)
    later.commanding.report_states()
    assert [(each.id, each.phase) for each in later.said] == [("i", P.UNKNOWN)]
    await later.ask()
    assert later.dome.asked == []
    await later.commanding.close()


async def test_no_answer_in_time_is_unknown_and_a_late_one_changes_nothing(
    tmp_path: Path,
) -> None:
    bench = Bench(tmp_path)
    bench.dome.answer = None
    await bench.ask()
    assert (await bench.ended()).phase is P.UNKNOWN
    bench.commanding._move_command("i", P.SUCCEEDED)
    assert bench.said[-1].phase is P.UNKNOWN
    await bench.commanding.close()


@pytest.mark.parametrize("ttl_ms", [0, -1, float("nan")])
async def test_command_without_time_left_is_refused(tmp_path: Path, ttl_ms: float) -> None:
    bench = Bench(tmp_path)
    await bench.ask(ttl_ms=ttl_ms)
    assert (await bench.ended()).phase is P.REFUSED
    assert bench.dome.asked == []
    await bench.commanding.close()


async def test_disk_that_takes_longer_than_the_ttl_means_refused(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    bench.disk = lambda: bench.clock.advance(6 * SECOND)
    await bench.ask()
    assert (await bench.ended()).phase is P.REFUSED
    assert bench.dome.asked == []
    await bench.commanding.close()


async def test_disk_that_is_full_means_refused(tmp_path: Path) -> None:
    bench = Bench(tmp_path)

    def full() -> None:
        raise OSError(28, "No space left on device")

    bench.disk = full
    await bench.ask()
    assert "No space left" in (await bench.ended()).message
    assert bench.dome.asked == []
    await bench.commanding.close()


async def test_the_gateways_own_closing_and_a_persons_do_not_wait_for_a_disk_that_hangs(
    tmp_path: Path,
) -> None:
    bench = Bench(tmp_path)
    works = asyncio.Event()

    async def hangs(work: Callable[[], None]) -> None:
        await works.wait()
        work()

    bench.commanding._writer._on_disk = hangs
    bench.commanding.redescribe(UNDER_A_ROOF)
    own = CommandRequest(id="own", device="dome", command="open", ttl_ms=5000, who="interlock")
    await bench.commanding.handle_request(own, guarded=False)
    assert bench.dome.asked == ["dome/open"]
    async with asyncio.timeout(PATIENCE_S):
        await bench.ask("hers")
    assert bench.dome.asked == ["dome/open"] * 2
    await bench.ask("hers")
    assert bench.dome.asked == ["dome/open"] * 2
    works.set()
    await bench.commanding.close()


async def test_trouble_with_the_journal_is_said_once_and_its_end_once(tmp_path: Path) -> None:
    said: list[str] = []

    class Mouth:
        def record_event(
            self, kind: str, device: str, message: str, who: str, *, good: bool
        ) -> None:
            said.append(kind)

    bench = Bench(tmp_path, Mouth())

    def fails() -> None:
        raise OSError(30, "Read-only file system")

    bench.disk = fails
    for number in range(3):
        await bench.ask(f"a{number}")
        await bench.ended()
        await bench.commanding.write_waiting()
    bench.disk = lambda: None
    for _ in range(3):
        await bench.commanding.write_waiting()
    assert said == ["disk_failed", "disk_recovered"]
    await bench.commanding.close()


def test_journal_ignores_a_line_cut_short(tmp_path: Path) -> None:
    path = tmp_path / "c.jsonl"
    journal = CommandJournal(path)
    journal.write_state(state(P.ACCEPTED, "a"), sure=True)
    journal.write_state(state(P.SUCCEEDED, "a"), sure=True)
    path.write_bytes(path.read_bytes()[:-10])
    later = CommandJournal(path)
    later.write_state(state(P.FAILED, "b"), sure=True)
    assert [each.phase for each in CommandJournal(path).remembered] == [P.ACCEPTED, P.FAILED]


STEPS = (Step(command="dome/open", within=0.05), Step(command="dome/open"))


async def run_sequence(bench: Bench, steps: tuple[Step, ...]) -> list[str]:
    """Run one to its end; give what was written down."""
    notes: list[str] = []
    done = asyncio.Event()

    class Mouth:
        def record_event(
            self, kind: str, device: str, message: str, who: str, *, good: bool
        ) -> None:
            notes.append(f"{kind}: {message}")
            if kind == "sequence_done" or "not done" in message:
                done.set()

    sequences = SequenceRunner(commands=bench.commanding, output=Mouth(), boot="boot")
    sequences.begin_sequence("interlock rain", steps)
    sequences.begin_sequence("interlock rain", steps)
    async with asyncio.timeout(PATIENCE_S):
        await done.wait()
    await sequences.close()
    await bench.commanding.close()
    return notes


async def test_a_sequence_does_its_steps_in_order_once_though_an_interlock_refuses_people(
    tmp_path: Path,
) -> None:
    bench = Bench(tmp_path)
    bench.barred = "Rain: it rains"
    notes = await run_sequence(bench, STEPS)
    assert bench.dome.asked == ["dome/open", "dome/open"]
    assert {each.who for each in bench.said} == {"interlock rain"}
    assert notes == ["sequence_done: interlock rain"]


async def test_a_required_step_that_fails_ends_the_sequence(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    bench.dome.answer = CommandOutcome(P.FAILED, "stuck")
    notes = await run_sequence(bench, STEPS)
    assert bench.dome.asked == ["dome/open"]
    assert "failed: stuck; the rest is not done" in notes[0]


async def test_a_step_that_is_not_required_holds_the_next_up_for_its_bound_only(
    tmp_path: Path,
) -> None:
    bench = Bench(tmp_path)
    bench.dome.answer = None
    # It has a minute to answer: on a busy machine it is under way when the bound is over, too.
    park = Step(command="dome/turn", within=0.02, required=False)
    late = Step(command="dome/turn", within=0.01)
    notes = await run_sequence(bench, (park, late))
    assert bench.dome.asked == ["dome/turn", "dome/turn"]
    assert "dome/turn running; going on" in notes[0]


@pytest.mark.parametrize("kind", ["sequence_done", "sequence_failed"])
async def test_a_command_whose_end_is_reached_all_the_same_has_not_failed(
    tmp_path: Path, kind: str
) -> None:
    bench = Bench(tmp_path)
    bench.dome.answer = CommandOutcome(P.FAILED, "the telescope parks")
    notes: list[str] = []

    class Mouth:
        def record_event(
            self, kind: str, device: str, message: str, who: str, *, good: bool
        ) -> None:
            notes.append(kind)

    looks = 0

    def reached(_command: str) -> bool:
        # The sensor says so a moment after the answer.
        nonlocal looks
        looks += 1
        return kind == "sequence_done" and looks > 3

    sequences = SequenceRunner(
        commands=bench.commanding, output=Mouth(), boot="boot", is_reached=reached
    )
    sequences.begin_sequence("enclosure dome park 1", (Step(command="dome/open"),))
    async with asyncio.timeout(PATIENCE_S):
        await asyncio.gather(*sequences._running.values())
    assert notes == [kind]
    await bench.commanding.close()


async def test_a_command_that_an_interlock_refuses_is_not_acted_on(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    bench.barred = "Rain: it rains"
    await bench.ask()
    assert (await bench.ended()).phase is P.REFUSED
    assert bench.said[-1].message == "Rain: it rains"
    assert bench.dome.asked == []
    await bench.commanding.close()


async def test_a_command_is_refused_when_it_became_unsafe_while_the_disk_was_busy(
    tmp_path: Path,
) -> None:
    bench = Bench(tmp_path)

    def raining() -> None:
        bench.barred = "Rain: it rains"

    bench.disk = raining
    await bench.ask()
    assert (await bench.ended()).phase is P.REFUSED
    assert bench.dome.asked == []
    await bench.commanding.close()


async def test_a_command_waits_until_what_it_needs_is_so(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    bench.held = Hold("Dome: waiting until it is open", 120)
    await bench.ask()
    assert await bench.says("waiting until it is open")
    assert bench.dome.asked == []
    assert bench.commanding.busy
    bench.held = None
    assert (await bench.ended()).phase is P.SUCCEEDED
    assert bench.dome.asked == ["dome/open"]
    await bench.commanding.close()


@pytest.mark.parametrize(
    ("change", "phase", "said"),
    [
        (lambda x: setattr(x, "barred", "Rain: it rains"), P.REFUSED, "Rain: it rains"),
        (lambda x: setattr(x, "held", Hold("it is closed", 9, final=True)), P.REFUSED, "closed"),
        (lambda x: x.clock.advance(121 * SECOND), P.FAILED, "longer than 120 s"),
        (
            lambda x: x.commanding.cancel_command(CommandCancel(id="i", device="dome", who="Ada")),
            P.CANCELLED,
            "nothing was done",
        ),
    ],
)
async def test_a_command_that_waits_ends_without_an_act_when_it_may_not_or_takes_too_long(
    change: Callable[[Bench], None], phase: P, said: str, tmp_path: Path
) -> None:
    bench = Bench(tmp_path)
    bench.held = Hold("waiting", 120)
    await bench.ask()
    await bench.says("waiting")
    change(bench)
    ended = await bench.ended()
    assert (ended.phase, said in ended.message) == (phase, True)
    assert bench.dome.asked == []
    assert not bench.commanding.busy
    await bench.commanding.close()
