"""The routes by which an admin opens and shuts client protocols."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from fastapi import APIRouter, Request

from talaia.hub.api.access import address_of, number_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.client_schemas import (
    BrokerShape,
    ClientDriverAsk,
    ClientDriverShape,
    ClientProtocolAsk,
    ClientProtocolList,
    ClientProtocolShape,
)
from talaia.hub.clients.catalog import CLIENT_PROTOCOLS

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.hub.clients.mqtt.broker_presence import BrokerContact, BrokerPresence
    from talaia.hub.clients.open_protocols import OpenProtocols
    from talaia.hub.ports import DescribedSites
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.clients.protocols import ClientProtocols, ProtocolState

__all__ = ["ClientProtocolPages"]

# Scheme, host and port, as a browser writes it: no path, nothing after it.
_ORIGIN = re.compile(r"https?://[a-z0-9.\-]+(:\d{1,5})?|https?://\[[0-9a-f:]+\](:\d{1,5})?")


class ClientProtocolPages:
    """The routes of client protocols, and of those who may drive by them."""

    def __init__(
        self,
        *,
        store: ClientProtocols,
        protocols: OpenProtocols,
        brokers: Mapping[str, Sequence[BrokerPresence]],
        sites: DescribedSites,
        audit: Audit,
    ) -> None:
        """Write into ``store``; ``protocols`` follows at once.

        ``brokers`` tell, by protocol, how those stand that files of their own name; they may
        become more.
        """
        self._brokers = brokers
        self._store = store
        self._protocols = protocols
        self._sites = sites
        self._audit = audit

    def router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/client-protocols")(self.list_protocols)
        router.put("/api/client-protocols/{protocol}", status_code=204)(self.set_protocol)
        router.put("/api/client-drivers", status_code=204)(self.set_driver)
        return router

    async def list_protocols(self) -> ClientProtocolList:
        """List the protocols that other tools may connect by, and who may drive by them."""
        # From the database and not from memory: another process may have changed it.
        states = {state.protocol: state for state in await self._store.read_states()}
        return ClientProtocolList(
            protocols=[self._shape(name, states.get(name)) for name in CLIENT_PROTOCOLS],
            drivers=[
                ClientDriverShape(
                    person=str(driver.user),
                    name=driver.name,
                    site=driver.site,
                    device=driver.device,
                    given_by=driver.given_by,
                    given_us=driver.given_us,
                )
                for driver in await self._store.read_drivers()
            ],
        )

    async def set_protocol(self, protocol: str, asked: ClientProtocolAsk, request: Request) -> None:
        """Open or shut a protocol, and name the origins whose pages are let in.

        Connections that are not allowed any more are closed at once.
        """
        info = CLIENT_PROTOCOLS.get(protocol)
        # Only what the catalog knows can be opened.
        if info is None:
            raise ApiProblem(404, "unknown", "there is no such protocol")
        for origin in asked.origins:
            if _ORIGIN.fullmatch(origin) is None:
                raise ApiProblem(
                    422,
                    "invalid",
                    f"{origin[:100]!r} is no origin; write it like https://tools.example:8080",
                )
        # In the order in which the admin named them.
        origins = list(dict.fromkeys(asked.origins))
        who = who_of(request).name
        await self._store.set_state(protocol, is_open=asked.open, origins=origins, who=who)
        # At once, instead of at the next check of the table.
        await self._protocols.reload_table()
        said = f"{info.title}; origins: {', '.join(origins) or 'none'}"
        kind = "client protocol opened" if asked.open else "client protocol shut"
        self._append_record(request, kind, said)

    async def set_driver(self, asked: ClientDriverAsk, request: Request) -> None:
        """Let an account drive a device by such clients, or no more."""
        live = self._sites.find_site(asked.site)
        described = live.description.devices.get(asked.device) if live is not None else None
        # Of a device that is gone a permission can still be taken back.
        if asked.allowed and (described is None or described.drive is None):
            raise ApiProblem(404, "unknown", "there is no such device that is driven")
        name = await self._store.set_driver(
            number_of(asked.person, "person"),
            asked.site,
            asked.device,
            allowed=asked.allowed,
            who=who_of(request).name,
        )
        if name is None:
            raise ApiProblem(404, "unknown", "there is no such person")
        await self._protocols.reload_table()
        kind = "client driving allowed" if asked.allowed else "client driving withdrawn"
        self._append_record(request, kind, name, site=asked.site, device=asked.device)

    def _shape(self, name: str, state: ProtocolState | None) -> ClientProtocolShape:
        # One without a row was never opened.
        info = CLIENT_PROTOCOLS[name]
        return ClientProtocolShape(
            protocol=name,
            title=info.title,
            path=info.path,
            socket=info.socket,
            tools=info.tools,
            open=state is not None and state.open,
            origins=list(state.origins) if state is not None else [],
            changed_by=state.changed_by if state is not None else "",
            changed_us=state.changed_us if state is not None else 0,
            connected=self._protocols.count_connected(name),
            brokers=[_broker_shape(one.contact) for one in self._brokers.get(name, ())],
        )

    def _append_record(
        self, request: Request, kind: str, message: str, *, site: str = "", device: str = ""
    ) -> None:
        self._audit.append_record(
            kind,
            who=who_of(request).name,
            address=address_of(request),
            site=site,
            device=device,
            message=message,
        )


def _broker_shape(contact: BrokerContact) -> BrokerShape:
    return BrokerShape(
        address=contact.address,
        connected=contact.connected,
        since_us=contact.since_us,
        why=contact.why,
        refused=list(contact.refused),
    )
