"""The hub as a process: open the door, serve until told to stop.

Long, because start and end of the server are read together.
"""

from __future__ import annotations

import asyncio
import contextlib
import datetime as dt
import faulthandler
import logging
import os
import signal
import socket
import sys
from typing import TYPE_CHECKING, Protocol

import uvicorn

from talaia.clock import SystemClock
from talaia.hub.accounts import make_data_folder
from talaia.hub.api.server.accept_queue import QUEUE, AcceptQueue
from talaia.hub.api.server.dead_peers import drop_dead_peers
from talaia.hub.api.server.http_limits import HubProtocol
from talaia.hub.api.server.large_messages import HubSocketProtocol
from talaia.hub.api.server.proxy_protocol import Balancers
from talaia.hub.api.server.silent_connections import SilentConnections, defer_silent
from talaia.hub.app import build_hub
from talaia.hub.auth.tokens import mask_tokens
from talaia.hub.certificate import (
    certificate_fingerprint,
    certificate_of,
    fresh_certificate,
    own_certificate,
)
from talaia.hub.errors import CannotStart, HubError
from talaia.hub.live.gc_schedule import collect_at_rest
from talaia.hub.lock import HubRuns, hub_lock
from talaia.hub.settings import is_loopback
from talaia.hub.store.backup import take_restored
from talaia.hub.store.database_url import parse_database_url
from talaia.hub.store.lead.only_hub import hold_only_hub
from talaia.hub.store.quarantine import set_aside_if_damaged
from talaia.log_setup import set_up_log
from talaia.process_tuning.allocator import keep_little_free_memory
from talaia.process_tuning.event_loop import new_event_loop
from talaia.process_tuning.time_slice import shorten_time_slice
from talaia.resource_usage import report_usage_on_signal
from talaia.service_manager import own_service_manager
from talaia.wire.frames import MAX_PICTURE

if TYPE_CHECKING:
    import ssl
    from collections.abc import Awaitable, Callable, Iterator, Sequence

    from starlette.types import ASGIApp

    from talaia.clock import Clock
    from talaia.hub.settings import Network, Settings
    from talaia.service_manager import ServiceManager

__all__ = ["HubServer", "renew_certificate", "serve_hub", "server_of"]

_LOG = logging.getLogger(__name__)
# Between two looks at the certificate (s); it is due 30 days before its end.
_RENEW_S = 3600.0


class Superseded(HubError):
    """Another hub leads now; this process is to begin anew."""


class ServedHub(Protocol):
    """What a process asks of a hub, whether it is alone or one of several."""

    @property
    def settings(self) -> Settings:
        """All that was chosen for it."""
        ...

    @property
    def asgi(self) -> ASGIApp:
        """What is served."""
        ...

    @property
    def judging(self) -> bool:
        """Whether alarms are being judged, where that is this hub's to do."""
        ...

    @property
    def setup_token(self) -> str | None:
        """What opens the set-up page, while there is nobody yet."""
        ...

    def is_driven(self) -> bool:
        """Tell whether somebody has control of a device."""
        ...

    def cached_bytes(self) -> int:
        """Give the memory of what may be asked for again (bytes)."""
        ...

    async def hand_over(self) -> None:
        """Send those who are in to other hubs, where there are others."""
        ...


