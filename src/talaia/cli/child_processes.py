"""Processes that run together: each started with its output kept, all ended together."""

from __future__ import annotations

import asyncio
import contextlib
import ctypes
import os
import random
import signal
import sys
import time
from collections import deque
from typing import TYPE_CHECKING

from talaia.cli.errors import PartStopped
from talaia.gateway.uplink.backoff import Backoff

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Mapping, Sequence
    from pathlib import Path

    _Launch = Callable[[], Coroutine[None, None, asyncio.subprocess.Process]]

__all__ = ["ChildProcess", "end_all", "run_together", "start_program", "start_talaia"]

# Of linux/prctl.h; see prctl(2).
_PR_SET_PDEATHSIG = 1
# Enough for the end of a traceback.
_LAST_LINES = 15
# Ends in a row after which a person should read the log.
_NOT_STAYING = 3


class ChildProcess:
    """One process of the product, with its last words and its log."""

    def __init__(
        self,
        name: str,
        process: asyncio.subprocess.Process,
        log: Path,
        relaunch: _Launch | None = None,
    ) -> None:
        """Take a process that was just started with its output piped.

        With ``relaunch`` it is started again when it ends by itself; see `keep_running`.
        """
        # What people read: "hub", "gateway of the vehicle".
        self.name = name
        # The one that runs now; replaced by `_start_again`.
        self.process = process
        # Appended to, so that a restart does not wipe out why it was needed.
        self.log = log
        # None: its end is the end of all.
        self._relaunch = relaunch
        # When the present process started (monotonic, s), to judge whether it stays.
        self._began = time.monotonic()
        # Newest lines of output; they go on over a restart.
        self.last: deque[str] = deque(maxlen=_LAST_LINES)
        # Words that somebody waits to see in the output.
        self._waiting: list[tuple[str, asyncio.Future[str]]] = []
        # Reads until the output ends, then tells everybody who waits for a word; one for each
        # process.
        self._reader = asyncio.create_task(self._read_output())

    async def wait_line(self, word: str, within: float) -> str:
        """Wait for a line of output that holds ``word`` and give it.

        Raises:
            PartStopped: the process ended first, or ``within`` seconds passed.

        """
        # It may have been said before anybody asked.
        found = next((line for line in self.last if word in line), None)
        if found is not None:
            return found
        future: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        self._waiting.append((word, future))
        try:
            return await asyncio.wait_for(future, within)
        except TimeoutError as error:
            words = "\n".join([*self.last, f"(it did not say {word!r} within {within:.0f} s)"])
            raise PartStopped(self.name, self.process.returncode or 0, words) from error

    async def wait_failure(self) -> None:
        """Wait for the end that nobody asked for, and raise it.

        Raises:
            PartStopped: always.

        """
        raise PartStopped(self.name, await self._exit_code(), "\n".join(self.last))

    async def keep_running(self) -> None:
        """Start it again whenever it ends, as a service manager does, if it is of that kind.

        The waits double while it does not stay. It is said once that it stopped, and once more
        that it does not stay.

        Raises:
            PartStopped: it ended, and is not of that kind.

        """
        # The gateway's rule for dialling: a process that lasted begins with short waits again.
        backoff = Backoff(random.SystemRandom().random)
        stops = 0
        while self._relaunch is not None:
            code = await self._exit_code()
            lasted = time.monotonic() - self._began
            stops = 1 if lasted >= Backoff.STABLE_S else stops + 1
            if stops == 1:
                print(f"\n  the {self.name} stopped (exit code {code}); it is started again")
            elif stops == _NOT_STAYING:
                last = "\n    ".join(self.last)
                print(f"\n  the {self.name} stops again and again; see {self.log}\n    {last}")
            sys.stdout.flush()
            await asyncio.sleep(backoff.after(lasted))
            await self._start_again(self._relaunch)
        await self.wait_failure()

    async def _exit_code(self) -> int:
        # The output first, for a process that has ended may have left lines in the pipe. Shielded:
        # who waits here may be cancelled, and the output must be read on.
        await asyncio.shield(self._reader)
        return await self.process.wait()

    async def _start_again(self, relaunch: _Launch) -> None:
        # A task of its own: cancelled half way, a process would run that nobody knows of.
        starting = asyncio.ensure_future(relaunch())
        try:
            await asyncio.shield(starting)
        finally:
            # Cut short just now: what is starting already is ended with the others.
            self.process = await starting
            self._began = time.monotonic()
            self._reader = asyncio.create_task(self._read_output())

    async def end_process(self, within: float = 5.0) -> None:
        """Ask the process to end, and end it when it does not."""
        if self.process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                # Gone between the test and the signal.
                self.process.send_signal(signal.SIGTERM)
        try:
            await asyncio.wait_for(self.process.wait(), within)
        except TimeoutError:
            with contextlib.suppress(ProcessLookupError):
                self.process.kill()
            await self.process.wait()
        # The log is complete only then.
        await self._reader

    async def _read_output(self) -> None:
        output = self.process.stdout
        if output is None:
            return
        with self.log.open("a", encoding="utf-8") as log:
            async for raw in output:
                line = raw.decode(errors="replace").rstrip()
                log.write(line + "\n")
                # Each line: whoever reads the log wants to see why nothing happens now.
                log.flush()
                self.last.append(line)
                for word, future in self._waiting:
                    if word in line and not future.done():
                        future.set_result(line)
        # Output has ended: what was not said until now will not be said.
        code = await self.process.wait()
        for _, future in self._waiting:
            if not future.done():
                future.set_exception(PartStopped(self.name, code, "\n".join(self.last)))


