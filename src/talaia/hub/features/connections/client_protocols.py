"""Client protocols: other tools connect, by token and while an admin has opened their protocol."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.clients.client_admission import ClientAdmission
from talaia.hub.api.clients.client_protocols import ClientProtocolPages
from talaia.hub.api.clients.client_sockets import ClientSockets
from talaia.hub.clients.catalog import MQTT
from talaia.hub.clients.client_connection import ClientConnections
from talaia.hub.clients.mqtt.broker_presence import BrokerPresence
from talaia.hub.clients.open_protocols import OpenProtocols
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.store.clients.protocols import ClientProtocols

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.hub.api.clients.client_sockets import BeginsSession
    from talaia.hub.features.feature import Core
    from talaia.hub.features.people import PeopleFeature
    from talaia.hub.live.pages.page_service import PageService
    from talaia.hub.store.audit import Audit

__all__ = ["ClientProtocolsFeature"]


class ClientProtocolsFeature(Feature):
    """Which protocols are open, and one route for each.

    Attributes:
        protocols: what is open now.
        admission: lets clients in.
        connections: connects them like pages.
        audit: keeps who came and went.

    """

    name = "client_protocols"

    def __init__(
        self, core: Core, *, people: PeopleFeature, service: PageService, audit: Audit
    ) -> None:
        """Serve clients by ``service``, as pages are."""
        # How often the table is read again: another process may have changed it.
        self._check_s = core.settings.check_s
        self.audit = audit
        # Two tables: what is open, and who drives.
        store = ClientProtocols(core.database, core.clock)
        # In memory, so that no connection waits for the database to be told yes or no.
        self.protocols = OpenProtocols(store, led_elsewhere=not core.shard.is_main)
        self.admission = ClientAdmission(
            access=people.access,
            limits=people.limits,
            protocols=self.protocols,
            sites=core.sites,
            known=core.known_sites,
        )
        self.connections = ClientConnections(
            service=service, protocols=self.protocols, clock=core.clock
        )
        # By protocol: filled by the features that a file of their own describes, which are built
        # after this one.
        self._brokers: dict[str, list[BrokerPresence]] = {}
        pages = ClientProtocolPages(
            store=store,
            protocols=self.protocols,
            brokers=self._brokers,
            sites=core.known_sites,
            audit=audit,
        )
        self.routers = [pages.router()]
        self.tasks = [BackgroundTask(name="check client protocols", run=self._check)]

    def serve_sockets(
        self, protocol: str, *, begin: BeginsSession, subprotocols: Sequence[str] = ()
    ) -> ClientSockets:
        """Make the sockets of a protocol; for its arguments see `ClientSockets`."""
        return ClientSockets(
            protocol,
            begin=begin,
            subprotocols=subprotocols,
            admission=self.admission,
            connections=self.connections,
            protocols=self.protocols,
            audit=self.audit,
        )

    def name_broker(self, address: str, protocol: str = MQTT) -> BrokerPresence:
        """Have the page tell of a broker that the hub connects to, or of a server that it is."""
        presence = BrokerPresence()
        presence.name_broker(address)
        self._brokers.setdefault(protocol, []).append(presence)
        return presence

    async def open(self) -> None:
        """Read which protocols are open."""
        await self.protocols.reload_table()

    async def _check(self) -> None:
        await self.protocols.watch(self._check_s)
