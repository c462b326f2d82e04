"""Start a Python program and talk with it: `asyncio.create_subprocess_exec`, from a fork server.

Where programs are not forked (see `fork_server`) it is that function.
"""

from __future__ import annotations

import asyncio
import os
import sys
from typing import TYPE_CHECKING

import fork_server

if TYPE_CHECKING:
    from fork_server import ForkedProcess


class AsyncProgram:
    """A program that runs: what tests use of `asyncio.subprocess.Process`.

    Attributes:
        pid: of the process.
        stdin, stdout, stderr: its pipes; without one for errors these go where this process's go.

    """

    def __init__(
        self,
        process: ForkedProcess,
        *,
        stdin: asyncio.StreamWriter,
        stdout: asyncio.StreamReader,
        stderr: asyncio.StreamReader | None,
    ) -> None:
        """Wrap what was forked and the pipes to it."""
        self._process = process
        self.pid = process.pid
        self.stdin, self.stdout, self.stderr = stdin, stdout, stderr

    @property
    def returncode(self) -> int | None:
        """The exit code, or None while it runs; negative for a signal."""
        return self._process.poll()

    async def wait(self) -> int:
        """Wait for its end and give the exit code."""
        code = await asyncio.to_thread(self._process.wait)
        self.stdin.close()
        return code

    async def communicate(self) -> tuple[bytes, bytes]:
        """Close its input, read all that it prints, and wait for its end."""
        self.stdin.close()
        reading = [self.stdout.read()] + ([self.stderr.read()] if self.stderr else [])
        output, *errors = await asyncio.gather(*reading)
        await self.wait()
        return output, b"".join(errors)

    def send_signal(self, number: int) -> None:
        """Send a signal, if it still runs."""
        self._process.send_signal(number)

    def terminate(self) -> None:
        """Ask it to end."""
        self._process.terminate()

    def kill(self) -> None:
        """End it."""
        self._process.kill()


async def start_program(
    *words: str, with_errors: bool = False, **environment: str
) -> AsyncProgram | asyncio.subprocess.Process:
    """Run ``python WORDS`` with pipes; ``environment`` comes on top of this process's.

    Args:
        words: ``-m``, a module and its arguments, or a script and its own.
        with_errors: with a pipe for its standard error, which is to be read then.
        environment: variables by name.

    """
    everything = {**os.environ, "PYTHONPATH": "src", "PYTHONUNBUFFERED": "1", **environment}
    if not fork_server.is_used():
        pipe = asyncio.subprocess.PIPE
        return await asyncio.create_subprocess_exec(
            sys.executable,
            *words,
            env=everything,
            stdin=pipe,
            stdout=pipe,
            stderr=pipe if with_errors else None,
        )
    output, theirs = os.pipe()
    errors, their_errors = os.pipe() if with_errors else (None, os.dup(2))
    with os.fdopen(theirs, "wb") as out, os.fdopen(their_errors, "wb") as err:
        process = fork_server.fork_program(list(words), everything, out, err)
    return AsyncProgram(
        process,
        stdin=await _write_to(process),
        stdout=await _read_from(output),
        stderr=None if errors is None else await _read_from(errors),
    )


async def _read_from(fd: int) -> asyncio.StreamReader:
    reader = asyncio.StreamReader()
    await asyncio.get_running_loop().connect_read_pipe(
        lambda: asyncio.StreamReaderProtocol(reader), os.fdopen(fd, "rb")
    )
    return reader


async def _write_to(process: ForkedProcess) -> asyncio.StreamWriter:
    loop = asyncio.get_running_loop()
    # A writer needs a protocol that tells it when to wait; this one reads nothing.
    transport, protocol = await loop.connect_write_pipe(
        lambda: asyncio.StreamReaderProtocol(asyncio.StreamReader()), process.stdin
    )
    return asyncio.StreamWriter(transport, protocol, None, loop)
