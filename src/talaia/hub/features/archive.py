"""The archive of an observatory's pictures, and what stands in the sky."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.records.archive import ArchivePages
from talaia.hub.api.sites.sky import SkyPages
from talaia.hub.archive.frame_measurer import FrameMeasurer
from talaia.hub.archive.frame_queues import FrameQueues
from talaia.hub.archive.hook import ArchiveHook, HookCommand, HookPost
from talaia.hub.archive.hook_settings import read_archive_hook
from talaia.hub.archive.store import Archive
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.live.files.disk_share import DiskShare
from talaia.hub.live.files.fits_archiver import FitsArchiver
from talaia.hub.live.files.uploads import Uploads
from talaia.hub.notify.senders import Sender

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.files.ports import FileStore
    from talaia.hub.store.audit import Audit

__all__ = ["ArchiveFeature"]


class ArchiveFeature(Feature):
    """FITS files that gateways send: kept, measured, and handed over to the owner's hook.

    Attributes:
        frames: those that are kept.
        uploads: takes files on their way, by their kind.

    """

    name = "archive"

    def __init__(self, core: Core, *, store: FileStore, audit: Audit) -> None:
        """Keep files in ``store``; write down in ``audit`` what is kept and what is refused.

        Raises:
            CannotStart: the file of the owner's hook cannot be read.

        """
        settings = core.settings
        # Files on their way are in another folder, so that the archive holds whole ones only.
        self.frames = Archive(core.database, store, hooked=settings.archive_hook is not None)
        # By the kind that a gateway's offer names; what has no keeper is refused.
        keepers = {"fits": FitsArchiver(core.sites, self.frames, audit)}
        share = DiskShare(
            settings.data,
            # Elsewhere they take none of this machine's disk.
            held=_hold_nothing if store.remote else self.frames.count_bytes,
            sites=lambda: sum(1 for _ in core.known_sites),
        )
        self.uploads = Uploads(
            settings.data / "uploads",
            keepers,
            most_bytes=settings.file_bytes,
            share=share.may_take,
            has_site=core.shard.has_site,
        )
        self.routers = [ArchivePages(self.frames).make_router(), SkyPages().make_router()]
        queues = FrameQueues(core.database, self.frames, core.shard.own_rows)
        self.tasks = [BackgroundTask(name="measure", run=FrameMeasurer(queues).run)]
        if settings.archive_hook is not None:
            told = read_archive_hook(settings.archive_hook)
            hooked = (
                HookCommand(told, settings.data)
                if told.command
                else HookPost(told, Sender(settings.notify_networks))
            )
            hook = ArchiveHook(queues, hooked, audit)
            self.tasks.append(BackgroundTask(name="hook", run=hook.run))


async def _hold_nothing(_site: str) -> int:
    return 0
