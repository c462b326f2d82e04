"""Act on commands: written to disk before the robot is asked, each id at most once.

Long, because each step of a command's life leans on what the one before it wrote down.
"""

from __future__ import annotations

import asyncio
import errno
import logging
import os
from typing import TYPE_CHECKING

import msgspec

from talaia.clock import SECOND
from talaia.gateway.commands import FINAL, CommandBook
from talaia.gateway.errors import SpoolError
from talaia.gateway.keep import write_whole
from talaia.model.arguments import args_of, fields_of, unit_problem
from talaia.wire.frames import CommandPhase, CommandState

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Collection
    from pathlib import Path

    from talaia.clock import Clock
    from talaia.gateway.enclosure import Hold
    from talaia.gateway.ports import CommandTarget, Outcome
    from talaia.model.site import Command, Site
    from talaia.wire.frames import CommandAsk, CommandCancel, Scalar

__all__ = ["Commanding", "Journal"]

log = logging.getLogger(__name__)
PROGRESS_NS = SECOND // 5
WAIT_LOOK_S = 0.1
_line = msgspec.json.Decoder(CommandState)
_encode = msgspec.json.Encoder().encode


class Journal:
    """Command states on disk, one JSON line each; a line cut short by a crash is ignored."""

    def __init__(self, path: Path) -> None:
        """Read what is there.

        Raises:
            SpoolError: the file cannot be read.

        """
        self._path = path
        self.remembered: list[CommandState] = []
        try:
            lines = path.read_bytes().splitlines()
        except FileNotFoundError:
            lines = []
        except OSError as error:
            raise SpoolError(f"{path} cannot be read: {error}") from error
        for line in filter(None, lines):
            try:
                self.remembered.append(_line.decode(line))
            except msgspec.DecodeError:
                log.warning("%s: a line was cut short; ignored", path)

    def compact(self, states: list[CommandState]) -> None:
        """Keep the newest state of each id only.

        Raises:
            OSError: not written; the journal is as it was.

        """
        write_whole(self._path, b"".join(_encode(state) + b"\n" for state in states))

    def write(self, state: CommandState, *, sure: bool) -> None:
        """Add a state; with ``sure`` it is on disk when this returns.

        Raises:
            OSError: not written.

        """
        with self._path.open("ab") as file:
            # The leading line end closes a line that a failed write may have left open.
            file.write(b"\n" + _encode(state) + b"\n" if file.tell() else _encode(state) + b"\n")
            file.flush()
            if sure:
                os.fsync(file.fileno())


