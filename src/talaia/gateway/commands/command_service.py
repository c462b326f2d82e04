"""Act on commands: written to disk before the robot is asked, each id at most once.

What makes safe does not wait for a disk that takes nothing: the gateway's own closing is done
first and written afterwards, a person's is tried to be written first and done in any case.

Long, because each step of a command's life leans on what the one before it wrote down.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from msgspec.structs import replace

from talaia.gateway.commands.command_book import FINAL, CommandBook
from talaia.gateway.commands.device_holders import DeviceHolder, DeviceHolders
from talaia.gateway.commands.readiness import wait_until_ready
from talaia.gateway.commands.robot_actions import RobotActions
from talaia.gateway.safety.dome_following import FOLLOW_LABEL
from talaia.model.arguments import args_of, fields_of, unit_problem
from talaia.model.interlocks.safe_commands import never_asks, safe_commands
from talaia.model.site import DeviceKind
from talaia.wire.frames import CommandPhase, CommandState

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from talaia.clock import Clock
    from talaia.gateway.commands.command_guard import CommandGuard
    from talaia.gateway.commands.journal_writer import JournalWriter
    from talaia.gateway.ports import CommandOutcome, CommandTarget
    from talaia.model.site import Command, Site
    from talaia.wire.frames import CommandCancel, CommandRequest, Scalar

__all__ = ["HELD_KINDS", "CommandService"]

log = logging.getLogger(__name__)
# What does one thing at a time, at whose hands people can meet. Vehicles have leases.
HELD_KINDS = frozenset({DeviceKind.DOME, DeviceKind.TELESCOPE, DeviceKind.CAMERA, DeviceKind.OTHER})


class CommandService:
    """Takes asks from the hub and sees each to its end.

    Attributes:
        holders: who acts on which device; whoever acts for longer than a command enters here.

    """

    def __init__(
        self,
        *,
        site: Site,
        clock: Clock,
        target: CommandTarget,
        guard: CommandGuard,
        writer: JournalWriter,
        send: Callable[[CommandState], None],
    ) -> None:
        """Take up what the journal remembers.

        Args:
            site: the description.
            clock: monotonic.
            target: who acts.
            guard: says what may be done now.
            writer: of the journal.
            send: tells the hub.

        """
        self._site = site  # Replaced by `redescribe`.
        # Commands that only make safe: a disk that takes nothing does not stop them.
        self._safe = safe_commands(site)
        self._clock = clock  # Monotonic: ttl and holds are judged by it.
        self._guard = guard
        self._writer = writer  # The journal on disk.
        self._send = send
        # Where every command stands, the ended ones of earlier runs included.
        self._book = CommandBook(writer.remembered)
        # What the robot was asked and has not answered for good.
        self._actions = RobotActions(target=target, clock=clock, report=self._on_outcome)
        # Commands that wait until a dome is in place; nobody has asked the robot yet.
        self._waiting: dict[str, asyncio.Task[None]] = {}
        # Whoever waits in `perform_command` for the end of a command of the gateway's own.
        self._ends: dict[str, asyncio.Future[CommandState]] = {}
        self.holders = DeviceHolders()
        writer.compact_journal(self._book.all_states())

    def command_state(self, command_id: str) -> CommandState | None:
        """Give where a command stands."""
        return self._book.find_state(command_id)

    @property
    def busy(self) -> bool:
        """Whether a command is under way."""
        return bool(self._actions.ids or self._waiting)

    def busy_with(self, devices: Collection[str]) -> str:
        """Name a command of these devices that is under way, if any."""
        for command_id in self._actions.ids:
            state = self._book.find_state(command_id)
            if state is not None and state.device in devices:
                return f"{state.device}/{state.command}"
        return ""

    def is_running(self, command: str) -> bool:
        """Tell whether a ``<device>/<command>`` is under way."""
        states = [self._book.find_state(command_id) for command_id in self._actions.ids]
        return any(f"{state.device}/{state.command}" == command for state in states if state)

    def redescribe(self, site: Site) -> None:
        """Take commands by another description from here on."""
        self._site = site
        self._safe = safe_commands(site)

    def report_states(self) -> None:
        """Tell a new link who acts now; and, once, of what a restart interrupted."""
        for state in self._book.interrupted:
            self._send(state)
        self._book.interrupted.clear()
        for holder in self.holders.all_holders():
            if (under_way := self._book.find_state(holder.id)) is not None:
                self._send_state(under_way)

    async def perform_command(
        self, ask: CommandRequest, within: float | None, *, guarded: bool = False
    ) -> CommandState:
        """Act on a command of the gateway's own; unless ``guarded`` no interlock refuses it.

        Gives how it ended, or how it stands after ``within`` (s).
        """
        ended: asyncio.Future[CommandState] = asyncio.get_running_loop().create_future()
        self._ends[ask.id] = ended
        try:
            await self.handle_request(ask, guarded=guarded)
            await asyncio.wait([ended], timeout=within)
            if ended.done():
                return ended.result()
            return self._book.find_state(ask.id) or CommandState(
                id=ask.id, device=ask.device, command=ask.command, phase=CommandPhase.UNKNOWN
            )
        finally:
            self._ends.pop(ask.id, None)

    async def handle_request(self, ask: CommandRequest, *, guarded: bool = True) -> None:
        """Act on a command, or say why not. A known id is only answered."""
        began_ns = self._clock.monotonic_ns()
        known = self._book.find_state(ask.id)
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
        # Before anything is awaited: a repeated ask finds it and is not acted on twice.
        self._book.enter_command(state)
        device = self._site.devices.get(ask.device)
        command = device.commands.get(ask.command) if device is not None else None
        if command is None:
            problem = f"{ask.device}/{ask.command} is not a command of this site"
            self._move_command(ask.id, CommandPhase.REFUSED, message=problem)
            return
        fields = fields_of(command, ask.args)
        problem = fields if isinstance(fields, str) else unit_problem(command, ask.units)
        if isinstance(fields, str) or problem:
            self._move_command(ask.id, CommandPhase.REFUSED, message=problem)
            return
        named = args_of(command, ask.args)
        if self._refused_now(ask, named, guarded=guarded):
            return
        only_safe = f"{ask.device}/{ask.command}" in self._safe
        if problem := await self._writer.write_accepted(
            state, guarded=guarded, only_safe=only_safe
        ):
            self._move_command(ask.id, CommandPhase.REFUSED, message=problem)
            return
        ttl_ns = min(ask.ttl_ms * 1e6, command.ttl * 1e9) if guarded else ask.ttl_ms * 1e6
        # Written so that NaN refuses as well.
        if not self._clock.monotonic_ns() - began_ns <= ttl_ns or ttl_ns <= 0:
            self._move_command(
                ask.id, CommandPhase.REFUSED, message="it came too late to be accepted"
            )
            return
        # Once more: it may have begun to rain while the disk was busy.
        if self._refused_now(ask, named, guarded=guarded):
            return
        # From here on nothing is awaited before the robot is asked: what was judged still holds.
        over = self._take_hold(ask, command, guarded=guarded)
        self._send_state(state, over)
        if guarded:
            self._guard.command_began(ask.device, ask.command, ask.who, named)
            self.holders.announce_command(ask.device, ask.who)
        if guarded and self._guard.hold_for(ask.device, ask.command) is not None:
            waiting = asyncio.ensure_future(self._wait_outcome(ask, command, fields, named))
            self._waiting[ask.id] = waiting
            return
        self._begin_command(ask, command, fields)

    def _refused_now(self, ask: CommandRequest, named: dict[str, Scalar], *, guarded: bool) -> bool:
        """Refuse a command that may not be done now; tell whether it was refused."""
        # What a safe state needs nobody switches off, not even a sequence of the gateway's own.
        barred = self._guard.power_cut_reason(ask.device, ask.command, named)
        if guarded and not barred:
            barred = self._guard.refusal_reason(ask.device, ask.command, named)
        if barred:
            self._move_command(ask.id, CommandPhase.REFUSED, message=barred)
            return True
        holder = self.holders.holder_against(ask.device, ask.who) if guarded else None
        if holder is None or never_asks(self._site, ask.device, ask.command):
            return False
        if holder.id == ask.over and not holder.firm:
            log.info("%s interrupts %s of %s", ask.who, holder.doing, holder.who)
            self.holders.let_interrupt(holder.id)
            return False
        why = holder.words_since(self._clock.monotonic_ns())
        blocked_by = "" if holder.firm else holder.id
        self._move_command(ask.id, CommandPhase.REFUSED, message=why, blocked_by=blocked_by)
        return True

    def _take_hold(self, ask: CommandRequest, command: Command, *, guarded: bool) -> str:
        """Let nobody else act on the device unasked while this is under way.

        Gives in words what it interrupts, if anything.
        """
        device = self._site.devices[ask.device]
        doing = f"{device.name}: {command.name}"
        over = self._interrupt_holder(ask, doing)
        if device.kind not in HELD_KINDS or (not guarded and ask.who.startswith(FOLLOW_LABEL)):
            return over
        now_ns = self._clock.monotonic_ns()
        self.holders.add_holder(
            DeviceHolder(ask.id, ask.device, doing, ask.who, now_ns, safety=not guarded)
        )
        return over

    def _interrupt_holder(self, ask: CommandRequest, doing: str) -> str:
        """Take the device out of the hands that may be interrupted; give whose, in words."""
        holder = self.holders.interrupt_holder(ask.over)
        if holder is None:
            return ""
        # Who asked for it sees what became of it, and all others that they act no longer.
        self._move_command(
            holder.id, CommandPhase.RUNNING, message=f"interrupted by {ask.who} ({doing})"
        )
        return f"{holder.doing} of {holder.who} ({holder.id})"

    def _send_state(self, state: CommandState, over: str = "") -> None:
        """Tell the hub where a command stands, and who acts by it."""
        holder = None if state.phase in FINAL else self.holders.find_holder(state.id)
        if holder is not None:
            seconds = holder.acting_s(self._clock.monotonic_ns())
            state = replace(state, acting=holder.words[:2000], acting_s=seconds)
        self._send(replace(state, over=over[:2000]) if over else state)

    async def _wait_outcome(
        self,
        ask: CommandRequest,
        command: Command,
        fields: dict[str, float | int | bool | str],
        named: dict[str, Scalar],
    ) -> None:
        """Begin a command as soon as what it waits for is so."""
        outcome = await wait_until_ready(
            guard=self._guard,
            clock=self._clock,
            ask=ask,
            named=named,
            report=lambda why: self._move_command(ask.id, CommandPhase.RUNNING, message=why),
        )
        if outcome is not None:
            self._move_command(ask.id, outcome.phase, message=outcome.message)
            return
        # Meanwhile somebody may have been let act on the device over this one.
        if self._refused_now(ask, named, guarded=True):
            return
        self._waiting.pop(ask.id, None)
        self._begin_command(ask, command, fields)

    def _begin_command(
        self, ask: CommandRequest, command: Command, fields: dict[str, float | int | bool | str]
    ) -> None:
        self._move_command(ask.id, CommandPhase.RUNNING)
        self._actions.begin_action(ask, command, fields)

    def _on_outcome(self, command_id: str, outcome: CommandOutcome) -> None:
        # The bar of a command that has ended stays where it was.
        # 0 keeps the old bar, for `CommandBook` never lets progress fall.
        progress = outcome.progress if outcome.phase is CommandPhase.RUNNING else 0.0
        self._move_command(command_id, outcome.phase, message=outcome.message, progress=progress)

    def cancel_command(self, ask: CommandCancel) -> None:
        """Ask the robot to end a command early; what came of it is told as its state."""
        state = self._book.find_state(ask.id)
        if state is None or state.device != ask.device:
            return
        waiting = self._waiting.get(ask.id)
        cancel = self._actions.canceller_of(ask.id) if waiting is None else waiting.cancel
        if state.phase in FINAL:
            self._send_state(state)
        elif cancel is None:
            self._move_command(
                ask.id, CommandPhase.RUNNING, message="this command cannot be cancelled"
            )
        else:
            self._move_command(
                ask.id, CommandPhase.RUNNING, message=f"{ask.who} asked to cancel it"
            )
            cancel()

    def _move_command(
        self,
        command_id: str,
        phase: CommandPhase,
        *,
        message: str = "",
        progress: float = 0.0,
        blocked_by: str = "",
    ) -> None:
        state = self._book.move_command(
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
            self.holders.release_holder(command_id)
            self._actions.forget_timer(command_id)
            self._waiting.pop(command_id, None)
            self._guard.command_ended(state.device)
            ended = self._ends.get(command_id)
            if ended is not None and not ended.done():
                ended.set_result(state)
            # Not forced to disk: should this line be lost, the command reads as unknown.
            self._writer.begin_write(state, sure=False)

    async def write_waiting(self) -> None:
        """Try again to write what the disk did not take."""
        await self._writer.write_waiting()

    async def close(self) -> None:
        """Stop the timers and finish the writes. What still runs will read as unknown."""
        self._actions.close()
        held = list(self._waiting.values())
        for waiting in held:
            waiting.cancel()
        await asyncio.gather(*held, return_exceptions=True)
        await self._writer.close()
