"""An adapter that an extension brings, in a process of its own.

It may block, leak or end as it likes: the gateway goes on, and begins it again a second later. What
it says is judged here like anything that comes from outside.

Long, because the process and what is asked of it are one life.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import logging
import math
import os
import socket
import sys
from typing import TYPE_CHECKING

import msgspec

from talaia.extensions.adapter_child import MAX_LINE
from talaia.extensions.adapter_messages import (
    ActMessage,
    AdapterJob,
    CancelMessage,
    DoneMessage,
    EndMessage,
    ReachableMessage,
    ReportMessage,
    SignalMessage,
    UpMessage,
    ValueMessage,
    read_from_adapter,
    write_message,
)
from talaia.extensions.declarations import AdapterExtension
from talaia.extensions.installed import installed_extensions
from talaia.gateway.adapters.outlast_cancellation import outlast_cancellation
from talaia.gateway.adapters.topic_readers import SampleBuffer
from talaia.gateway.adapters.undriven_adapter import UndrivenAdapter
from talaia.gateway.errors import AdapterLost, SettingsError
from talaia.gateway.ports import ChannelReading, CommandOutcome
from talaia.gateway.samples.rate_limit import Sampler, rule_of
from talaia.model.connection import ExtensionConnection, ExtensionSource, source_as
from talaia.model.site import CommandKind, SignalType
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from talaia.extensions.adapter_messages import FromAdapter, ToAdapter
    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.ports import AdapterContext, AdapterStatus
    from talaia.model.site import Signal
    from talaia.wire.frames import Scalar

__all__ = ["ExtensionAdapterProcess"]

log = logging.getLogger(__name__)
# Characters of a text value that are kept.
_MAX_TEXT = 2000
# Seconds that its process has to end by itself once its socket is closed.
_END_S = 3.0
# Values that come in one turn of the event loop go on together.
_FLUSH_S = 0.01
# What it may say of a command; any other word is taken as unknown.
_PHASES = {
    "succeeded": CommandPhase.SUCCEEDED,
    "failed": CommandPhase.FAILED,
    "refused": CommandPhase.REFUSED,
}


class ExtensionAdapterProcess(UndrivenAdapter):
    """An `Adapter` for a connection of kind ``extension``."""

    def __init__(
        self, scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
    ) -> None:
        """Speak for ``scope``.

        Raises:
            SettingsError: the extension is not installed here.

        """
        connection = scope.connection
        assert isinstance(connection, ExtensionConnection)  # noqa: S101 - the catalogue's promise
        self._name, self._keys = connection.extension, connection.keys
        _require_installed(scope.name, self._name)
        self._scope, self._context, self._status = scope, context, status
        # By address; what it says of other addresses is left out.
        self._signals: dict[str, Signal] = {
            f"{device_id}/{signal_id}": signal
            for device_id, device in scope.devices.items()
            for signal_id, signal in device.signals.items()
        }
        self._samplers = {  # By address; texts and signals without a rule are kept whole.
            address: Sampler(rule)
            for address, signal in self._signals.items()
            if signal.type is not SignalType.TEXT and (rule := rule_of(signal)) is not None
        }
        self._gathered = SampleBuffer()  # Until the next flush.
        # Of guarded signals; cleared when its process ends.
        self._latest: dict[str, ChannelReading] = {}
        # Addresses whose values were told as unreadable, each once.
        self._unreadable: set[str] = set()
        # To its process; None while there is none.
        self._writer: asyncio.StreamWriter | None = None
        # Of commands; not begun anew with a new process, so a late answer meets no other.
        self._numbers = itertools.count(1)
        # Commands under way, by number: whoever asked, told once.
        self._acts: dict[int, Callable[[CommandOutcome], None]] = {}
        self._flushing: asyncio.TimerHandle | None = None  # Set while something is gathered.

    async def run(self) -> None:
        """See `Adapter.run`."""
        # A socket and no pipe on its output: whatever its libraries print goes elsewhere.
        ours, theirs = socket.socketpair()
        try:
            # Our copy of its end is closed when it has started: else its death would never be
            # heard.
            with theirs:
                starting = asyncio.ensure_future(
                    asyncio.create_subprocess_exec(
                        sys.executable,
                        "-m",
                        "talaia.extensions.adapter_child",
                        str(theirs.fileno()),
                        stdin=asyncio.subprocess.DEVNULL,
                        # This one is handed on; all others of the gateway stay closed in it.
                        pass_fds=(theirs.fileno(),),
                    )
                )
                # Cut off while it starts, it would run on, and nobody would know of it.
                cancelled = await outlast_cancellation(starting)
                child = starting.result()
        except OSError as error:
            ours.close()
            raise AdapterLost(f"its process cannot be started: {error}") from error
        ours.setblocking(False)  # noqa: FBT003 - as it is there
        try:
            if cancelled is not None:
                ours.close()
                raise cancelled
            # A longer line is an error: it must not fill our memory.
            reader, self._writer = await asyncio.open_connection(sock=ours, limit=MAX_LINE)
            self._send_message(self._make_job())
            # `_read_messages` returns only when nothing more is to be heard, with the reason.
            raise AdapterLost(await self._read_messages(reader))
        finally:
            # The socket first: its end is what tells the process to go.
            try:
                self._end_process()
            finally:
                await _wait_ended(child)

    def _make_job(self) -> AdapterJob:
        signals = tuple(
            SignalMessage(
                address,
                address.partition("/")[0],
                str(signal.type),
                signal.unit,
                signal.states,
                source_as(signal.source, ExtensionSource).keys,
            )
            for address, signal in self._signals.items()
        )
        folder = os.fspath(self._context.folder.absolute())
        return AdapterJob(
            self._scope.name, self._name, self._keys, folder, tuple(self._scope.devices), signals
        )

    def _end_process(self) -> None:
        """Let go of the process, and of all that it was asked."""
        # What it said before it ended is heard, and goes out.
        if self._flushing is not None:
            self._flush_samples()
        if self._writer is not None:
            self._writer.close()
            self._writer = None
        # Nothing old may look true while nobody reads the device.
        self._latest.clear()
        # A copy: each outcome takes its own number out.
        for number in list(self._acts):
            said = "the adapter ended meanwhile; look at the device"
            self._finish_command(number, CommandOutcome(CommandPhase.UNKNOWN, said))

    async def _read_messages(self, reader: asyncio.StreamReader) -> str:
        """Take what the process says; give why it ended."""
        why = ""
        while True:
            try:
                # ValueError: a line beyond the bound. Either way nothing after it can be trusted.
                line = await reader.readline()
            except (ValueError, OSError) as error:
                return f"what its process says cannot be read: {error}"
            if not line:
                # End of the stream; `why` is what it said before, in a message of its own.
                return why or "its process ended without a word"
            try:
                words = read_from_adapter(line)
            # Wrong words are as a broken process: it is begun anew, not guessed at.
            except (msgspec.MsgspecError, UnicodeError, RecursionError) as error:
                return f"what its process says cannot be read: {error}"
            if isinstance(words, EndMessage):
                why = words.why
                if words.broken:
                    why = f"the extension {self._name!r} failed: {why}"
                    installed_extensions().note_failure(AdapterExtension, self._name, words.why)
            else:
                self._dispatch_message(words)

    def _dispatch_message(self, words: FromAdapter) -> None:
        match words:
            case UpMessage():
                self._status.up()
            case ValueMessage():
                self._handle_value(words)
            case ReachableMessage():
                # Of its own devices only: an extension has no say in others.
                if words.device in self._scope.devices:
                    self._status.device(words.device, there=words.reachable, why=words.why[:200])
            case ReportMessage():
                said = f"{self._scope.name}: {words.message}"
                self._context.events.report_event(words.kind, said)
            case DoneMessage():
                # A phase that is not known here: something may have moved all the same.
                phase = _PHASES.get(words.phase, CommandPhase.UNKNOWN)
                self._finish_command(words.number, CommandOutcome(phase, words.message))
            case EndMessage():
                pass

    def _handle_value(self, words: ValueMessage) -> None:
        signal = self._signals.get(words.address)
        # A signal of an earlier description, or one that it made up.
        if signal is None:
            return
        clock = self._context.clock
        mono_ns = clock.monotonic_ns()
        # Its own time if it has one; for ages only our monotonic clock counts.
        time_us = clock.wall_ns() // 1000 if words.time_us is None else words.time_us
        channel = self._scope.channel[words.address]
        if signal.type is SignalType.TEXT:
            text = words.value if isinstance(words.value, str) else f"{words.value}"
            self._gathered.add_text(channel, time_us, text[:_MAX_TEXT])
        else:
            value = _to_number(signal, words.value)
            if value is None:
                self._report_unreadable(words)
                return
            # Before the sampler: interlocks see every value.
            if words.address in self._scope.guarded:
                self._latest[words.address] = ChannelReading(value, mono_ns)
            sampler = self._samplers.get(words.address)
            if sampler is not None and not sampler.accept_sample(time_us, (value,)):
                return
            self._gathered.add_number(channel, time_us, value)
        if self._flushing is None:
            self._flushing = asyncio.get_running_loop().call_later(_FLUSH_S, self._flush_samples)

    def _report_unreadable(self, words: ValueMessage) -> None:
        # Once for each address: a wrong unit would come with every value.
        if words.address in self._unreadable:
            return
        self._unreadable.add(words.address)
        said = f"{words.address}: {str(words.value)[:80]!r} is no value of this signal"
        log.warning("%s", said)
        self._context.events.report_event(
            "unreadable", said, device=words.address.partition("/")[0]
        )

    def _flush_samples(self) -> None:
        if self._flushing is not None:
            # Also called by `_end_process`, before the timer has run out.
            self._flushing.cancel()
            self._flushing = None
        columns = self._gathered.take_columns()
        if columns is not None:
            self._context.samples.put_samples(columns)

    def _send_message(self, words: ToAdapter) -> None:
        if self._writer is not None:
            self._writer.write(write_message(words))

    # ── what is asked of it ──

    def latest(self, address: str) -> ChannelReading | None:
        """See `ReadingSource.latest`."""
        return self._latest.get(address)

    def watch(self, streams: Collection[str]) -> None:
        """Take no pictures: extensions give none."""

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """Begin the process anew, for all its devices."""
        if self._writer is None:
            done(
                CommandOutcome(CommandPhase.FAILED, "it is not connected; it is tried every second")
            )
            return
        # The reader meets the end, `run` raises, and the caller begins it again.
        self._writer.close()
        done(CommandOutcome(CommandPhase.SUCCEEDED, "its process is started anew"))

    def act(
        self,
        device: str,
        command: str,
        fields: dict[str, Scalar],
        done: Callable[[CommandOutcome], None],
    ) -> Callable[[], None] | None:
        """See `CommandTarget.act`."""
        described = self._scope.devices[device].commands.get(command)
        if described is None or described.kind is not CommandKind.EXTENSION:
            said = f"{device}/{command} is no command of an extension"
            done(CommandOutcome(CommandPhase.REFUSED, said))
            return None
        if self._writer is None:
            done(
                CommandOutcome(CommandPhase.REFUSED, "the adapter of this device does not run now")
            )
            return None
        number = next(self._numbers)
        self._acts[number] = done
        keys = {"target": described.target, **fields}
        self._send_message(ActMessage(number, device, command, keys))
        loop = asyncio.get_running_loop()

        def cancel() -> None:
            # `act` promises that it may be called from any thread.
            loop.call_soon_threadsafe(self._send_message, CancelMessage(number))

        return cancel

    def _finish_command(self, number: int, outcome: CommandOutcome) -> None:
        # Taken out first: a second answer to the same number finds nobody.
        done = self._acts.pop(number, None)
        if done is not None:
            done(outcome)


def _require_installed(connection: str, name: str) -> None:
    # By name only: its code is for a process of its own.
    names = installed_extensions().names_of(AdapterExtension)
    if name in names:
        return
    there = ", ".join(names) or "none"
    raise SettingsError(
        f"the connection {connection} of the description needs the extension {name!r}, which is "
        "not installed here: pip install the package that brings it, into the gateway's "
        f"environment; installed adapters: {there}"
    )


def _to_number(signal: Signal, value: float | str) -> float | None:
    """Give a value as a number of the signal's; none where it is no value of it."""
    if signal.type is SignalType.STATE:
        if isinstance(value, str):
            # A state that is not in the list is no value: a guess would be acted upon.
            return float(signal.states.index(value)) if value in signal.states else None
        # NaN first, for it compares with nothing.
        whole = not math.isnan(value) and 0 <= value < len(signal.states) and value == value // 1
        return float(value) if whole else None
    try:
        number = float(value) * signal.scale
    except ValueError:
        return None
    return number if math.isfinite(number) else None


async def _wait_ended(child: asyncio.subprocess.Process) -> None:
    """Wait for the end of a process whose socket is closed, also when cancelled meanwhile."""
    cancelled = await outlast_cancellation(asyncio.ensure_future(_end_process(child)))
    if cancelled is not None:
        raise cancelled


async def _end_process(child: asyncio.subprocess.Process) -> None:
    """Wait for a process, and kill it when it does not end by itself."""
    waiting = asyncio.ensure_future(child.wait())
    # `wait` and not `wait_for`: that would cancel the waiting, which goes on after the kill.
    done, _ = await asyncio.wait([waiting], timeout=_END_S)
    if not done:
        with contextlib.suppress(ProcessLookupError):
            # It ended in between.
            child.kill()
        await waiting
