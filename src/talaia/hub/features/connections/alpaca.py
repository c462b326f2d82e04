"""The hub as an ASCOM Alpaca server, at the address that its administrator has named."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.clients.alpaca.served_settings import read_alpaca_serving
from talaia.hub.clients.alpaca.serving import AlpacaService, ServiceParts
from talaia.hub.clients.catalog import ALPACA
from talaia.hub.features.feature import BackgroundTask, Feature

if TYPE_CHECKING:
    from talaia.hub.api.access import Access
    from talaia.hub.auth.permissions import Who
    from talaia.hub.features.connections.client_protocols import ClientProtocolsFeature
    from talaia.hub.features.feature import Core
    from talaia.hub.store.audit import Audit

__all__ = ["AlpacaFeature"]


class AlpacaFeature(Feature):
    """A task, where the hub was started with a file that says where to answer."""

    name = "alpaca"

    def __init__(
        self, core: Core, *, clients: ClientProtocolsFeature, access: Access, audit: Audit
    ) -> None:
        """Serve by what ``clients`` knows, for the account whose token ``access`` finds.

        Raises:
            CannotStart: the file of the settings cannot be used.

        """
        if core.settings.alpaca is None:
            return
        settings = read_alpaca_serving(core.settings.alpaca)

        async def who_of_token(token: str) -> Who | None:
            alive = await access.who_of_token(token)
            return alive.who if alive is not None else None

        def is_here() -> bool:
            # One address for one site: of several shards that one listens which has it.
            return core.shard.is_whole or core.sites.find_site(settings.site) is not None

        parts = ServiceParts(
            connections=clients.connections,
            protocols=clients.protocols,
            presence=clients.name_broker(f"{settings.address}:{settings.port}", ALPACA),
            sites=core.sites,
            audit=audit,
            clock=core.clock,
            who_of_token=who_of_token,
            is_here=is_here,
            hosts=core.settings.host_names,
        )
        service = AlpacaService(settings, parts, check_s=core.settings.check_s)
        self.tasks = [BackgroundTask(name="serve Alpaca", run=service.run)]
