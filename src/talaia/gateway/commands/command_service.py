"""Act on commands: written to disk before the robot is asked, each id at most once.

What makes safe does not wait for a disk that takes nothing: the gateway's own closing is done
first and written afterwards, a person's is tried to be written first and done in any case.

Long, because each step of a command's life leans on what the one before it wrote down.
"""

from __future__ import annotations

import asyncio
import logging
from functools import partial
from typing import TYPE_CHECKING

from msgspec.structs import replace

from talaia.clock import SECOND
from talaia.gateway.commands.command_book import FINAL, CommandBook
from talaia.gateway.commands.command_journal import CommandJournal
from talaia.gateway.commands.device_holders import DeviceHolder, DeviceHolders
from talaia.gateway.disk_trouble import DiskTrouble
from talaia.model.arguments import args_of, fields_of, unit_problem
from talaia.model.interlocks.safe_commands import never_asks, safe_commands
from talaia.model.site import DeviceKind
from talaia.wire.frames import CommandPhase, CommandState

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Collection

    from talaia.clock import Clock
    from talaia.gateway.ports import CommandOutcome, CommandTarget
    from talaia.gateway.safety.enclosure_guard import Hold
    from talaia.model.site import Command, Site
    from talaia.wire.frames import CommandCancel, CommandRequest, Scalar

__all__ = ["CommandJournal", "CommandService"]

log = logging.getLogger(__name__)
PROGRESS_NS = SECOND // 5
WAIT_LOOK_S = 0.1
# What only makes safe waits no longer for the disk.
SAFE_WRITE_S = 0.5
_JOURNAL = "journal"
# What does one thing at a time, at whose hands people can meet. Vehicles have leases.
HELD_KINDS = frozenset({DeviceKind.DOME, DeviceKind.TELESCOPE, DeviceKind.CAMERA, DeviceKind.OTHER})


