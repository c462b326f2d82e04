"""The bus on NATS: core NATS alone, which keeps nothing."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import ssl
from typing import TYPE_CHECKING

from talaia.hub.cluster.bus import BusLane
from talaia.hub.errors import CannotStart

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from nats.aio.client import Client
    from nats.aio.msg import Msg

__all__ = ["NatsBus"]

_LOG = logging.getLogger(__name__)
# A server that is not there is dialled again after this (s).
_AGAIN_S = 0.25
_CONNECT_S = 2
# A server whose machine is gone is noticed after three of these (s).
_PING_S = 1
# More than this waits for a server that does not read (bytes): then it counts as gone.
_MOST_WAITING = 8 * 1024 * 1024


class NatsBus:
    """See `Bus`. A connection for each lane, so that no picture stands before a STOP."""

    def __init__(self, servers: Sequence[str], *, name: str, ca: Path | None = None) -> None:
        """Dial ``servers`` later; ``ca``: authorities of theirs, none takes the system's.

        Raises:
            CannotStart: the library is missing, or ``ca`` cannot be read.

        """
        try:
            from nats import errors
            from nats.aio.client import Client
        except ImportError as error:
            raise CannotStart(
                "--cluster needs nats-py, which is not installed", "pip install 'talaia[cluster]'"
            ) from error
        self._make_client = Client
        self._failures = (errors.Error, OSError, TimeoutError)
        self._servers = list(servers)
        self._name = name
        self._tls = _tls_context(ca) if _asks_tls(servers) or ca else None
        self._clients: dict[BusLane, Client] = {}
        # Dial for the first time; later the library does so by itself.
        self._dialling: list[asyncio.Task[None]] = []
        self._said_lost = False
        self._closing = False
        # Called when the servers are gone, and when both lanes have one.
        self._lost: Callable[[], None] = lambda: None
        self._returned: Callable[[], None] = lambda: None

    @property
    def connected(self) -> bool:
        """Whether both lanes are there: with one alone, nothing would be whole."""
        return len(self._clients) == len(BusLane) and all(
            client.is_connected for client in self._clients.values()
        )

    async def open(
        self,
        subjects: Mapping[BusLane, tuple[str, ...]],
        receive: Callable[[BusLane, str, bytes], None],
        lost: Callable[[], None],
        returned: Callable[[], None],
    ) -> None:
        """Dial in the background, for as long as it takes."""
        self._lost, self._returned = lost, returned
        self._dialling = [
            asyncio.create_task(self._dial(lane, names, receive), name=f"dial NATS {lane}")
            for lane, names in subjects.items()
        ]

    async def publish(self, lane: BusLane, subject: str, data: bytes) -> None:
        """Send, or raise at once: nothing is kept for a server that comes back."""
        if not self.connected:
            raise ConnectionError("NATS is away")
        try:
            await self._clients[lane].publish(subject, data)
        except self._failures as error:
            raise ConnectionError(f"NATS does not take it: {error}") from error

    async def close(self) -> None:
        """Close both connections."""
        self._closing = True
        for task in self._dialling:
            task.cancel()
        await asyncio.gather(*self._dialling, return_exceptions=True)
        for client in self._clients.values():
            with contextlib.suppress(*self._failures):
                async with asyncio.timeout(1.0):
                    await client.close()

    async def _dial(
        self,
        lane: BusLane,
        subjects: tuple[str, ...],
        receive: Callable[[BusLane, str, bytes], None],
    ) -> None:
        async def report_loss() -> None:
            if not self._said_lost and not self._closing:
                _LOG.warning("NATS is lost; hubs do not hear each other")
            self._said_lost = True
            self._lost()

        async def report_return() -> None:
            if not self.connected:
                return
            if self._said_lost:
                _LOG.warning("NATS is there again")
                self._said_lost = False
            self._returned()

        async def report_failure(error: Exception) -> None:
            # The library dials on by itself; said once.
            if lane not in self._clients and not self._said_lost:
                _LOG.warning("NATS cannot be reached: %s; trying again", error)
                self._said_lost = True
            # A subscriber that is too slow has lost some: its tunnels see the hole.
            _LOG.debug("NATS: %s", error)

        async def hear_message(message: Msg) -> None:
            receive(lane, message.subject, message.data)

        while True:
            client = self._make_client()
            try:
                await client.connect(
                    servers=self._servers,
                    name=f"{self._name} {lane.name.lower()}",
                    connect_timeout=_CONNECT_S,
                    # It sleeps for so long; parts of a second are well.
                    reconnect_time_wait=_AGAIN_S,  # type: ignore[arg-type]
                    max_reconnect_attempts=-1,
                    ping_interval=_PING_S,
                    pending_size=_MOST_WAITING,
                    allow_reconnect=True,
                    disconnected_cb=report_loss,
                    reconnected_cb=report_return,
                    error_cb=report_failure,
                    tls=self._tls,
                )
                for subject in subjects:
                    await client.subscribe(subject, cb=hear_message)
            except self._failures as error:
                await report_failure(error)
                with contextlib.suppress(*self._failures):
                    await client.close()
                await asyncio.sleep(_AGAIN_S)
                continue
            self._clients[lane] = client
            await report_return()
            return


def _asks_tls(servers: Sequence[str]) -> bool:
    return any(server.startswith("tls://") for server in servers)


def _tls_context(ca: Path | None) -> ssl.SSLContext:
    try:
        return ssl.create_default_context(cafile=str(ca) if ca else None)
    except OSError as error:
        raise CannotStart(
            f"--cluster-ca {ca} cannot be read: {error}", "name a file of authorities (PEM)"
        ) from error