class Commanding:
    """Takes asks from the hub and sees each to its end."""

    def __init__(
        self,
        site: Site,
        clock: Clock,
        target: CommandTarget,
        journal: Journal,
        on_disk: Callable[[Callable[[], None]], Awaitable[None]],
        send: Callable[[CommandState], None],
        refusal: Callable[[str, str, dict[str, Scalar]], str] = lambda _device, _command, _args: "",
        begun: Callable[[str, str, str], None] = lambda _device, _command, _who: None,
        hold: Callable[[str, str], Hold | None] = lambda _device, _command: None,
        ended: Callable[[str], None] = lambda _device: None,
    ) -> None:
        """Take up what the journal remembers.

        Args:
            site: the description.
            clock: monotonic.
            target: who acts.
            journal: see `Journal`.
            on_disk: runs a blocking write elsewhere, in order; raises what it raises.
            send: tells the hub.
            refusal: says why a command of a device with these arguments (by name) may not be
                given now, if so: interlocks.
            begun: told of each command of a person that begins: device, command, who.
            hold: says what a command has to wait for before the robot is asked, if so.
            ended: told of which device a command has ended.

        Raises:
            SpoolError: the journal cannot be written.

        """
        self._site = site
        self._clock = clock
        self._target = target
        self._journal = journal
        self._on_disk = on_disk
        self._send = send
        self._refusal = refusal
        self._begun = begun
        self._hold = hold
        self._on_ended = ended
        self._held: dict[str, asyncio.Task[None]] = {}
        self._ends: dict[str, asyncio.Future[CommandState]] = {}
        self._book = CommandBook(journal.remembered)
        self._timers: dict[str, asyncio.TimerHandle] = {}
        self._cancels: dict[str, Callable[[], None]] = {}
        self._progress_ns: dict[str, int] = {}
        self._writes: set[asyncio.Task[None]] = set()
        try:
            journal.compact(self._book.states())
        except OSError as error:
            if error.errno != errno.ENOSPC:
                raise SpoolError(f"the journal of commands cannot be written: {error}") from error
            log.warning("the journal of commands stays as long as it is: %s", error)

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

    def redescribe(self, site: Site) -> None:
        """Take commands by another description from here on."""
        self._site = site

    def report(self) -> None:
        """Tell a new link of the commands that a restart interrupted; once."""
        for state in self._book.interrupted:
            self._send(state)
        self._book.interrupted.clear()

    async def perform(self, ask: CommandAsk, within: float | None) -> CommandState:
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

    async def ask(self, ask: CommandAsk, *, guarded: bool = True) -> None:
        """Act on a command, or say why not. A known id is only answered."""
        began_ns = self._clock.monotonic_ns()
        known = self._book.get(ask.id)
        if known is not None:
            self._send(known)
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
            self._move(ask.id, CommandPhase.REFUSED, problem)
            return
        fields = fields_of(command, ask.args)
        problem = fields if isinstance(fields, str) else unit_problem(command, ask.units)
        if isinstance(fields, str) or problem:
            self._move(ask.id, CommandPhase.REFUSED, problem)
            return
        named = args_of(command, ask.args)
        if barred := guarded and self._refusal(ask.device, ask.command, named):
            self._move(ask.id, CommandPhase.REFUSED, barred)
            return
        try:
            await self._on_disk(lambda: self._journal.write(state, sure=True))
        except OSError as error:
            problem = f"the gateway cannot write its journal: {error}"
            self._move(ask.id, CommandPhase.REFUSED, problem)
            return
        ttl_ns = min(ask.ttl_ms * 1e6, command.ttl * 1e9) if guarded else ask.ttl_ms * 1e6
        # Written so that NaN refuses as well.
        if not self._clock.monotonic_ns() - began_ns <= ttl_ns or ttl_ns <= 0:
            self._move(ask.id, CommandPhase.REFUSED, "it came too late to be accepted")
            return
        # Once more: it may have begun to rain while the disk was busy.
        if barred := guarded and self._refusal(ask.device, ask.command, named):
            self._move(ask.id, CommandPhase.REFUSED, barred)
            return
        self._send(state)
        if guarded:
            self._begun(ask.device, ask.command, ask.who)
        if guarded and self._hold(ask.device, ask.command) is not None:
            waiting = asyncio.ensure_future(self._wait(ask, command, fields, named))
            self._held[ask.id] = waiting
            self._cancels[ask.id] = lambda: self._stop_waiting(ask.id)
            return
        self._begin(ask, command, fields)

    def _stop_waiting(self, command_id: str) -> None:
        waiting = self._held.get(command_id)
        if waiting is not None:
            waiting.cancel()

    async def _wait(
        self,
        ask: CommandAsk,
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
                    self._move(ask.id, CommandPhase.REFUSED, held.why)
                    return
                if waited > held.wait_s:
                    late = f"{held.why} took longer than {held.wait_s:g} s; nothing was done"
                    self._move(ask.id, CommandPhase.FAILED, late)
                    return
                if held.why != said:
                    said = held.why
                    self._move(ask.id, CommandPhase.RUNNING, said)
                await asyncio.sleep(WAIT_LOOK_S)
                if barred := self._refusal(ask.device, ask.command, named):
                    self._move(ask.id, CommandPhase.REFUSED, barred)
                    return
        except asyncio.CancelledError:
            self._move(ask.id, CommandPhase.CANCELLED, "it was still waiting; nothing was done")
            return
        self._cancels.pop(ask.id, None)
        self._held.pop(ask.id, None)
        self._begin(ask, command, fields)

    def _begin(
        self, ask: CommandAsk, command: Command, fields: dict[str, float | int | bool | str]
    ) -> None:
        loop = asyncio.get_running_loop()
        self._move(ask.id, CommandPhase.RUNNING)
        self._time_out(ask.id, command.timeout)

        def done(outcome: Outcome) -> None:
            loop.call_soon_threadsafe(self._told, ask.id, command.timeout, outcome)

        cancel = self._target.act(ask.device, ask.command, fields, done)
        if cancel is not None:
            self._cancels[ask.id] = cancel

    def _time_out(self, command_id: str, seconds: float) -> None:
        before = self._timers.get(command_id)
        if before is not None:
            before.cancel()
        message = f"no answer for {seconds:g} s; look at the device"
        self._timers[command_id] = asyncio.get_running_loop().call_later(
            seconds, self._move, command_id, CommandPhase.UNKNOWN, message
        )

    def _told(self, command_id: str, timeout: float, outcome: Outcome) -> None:
        if outcome.phase is not CommandPhase.RUNNING:
            self._move(command_id, outcome.phase, outcome.message)
            return
        state = self._book.get(command_id)
        if state is None or state.phase in FINAL:
            return
        self._time_out(command_id, timeout)
        # Feedback may come a hundred times a second; a bar on a page does not move that fast.
        now_ns = self._clock.monotonic_ns()
        if outcome.message or now_ns - self._progress_ns.get(command_id, 0) >= PROGRESS_NS:
            self._progress_ns[command_id] = now_ns
            self._move(command_id, CommandPhase.RUNNING, outcome.message, outcome.progress)

    def cancel(self, ask: CommandCancel) -> None:
        """Ask the robot to end a command early; what came of it is told as its state."""
        state = self._book.get(ask.id)
        if state is None or state.device != ask.device:
            return
        cancel = self._cancels.get(ask.id)
        if state.phase in FINAL:
            self._send(state)
        elif cancel is None:
            self._move(ask.id, CommandPhase.RUNNING, "this command cannot be cancelled")
        else:
            self._move(ask.id, CommandPhase.RUNNING, f"{ask.who} asked to cancel it")
            cancel()

    def _move(
        self, command_id: str, phase: CommandPhase, message: str = "", progress: float = 0.0
    ) -> None:
        state = self._book.move(command_id, phase, message, progress)
        if state is None:
            log.info("command %s: %s came after its end", command_id, phase)
            return
        self._send(state)
        if phase in FINAL:
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
            task = asyncio.ensure_future(self._keep(state))
            self._writes.add(task)
            task.add_done_callback(self._writes.discard)

    async def _keep(self, state: CommandState) -> None:
        try:
            await self._on_disk(lambda: self._journal.write(state, sure=False))
        except OSError as error:
            log.warning("the journal of commands cannot be written: %s", error)

    async def close(self) -> None:
        """Stop the timers and finish the writes. What still runs will read as unknown."""
        for timer in self._timers.values():
            timer.cancel()
        held = list(self._held.values())
        for waiting in held:
            waiting.cancel()
        await asyncio.gather(*held, return_exceptions=True)
        await asyncio.gather(*self._writes)
