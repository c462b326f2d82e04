"""The HTTP adapter: asks for what the description names, and reads fields of the answers.

Each address is asked for every `poll` seconds, never twice at once, a few at a time. A device of
which nothing is answered is not reached.
"""

from __future__ import annotations

import asyncio
from base64 import b64encode
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

from talaia import __version__
from talaia.gateway.adapters.credentials import read_authorities, read_secret
from talaia.gateway.adapters.http.fetching import FetchFailed, HttpQuestion, HttpServer
from talaia.gateway.adapters.json_signals import JsonSignals
from talaia.gateway.adapters.undriven_adapter import JsonAdapter
from talaia.gateway.adapters.unreadable_reports import UnreadableReports
from talaia.gateway.ports import CommandOutcome
from talaia.model.connection import HttpConnection, HttpSource, source_as
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.ports import AdapterContext, AdapterStatus
    from talaia.model.site import Signal

__all__ = ["HttpAdapter", "server_of"]

# Questions to one server at a time: small devices answer no more.
_AT_ONCE = 4
# Pace at which held-back values are given out.
_TURN_S = 0.1


class HttpAdapter(JsonAdapter):
    """An `Adapter` for a server that is asked; see `talaia.gateway.ports`."""

    def __init__(
        self, scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
    ) -> None:
        """Take what is to be asked; `run` begins.

        Raises:
            SettingsError: a secret or the certificate authorities cannot be read.

        """
        settings = scope.connection
        assert isinstance(settings, HttpConnection)  # noqa: S101 - the catalog has seen to it
        self._poll_s = settings.poll
        self._status = status
        self._clock = context.clock
        self._server = server_of(settings, context.folder)
        unreadable = UnreadableReports(context.events)
        signals = JsonSignals(scope, _place_of, unreadable.report_unreadable)
        super().__init__(signals, context.samples, "http")
        # By what is asked for: what was wrong with the last answer, empty for a good one; none
        # before the first.
        self._wrong: dict[str, str] = {}
        self._slots = asyncio.Semaphore(_AT_ONCE)  # As many questions as there are threads.

    # ── Adapter ──

    async def run(self) -> None:
        """See `Adapter.run`."""
        self._wrong.clear()
        self._status.up()
        threads = ThreadPoolExecutor(_AT_ONCE, "talaia-http")
        tasks = [
            asyncio.ensure_future(self._poll_address(get, threads)) for get in self._signals.keys
        ]
        try:
            while True:
                await asyncio.sleep(_TURN_S)
                # One that failed by a fault of ours must not be silent for ever.
                for task in tasks:
                    if task.done():
                        task.result()
                self._signals.gather_due(self._clock.wall_ns() // 1000)
                self._publish_samples()
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            # Not waited for: those that were under way are cut off.
            threads.shutdown(wait=False, cancel_futures=True)
            self._signals.forget_readings()

    async def _poll_address(self, get: str, threads: ThreadPoolExecutor) -> None:
        loop = asyncio.get_running_loop()
        while True:
            began = loop.time()
            try:
                async with self._slots:
                    data = await HttpQuestion(self._server, get).fetch_in_time(threads)
            except FetchFailed as error:
                self._wrong[get] = str(error)
            else:
                self._read_answer(get, data)
            self._report_devices(get)
            await asyncio.sleep(max(0.0, began + self._poll_s - loop.time()))

    def _read_answer(self, get: str, data: bytes) -> None:
        time_us, mono_ns = self._clock.wall_ns() // 1000, self._clock.monotonic_ns()
        read = self._signals.read_payload(get, data, time_us, mono_ns)
        # A page of HTML, say, that a gateway in between put in its place.
        self._wrong[get] = "" if read else f"nothing of what is asked for is in {data[:60]!r}"
        self._publish_samples()

    def _report_devices(self, get: str) -> None:
        """Say whether the devices of an address answer: one good address of each is enough."""
        for device in self._signals.keys[get]:
            states = [
                self._wrong.get(other)
                for other, devices in self._signals.keys.items()
                if device in devices
            ]
            if "" in states:
                self._status.device(device, there=True)
            # Not while one has yet to answer for the first time: that is no silence.
            elif None not in states:
                self._status.device(device, there=False, why=self._wrong[get][:200])

    def reconnect(self, device: str, done: Callable[[CommandOutcome], None]) -> None:
        """Say how the newest answers were: there is no connection to be made anew."""
        wrong = [
            f"{get}: {self._wrong[get]}"
            for get, devices in self._signals.keys.items()
            if device in devices and self._wrong.get(get)
        ]
        phase = CommandPhase.FAILED if wrong else CommandPhase.SUCCEEDED
        done(CommandOutcome(phase, "; ".join(wrong)[:2000]))


def server_of(settings: HttpConnection, folder: Path) -> HttpServer:
    """Give the server of a connection, with its secrets.

    Raises:
        SettingsError: a secret or the authorities cannot be read.

    """
    token = read_secret("token", folder, file=settings.token_file, variable=settings.token_env)
    password = read_secret("password", folder, file=settings.password_file)
    headers = {"User-Agent": f"talaia/{__version__}", "Accept": "application/json, text/plain"}
    if token:
        headers["Authorization"] = f"Bearer {token}"
    elif password:
        said = b64encode(f"{settings.user}:{password}".encode()).decode()
        headers["Authorization"] = f"Basic {said}"
    secure = settings.url.startswith("https:")
    tls = read_authorities(folder, settings.ca) if secure else None
    return HttpServer(settings.url, headers, tls, settings.timeout, settings.here)


def _place_of(signal: Signal) -> tuple[str, str]:
    source = source_as(signal.source, HttpSource)
    return source.get, source.path
