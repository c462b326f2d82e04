"""Recordings: raw topics and films that gateways hand over."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.records.recordings import RecordingPages
from talaia.hub.api.sockets.gateway_sockets import GatewaySocket
from talaia.hub.features.feature import Feature
from talaia.hub.live.files.recordings import FileLinks, Recordings
from talaia.hub.store.sites.recordings import RecordingList

if TYPE_CHECKING:
    from talaia.hub.api.sockets.socket_admission import SocketAdmission
    from talaia.hub.features.feature import Core
    from talaia.hub.live.files.uploads import Uploads
    from talaia.hub.live.gateways.open_links import OpenLinks
    from talaia.hub.store.audit import Audit

__all__ = ["RecordingsFeature"]


class RecordingsFeature(Feature):
    """Files of recordings, and their list.

    Attributes:
        files: those that are kept.

    """

    name = "recordings"

    def __init__(
        self,
        core: Core,
        *,
        admission: SocketAdmission,
        links: OpenLinks,
        uploads: Uploads,
        audit: Audit,
    ) -> None:
        """Write down in ``audit`` what comes and goes; other files go to ``uploads``."""
        # The list is in the database and the files on the disk; `open` makes the two fit.
        self.files = Recordings(
            rows=RecordingList(core.database),
            audit=audit,
            data=core.settings.data,
            most_bytes=core.settings.recordings_bytes,
        )
        gateways = GatewaySocket(
            "/gateway/files",
            admission=admission,
            server=FileLinks(links=links, recordings=self.files, uploads=uploads),
        )
        self.sockets = [gateways.router()]
        self.routers = [RecordingPages(self.files, audit).make_router()]

    async def open(self) -> None:
        """Bring files and their list together."""
        await self.files.open()
