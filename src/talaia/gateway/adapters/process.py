"""Commands of the operating system as a robot's side: run for what they print or what they do.

Each command line is cut into arguments once, by the rules of a shell's quotes but without a shell;
what a person writes fills one argument, whatever is in it. A line that several signals read is run
once. A command that does not end in time is ended with all it has started.

Long, because running, ending and reading a command scope its process and are read together.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
import os
import re
import shlex
import signal as signals
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.adapters.outlast_cancellation import outlast_cancellation
from talaia.gateway.adapters.topic_readers import SampleBuffer
from talaia.gateway.adapters.undriven_adapter import UndrivenAdapter
from talaia.gateway.errors import AdapterLost
from talaia.gateway.ports import ChannelReading, CommandOutcome
from talaia.gateway.samples.rate_limit import Sampler, rule_of
from talaia.model.connection import ProcessConnection, ProcessSource, source_as
from talaia.model.connections.process import PLACEHOLDER
from talaia.model.site import CommandKind, SignalType
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.ports import AdapterContext, AdapterStatus
    from talaia.model.site import Command, Signal
    from talaia.wire.frames import Scalar

__all__ = ["ProcessAdapter", "ProcessResult", "filled", "number_in", "run_words"]

log = logging.getLogger(__name__)
MAX_ANSWER = 64 * 1024
MAX_SAID = 2000
# So many at once: starting a ROS client takes most of a second of a processor.
AT_ONCE = 2
_NEGATIVE = re.compile(r"-\.?\d[\d.:eE+-]*\Z")


class ProcessResult(NamedTuple):
    """What a command printed and how it ended.

    Attributes:
        code: exit code; negative is a signal.
        text: standard output, cut at 64 KiB.
        problem: standard error, or why there is no answer.

    """

    code: int
    text: str
    problem: str = ""


def filled(target: str, command: Command, fields: Mapping[str, Scalar]) -> list[str] | str:
    """Give the arguments of a command with its placeholders filled, or what is wrong with one.

    Each placeholder becomes one argument as it is; an optional text that is empty becomes none.
    A text that begins with a dash would be an option of the program, so it is refused.
    """
    optional = {argument.field for argument in command.arguments.values() if argument.default == ""}
    words: list[str] = []
    for word in shlex.split(target):
        found = PLACEHOLDER.fullmatch(word)
        if found is None:
            words.append(word)
            continue
        value = fields.get(found[1], "")
        if isinstance(value, bool):
            words.append("true" if value else "false")
        elif isinstance(value, str):
            if not value and found[1] in optional:
                continue
            if "\0" in value:
                return f"{found[1]}: there is a NUL character in it"
            if value.startswith("-") and not _NEGATIVE.match(value):
                return f"{found[1]}: {value!r} begins with a dash, so it would be an option"
            words.append(value)
        else:
            # Not 1e-05: not every program reads that.
            words.append(f"{value:.12f}".rstrip("0").rstrip(".") if value % 1 else f"{value:.0f}")
    return words


def number_in(signal: Signal, text: str) -> float | str | None:
    """Read a signal's value in an answer; none where it is not in it."""
    source = source_as(signal.source, ProcessSource)
    said = text.strip()
    if source.pattern:
        found = re.search(source.pattern, text)
        if found is None:
            return None
        said = (found[1] if found.groups() else found[0]).strip()
    if signal.type is SignalType.STATE:
        return float(signal.states.index(said)) if said in signal.states else None
    if signal.type is SignalType.TEXT:
        return source.messages.get(said, said)[:MAX_SAID]
    try:
        value = float(said) * signal.scale
    except ValueError:
        return None
    return value if math.isfinite(value) else None


async def run_words(words: Sequence[str], within: float) -> ProcessResult:
    """Run a command and wait for its end, ``within`` seconds at the most.

    Raises:
        OSError: it cannot be started.

    """
    starting = asyncio.ensure_future(
        asyncio.create_subprocess_exec(
            *words,
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
            # A group of its own, so that what it starts can be ended with it.
            start_new_session=True,
        )
    )
    # Cut off while it starts, it would run on, and nobody would know of it.
    cancelled = await outlast_cancellation(starting)
    process = starting.result()
    try:
        if cancelled is not None:
            raise cancelled
        async with asyncio.timeout(within):
            text, problem = await asyncio.gather(_all_of(process.stdout), _all_of(process.stderr))
            code = await process.wait()
    except TimeoutError:
        return ProcessResult(-1, "", f"did not end within {within:g} s and was ended")
    finally:
        # Also on cancellation, and when it left children behind that hold its output.
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signals.SIGKILL)
        cancelled = await outlast_cancellation(asyncio.ensure_future(process.wait()))
        if cancelled is not None:
            raise cancelled
    return ProcessResult(code, text, problem.strip()[-MAX_SAID:])


