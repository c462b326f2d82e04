"""The process of one adapter that an extension brings: started by a gateway, for one connection.

``python -m talaia.extensions.adapter_child FD``, where FD is a socket to the gateway. It ends when
the gateway closes that socket.
"""

from __future__ import annotations

import asyncio
import contextlib
import ctypes
import logging
import math
import signal
import socket
import sys
import traceback
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from talaia.extensions.adapter_host import (
    CommandRefused,
    ConnectionLost,
    ExecutionFailed,
    ExtensionCommand,
    WantedSignal,
)
from talaia.extensions.adapter_messages import (
    ActMessage,
    AdapterJob,
    CancelMessage,
    DoneMessage,
    EndMessage,
    ReachableMessage,
    ReportMessage,
    UpMessage,
    ValueMessage,
    read_to_adapter,
    write_message,
)
from talaia.extensions.declarations import ExtensionKeys
from talaia.extensions.installed import installed_extensions
from talaia.model.checks.extension_rules import keys_fit

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.extensions.adapter_host import ExtensionAdapter
    from talaia.extensions.adapter_messages import FromAdapter
    from talaia.extensions.declarations import AdapterExtension
    from talaia.model.checks.identifiers import Finding

__all__ = ["main"]

# Of one line, either way: the job of a large description is one.
MAX_LINE = 16 * 1024 * 1024
# In letters: as many as a `Sentence` of the wire has.
_MAX_SAID = 2000
# As in <linux/prctl.h>.
_PR_SET_PDEATHSIG = 1


class _Host:
    """An `AdapterHost`."""

    def __init__(
        self, job: AdapterJob, declared: AdapterExtension, writer: asyncio.StreamWriter
    ) -> None:
        self.signals = tuple(
            WantedSignal(
                signal.address,
                signal.device,
                signal.type,
                signal.unit,
                signal.states,
                msgspec.convert(signal.keys, declared.source),
            )
            for signal in job.signals
        )
        self.devices = job.devices
        self.folder = Path(job.folder)
        # What may be published: a mistyped address is an error where it is made, in the extension.
        self._known = frozenset(signal.address for signal in job.signals)
        # To the gateway. Never drained: `AdapterHost` promises that `publish` does not block.
        self._writer = writer

    def connected(self) -> None:
        self.send(UpMessage())

    def publish(self, address: str, value: float | str, time_us: int | None = None) -> None:
        if address not in self._known:
            raise KeyError(f"{address} is no signal of this adapter")
        if not isinstance(value, bool | int | str):
            # NumPy's numbers, too.
            value = float(value)
        if isinstance(value, float) and not math.isfinite(value):
            # JSON has no such number.
            value = str(value)
        self.send(ValueMessage(address, value, None if time_us is None else int(time_us)))

    def device_reachable(self, device: str, *, reachable: bool, why: str = "") -> None:
        self.send(ReachableMessage(device, reachable, why[:_MAX_SAID]))

    def report(self, kind: str, message: str) -> None:
        self.send(ReportMessage(kind[:100], message[:_MAX_SAID]))

    def send(self, words: FromAdapter) -> None:
        self._writer.write(write_message(words))


