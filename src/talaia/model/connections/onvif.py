"""A network camera that is controlled by ONVIF: pictures, pan, tilt, zoom and presets."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from talaia.model.base import Shape, SourceShape
from talaia.model.camera_addresses import NO_ADDRESS, remedy_for, why_no_camera
from talaia.model.checks.identifiers import Finding
from talaia.model.closed_lists import CommandKind, DriveMessage, SignalType
from talaia.model.connections.addresses import url_fits
from talaia.model.connections.kinds import ConnectionKind
from talaia.model.connections.rules import KindRules, argument_fields

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Command, Device, Signal

__all__ = [
    "ONVIF_COMMANDS",
    "ONVIF_TRAVELS",
    "PTZ_VALUES",
    "OnvifConnection",
    "OnvifRules",
    "OnvifSource",
    "host_of",
]

# What a camera tells of its motion, and of which type a signal of it is.
PTZ_VALUES = {
    "pan": SignalType.NUMBER,
    "tilt": SignalType.NUMBER,
    "zoom": SignalType.NUMBER,
    "moving": SignalType.NUMBER,
    "presets": SignalType.TEXT,
}
# ONVIF's own names (PTZ service), each with the fields that it has to be given.
ONVIF_COMMANDS: dict[str, frozenset[str]] = {
    "GotoPreset": frozenset({"preset"}),
    "SetPreset": frozenset({"preset"}),
    "RemovePreset": frozenset({"preset"}),
    "GotoHomePosition": frozenset(),
    "SetHomePosition": frozenset(),
    "Stop": frozenset(),
}
# Of these: what takes its time, and can be stopped on its way.
ONVIF_TRAVELS = frozenset({"GotoPreset", "GotoHomePosition"})
# A ReferenceToken of ONVIF has 64 letters at the most.
_TOKEN = re.compile(r"[!-~]{0,64}\Z")
_POLL_S = (0.2, 60)
_TIMEOUT_S = (0.2, 30)
_SECRETS = "write user and password_file at the connection"


class OnvifConnection(Shape, frozen=True, kw_only=True, tag_field="kind", tag="onvif"):
    """A network camera that is controlled by ONVIF.

    Attributes:
        url: of its device service, ``http://camera.local/onvif/device_service``; without a
            password. Nothing else is asked, and nobody else gets the password.
        profile: the token of the media profile whose camera moves, as ``talaia probe --onvif``
            lists them; empty for the first that has pan, tilt or zoom.
        user: who signs in at the camera.
        password_file: a file that holds that user's password.
        poll: position and presets are asked for so often while nothing moves (s).
        timeout: what has not answered whole by then counts as silent (s).
        ca: file of certificate authorities for ``https://``; empty takes the system's.
        udp: pictures: let the network drop what is late, where the camera can do no TCP.
        here: the camera's server may run on the gateway's own computer (``127.0.0.1``), which is
            refused otherwise.

    """

    url: str
    profile: str = ""
    user: str = ""
    password_file: str = ""
    poll: float = 2.0
    timeout: float = 3.0
    ca: str = ""
    udp: bool = False
    here: bool = False


class OnvifSource(SourceShape, frozen=True, kw_only=True, tag="onvif"):
    """Where a signal or a picture comes from at an ONVIF camera.

    Attributes:
        ptz: of a signal: ``pan``, ``tilt``, ``zoom`` (as the camera gives them: -1 to 1, zoom 0 to
            1), ``moving`` (1 while it moves, else 0) or ``presets`` (a text: one name a line).
        url: of a picture: the camera's address for it, ``rtsp://camera.local/stream``.

    """

    ptz: str = ""
    url: str = ""


def host_of(url: str) -> str:
    """Name the host of an address, as it is compared; empty for one that has none."""
    try:
        return (urlsplit(url).hostname or "").rstrip(".").lower()
    except ValueError:
        return ""


class OnvifRules(KindRules[OnvifConnection, OnvifSource]):
    """Checks what is described of a camera with ONVIF."""

    kind = ConnectionKind.ONVIF
    source = OnvifSource
    example = "ptz: pan, or of a picture url: rtsp://camera.local/stream"
    commands = frozenset({CommandKind.ONVIF})
    drives = True

    def __init__(self, connection: OnvifConnection) -> None:
        """Answer for this connection."""
        super().__init__(connection, OnvifSource)

    def own_findings(self, where: str) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        connection = self.connection
        yield from self._address_fits(
            f"{where}.url", connection.url, ("http", "https"), "camera.local/onvif/device_service"
        )
        if not _TOKEN.match(connection.profile):
            problem = f"{connection.profile[:80]!r} cannot be a profile"
            yield Finding(f"{where}.profile", problem, "talaia probe --onvif lists them")
        for key, (low, high) in (("poll", _POLL_S), ("timeout", _TIMEOUT_S)):
            found = getattr(connection, key)
            # Written so that NaN is found as well.
            if not low <= found <= high:
                yield Finding(f"{where}.{key}", f"expected {low:g} to {high:g} s, found {found:g}")
        if connection.password_file and not connection.user:
            yield Finding(f"{where}.user", "whose password is it?", "write: user: operator")
        if connection.ca and not connection.url.startswith("https:"):
            problem = "authorities are for https:// alone"
            yield Finding(f"{where}.ca", problem, "write the url with https://, or leave it out")

    def device_findings(self, where: str, device: Device) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        yield from super().device_findings(where, device)
        if device.drive is not None and device.drive.message is not DriveMessage.PTZ:
            problem = f"an ONVIF camera takes no {device.drive.message}"
            yield Finding(f"{where}.drive.message", problem, f"write: message: {DriveMessage.PTZ}")

    def signal_fits(self, where: str, signal: Signal, source: OnvifSource) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        if source.url:
            yield Finding(f"{where}.url", "it is a picture's", "write: ptz: pan")
        wanted = PTZ_VALUES.get(source.ptz)
        if wanted is None:
            problem = f"{source.ptz[:80]!r} is nothing that a camera tells"
            yield Finding(f"{where}.ptz", problem, f"write one of: {', '.join(PTZ_VALUES)}")
        elif signal.type is not wanted:
            problem = f"{source.ptz} is a {wanted}, and the signal a {signal.type}"
            yield Finding(f"{where}.ptz", problem, f"write: type: {wanted}")

    def stream_fits(self, where: str, source: OnvifSource) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        if source.ptz or not source.url:
            yield Finding(where, "where is the picture?", "write: url: rtsp://camera.local/stream")
            return
        findings = [
            *self._address_fits(
                f"{where}.url", source.url, ("rtsp", "rtsps"), "camera.local/stream"
            )
        ]
        yield from findings
        # The password goes with it, and is for nobody else.
        if not findings and host_of(source.url) != host_of(self.connection.url):
            problem = f"it is not at {host_of(self.connection.url)}, as the camera is"
            remedy = "reach a picture from elsewhere by a connection of kind: video"
            yield Finding(f"{where}.url", problem, remedy)

    def command_fits(self, where: str, command: Command) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        needed = ONVIF_COMMANDS.get(command.target)
        if needed is None:
            problem = f"{command.target[:80]!r} is nothing that a camera is asked here"
            yield Finding(f"{where}.target", problem, f"write one of: {', '.join(ONVIF_COMMANDS)}")
            return
        given = argument_fields(where, command)
        for at, field in given:
            if field not in needed:
                problem = f"{command.target} takes no {field[:80]!r}"
                yield Finding(at, problem, "leave it out" if not needed else "write: field: preset")
        for field in sorted(needed - {field for _, field in given}):
            problem = f"{command.target} needs a {field}"
            remedy = "add arguments: {preset: {type: text, field: preset}}"
            yield Finding(f"{where}.arguments", problem, remedy)

    def _address_fits(
        self, where: str, url: str, schemes: tuple[str, ...], example: str
    ) -> Iterator[Finding]:
        findings = [*url_fits(where, url, schemes, example=example, instead=_SECRETS)]
        yield from findings
        host = "" if findings else urlsplit(url).hostname or ""
        # A name is looked up, and checked likewise, each time it is asked.
        why = why_no_camera(host, here=self.connection.here)
        if why and why != NO_ADDRESS:
            yield Finding(where, f"a camera may not be at {host}, {why}", remedy_for(why))