class HubServer(uvicorn.Server):
    """uvicorn, which leaves signals and accepting to us and says when it is ready."""

    def __init__(
        self,
        config: uvicorn.Config,
        on_ready: Callable[[], None],
        proxies: Sequence[Network] = (),
        *,
        balancers: Sequence[Network] = (),
        hand_over: Callable[[], Awaitable[None]] | None = None,
    ) -> None:
        """Serve.

        Args:
            config: uvicorn's own.
            on_ready: called once requests are taken.
            proxies: behind each of them there are many.
            balancers: they say first who comes.
            hand_over: sends those who are in to other hubs, before all are let go.

        """
        super().__init__(config)
        self._balancers = Balancers(balancers)
        self._hand_over = hand_over
        # Counted over all listening sockets.
        self._silent = SilentConnections(proxies)
        # Called once, when the doors are open: whoever started the hub may rely on it then.
        self._on_ready = on_ready
        # One for each listening socket; they are closed before uvicorn's own end.
        self._doorways: list[AcceptQueue] = []

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Leave them: `main` ends the server cleanly, and with its own exit status."""
        yield

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start, open the doors, and say so."""
        # Without sockets uvicorn only runs the lifespan: accepting is the doorways' matter.
        await super().startup(sockets=[])
        # The lifespan has failed, and has logged why.
        if not self.started:
            return
        for listener in sockets or ():
            doorway = AcceptQueue(
                listener,
                self._make_protocol,
                self.config.ssl,
                self._silent,
                balancers=self._balancers,
            )
            doorway.open()
            self._doorways.append(doorway)
        self._on_ready()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Close the doors, then let go of who is in."""
        # First, so that nobody comes in while the others are being let go.
        for doorway in self._doorways:
            await doorway.close()
        # What dials from now on is refused, and goes to another hub.
        for listener in sockets or ():
            listener.close()
        if self._hand_over is not None:
            await self._hand_over()
        await super().shutdown(sockets)

    def _make_protocol(self) -> asyncio.Protocol:
        # As uvicorn's own startup makes them, for each connection.
        protocol: asyncio.Protocol = self.config.http_protocol_class(  # type: ignore[call-arg]
            config=self.config, server_state=self.server_state, app_state=self.lifespan.state
        )
        return protocol


def server_of(hub: ServedHub, on_ready: Callable[[], None] = lambda: None) -> HubServer:
    """Make the server of a hub; run it with ``serve(sockets=[…])``."""
    settings = hub.settings
    # Made at the first start, so that the hub answers over TLS without any set-up.
    tls = None if settings.plain else own_certificate(settings, _utc_now())
    config = uvicorn.Config(
        hub.asgi,
        ws=HubSocketProtocol,
        http=HubProtocol,
        # The loop is made in `main`.
        loop="none",
        # Not "auto": a hub that cannot open must end instead of serving without its lifespan.
        lifespan="on",
        # Compressing each frame would take the loop's time, and pictures are packed already.
        ws_per_message_deflate=False,
        # Links and pages have beats of their own, at the pace of the settings.
        ws_ping_interval=None,
        # The largest message is a picture with what is said of it.
        ws_max_size=MAX_PICTURE + 65_536,
        ssl_certfile=tls.cert if tls else None,
        ssl_keyfile=tls.key if tls else None,
        # `Proxies` reads them, and only from peers that the settings list.
        proxy_headers=False,
        server_header=False,
        access_log=False,
        # `main` has set logging up; uvicorn would put its own in its place.
        log_config=None,
        log_level="warning",
        # Pages and gateways dial again by themselves: nobody gains by a longer farewell (s).
        timeout_graceful_shutdown=1,
        timeout_keep_alive=30,
    )
    return HubServer(
        config,
        on_ready,
        settings.proxies,
        balancers=settings.balancers,
        hand_over=hub.hand_over,
    )


def serve_hub(settings: Settings, log_level: str = "info", log_format: str = "auto") -> int:
    """Serve until SIGTERM or SIGINT; 0 after a clean end, 2 when it cannot start."""
    # Says where each thread stood when a service manager ends a process that stands still.
    faulthandler.enable()
    # No API token gets into the log, whoever logs it: tools bring theirs in the address.
    set_up_log(log_level, log_format, mask_tokens, program="hub")
    logging.getLogger("alembic").setLevel(logging.WARNING)
    # Whatever it makes in its folders, now or later, is its own user's alone.
    os.umask(0o077)
    # A thread that reads a description or writes the history may hold the interpreter this long
    # before a driving frame gets it; Python's own 5 ms would be more than the whole way down.
    sys.setswitchinterval(0.0005)
    # The event loop is in this thread: each driving frame wakes it.
    shorten_time_slice()
    # Before any thread is started: the allocator makes its arenas with them.
    keep_little_free_memory()
    try:
        with asyncio.Runner(loop_factory=new_event_loop) as runner:
            runner.run(_serve_hub(settings))
    except Superseded:
        # All of it anew: what is in memory is of the past, and threads of it may be stuck.
        words = [sys.executable, "-m", "talaia", *sys.argv[1:]]
        os.execv(sys.executable, words)  # noqa: S606 - ourselves
    except HubError as error:
        # A sentence with what to do, and no traceback: it is nothing that went wrong in the hub.
        sys.stderr.write(f"talaia hub: {error}\n")
        return 2
    return 0


async def _serve_hub(settings: Settings) -> None:
    # Said here: SQLite would only say that it is unable to open the file.
    make_data_folder(settings)
    if not os.access(settings.data, os.W_OK | os.X_OK):
        raise CannotStart(
            f"the data folder {settings.data} cannot be written", "choose another with --data"
        )
    if settings.files:
        # Here and not when it leads: a hub takes over from another one though the store is away.
        from talaia.hub.files.bucket_check import check_files

        await check_files(settings)
    # Two hubs on one folder would both write the history.
    clock = SystemClock()
    if settings.cluster:
        await _serve_among_others(settings, clock)
        return
    with hub_lock(settings.data):
        # Before the look for damage: what is looked at must be what the hub then opens.
        take_restored(settings.data, clock)
        set_aside_if_damaged(settings.url, clock)
        await _serve_alone(settings, clock)


async def _serve_among_others(settings: Settings, clock: Clock) -> None:
    """Serve as one of several hubs; which of them leads, the database says."""
    # Only here: a hub that is alone imports nothing of it.
    from talaia.hub.cluster_run import ClusterHub

    # Of a folder that a running hub has, too, nothing is moved.
    with contextlib.suppress(HubRuns), hub_lock(settings.data):
        take_restored(settings.data, clock)
    hub = ClusterHub(settings, clock)
    await _serve_until_told(hub, hub.ended)
    if hub.failure is not None:
        raise hub.failure
    if hub.ended.is_set():
        raise Superseded("another hub leads now")


async def _serve_alone(settings: Settings, clock: Clock) -> None:
    """Serve as the only hub of a database; a file is kept by the data folder's lock already."""
    if not parse_database_url(settings.url).dialect.is_server:
        await _serve_until_told(build_hub(settings, clock))
        return
    hub, lost = build_hub(settings, clock), asyncio.Event()
    loop = asyncio.get_running_loop()

    def tell_lost() -> None:
        loop.call_soon_threadsafe(lost.set)

    async with hold_only_hub(settings.url, tell_lost):
        await _serve_until_told(hub, lost)
    if lost.is_set():
        raise CannotStart(
            "another hub uses this database", "start both with --cluster to make them one"
        )


