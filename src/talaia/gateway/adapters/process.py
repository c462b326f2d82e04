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

__all__ = ["ProcessAdapter", "ProcessResult", "fill_arguments", "number_in", "run_words"]

log = logging.getLogger(__name__)
# Bytes of one output that are kept; the rest is read and thrown away, so that the command can end.
MAX_ANSWER = 64 * 1024
# Characters of what a command printed that go on as a value or as words for people.
MAX_SAID = 2000
# So many at once: starting a ROS client takes most of a second of a processor.
AT_ONCE = 2
# Negative angles and coordinates are arguments, as -12.5 or -05:23:28; other dashes are options.
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


def fill_arguments(target: str, command: Command, fields: Mapping[str, Scalar]) -> list[str] | str:
    """Give the arguments of a command with its placeholders filled, or what is wrong with one.

    Each placeholder becomes one argument as it is; an optional text that is empty becomes none.
    A text that begins with a dash would be an option of the program, so it is refused.
    """
    optional = {argument.field for argument in command.arguments.values() if argument.default == ""}
    words: list[str] = []
    # Cut before anything is filled in: what a person writes cannot become two arguments.
    for word in shlex.split(target):
        found = PLACEHOLDER.fullmatch(word)
        if found is None:
            words.append(word)
            continue
        # An argument that is not given stands for its default, an empty text.
        value = fields.get(found[1], "")
        if isinstance(value, bool):
            words.append("true" if value else "false")
        elif isinstance(value, str):
            if not value and found[1] in optional:
                continue
            # The system ends an argument there: the program would see another text than was
            # checked.
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
        # In the raw text: a pattern may count on spaces and line ends.
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
        # Not this signal's value, as an error's text: none is better than a wrong one.
        return None
    # A program's `nan` or `inf` is no reading.
    return value if math.isfinite(value) else None


