"""Which cameras are filmed for a few seconds when something comes into sight."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.derived_signals import detecting_cameras

if TYPE_CHECKING:
    from talaia.model.detection import Clip
    from talaia.model.site import Site

__all__ = ["clip_lengths", "clips_of"]


def clips_of(site: Site) -> dict[str, Clip]:
    """Give the clips by camera (``device/stream``); none where the site records nothing."""
    if site.recording is None:
        return {}
    return {
        camera: detect.clip for camera, detect in detecting_cameras(site) if detect.clip is not None
    }


def clip_lengths(site: Site) -> dict[str, float]:
    """Give how much of before each clip wants (s), by camera."""
    return {camera: clip.before for camera, clip in clips_of(site).items()}
