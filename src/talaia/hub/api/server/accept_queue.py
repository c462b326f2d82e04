"""Connections are taken in as the loop has time for them.

After a hub was away, everybody dials within seconds, and a TLS handshake takes the loop's time in
one piece. Whoever is connected already, and may be driving, goes before those who come: a few
connections are taken in at a time, and the next ones only when the loop is in time again. The rest
wait in the kernel's queue, where they cost nothing; those who say nothing are bounded
(`silent_connections`).
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from typing import TYPE_CHECKING

from talaia.hub.api.server.proxy_protocol import (
    Balancers,
    KnowsAsker,
    NoProxyHeader,
    receive_asker,
)
from talaia.hub.api.server.silent_connections import SilentConnections, Speaks

if TYPE_CHECKING:
    import socket
    import ssl
    from collections.abc import Callable

    from talaia.hub.api.server.proxy_protocol import Asker
    from talaia.hub.api.server.silent_connections import Arrival

__all__ = ["AcceptQueue"]

_LOG = logging.getLogger(__name__)
QUEUE = 1024  # in the kernel, which may cap it (net.core.somaxconn)
# Who is slower holds a socket and does nothing (s).
_HANDSHAKE_S = 15.0
# A balancer says who comes as soon as it has connected; what it waits for takes no place (s).
_HEADER_S = 5.0
# Taken in before the loop is looked at: their handshakes come one after the other in its turn.
_AT_ONCE = 4
# Then; if this takes longer than that for the loop, the next ones wait as long as that.
_PAUSE_S = 0.002
_LONGEST_PAUSE_S = 0.05
# When the system has no room for one more connection.
_FULL_S = 0.2


class AcceptQueue:
    """Accepts connections of one listening socket until it is closed."""

    def __init__(
        self,
        listener: socket.socket,
        protocol: Callable[[], asyncio.Protocol],
        tls: ssl.SSLContext | None,
        silent: SilentConnections | None = None,
        *,
        balancers: Balancers | None = None,
    ) -> None:
        """Make a ``protocol`` for each connection, over ``tls`` if there is any.

        ``silent`` counts those of each address that say nothing; ``balancers`` say first from
        where a connection comes.
        """
        self._balancers = Balancers() if balancers is None else balancers
        self._silent = SilentConnections() if silent is None else silent
        self._listener = listener
        self._protocol = protocol
        self._tls = tls
        # Shaking hands now. Kept, since the loop holds tasks only weakly, and ended by `close`.
        self._arriving: set[asyncio.Task[None] | asyncio.Task[bool]] = set()
        # The balancer's last connection did not begin as it must.
        self._misheard = False
        # Takes connections in, from `open` to `close`.
        self._task: asyncio.Task[None] | None = None

    def open(self) -> None:
        """Listen."""
        # Not blocking, as `sock_accept` needs it.
        self._listener.settimeout(0)
        self._listener.listen(QUEUE)
        self._task = asyncio.create_task(self._accept_loop())

    async def close(self) -> None:
        """Take nobody in any more; who was just arriving is turned away."""
        if self._task is not None:
            ending = [self._task, *self._arriving]
            for task in ending:
                task.cancel()
            await asyncio.gather(*ending, return_exceptions=True)

    async def _accept_loop(self) -> None:
        loop = asyncio.get_running_loop()
        # Whether it was said already: one line when it begins, one when it is over.
        full, taken = False, 0
        while True:
            try:
                await self._wait_for_arrival()
                # At once: `loop.sock_accept` that is cancelled as somebody comes loses the
                # connection, open, and whoever dialled waits for an answer until it gives up.
                connection, peer = self._listener.accept()
            except (ConnectionError, BlockingIOError):
                continue  # it has gone again
            except OSError as error:
                # No descriptors are left, or no memory. The connection still waits in the queue,
                # so without a pause this would spin.
                if not full:
                    _LOG.error("no more connections can be taken in for now: %s", error)
                full = True
                await asyncio.sleep(_FULL_S)
                continue
            if full:
                _LOG.warning("connections are taken in again")
            full = False
            # Not blocking, as the loop needs it.
            connection.settimeout(0)
            if self._balancers.is_listed(peer[0]):
                self._hear_balancer(connection, peer[0])
            else:
                self._count_arrival(connection, peer[0])
            taken += 1
            if taken < _AT_ONCE:
                continue
            taken = 0
            # How late this task is woken tells how long everybody else waits for the loop.
            due = loop.time() + _PAUSE_S
            await asyncio.sleep(_PAUSE_S)
            late = loop.time() - due
            if late > _PAUSE_S:
                await asyncio.sleep(min(late, _LONGEST_PAUSE_S))

    async def _wait_for_arrival(self) -> None:
        """Wait until somebody stands in the kernel's queue."""
        loop = asyncio.get_running_loop()
        arrived = asyncio.Event()
        loop.add_reader(self._listener, arrived.set)
        try:
            await arrived.wait()
        finally:
            loop.remove_reader(self._listener)

    def _hear_balancer(self, connection: socket.socket, address: str) -> None:
        """Hear who comes, and take that one in."""
        task = asyncio.create_task(self._ask_balancer(connection, address))
        self._arriving.add(task)

        def end_asking(_: object) -> None:
            self._arriving.discard(task)
            # Cancelled, or nothing of use was said: nobody has it.
            if task.cancelled() or not task.result():
                connection.close()

        task.add_done_callback(end_asking)

    async def _ask_balancer(self, connection: socket.socket, address: str) -> bool:
        loop = asyncio.get_running_loop()
        try:
            async with asyncio.timeout(_HEADER_S):
                asker = await receive_asker(loop, connection)
        except NoProxyHeader as error:
            # Its health checks come twice a second: said once, until it does better.
            if not self._misheard:
                _LOG.warning("connections from %s are closed: %s", address, error)
            self._misheard = True
            return False
        except (OSError, TimeoutError):
            return False
        self._misheard = False
        self._count_arrival(connection, address if asker is None else asker[0], asker)
        return True

    def _count_arrival(
        self, connection: socket.socket, address: str, asker: Asker | None = None
    ) -> None:
        arrival = self._silent.add_arrival(address, asyncio.get_running_loop().time())
        if arrival is None:
            connection.close()
        else:
            self._take_in(connection, arrival, asker)

    def _take_in(self, connection: socket.socket, arrival: Arrival, asker: Asker | None) -> None:
        shaking = self._shake_hands(connection, arrival, asker)
        task = arrival.task = asyncio.create_task(shaking)
        self._arriving.add(task)

        def end_arrival(_: object) -> None:
            self._arriving.discard(task)
            # Not in the task itself: one that is cancelled before it began runs no line.
            if arrival.transport is None:
                connection.close()

        task.add_done_callback(end_arrival)

    async def _shake_hands(
        self, connection: socket.socket, arrival: Arrival, asker: Asker | None
    ) -> None:
        """Shake hands; what fails there is the other side's matter."""

        def make_protocol() -> asyncio.Protocol:
            protocol = self._protocol()
            # Before anything comes: requests are counted by it.
            if asker is not None and isinstance(protocol, KnowsAsker):
                protocol.asker = asker
            return protocol

        with contextlib.suppress(OSError, TimeoutError):
            loop = asyncio.get_running_loop()
            arrival.transport, protocol = await loop.connect_accepted_socket(
                make_protocol,
                connection,
                ssl=self._tls,
                ssl_handshake_timeout=_HANDSHAKE_S if self._tls is not None else None,
            )
            arrival.protocol = protocol if isinstance(protocol, Speaks) else None
