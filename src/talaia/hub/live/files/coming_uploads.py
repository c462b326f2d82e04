"""Which files of which sites are on their way to the hub, how far, and since when. Pure."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["ComingUploads"]

# A row says how far its file is after so many bytes; the file itself knows it exactly.
_TELL_BYTES = 4 * 1024 * 1024


class _Upload(NamedTuple):
    # Bytes that are on the disk.
    have: int
    # When something of it came last (s since the epoch, UTC).
    touched: float
    # Bytes when its row last said how far it is.
    told: int


class ComingUploads:
    """Uploads that have begun and not ended, of each site in the order in which they were offered.

    Kept in memory: a gateway may offer as often as it likes, and none of it is looked up.
    """

    def __init__(self) -> None:
        """Know none."""
        self._uploads: dict[str, dict[str, _Upload]] = {}

    def begin_upload(self, site: str, name: str, have: int, now: float) -> None:
        """Put it last: which was offered last is what its gateway goes on with."""
        uploads = self._uploads.setdefault(site, {})
        uploads.pop(name, None)
        uploads[name] = _Upload(have, now, have)

    def update_upload(self, site: str, name: str, have: int, now: float) -> bool:
        """Write down how far it is; its turn stays. Tell whether its row should say so anew."""
        uploads = self._uploads.setdefault(site, {})
        told = uploads[name].told if name in uploads else 0
        due = have - told >= _TELL_BYTES
        uploads[name] = _Upload(have, now, have if due else told)
        return due

    def end_upload(self, site: str, name: str) -> None:
        """Forget it, if it is there."""
        uploads = self._uploads.get(site, {})
        uploads.pop(name, None)
        if not uploads:
            self._uploads.pop(site, None)

    def sites(self) -> list[str]:
        """List those of which something is on its way."""
        return list(self._uploads)

    def standing_uploads(self, site: str, since: float) -> list[str]:
        """List those that nothing has come of since a time (s since the epoch, UTC)."""
        uploads = self._uploads.get(site, {})
        return [name for name, upload in uploads.items() if upload.touched < since]

    def others_than(self, site: str, name: str) -> list[str]:
        """List those of a site but one, the first offered first."""
        return [other for other in self._uploads.get(site, {}) if other != name]

    def total_bytes(self, site: str) -> int:
        """Give what a site's uploads take on the disk (bytes)."""
        return sum(upload.have for upload in self._uploads.get(site, {}).values())
