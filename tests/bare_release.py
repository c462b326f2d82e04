"""Releases whose signature was checked and that bring no wheels."""

from __future__ import annotations

from pathlib import Path

from talaia.updates.signed_release import ReleaseManifest, SignedRelease


class BareRelease(SignedRelease):
    """A release without wheels."""

    def unpack_wheels(self, folder: Path) -> list[Path]:
        """Unpack nothing."""
        return []


def bare_release(version: str) -> BareRelease:
    """Give a release of this version."""
    return BareRelease(Path(version), ReleaseManifest(form=1, version=version, files={"a": "b"}))