async def run_words(words: Sequence[str], within: float) -> ProcessResult:
    """Run a command and wait for its end, ``within`` seconds at the most.

    Raises:
        OSError: it cannot be started.

    """
    starting = asyncio.ensure_future(
        asyncio.create_subprocess_exec(
            *words,
            # Nobody can answer a program that asks something, so it meets the end of its input.
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
            # Both at once: a program that fills one pipe while the other is read would wait for
            # ever.
            text, problem = await asyncio.gather(_all_of(process.stdout), _all_of(process.stderr))
            code = await process.wait()
    except TimeoutError:
        return ProcessResult(-1, "", f"did not end within {within:g} s and was ended")
    finally:
        # Also on cancellation, and when it left children behind that hold its output.
        # ProcessLookupError: all is gone already. PermissionError: what is left runs as somebody
        # else.
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signals.SIGKILL)
        # Waited for in any case: else it would stay behind as a zombie.
        cancelled = await outlast_cancellation(asyncio.ensure_future(process.wait()))
        if cancelled is not None:
            raise cancelled
    return ProcessResult(code, text, problem.strip()[-MAX_SAID:])


async def _all_of(stream: asyncio.StreamReader | None) -> str:
    """Read to the end, and keep the first 64 KiB."""
    kept = bytearray()
    # Read on beyond the bound: a full pipe would keep the command from ending.
    while stream is not None and (data := await stream.read(8192)):
        kept += data[: max(0, MAX_ANSWER - len(kept))]
    return kept.decode(errors="replace")


class _Line:
    """A command line that is asked for again and again, and the signals in its answer."""

    def __init__(self, device: str, words: list[str]) -> None:
        self.device = device  # Its device; one line never serves two.
        self.words = words  # Its arguments, prefix first; cut once.
        self.signals: dict[str, Signal] = {}  # By address; all read the same answer.
        self.good: bool | None = None  # How its last answer was; None before the first.
        self.why = ""  # What was wrong with it; empty when it was good.


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
        self._connection = connection  # The description's, for its times (s).
        # Stands before every line; no shell reads it.
        self._prefix = shlex.split(connection.prefix)
        self._gathered = SampleBuffer()  # Filled and emptied within one answer.
        # Of guarded signals; cleared when `run` ends, as nothing is heard then.
        self._latest: dict[str, ChannelReading] = {}
        # By device and its written line: several signals share one run.
        self._lines: dict[tuple[str, str], _Line] = {}
        # By address; none for a signal of which every value is kept.
        self._samplers: dict[str, Sampler] = {}
        # Addresses that were told as unreadable; once in this run is enough.
        self._unreadable: set[str] = set()
        # Lines that are asked for at the same time; people's commands do not wait here.
        self._slots = asyncio.Semaphore(AT_ONCE)
        # People's commands under way; held here, for asyncio alone would let them go.
        self._acts: set[asyncio.Task[None]] = set()
        self._running = False  # `run` is under way; before and after it nothing is begun.
        # Not `or`: an empty one is still the one that others look at.
        self.answers = {} if context.answers is None else context.answers
        for device_id, device in scope.devices.items():
            for signal_id, signal in device.signals.items():
                self._plan_signal(device_id, f"{device_id}/{signal_id}", signal)

    def _plan_signal(self, device: str, address: str, signal: Signal) -> None:
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
        asks = [asyncio.ensure_future(self._poll_command(line)) for line in self._lines.values()]
        try:
            self._status.up()
            if asks:
                await asyncio.gather(*asks)
            else:
                # Only commands for people: nothing is asked, and `run` lasts until it is cancelled.
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
            # Waited for: `run` promises that all is released when it returns.
            await asyncio.gather(*tasks, return_exceptions=True)
            self._latest.clear()
            # Old answers must not look like new ones after a restart.
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
        words = fill_arguments(described.target, described, fields)
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
        # As `run_words` says it of a command that was ended for its time: it may have done its
        # work.
        elif answer.code == -1 and not answer.text:
            done(CommandOutcome(CommandPhase.UNKNOWN, f"the command {said}; look at the device"))
        else:
            failed = said or f"the command ended with exit code {answer.code}"
            done(CommandOutcome(CommandPhase.FAILED, failed))

    # ── asking ──

    async def _poll_command(self, line: _Line) -> None:
        loop = asyncio.get_running_loop()
        while True:
            began = loop.time()
            # In turn: the whole time counts for the pace, with the wait for a place.
            async with self._slots:
                answer = await run_words(line.words, self._connection.timeout)
            self._read_answer(line, answer)
            # Never two of one line at once: a slow one is asked as often as it answers.
            took = loop.time() - began
            # A machine on which clients start slowly has other things to do as well.
            await asyncio.sleep(max(took / 2, self._connection.poll - took))

    def _read_answer(self, line: _Line, answer: ProcessResult) -> None:
        clock = self._context.clock
        # One time for all signals of an answer: they were true together.
        time_us, mono_ns = clock.wall_ns() // 1000, clock.monotonic_ns()
        known = False
        for address, signal in line.signals.items():
            # No answer, or too late: what it printed before is not true any more.
            if not answer.text:
                self.answers.pop(address, None)
                continue
            self.answers[address] = answer.text
            value = number_in(signal, answer.text)
            if isinstance(value, str):
                self._gathered.add_text(self._scope.channel[address], time_us, value)
            elif value is not None:
                known = True
                self._record_number(address, value, time_us, mono_ns)
            # Only after a good end: a command that fails prints an error instead, which is no news
            # here.
            elif answer.code == 0 and address not in self._unreadable:
                self._unreadable.add(address)
                said = f"{address}: its value is not in the answer {answer.text.strip()[:80]!r}"
                log.warning("%s", said)
                self._context.events.report_event("unreadable", said, device=line.device)
        columns = self._gathered.take_columns()
        if columns is not None:
            self._context.samples.put_samples(columns)
        # One value that was read is enough; else it must have ended well and printed something.
        line.good = known or (answer.code == 0 and bool(answer.text))
        line.why = "" if line.good else (answer.text.strip() or answer.problem or "no answer")
        self._report_device(line)

    def _record_number(self, address: str, value: float, time_us: int, mono_ns: int) -> None:
        # Before rate and deadband, which are for the record; interlocks see every value.
        if address in self._scope.guarded:
            self._latest[address] = ChannelReading(value, mono_ns)
        sampler = self._samplers.get(address)
        if sampler is None or sampler.accept_sample(time_us, (value,)):
            self._gathered.add_number(self._scope.channel[address], time_us, value)

    def _report_device(self, line: _Line) -> None:
        """Say whether the device answers: one line that does is enough."""
        lines = [other for other in self._lines.values() if other.device == line.device]
        if any(line.good for line in lines):
            self._status.device(line.device, there=True)
        # Not while one has yet to answer for the first time: that is no silence.
        elif all(line.good is False for line in lines):
            self._status.device(line.device, there=False, why=line.why[:200])