async def _serve_until_told(hub: ServedHub, ended: asyncio.Event | None = None) -> None:
    settings = hub.settings
    # A port that is taken is told now, before the database is opened and migrated.
    with _listen_socket(settings) as listener:
        port = listener.getsockname()[1]
        manager = own_service_manager()
        server = server_of(hub, lambda: _announce_hub(hub, port, manager))
        loop = asyncio.get_running_loop()
        for number in (signal.SIGINT, signal.SIGTERM):
            # By the loop, between two callbacks; Python's own handlers run within any line.
            loop.add_signal_handler(number, _stop, server)
        report_usage_on_signal(loop, hub.cached_bytes)
        # They end with the server; none of them holds anything that must be written.
        beside = [
            asyncio.create_task(keep_certificate(server, settings)),
            asyncio.create_task(collect_at_rest(hub.is_driven)),
            asyncio.create_task(keep_service_manager(hub, manager)),
        ]
        if ended is not None:
            beside.append(asyncio.create_task(_stop_when(ended, server)))
        try:
            await server.serve(sockets=[listener])
        finally:
            manager.report_stopping()
            for task in beside:
                task.cancel()
        # uvicorn returns like after any end; it is told apart here by the exit status.
        if not server.started:
            raise CannotStart("the hub did not start", "its log above says why")


