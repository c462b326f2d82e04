"""A gateway's pictures on their way from the files that have come to the archive."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.archive.fits_reader import NotKept
from talaia.hub.live.files.uploads import UploadRefused

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.hub.archive.store import Archive
    from talaia.hub.live.sites import Sites
    from talaia.hub.store.audit import Audit
    from talaia.wire.frames import ArchiveOffer

__all__ = ["FitsArchiver"]


class FitsArchiver:
    """A `Keeper` of pictures."""

    def __init__(self, sites: Sites, archive: Archive, audit: Audit) -> None:
        """Keep them in the archive, and write each down."""
        self._sites = sites
        self._archive = archive
        self._audit = audit

    async def __call__(self, site: str, offer: ArchiveOffer, path: Path) -> None:
        """See `Keeper`."""
        live = self._sites.find_site(site)
        if live is None:
            raise UploadRefused(f"there is no site {site!r}")
        try:
            kept = await self._archive.archive_file(site, live.description.zone, offer, path)
        except NotKept as error:
            self._audit.append_record(
                "picture refused",
                site=site,
                device=offer.device,
                message=str(error),
                good=False,
                source="gateway",
            )
            raise UploadRefused(str(error)) from error
        if not kept.width:
            # Its file is there, and nothing of it could be looked at.
            self._audit.append_record(
                "picture not read",
                site=site,
                device=offer.device,
                message=f"{kept.name}: {'; '.join(kept.problems)}",
                good=False,
                source="gateway",
            )
            return
        self._audit.append_record(
            "picture kept", site=site, device=offer.device, message=kept.name, source="gateway"
        )