class _Session:
    """Runs an adapter, and does commands beside it."""

    def __init__(self, host: _Host, adapter: ExtensionAdapter, declared: AdapterExtension) -> None:
        self._host, self._adapter, self._declared = host, adapter, declared
        # Commands under way, by the gateway's number; the gateway may cancel one by it.
        self._acts: dict[int, asyncio.Task[None]] = {}

    async def serve_gateway(self, reader: asyncio.StreamReader) -> EndMessage:
        running = asyncio.ensure_future(self._run_adapter())
        hearing = asyncio.ensure_future(self._read_messages(reader))
        try:
            await asyncio.wait([running, hearing], return_when=asyncio.FIRST_COMPLETED)
            # When both end at once, what the adapter says is told.
            return running.result() if running.done() else EndMessage("the gateway has gone away")
        finally:
            # Commands too: nothing of the adapter runs on behind its last word.
            tasks = [running, hearing, *self._acts.values()]
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def _run_adapter(self) -> EndMessage:
        try:
            await self._adapter.run()
        except ConnectionLost as error:
            return EndMessage(str(error)[:_MAX_SAID])
        except Exception as error:  # noqa: BLE001 - whatever it raises, it is named
            return _end_of_broken(error)
        return EndMessage("its run ended by itself", broken=True)

    async def _read_messages(self, reader: asyncio.StreamReader) -> None:
        while line := await reader.readline():
            match read_to_adapter(line):
                case ActMessage() as act:
                    task = self._acts[act.number] = asyncio.ensure_future(self._run_command(act))
                    task.add_done_callback(partial(self._forget_task, act.number))
                case CancelMessage(number=number):
                    # One that has ended meanwhile is not there any more.
                    if number in self._acts:
                        self._acts[number].cancel()
                case AdapterJob():
                    # It comes once, as the first line, and was read before.
                    pass

    def _forget_task(self, number: int, _task: asyncio.Task[None]) -> None:
        self._acts.pop(number, None)

    def _keys_of(self, act: ActMessage) -> ExtensionKeys:
        try:
            # Without commands there are no keys that fit.
            return msgspec.convert(act.keys, self._declared.command or ExtensionKeys)
        # Told apart here, where nothing is begun yet: in `execute` it is the extension's own.
        except msgspec.ValidationError as error:
            raise CommandRefused(str(error)) from error

    async def _run_command(self, act: ActMessage) -> None:
        # What stands if it is cancelled: then only `finally` is passed.
        done = DoneMessage(act.number, "unknown", "it was cancelled; check the device")
        try:
            keys = self._keys_of(act)
            said = await self._adapter.execute(ExtensionCommand(act.device, act.command, keys))
            done = DoneMessage(act.number, "succeeded", str(said or "")[:_MAX_SAID])
        except CommandRefused as error:
            done = DoneMessage(act.number, "refused", str(error)[:_MAX_SAID])
        except ExecutionFailed as error:
            done = DoneMessage(act.number, "failed", str(error)[:_MAX_SAID])
        except Exception as error:  # noqa: BLE001 - whatever it raises, it is named
            traceback.print_exc()
            said = f"the extension failed: {type(error).__name__}: {error}"
            done = DoneMessage(act.number, "unknown", said[:_MAX_SAID])
        finally:
            # In every case: the gateway waits for an answer to this number.
            self._host.send(done)


def main(argv: list[str]) -> None:
    """Speak with the gateway over the socket that ``argv`` names, until it is closed."""
    if sys.platform == "linux":
        # Even one that hangs does not outlive its gateway.
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    # Ctrl-C in a terminal is the gateway's to hear.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    logging.basicConfig(level=logging.INFO, format="%(levelname)s %(name)s: %(message)s")
    with socket.socket(fileno=int(argv[0])) as connection, contextlib.redirect_stdout(sys.stderr):
        asyncio.run(_exchange_messages(connection))


async def _exchange_messages(connection: socket.socket) -> None:
    connection.setblocking(False)  # noqa: FBT003 - as it is there
    reader, writer = await asyncio.open_connection(sock=connection, limit=MAX_LINE)
    first = await reader.readline()
    if not first:
        # The gateway has closed before it said what is to be done.
        return
    job = read_to_adapter(first)
    assert isinstance(job, AdapterJob)  # noqa: S101 - the gateway's promise
    end = await _serve_gateway(job, reader, writer)
    # Whoever would read it may be gone already.
    with contextlib.suppress(OSError):
        writer.write(write_message(end))
        await writer.drain()
        writer.close()
        await writer.wait_closed()


async def _serve_gateway(
    job: AdapterJob, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
) -> EndMessage:
    declared = installed_extensions().adapters_by_name().get(job.extension)
    if declared is None:
        # Why it could not be loaded, if that is the reason.
        said = [
            str(broken_extension)
            for broken_extension in installed_extensions().list_broken()
            if broken_extension.name == job.extension
        ]
        return EndMessage("; ".join(said) or "it is not installed here", broken=True)
    # Checked again: only where it is installed is it known what the extension asks for.
    if findings := [str(finding) for finding in _job_findings(job, declared)]:
        return EndMessage("; ".join(findings)[:_MAX_SAID], broken=True)
    try:
        host = _Host(job, declared, writer)
        adapter = declared.make(msgspec.convert(job.keys, declared.connection), host)
    except Exception as error:  # noqa: BLE001 - whatever it raises, it is named
        return _end_of_broken(error)
    return await _Session(host, adapter, declared).serve_gateway(reader)


def _job_findings(job: AdapterJob, declared: AdapterExtension) -> Iterator[Finding]:
    yield from keys_fit(f"$.connections.{job.connection}.keys", declared.connection, job.keys)
    for wanted in job.signals:
        device, _, signal = wanted.address.partition("/")
        where = f"$.devices.{device}.signals.{signal}.source.keys"
        yield from keys_fit(where, declared.source, wanted.keys)


def _end_of_broken(error: Exception) -> EndMessage:
    traceback.print_exception(error)
    return EndMessage(f"{type(error).__name__}: {error}"[:_MAX_SAID], broken=True)


if __name__ == "__main__":
    main(sys.argv[1:])
