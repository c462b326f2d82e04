"""Recordings: raw topics and films that gateways hand over."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from talaia.hub.api.records.recorded_topics import RecordedTopicPages
from talaia.hub.api.records.recordings import RecordingPages
from talaia.hub.api.sockets.gateway_sockets import GatewaySocket
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.live.files.file_links import FileLinks
from talaia.hub.live.files.recordings import Recordings
from talaia.hub.live.files.standstill import end_standing_for_ever
from talaia.hub.live.files.stored_recordings import StoredRecordings
from talaia.hub.live.recorded.film_pictures import FilmPictures
from talaia.hub.live.recorded.recorded_topics import RecordedTopics
from talaia.hub.store.sites.recordings import RecordingList

if TYPE_CHECKING:
    from talaia.hub.api.sockets.socket_admission import SocketAdmission
    from talaia.hub.features.feature import Core
    from talaia.hub.files.ports import FileStore
    from talaia.hub.live.assets.robot_assets import RobotAssets
    from talaia.hub.live.files.uploads import Uploads
    from talaia.hub.live.gateways.flood_guard import FloodGuard
    from talaia.hub.live.gateways.open_links import OpenLinks
    from talaia.hub.live.releases.release_folder import ReleaseFolder
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
        store: FileStore,
        admission: SocketAdmission,
        links: OpenLinks,
        flood_guard: FloodGuard,
        uploads: Uploads,
        assets: RobotAssets,
        releases: ReleaseFolder,
        audit: Audit,
    ) -> None:
        """Keep them in ``store``, write down in ``audit`` what comes and goes.

        Other files go to ``uploads``, those of robots to ``assets``; ``flood_guard`` slows
        gateways that say too much; ``releases`` go the other way.
        """
        # The list is in the database and the files on the disk; `open` makes the two fit.
        rows = RecordingList(core.database, core.shard.own_rows)
        self.files = Recordings(
            rows=rows,
            store=store,
            audit=audit,
            data=core.settings.data,
            most_bytes=core.settings.recordings_bytes,
            has_site=core.shard.has_site,
        )
        gateways = GatewaySocket(
            "/gateway/files",
            admission=admission,
            flood_guard=flood_guard,
            server=FileLinks(
                sites=core.sites,
                links=links,
                flood_guard=flood_guard,
                recordings=self.files,
                uploads=uploads,
                assets=assets,
                releases=releases,
            ),
        )
        self.sockets = [gateways.router()]
        recorded = RecordedTopicPages(RecordedTopics(self.files), clock=core.clock, audit=audit)
        films = RecordingPages(self.files, FilmPictures(store), audit)
        self.routers = [films.make_router(), recorded.make_router()]
        ends = [keeper.end_standing_uploads for keeper in (self.files, uploads, assets)]
        self.tasks = [BackgroundTask(name="standstill", run=partial(end_standing_for_ever, ends))]
        if store.remote:
            stored = StoredRecordings(self.files, rows, core.shard)
            self.tasks.append(BackgroundTask(name="stored", run=stored.fit_for_ever))

    async def open(self) -> None:
        """Bring files and their list together."""
        await self.files.open()
