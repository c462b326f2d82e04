"""A connection to a broker that is kept up: an account's, begun again, its troubles said once."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, NamedTuple

import aiomqtt

from talaia.first_completed import until_first
from talaia.hub.auth.rate_limiter import RateLimiter
from talaia.hub.clients.catalog import MQTT
from talaia.hub.clients.mqtt.broker_settings import read_secret
from talaia.hub.errors import StoreDown

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Collection

    from talaia.clock import Clock
    from talaia.hub.auth.permissions import Who
    from talaia.hub.clients.client_connection import ClientConnections
    from talaia.hub.clients.mqtt.asked_commands import InboundMessage, RefusedMessage
    from talaia.hub.clients.mqtt.broker_presence import BrokerPresence
    from talaia.hub.clients.mqtt.broker_settings import BrokerSettings
    from talaia.hub.clients.open_protocols import OpenProtocols
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.store.audit import Audit

__all__ = ["FAREWELL_S", "BridgeParts", "BrokerKeeper"]

_LOG = logging.getLogger(__name__)
# Between two tries to connect (s): first, and at the most.
_FIRST_WAIT_S, _MOST_WAIT_S = 0.5, 30.0
# Of a farewell to a broker that does not read (s).
FAREWELL_S = 3.0
# Commands at once, and for long (1/s).
_BURST, _PER_S = 20, 5.0
# Topics of which it was said that a retained message was refused.
_MOST_TOLD = 1000


class BridgeParts(NamedTuple):
    """What of the hub a bridge uses.

    Attributes:
        has_site: tells whether a site is published here, where several hubs have some each.
        who_of_token: tells whose a token is; raises `StoreDown`.

    """

    connections: ClientConnections
    protocols: OpenProtocols
    presence: BrokerPresence
    sites: Sites
    has_site: Callable[[str], bool]
    audit: Audit
    clock: Clock
    who_of_token: Callable[[str], Awaitable[Who | None]]


class BrokerKeeper:
    """Connects for as long as an admin lets it, and says who may publish.

    Attributes:
        ending: it is to end.

    """

    def __init__(
        self, settings: BrokerSettings, parts: BridgeParts, *, via: str, check_s: float
    ) -> None:
        """Keep the broker of ``settings``.

        Args:
            settings: of the broker.
            parts: of the hub.
            via: what the connection is called beside the broker's address.
            check_s: it is looked so often whether the token is good and the protocol open.

        """
        self.ending = asyncio.Event()
        self.name = f"{via} {settings.broker}"
        self._settings = settings
        self._parts = parts
        self._check_s = check_s
        self._broker = str(settings.broker)
        self._limits = RateLimiter(_BURST, _PER_S)
        self._told_retained: set[str] = set()
        # What it was said of that it is in trouble: ``broker``, ``token``, ``flood``.
        self._troubles: set[str] = set()

    # ── connecting ──

    async def keep_connected(
        self,
        *,
        connect: Callable[[], aiomqtt.Client],
        serve: Callable[[aiomqtt.Client], Awaitable[None]],
        has_duties: Callable[[], bool],
    ) -> None:
        """Connect and serve, again and again, until `stop` was called.

        Args:
            connect: makes a client; entering it connects.
            serve: returns when nothing is to be done any more.
            has_duties: tells whether to connect although nobody may publish.

        """
        work = self._keep_connected(connect, serve, has_duties)
        for result in await until_first(work, self._end_late()):
            if isinstance(result, Exception):
                raise result

    async def _keep_connected(
        self,
        connect: Callable[[], aiomqtt.Client],
        serve: Callable[[aiomqtt.Client], Awaitable[None]],
        has_duties: Callable[[], bool],
    ) -> None:
        wait_s = _FIRST_WAIT_S
        while not self.ending.is_set():
            try:
                if await self.find_account() is None and not has_duties():
                    self._parts.presence.report_left(self._now_us())
                    await self.pause(self._check_s)
                    continue
                async with connect() as client:
                    wait_s = _FIRST_WAIT_S
                    self._parts.presence.report_connected(self._now_us())
                    self._end_trouble("broker", f"the broker {self._broker} is connected again")
                    await serve(client)
                self._parts.presence.report_left(self._now_us())
                await self.pause(self._check_s)
            except StoreDown:
                # Who may do what will be known again; until then all stays as it is.
                await self.pause(self._check_s)
            except (aiomqtt.MqttError, OSError, ValueError) as error:
                self._parts.presence.report_lost(self._now_us(), str(error))
                self._begin_trouble("broker", f"the broker {self._broker} is not reached: {error}")
                await self.pause(wait_s)
                wait_s = min(2 * wait_s, _MOST_WAIT_S)

    async def _end_late(self) -> None:
        """Return when the bridge was to end and has not: its broker may not answer."""
        await self.ending.wait()
        await asyncio.sleep(FAREWELL_S + 1)

    async def pause(self, wait_s: float) -> None:
        """Wait, unless it ends before."""
        try:
            async with asyncio.timeout(wait_s):
                await self.ending.wait()
        except TimeoutError:
            return

    async def wait_turn(self) -> None:
        """Wait until the account and the sites should be looked at again."""
        await self.pause(self._check_s)

    # ── who, and what ──

    async def find_account(self) -> Who | None:
        """Give the account by whose rights all is done now; None: nothing is to be published.

        Raises:
            StoreDown: it cannot be told now.

        """
        if not self._parts.protocols.is_open(MQTT):
            return None
        name = self._settings.token_file
        try:
            who = await self._parts.who_of_token(await asyncio.to_thread(read_secret, name))
        except OSError as error:
            self._begin_trouble("token", f"the token in {name} cannot be read: {error.strerror}")
            return None
        if who is None:
            self._begin_trouble("token", f"the token in {name} is not good; see Account, Tokens")
        else:
            self._end_trouble("token", f"the token in {name} is good again")
        return who

    def find_sites(self) -> list[LiveSite]:
        """Give the sites that are there and named in the settings."""
        return [live for live in self._parts.sites if live.name in self._settings.sites]

    async def watch_sites(self, names: Collection[str]) -> None:
        """Return when there are other sites than these."""
        while True:
            await asyncio.sleep(self._check_s)
            if {live.name for live in self.find_sites()} != names:
                return

    # ── commands ──

    def is_too_much(self) -> bool:
        """Count a command; tell whether it is one too many, and left out."""
        wait_ns = self._limits.request_turn("commands", self._parts.clock.monotonic_ns())
        if not wait_ns:
            self._end_trouble("flood", "commands by MQTT are heard again")
            return False
        self._begin_trouble("flood", f"more than {_PER_S:g} commands a second by MQTT are left out")
        return True

    def report_refused(self, message: InboundMessage, refused: RefusedMessage) -> None:
        """Write down that something was refused; of what is repeated for ever, once."""
        if refused.quiet:
            if message.topic in self._told_retained or len(self._told_retained) >= _MOST_TOLD:
                return
            self._told_retained.add(message.topic)
            _LOG.warning("refused on %r: %s", message.topic, refused.why)
        self._parts.audit.append_record(
            "mqtt command refused",
            who=self.name,
            site=message.asked.site,
            device=message.asked.device,
            message=f"{message.topic}: {refused.why}",
            good=False,
        )

    # ── troubles ──

    def report_refusal(self, text: str) -> None:
        """Say once on a connection what the broker does not let the hub do."""
        if self._parts.presence.report_refusal(text):
            _LOG.warning("the broker %s refuses: %s", self._broker, text)

    def _begin_trouble(self, kind: str, text: str) -> None:
        """Say once what is wrong, until it ends."""
        if kind not in self._troubles:
            self._troubles.add(kind)
            _LOG.warning("%s", text)

    def _end_trouble(self, kind: str, text: str) -> None:
        if kind in self._troubles:
            self._troubles.discard(kind)
            _LOG.info("%s", text)

    def _now_us(self) -> int:
        return self._parts.clock.wall_ns() // 1000
