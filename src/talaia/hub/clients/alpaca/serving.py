"""Keeps the Alpaca server up while an admin has opened it and its account's token is good."""

from __future__ import annotations

import asyncio
import contextlib
import ipaddress
import logging
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.clients.alpaca.application import AlpacaApplication, AlpacaParts
from talaia.hub.clients.alpaca.command_call import call_command
from talaia.hub.clients.alpaca.device_answers import INVALID_OPERATION, DeviceError
from talaia.hub.clients.alpaca.listener import DISCOVERY_PORT, answer_discovery, serve_alpaca
from talaia.hub.clients.alpaca.site_values import SiteValues
from talaia.hub.clients.catalog import ALPACA
from talaia.hub.clients.mqtt.broker_settings import read_secret
from talaia.hub.errors import StoreDown
from talaia.hub.policy import AccessNeed, allows

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Collection

    from talaia.clock import Clock
    from talaia.hub.auth.permissions import Who
    from talaia.hub.clients.alpaca.device_answers import DomeCommand
    from talaia.hub.clients.alpaca.served_settings import AlpacaServing
    from talaia.hub.clients.client_connection import ClientConnections
    from talaia.hub.clients.mqtt.broker_presence import BrokerPresence
    from talaia.hub.clients.open_protocols import OpenProtocols
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.store.audit import Audit

__all__ = ["AlpacaService", "ServiceParts"]

_LOG = logging.getLogger(__name__)
# Between two tries to have the port (s).
_AGAIN_S = 5.0
# Commands under way at once.
_MOST_CALLS = 10


class ServiceParts(NamedTuple):
    """What of the hub is used.

    Attributes:
        who_of_token: tells whose a token is; raises `StoreDown`.
        is_here: tells whether the site is served by this hub, where several have some each.
        hosts: names by which the hub is reached.

    """

    connections: ClientConnections
    protocols: OpenProtocols
    presence: BrokerPresence
    sites: Sites
    audit: Audit
    clock: Clock
    who_of_token: Callable[[str], Awaitable[Who | None]]
    is_here: Callable[[], bool]
    hosts: Collection[str]


class AlpacaService:
    """The server of one file; `run` until cancelled.

    Attributes:
        port: at which it answers now; 0 while it does not.

    """

    def __init__(
        self,
        settings: AlpacaServing,
        parts: ServiceParts,
        *,
        check_s: float,
        discovery_port: int = DISCOVERY_PORT,
    ) -> None:
        """Serve by ``settings``; ``check_s``: it is looked so often whether it still may."""
        self._settings, self._parts, self._check_s = settings, parts, check_s
        self._discovery_port = discovery_port
        self._who: Who | None = None  # By whose rights all is done now.
        self._calls = 0
        self._told = ""  # The trouble that was said last.
        self.port = 0

    async def run(self) -> None:
        """Serve whenever it may be."""
        while True:
            await self._look_up_account()
            if self._who is None:
                self._parts.presence.report_left(self._now_us())
                await asyncio.sleep(self._check_s)
                continue
            try:
                await self._serve_while_open()
            except OSError as error:
                where = f"{self._settings.address}:{self._settings.port}"
                why = f"{where} cannot be had: {error.strerror or error}"
                self._parts.presence.report_lost(self._now_us(), why)
                self._report_trouble(f"the Alpaca server at {why}")
                await asyncio.sleep(_AGAIN_S)

    async def _serve_while_open(self) -> None:
        settings = self._settings
        application = AlpacaApplication(
            AlpacaParts(
                values=self._values,
                permits=lambda device, command: settings.has_command(f"{device}/{command}"),
                call=self._call,
                refuse=self._report_refused,
                hosts={settings.address.lower(), *self._parts.hosts},
            )
        )
        async with contextlib.AsyncExitStack() as stack:
            port = await stack.enter_async_context(
                serve_alpaca(application, settings.address, settings.port)
            )
            # ASCOM's discovery over IPv6 is another one, which is not done.
            if settings.discovery and ipaddress.ip_address(settings.address).version == 4:
                await self._open_discovery(stack, port)
            self.port = port
            self._report_trouble("")
            self._parts.presence.report_connected(self._now_us())
            try:
                while self._who is not None:
                    await asyncio.sleep(self._check_s)
                    await self._look_up_account()
            finally:
                self.port = 0

    async def _open_discovery(self, stack: contextlib.AsyncExitStack, port: int) -> None:
        answers = answer_discovery(self._settings.address, port, at=self._discovery_port)
        try:
            await stack.enter_async_context(answers)
        except OSError as error:
            # Clients can still be told the address by hand.
            _LOG.warning("Alpaca's discovery is not answered: %s", error.strerror or error)

    async def _look_up_account(self) -> None:
        if not self._parts.protocols.is_open(ALPACA) or not self._parts.is_here():
            self._who = None
            return
        try:
            secret = await asyncio.to_thread(read_secret, self._settings.token_file)
            self._who = await self._parts.who_of_token(secret)
        except StoreDown:
            # Whose it is is not known now, and nothing here may be served on a guess.
            self._who = None
            return
        except OSError as error:
            self._who = None
            self._report_trouble(f"the token of the Alpaca server cannot be read: {error}")
            return
        if self._who is None:
            self._report_trouble("the token of the Alpaca server is not good; see Account, Tokens")

    def _values(self) -> SiteValues | None:
        live, who = self._live(), self._who
        if live is None or who is None:
            return None
        return SiteValues(live, who.grants, self._parts.clock.monotonic_ns())

    def _live(self) -> LiveSite | None:
        live, who = self._parts.sites.find_site(self._settings.site), self._who
        if live is None or who is None or not allows(AccessNeed.SEE, who.grants, live.description):
            return None
        return live

    async def _call(self, asked: DomeCommand, client: str) -> None:
        live, who = self._live(), self._who
        if live is None or who is None:
            raise DeviceError(INVALID_OPERATION, "the site is not served any more")
        if self._calls >= _MOST_CALLS:
            raise DeviceError(INVALID_OPERATION, "too many commands at once")
        self._calls += 1
        try:
            connection = self._parts.connections.connect(live, who, via=f"Alpaca {client}")
            await call_command(connection, asked)
        finally:
            self._calls -= 1

    def _report_refused(self, client: str, device: str, why: str) -> None:
        self._parts.audit.append_record(
            "alpaca command refused",
            who=f"Alpaca {client}",
            site=self._settings.site,
            device=device,
            message=why,
            good=False,
        )

    def _report_trouble(self, text: str) -> None:
        """Say once what is wrong, until it ends."""
        if text and text != self._told:
            _LOG.warning("%s", text)
        self._told = text

    def _now_us(self) -> int:
        return self._parts.clock.wall_ns() // 1000