async def start_talaia(
    name: str,
    words: Sequence[str],
    log: Path,
    environment: Mapping[str, str] | None = None,
    *,
    restart: bool = False,
) -> ChildProcess:
    """Start ``talaia <words>`` in a session of its own, so that Ctrl-C reaches only us.

    Its output goes to ``log`` and to `ChildProcess.last`. It gets SIGTERM when this process dies,
    however that happens: a simulated robot must not go on alone. With ``restart`` it is started
    again when it ends by itself, once all processes were ready.
    """
    program = [sys.executable, "-m", "talaia", *words]
    return await start_program(name, program, log, environment, restart=restart)


async def start_program(
    name: str,
    words: Sequence[str],
    log: Path,
    environment: Mapping[str, str] | None = None,
    *,
    restart: bool = False,
) -> ChildProcess:
    """Start another program in the same way."""

    async def launch() -> asyncio.subprocess.Process:
        return await asyncio.create_subprocess_exec(
            *words,
            # No part may take the keys that are typed in the terminal.
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.STDOUT,
            # Python holds output to a pipe back otherwise, and `wait_line` would wait for a full
            # buffer.
            env={**os.environ, "PYTHONUNBUFFERED": "1", **(environment or {})},
            start_new_session=True,
            preexec_fn=_follow_parent if sys.platform == "linux" else None,
            # Bytes of a line; asyncio's own limit of 64 KiB would end the reader.
            limit=1024 * 1024,
        )

    return ChildProcess(name, await launch(), log, launch if restart else None)


async def run_together(begin: Callable[[list[ChildProcess]], Coroutine[None, None, None]]) -> None:
    """Run what ``begin`` starts until Ctrl-C or SIGTERM, then end every part of it.

    ``begin`` adds each part to its list as soon as it is started, so that none is left over when
    it fails or is cut short.

    Raises:
        PartStopped: a part ended by itself that is not started again.

    """
    stop = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        # Only sets an event: the parts are ended below, in one place.
        loop.add_signal_handler(number, stop.set)
    parts: list[ChildProcess] = []
    stopped: asyncio.Future[object] = asyncio.ensure_future(stop.wait())
    try:
        ready: asyncio.Future[object] = asyncio.ensure_future(begin(parts))
        await asyncio.wait({ready, stopped}, return_when=asyncio.FIRST_COMPLETED)
        if not ready.done():
            # Cut short while starting; what was started is in `parts` already.
            ready.cancel()
            return
        await ready
        kept: list[asyncio.Future[object]] = [
            asyncio.ensure_future(part.keep_running()) for part in parts
        ]
        done, _ = await asyncio.wait([stopped, *kept], return_when=asyncio.FIRST_COMPLETED)
        for task in kept:
            task.cancel()
        # What is starting again just now must have started before it can be ended.
        await asyncio.gather(*kept, return_exceptions=True)
        # Raises why a part ended, when it was that and not a person.
        for task in done - {stopped}:
            await task
    finally:
        stopped.cancel()
        print("\nstopping …", flush=True)
        await end_all(parts)


async def end_all(parts: Sequence[ChildProcess]) -> None:
    """End every part at once."""
    await asyncio.gather(*(part.end_process() for part in parts))


# Loaded before any fork: a forked child should do as little as it can.
_LIBC = ctypes.CDLL(None) if sys.platform == "linux" else None


def _follow_parent() -> None:
    if _LIBC is not None:
        # Between fork and exec: SIGTERM to this process when its parent dies, a killed one
        # included.
        _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