async def _all_of(stream: asyncio.StreamReader | None) -> str:
    """Read to the end, and keep the first 64 KiB."""
    kept = bytearray()
    while stream is not None and (data := await stream.read(8192)):
        kept += data[: max(0, MAX_ANSWER - len(kept))]
    return kept.decode(errors="replace")


class _Line:
    """A command line that is asked for again and again, and the signals in its answer."""

    def __init__(self, device: str, words: list[str]) -> None:
        self.device = device
        self.words = words
        self.signals: dict[str, Signal] = {}
        self.good: bool | None = None
        self.why = ""


class ProcessAdapter(UndrivenAdapter):
    """An `Adapter` for plain commands. See `talaia.gateway.ports` for its promises.

    Attributes:
        answers: the newest answer to each signal's command, as it was printed, by address.

    """

    def __init__(
        self, scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
    ) -> None:
        """Cut every line; `run` begins to ask."""
        connection = scope.connection
        assert isinstance(connection, ProcessConnection)  # noqa: S101 - the catalogue's promise
        self._scope, self._context, self._status = scope, context, status
        self._connection = connection
        self._prefix = shlex.split(connection.prefix)
        self._gathered = SampleBuffer()
        self._latest: dict[str, ChannelReading] = {}
        self._lines: dict[tuple[str, str], _Line] = {}
        self._samplers: dict[str, Sampler] = {}
        self._unreadable: set[str] = set()
        self._slots = asyncio.Semaphore(AT_ONCE)
        self._acts: set[asyncio.Task[None]] = set()
        self._running = False
        # Not `or`: an empty one is still the one that others look at.
        self.answers = {} if context.answers is None else context.answers
        for device_id, device in scope.devices.items():
            for signal_id, signal in device.signals.items():
                self._plan(device_id, f"{device_id}/{signal_id}", signal)

    def _plan(self, device: str, address: str, signal: Signal) -> None:
        written = source_as(signal.source, ProcessSource).run
        key = (device, written)
        if not written:
            return
        line = self._lines.get(key)
        if line is None:
            words = [*self._prefix, *shlex.split(written)]
            line = self._lines[key] = _Line(device, words)
        line.signals[address] = signal
        rule = rule_of(signal)
        if rule is not None:
            self._samplers[address] = Sampler(rule)

    # ── Adapter ──

    async def run(self) -> None:
        """See `Adapter.run`."""
        self._running = True
        asks = [asyncio.ensure_future(self._poll(line)) for line in self._lines.values()]
        try:
            self._status.up()
            if asks:
                await asyncio.gather(*asks)
            else:
                await asyncio.Event().wait()
        except OSError as error:
            what = error.strerror or str(error)
            raise AdapterLost(
                f"{error.filename or 'a command'} cannot be started: {what}"
            ) from error
        finally:
            self._running = False
            tasks = [*asks, *self._acts]
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            self._latest.clear()
            for line in self._lines.values():
                for address in line.signals:
                    self.answers.pop(address, None)

    def watch(self, streams: Collection[str]) -> None:
        """Take no pictures: commands give none."""

    def latest(self, address: str) -> ChannelReading | None:
        """See `ReadingSource.latest`."""
        return self._latest.get(address)

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """Say how the newest answers were: there is no connection to be made anew."""
        silent = [
            f"{shlex.join(line.words)} ({line.why})"
            for line in self._lines.values()
            if line.device == device and not line.good
        ]
        phase = CommandPhase.FAILED if silent else CommandPhase.SUCCEEDED
        done(CommandOutcome(phase, "; ".join(silent)[:MAX_SAID]))

    def act(
        self,
        device: str,
        command: str,
        fields: dict[str, Scalar],
        done: Callable[[CommandOutcome], None],
    ) -> Callable[[], None] | None:
        """See `CommandTarget.act`."""
        described = self._scope.devices[device].commands.get(command)
        if described is None or described.kind is not CommandKind.PROCESS:
            done(CommandOutcome(CommandPhase.REFUSED, f"{device}/{command} is not a command line"))
            return None
        if not self._running:
            done(
                CommandOutcome(CommandPhase.REFUSED, "the commands of this robot cannot be run now")
            )
            return None
        words = filled(described.target, described, fields)
        if isinstance(words, str):
            done(CommandOutcome(CommandPhase.REFUSED, words))
            return None
        task = asyncio.ensure_future(
            self._run_command([*self._prefix, *words], described.timeout, done)
        )
        self._acts.add(task)
        task.add_done_callback(self._acts.discard)

        def cancel() -> None:
            task.cancel()

        return cancel

    async def _run_command(
        self, words: list[str], within: float, done: Callable[[CommandOutcome], None]
    ) -> None:
        try:
            # Ended a little before the caller gives up, so that its words are still heard.
            answer = await run_words(words, max(0.1, within * 0.95))
        except OSError as error:
            said = f"{words[0]} cannot be started: {error.strerror or error}"
            done(CommandOutcome(CommandPhase.REFUSED, said))
            return
        except asyncio.CancelledError:
            # Ended, but nobody knows what it had already set in motion.
            said = "the command was ended; look at the device to see what it did"
            done(CommandOutcome(CommandPhase.UNKNOWN, said))
            raise
        said = (answer.text.strip() or answer.problem)[:MAX_SAID]
        if answer.code == 0:
            done(CommandOutcome(CommandPhase.SUCCEEDED, said))
        elif answer.code == -1 and not answer.text:
            done(CommandOutcome(CommandPhase.UNKNOWN, f"the command {said}; look at the device"))
        else:
            failed = said or f"the command ended with exit code {answer.code}"
            done(CommandOutcome(CommandPhase.FAILED, failed))

    # ── asking ──

    async def _poll(self, line: _Line) -> None:
        loop = asyncio.get_running_loop()
        while True:
            began = loop.time()
            async with self._slots:
                answer = await run_words(line.words, self._connection.timeout)
            self._read_answer(line, answer)
            # Never two of one line at once: a slow one is asked as often as it answers.
            took = loop.time() - began
            # A machine on which clients start slowly has other things to do as well.
            await asyncio.sleep(max(took / 2, self._connection.poll - took))

    def _read_answer(self, line: _Line, answer: ProcessResult) -> None:
        clock = self._context.clock
        time_us, mono_ns = clock.wall_ns() // 1000, clock.monotonic_ns()
        known = False
        for address, signal in line.signals.items():
            if not answer.text:
                self.answers.pop(address, None)
                continue
            self.answers[address] = answer.text
            value = number_in(signal, answer.text)
            if isinstance(value, str):
                self._gathered.add_text(self._scope.channel[address], time_us, value)
            elif value is not None:
                known = True
                self._number(address, value, time_us, mono_ns)
            elif answer.code == 0 and address not in self._unreadable:
                self._unreadable.add(address)
                said = f"{address}: its value is not in the answer {answer.text.strip()[:80]!r}"
                log.warning("%s", said)
                self._context.events.report_event("unreadable", said, device=line.device)
        columns = self._gathered.take_columns()
        if columns is not None:
            self._context.samples.put_samples(columns)
        line.good = known or (answer.code == 0 and bool(answer.text))
        line.why = "" if line.good else (answer.text.strip() or answer.problem or "no answer")
        self._report_device(line)

    def _number(self, address: str, value: float, time_us: int, mono_ns: int) -> None:
        if address in self._scope.guarded:
            self._latest[address] = ChannelReading(value, mono_ns)
        sampler = self._samplers.get(address)
        if sampler is None or sampler.accepts(time_us, (value,)):
            self._gathered.add(self._scope.channel[address], time_us, value)

    def _report_device(self, line: _Line) -> None:
        """Say whether the device answers: one line that does is enough."""
        lines = [other for other in self._lines.values() if other.device == line.device]
        if any(line.good for line in lines):
            self._status.device(line.device, there=True)
        elif all(line.good is False for line in lines):
            self._status.device(line.device, there=False, why=line.why[:200])
