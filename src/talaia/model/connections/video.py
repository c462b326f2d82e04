"""Cameras without ROS: on the network by RTSP, or at this computer's USB."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from talaia.model.base import Shape, SourceShape
from talaia.model.camera_addresses import NO_ADDRESS, remedy_for, why_no_camera
from talaia.model.checks.identifiers import Finding
from talaia.model.connections.addresses import url_fits
from talaia.model.connections.kinds import ConnectionKind
from talaia.model.connections.rules import KindRules

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Signal

__all__ = ["VideoConnection", "VideoRules", "VideoSource"]

# As the kernel names them: /dev/video0, or /dev/v4l/by-id/….
_CAMERA_FILE = re.compile(r"/dev/(video[0-9]{1,3}|v4l/by-(id|path)/[A-Za-z0-9_.:+-]{1,200})\Z")


class VideoConnection(Shape, frozen=True, kw_only=True, tag_field="kind", tag="video"):
    """Cameras without ROS: on the network by RTSP, or at this computer's USB.

    Attributes:
        user: whom a camera's server asks for; empty for nobody.
        password_file: a file that holds that user's password; empty for none.
        udp: let the network drop what is late, where a camera can do no TCP.
        here: cameras' servers may run on the gateway's own computer (``127.0.0.1``), which is
            refused otherwise.

    """

    user: str = ""
    password_file: str = ""
    udp: bool = False
    here: bool = False


class VideoSource(SourceShape, frozen=True, kw_only=True, tag="video"):
    """Where a picture comes from: one of the two.

    Attributes:
        url: of the camera's own server, ``rtsp://camera.local/stream``; without a password.
        file: the camera's device file, ``/dev/video0``.

    """

    url: str = ""
    file: str = ""


class VideoRules(KindRules[VideoConnection, VideoSource]):
    """Checks what is described of cameras without ROS."""

    kind = ConnectionKind.VIDEO
    source = VideoSource
    example = "url: rtsp://camera.local/stream, or file: /dev/video0"

    def __init__(self, connection: VideoConnection) -> None:
        """Answer for this connection."""
        super().__init__(connection, VideoSource)

    def own_findings(self, where: str) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        if self.connection.password_file and not self.connection.user:
            yield Finding(f"{where}.user", "whose password is it?", "write: user: viewer")

    def signal_fits(self, where: str, signal: Signal, source: VideoSource) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        yield Finding(where, "a camera gives no signals", "take another connection for them")

    def stream_fits(self, where: str, source: VideoSource) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        # One of the two, and not both.
        if bool(source.url) == bool(source.file):
            yield Finding(where, "where is the camera?", f"write {self.example}")
        elif source.url:
            yield from self._server_fits(f"{where}.url", source.url)
        elif not _CAMERA_FILE.match(source.file):
            problem = f"{source.file[:80]!r} is not a camera's device file"
            yield Finding(f"{where}.file", problem, "write it as /dev/video0")

    def _server_fits(self, where: str, url: str) -> Iterator[Finding]:
        findings = [
            *url_fits(
                where,
                url,
                ("rtsp", "rtsps"),
                example="camera.local/stream",
                instead="write user and password_file at the connection",
            )
        ]
        yield from findings
        host = "" if findings else urlsplit(url).hostname or ""
        # A name is looked up, and checked likewise, when the camera is opened.
        why = why_no_camera(host, here=self.connection.here)
        if why and why != NO_ADDRESS:
            yield Finding(where, f"a camera may not be at {host}, {why}", remedy_for(why))