async def _stop_when(ended: asyncio.Event, server: HubServer) -> None:
    await ended.wait()
    server.should_exit = True


async def keep_service_manager(hub: ServedHub, manager: ServiceManager) -> None:
    """Feed the service manager's watchdog for as long as alarms are being judged."""
    # Several times in each period, so that one late turn of the loop ends nothing.
    while manager.watchdog_s:
        await asyncio.sleep(min(1.0, manager.watchdog_s / 4))
        # A loop that turns while alarms stand still is not well: then it is started anew.
        if hub.judging:
            manager.feed_watchdog()


async def keep_certificate(server: HubServer, settings: Settings) -> None:
    """Look for a renewed certificate every hour, for as long as the hub runs."""
    if settings.plain:
        return
    shown = certificate_fingerprint(certificate_of(settings).cert)
    while True:
        await asyncio.sleep(_RENEW_S)
        if server.config.ssl is not None:
            shown = await renew_certificate(server.config.ssl, settings, shown)


async def renew_certificate(context: ssl.SSLContext, settings: Settings, shown: str) -> str:
    """Show a renewed certificate to whoever connects from now on; give its fingerprint.

    The one of before (``shown``) stays where the new one cannot be used.
    """
    try:
        found = await asyncio.to_thread(fresh_certificate, settings, _utc_now(), shown)
        if found is None:
            return shown
        # Connections that are open keep what they shook hands with.
        context.load_cert_chain(found.cert, found.key)
        shown = certificate_fingerprint(found.cert)
    except (CannotStart, OSError) as error:
        # A renewal that failed must not end a hub that works; it is tried again in an hour.
        _LOG.warning("the certificate of before stays: %s", error)
    else:
        _LOG.info("a renewed certificate is shown from now on: %s (SHA-256)", shown)
    return shown


def _stop(server: HubServer) -> None:
    server.should_exit = True


def _listen_socket(settings: Settings) -> socket.socket:
    # Only an IPv6 address has colons; a name is taken as IPv4.
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    try:
        listener = socket.create_server(
            (settings.host, settings.port), family=family, backlog=QUEUE
        )
    except (OSError, OverflowError) as error:
        # OverflowError: a port above 65535.
        reason = getattr(error, "strerror", None) or str(error)
        raise CannotStart(
            f"cannot listen on {settings.host}:{settings.port}: {reason}",
            "choose another with --port or --host",
        ) from error
    drop_dead_peers(listener)
    defer_silent(listener)
    return listener


def _announce_hub(hub: ServedHub, port: int, manager: ServiceManager) -> None:
    settings = hub.settings
    host = "localhost" if is_loopback(settings.host) else settings.host
    address = f"{'http' if settings.plain else 'https'}://{host}:{port}"
    lines = [f"talaia hub is ready: {address}"]
    if not settings.plain:
        cert = own_certificate(settings, _utc_now()).cert
        lines.append(f"certificate: {certificate_fingerprint(cert)} (SHA-256)")
    if hub.setup_token:
        lines.append(
            # After the #, which browsers do not send: so the token is in no proxy's log.
            f"set up the first admin within a day: {address}/setup#{hub.setup_token}"
        )
    sys.stdout.write("\n".join(lines) + "\n")
    # Whoever reads this through a pipe waits for these lines.
    sys.stdout.flush()
    # After the doors have opened; units that follow this one may connect now.
    manager.report_ready()


def _utc_now() -> dt.datetime:
    return dt.datetime.now(dt.UTC)
