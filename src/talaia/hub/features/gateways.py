"""Gateways: their keys, the codes by which new ones enrol, and which are connected."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.sites.gateways import GatewayPages, Proof
from talaia.hub.certificate import certificate_fingerprint, certificate_of, key_hash
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.live.gateways.open_links import OpenLinks
from talaia.hub.store.sites.enrolment import Enrolment
from talaia.hub.store.sites.site_registry import SiteRegistry

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.store.audit import Audit

__all__ = ["GatewaysFeature"]


class GatewaysFeature(Feature):
    """What the hub knows of gateways; their links are a feature of its own (`gateway_links`).

    Attributes:
        registry: the sites of before and the keys of their gateways.
        links: the connections that are open now.

    """

    name = "gateways"

    def __init__(self, core: Core, *, audit: Audit) -> None:
        """Write down in ``audit`` who enrols and is revoked."""
        # How often keys are checked, and where the certificate is.
        self._settings = core.settings
        self.registry = SiteRegistry(core.database, core.clock)
        self.links = OpenLinks(core.sites, self.registry)
        pages = GatewayPages(
            registry=self.registry,
            enrolment=Enrolment(core.database, core.clock),
            links=self.links,
            audit=audit,
            clock=core.clock,
            proof=self._make_proof,
            shard=core.shard,
        )
        attendance = self.registry.attendance
        self.routers = [pages.make_router()]
        self.tasks = [
            BackgroundTask(name="keep attendance", run=attendance.run, stop=attendance.stop),
            # A key may be made void from the command line, past this process.
            BackgroundTask(name="check keys", run=self._check_keys),
        ]

    async def _check_keys(self) -> None:
        await self.links.watch_keys(self._settings.check_s)

    def _make_proof(self) -> Proof:
        if self._settings.plain:
            return Proof()
        # Read each time: the hub renews it while it runs.
        cert = certificate_of(self._settings).cert
        return Proof(certificate_fingerprint(cert), key_hash(cert))
