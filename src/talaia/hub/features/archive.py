"""The archive of an observatory's pictures, and what stands in the sky."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.records.archive import ArchivePages
from talaia.hub.api.sites.sky import SkyPages
from talaia.hub.archive.store import Archive
from talaia.hub.features.feature import Feature
from talaia.hub.live.files.fits_archiver import FitsArchiver
from talaia.hub.live.files.uploads import Uploads

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.store.audit import Audit

__all__ = ["ArchiveFeature"]


class ArchiveFeature(Feature):
    """FITS files that gateways send.

    Attributes:
        frames: those that are kept.
        uploads: takes files on their way, by their kind.

    """

    name = "archive"

    def __init__(self, core: Core, *, audit: Audit) -> None:
        """Write down in ``audit`` what is kept and what is refused."""
        settings = core.settings
        # Files on their way are in another folder, so that the archive holds whole ones only.
        self.frames = Archive(core.database, settings.data / "archive")
        # By the kind that a gateway's offer names; what has no keeper is refused.
        keepers = {"fits": FitsArchiver(core.sites, self.frames, audit)}
        self.uploads = Uploads(settings.data / "uploads", keepers, settings.file_bytes)
        self.routers = [ArchivePages(self.frames).make_router(), SkyPages().make_router()]