class CommandService:
    """Takes asks from the hub and sees each to its end."""

    def __init__(
        self,
        *,
        site: Site,
        clock: Clock,
        target: CommandTarget,
        journal: CommandJournal,
        on_disk: Callable[[Callable[[], None]], Awaitable[None]],
        send: Callable[[CommandState], None],
        refusal: Callable[[str, str, dict[str, Scalar]], str] = lambda _device, _command, _args: "",
        begun: Callable[[str, str, str], None] = lambda _device, _command, _who: None,
        hold: Callable[[str, str], Hold | None] = lambda _device, _command: None,
        ended: Callable[[str], None] = lambda _device: None,
        trouble: DiskTrouble | None = None,
        power_cut: Callable[[str, str, dict[str, Scalar]], str] = lambda _dev, _cmd, _args: "",
    ) -> None:
        """Take up what the journal remembers.

        Args:
            site: the description.
            clock: monotonic.
            target: who acts.
            journal: see `CommandJournal`.
            on_disk: runs a blocking write elsewhere, in order; raises what it raises.
            send: tells the hub.
            refusal: says why a command of a device with these arguments (by name) may not be
                given now, if so: interlocks.
            begun: told of each command of a person that begins: device, command, who.
            hold: says what a command has to wait for before the robot is asked, if so.
            ended: told of which device a command has ended.
            power_cut: says why a command takes power that a safe state needs, if so.
            trouble: told when the journal cannot be written, and when it can be again.

        """
        self._site = site
        self._safe = safe_commands(site)
        self._trouble = DiskTrouble() if trouble is None else trouble
        self._clock = clock
        self._target = target
        self._journal = journal
        self._on_disk = on_disk
        self._send = send
        self._refusal = refusal
        self._begun = begun
        self._hold = hold
        self._power_cut = power_cut
        self._on_ended = ended
        self._held: dict[str, asyncio.Task[None]] = {}
        self._ends: dict[str, asyncio.Future[CommandState]] = {}
        self._holders = DeviceHolders()
        self._interrupted: set[str] = set()
        self._book = CommandBook(journal.remembered)
        self._timers: dict[str, asyncio.TimerHandle] = {}
        self._cancels: dict[str, Callable[[], None]] = {}
        self._progress_ns: dict[str, int] = {}
        self._writes: set[asyncio.Task[OSError | None]] = set()
        try:
            journal.compact(self._book.states())
        except OSError as error:
            # It guards all the same; what is not safe is refused until it can be written.
            self._trouble.failed(_JOURNAL, error)

    def state(self, command_id: str) -> CommandState | None:
        """Give where a command stands."""
        return self._book.get(command_id)

    @property
    def busy(self) -> bool:
        """Whether a command is under way."""
        return bool(self._timers or self._held)

    def busy_with(self, devices: Collection[str]) -> str:
        """Name a command of these devices that is under way, if any."""
        for command_id in self._timers:
            state = self._book.get(command_id)
            if state is not None and state.device in devices:
                return f"{state.device}/{state.command}"
        return ""

    def runs(self, command: str) -> bool:
        """Tell whether a ``<device>/<command>`` is under way."""
        states = [self._book.get(command_id) for command_id in self._timers]
        return any(f"{state.device}/{state.command}" == command for state in states if state)

    def redescribe(self, site: Site) -> None:
        """Take commands by another description from here on."""
        self._site = site
        self._safe = safe_commands(site)

    def report(self) -> None:
        """Tell a new link who acts now; and, once, of what a restart interrupted."""
        for state in self._book.interrupted:
            self._send(state)
        self._book.interrupted.clear()
        for holder in self._holders.all():
            if (under_way := self._book.get(holder.id)) is not None:
                self._send_state(under_way)

    async def perform(self, ask: CommandRequest, within: float | None) -> CommandState:
        """Act on a command of the gateway's own, which no interlock refuses.

        Gives how it ended, or how it stands after ``within`` (s).
        """
        ended: asyncio.Future[CommandState] = asyncio.get_running_loop().create_future()
        self._ends[ask.id] = ended
        try:
            await self.ask(ask, guarded=False)
            await asyncio.wait([ended], timeout=within)
            if ended.done():
                return ended.result()
            state = self._book.get(ask.id)
            return (
                state
                if state is not None
                else CommandState(
                    id=ask.id, device=ask.device, command=ask.command, phase=CommandPhase.UNKNOWN
                )
            )
        finally:
            self._ends.pop(ask.id, None)

    async def ask(self, ask: CommandRequest, *, guarded: bool = True) -> None:
        """Act on a command, or say why not. A known id is only answered."""
        began_ns = self._clock.monotonic_ns()
        known = self._book.get(ask.id)
        if known is not None:
            self._send_state(known)
            return
        state = CommandState(
            id=ask.id,
            device=ask.device,
            command=ask.command,
            phase=CommandPhase.ACCEPTED,
            who=ask.who,
        )
        self._book.open(state)
        device = self._site.devices.get(ask.device)
        command = device.commands.get(ask.command) if device is not None else None
        if command is None:
            problem = f"{ask.device}/{ask.command} is not a command of this site"
            self._move(ask.id, CommandPhase.REFUSED, message=problem)
            return
        fields = fields_of(command, ask.args)
        problem = fields if isinstance(fields, str) else unit_problem(command, ask.units)
        if isinstance(fields, str) or problem:
            self._move(ask.id, CommandPhase.REFUSED, message=problem)
            return
        named = args_of(command, ask.args)
        if self._refused_now(ask, named, guarded=guarded):
            return
        if problem := await self._write_accepted(state, guarded=guarded):
            self._move(ask.id, CommandPhase.REFUSED, message=problem)
            return
        ttl_ns = min(ask.ttl_ms * 1e6, command.ttl * 1e9) if guarded else ask.ttl_ms * 1e6
        # Written so that NaN refuses as well.
        if not self._clock.monotonic_ns() - began_ns <= ttl_ns or ttl_ns <= 0:
            self._move(ask.id, CommandPhase.REFUSED, message="it came too late to be accepted")
            return
        # Once more: it may have begun to rain while the disk was busy.
        if self._refused_now(ask, named, guarded=guarded):
            return
        over = self._take_hold(ask, command, guarded=guarded)
        self._send_state(state, over)
        if guarded:
            self._begun(ask.device, ask.command, ask.who)
        if guarded and self._hold(ask.device, ask.command) is not None:
            waiting = asyncio.ensure_future(self._wait(ask, command, fields, named))
            self._held[ask.id] = waiting
            self._cancels[ask.id] = lambda: self._stop_waiting(ask.id)
            return
        self._begin(ask, command, fields)

    def _refused_now(self, ask: CommandRequest, named: dict[str, Scalar], *, guarded: bool) -> bool:
        """Refuse a command that may not be done now; tell whether it was refused."""
        if barred := self._barred(ask, named, guarded=guarded):
            self._move(ask.id, CommandPhase.REFUSED, message=barred)
            return True
        holder = self._holders.against(ask.device, ask.who) if guarded else None
        if holder is None or never_asks(self._site, ask.device, ask.command):
            return False
        if holder.id == ask.over and not holder.safety:
            log.info("%s interrupts %s of %s", ask.who, holder.doing, holder.who)
            # From here on it is in the new one's hands; how the old one ends the robot says.
            self._interrupted.add(holder.id)
            return False
        why = f"{holder.words} (since {self._acting_s(holder):.0f} s)"
        blocked_by = "" if holder.safety else holder.id
        self._move(ask.id, CommandPhase.REFUSED, message=why, blocked_by=blocked_by)
        return True

    def _take_hold(self, ask: CommandRequest, command: Command, *, guarded: bool) -> str:
        """Let nobody else act on the device unasked while this is under way.

        Gives in words what it interrupts, if anything.
        """
        device = self._site.devices[ask.device]
        doing = f"{device.name}: {command.name}"
        over = self._interrupt(ask, doing)
        if device.kind not in HELD_KINDS or (not guarded and ask.who.startswith("follow ")):
            return over
        now_ns = self._clock.monotonic_ns()
        self._holders.hold(
            DeviceHolder(ask.id, ask.device, doing, ask.who, now_ns, safety=not guarded)
        )
        return over

    def _interrupt(self, ask: CommandRequest, doing: str) -> str:
        """Take the device out of the hands that may be interrupted; give whose, in words."""
        if ask.over not in self._interrupted:
            return ""
        self._interrupted.discard(ask.over)
        holder = self._holders.get(ask.over)
        self._holders.release(ask.over)
        if holder is None:
            return ""
        # Who asked for it sees what became of it, and all others that they act no longer.
        self._move(holder.id, CommandPhase.RUNNING, message=f"interrupted by {ask.who} ({doing})")
        return f"{holder.doing} of {holder.who} ({holder.id})"

    def _acting_s(self, holder: DeviceHolder) -> float:
        return (self._clock.monotonic_ns() - holder.since_ns) / SECOND

    def _send_state(self, state: CommandState, over: str = "") -> None:
        """Tell the hub where a command stands, and who acts by it."""
        holder = None if state.phase in FINAL else self._holders.get(state.id)
        if holder is not None:
            seconds = self._acting_s(holder)
            state = replace(state, acting=holder.words[:2000], acting_s=seconds)
        self._send(replace(state, over=over[:2000]) if over else state)

    def _barred(self, ask: CommandRequest, named: dict[str, Scalar], *, guarded: bool) -> str:
        """Say why a command may not be done now, if so; ``guarded`` is what a person asks."""
        # What a safe state needs nobody switches off, not even a sequence of the gateway's own.
        if needed := self._power_cut(ask.device, ask.command, named):
            return needed
        return self._refusal(ask.device, ask.command, named) if guarded else ""

    def _stop_waiting(self, command_id: str) -> None:
        waiting = self._held.get(command_id)
        if waiting is not None:
            waiting.cancel()

    async def _wait(
        self,
        ask: CommandRequest,
        command: Command,
        fields: dict[str, float | int | bool | str],
        named: dict[str, Scalar],
    ) -> None:
        """Begin a command as soon as what it waits for is so; the interlocks count all the time."""
        since_ns, said = self._clock.monotonic_ns(), ""
        try:
            while (held := self._hold(ask.device, ask.command)) is not None:
                waited = (self._clock.monotonic_ns() - since_ns) / SECOND
                if held.final:
                    self._move(ask.id, CommandPhase.REFUSED, message=held.why)
                    return
                if waited > held.wait_s:
                    late = f"{held.why} took longer than {held.wait_s:g} s; nothing was done"
                    self._move(ask.id, CommandPhase.FAILED, message=late)
                    return
                if held.why != said:
                    said = held.why
                    self._move(ask.id, CommandPhase.RUNNING, message=said)
                await asyncio.sleep(WAIT_LOOK_S)
                if barred := self._refusal(ask.device, ask.command, named):
                    self._move(ask.id, CommandPhase.REFUSED, message=barred)
                    return
        except asyncio.CancelledError:
            self._move(
                ask.id, CommandPhase.CANCELLED, message="it was still waiting; nothing was done"
            )
            return
        # Meanwhile somebody may have been let act on the device over this one.
        if self._refused_now(ask, named, guarded=True):
            return
        self._cancels.pop(ask.id, None)
        self._held.pop(ask.id, None)
        self._begin(ask, command, fields)

    def _begin(
        self, ask: CommandRequest, command: Command, fields: dict[str, float | int | bool | str]
    ) -> None:
        loop = asyncio.get_running_loop()
        self._move(ask.id, CommandPhase.RUNNING)
        self._time_out(ask.id, command.timeout)

        def done(outcome: CommandOutcome) -> None:
            loop.call_soon_threadsafe(self._on_outcome, ask.id, command.timeout, outcome)

        cancel = self._target.act(ask.device, ask.command, fields, done)
        if cancel is not None:
            self._cancels[ask.id] = cancel

    def _time_out(self, command_id: str, seconds: float) -> None:
        before = self._timers.get(command_id)
        if before is not None:
            before.cancel()
        message = f"no answer for {seconds:g} s; look at the device"
        self._timers[command_id] = asyncio.get_running_loop().call_later(
            seconds, partial(self._move, command_id, CommandPhase.UNKNOWN, message=message)
        )

    def _on_outcome(self, command_id: str, timeout: float, outcome: CommandOutcome) -> None:
        if outcome.phase is not CommandPhase.RUNNING:
            self._move(command_id, outcome.phase, message=outcome.message)
            return
        state = self._book.get(command_id)
        if state is None or state.phase in FINAL:
            return
        self._time_out(command_id, timeout)
        # Feedback may come a hundred times a second; a bar on a page does not move that fast.
        now_ns = self._clock.monotonic_ns()
        if outcome.message or now_ns - self._progress_ns.get(command_id, 0) >= PROGRESS_NS:
            self._progress_ns[command_id] = now_ns
            self._move(
                command_id, CommandPhase.RUNNING, message=outcome.message, progress=outcome.progress
            )

    def cancel(self, ask: CommandCancel) -> None:
        """Ask the robot to end a command early; what came of it is told as its state."""
        state = self._book.get(ask.id)
        if state is None or state.device != ask.device:
            return
        cancel = self._cancels.get(ask.id)
        if state.phase in FINAL:
            self._send_state(state)
        elif cancel is None:
            self._move(ask.id, CommandPhase.RUNNING, message="this command cannot be cancelled")
        else:
            self._move(ask.id, CommandPhase.RUNNING, message=f"{ask.who} asked to cancel it")
            cancel()

    def _move(
        self,
        command_id: str,
        phase: CommandPhase,
        *,
        message: str = "",
        progress: float = 0.0,
        blocked_by: str = "",
    ) -> None:
        state = self._book.move(
            command_id=command_id,
            phase=phase,
            message=message,
            progress=progress,
            blocked_by=blocked_by,
        )
        if state is None:
            log.info("command %s: %s came after its end", command_id, phase)
            return
        self._send_state(state)
        if phase in FINAL:
            self._holders.release(command_id)
            self._interrupted.discard(command_id)
            timer = self._timers.pop(command_id, None)
            if timer is not None:
                timer.cancel()
            self._cancels.pop(command_id, None)
            self._held.pop(command_id, None)
            self._on_ended(state.device)
            self._progress_ns.pop(command_id, None)
            ended = self._ends.get(command_id)
            if ended is not None and not ended.done():
                ended.set_result(state)
            # Not forced to disk: should this line be lost, the command reads as unknown.
            self._begin_write(state, sure=False)

    # ── the journal ──

    async def _write_accepted(self, state: CommandState, *, guarded: bool) -> str:
        """Have it on disk that a command is about to be done; say why it may not be, if so."""
        writing = self._begin_write(state, sure=True)
        if not guarded:
            # The gateway's own ids never come again: nothing is gained by waiting.
            return ""
        if f"{state.device}/{state.command}" in self._safe:
            await asyncio.wait([writing], timeout=SAFE_WRITE_S)
            return ""
        error = await writing
        return "" if error is None else f"the gateway cannot write its journal: {error}"

    def _begin_write(self, state: CommandState, *, sure: bool) -> asyncio.Task[OSError | None]:
        work = partial(self._journal.write, state, sure=sure)
        task = asyncio.ensure_future(self._write(work, sure=sure))
        self._writes.add(task)
        task.add_done_callback(self._writes.discard)
        return task

    async def _write(self, work: Callable[[], None], *, sure: bool) -> OSError | None:
        try:
            await self._on_disk(work)
        except OSError as error:
            self._trouble.failed(_JOURNAL, error)
            return error
        if sure:
            # What is not forced to disk proves nothing of it.
            self._trouble.worked(_JOURNAL)
        return None

    async def write_waiting(self) -> None:
        """Try again to write what the disk did not take."""
        if self._journal.behind or self._trouble.failing(_JOURNAL):
            await self._write(self._journal.write_waiting, sure=True)

    async def close(self) -> None:
        """Stop the timers and finish the writes. What still runs will read as unknown."""
        for timer in self._timers.values():
            timer.cancel()
        held = list(self._held.values())
        for waiting in held:
            waiting.cancel()
        await asyncio.gather(*held, return_exceptions=True)
        await asyncio.gather(*self._writes)
