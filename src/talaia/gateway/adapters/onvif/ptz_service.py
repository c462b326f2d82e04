"""The PTZ service of one camera: moves that end by themselves, Stop, presets and status."""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.sax.saxutils import escape

from talaia.gateway.adapters.onvif.answers import parse_presets, parse_profiles, parse_status
from talaia.gateway.adapters.onvif.soap import CameraFault

if TYPE_CHECKING:
    from talaia.gateway.adapters.onvif.answers import Preset, PtzStatus
    from talaia.gateway.adapters.onvif.camera_server import OnvifServer
    from talaia.gateway.adapters.onvif.xml_nodes import XmlNode

__all__ = ["MOVE_S", "PtzService", "PtzVelocity", "choose_profile"]

# After so long without another a move ends by itself (s), by the camera's own clock. Whole
# seconds, for some cameras read no others.
MOVE_S = 1
# Pan to the right, tilt up, zoom in: -1 to 1 of the camera's fastest.
PtzVelocity = tuple[float, float, float]


async def choose_profile(server: OnvifServer, wanted: str) -> str:
    """Choose the profile whose camera is moved: the wanted one, or the first that moves.

    Raises:
        CameraFault: there is none; or as `OnvifServer.ask`.
        FetchFailed: see `OnvifServer.ask`.
        UnreadableXml: see `OnvifServer.ask`.

    """
    profiles = parse_profiles(await server.ask("media", "GetProfiles"))
    for profile in profiles:
        if profile.token == wanted or (not wanted and profile.moves):
            return profile.token
    named = ", ".join(profile.token for profile in profiles[:10]) or "none"
    raise CameraFault(
        "", f"no profile {wanted} (it has {named})" if wanted else "nothing of it can be moved"
    )


class PtzService:
    """Asks one profile's PTZ. All raise what `OnvifServer.ask` does."""

    def __init__(self, server: OnvifServer, profile: str) -> None:
        """Take whom to ask, and the token of what is moved."""
        self._server = server
        self._profile = f"<ptz:ProfileToken>{escape(profile)}</ptz:ProfileToken>"

    async def move(self, velocity: PtzVelocity, axes: frozenset[str]) -> None:
        """Move until `MOVE_S` is over, unless it is told again; only the axes that it has."""
        pan, tilt, zoom = velocity
        speed = ""
        if axes & {"pan", "tilt"}:
            speed += f'<tt:PanTilt x="{pan:.3f}" y="{tilt:.3f}"/>'
        if "zoom" in axes:
            speed += f'<tt:Zoom x="{zoom:.3f}"/>'
        await self._ask(
            "ContinuousMove",
            f"<ptz:Velocity>{speed}</ptz:Velocity><ptz:Timeout>PT{MOVE_S}S</ptz:Timeout>",
        )

    async def stop(self) -> None:
        """Stop all axes."""
        await self._ask("Stop", "<ptz:PanTilt>true</ptz:PanTilt><ptz:Zoom>true</ptz:Zoom>")

    async def read_status(self) -> PtzStatus:
        """Say how it stands."""
        return parse_status(await self._ask("GetStatus"))

    async def read_presets(self) -> list[Preset]:
        """List its presets."""
        return parse_presets(await self._ask("GetPresets"))

    async def goto_preset(self, token: str) -> None:
        """Begin to go to a preset."""
        await self._ask("GotoPreset", _token(token))

    async def set_preset(self, name: str, token: str = "") -> None:
        """Keep where it looks as a preset, under the token of one that is there already."""
        named = f"<ptz:PresetName>{escape(name)}</ptz:PresetName>"
        await self._ask("SetPreset", named + (_token(token) if token else ""))

    async def remove_preset(self, token: str) -> None:
        """Forget a preset."""
        await self._ask("RemovePreset", _token(token))

    async def goto_home(self) -> None:
        """Begin to go to the home position."""
        await self._ask("GotoHomePosition")

    async def set_home(self) -> None:
        """Keep where it looks as the home position."""
        await self._ask("SetHomePosition")

    async def _ask(self, action: str, more: str = "") -> XmlNode:
        return await self._server.ask("ptz", action, self._profile + more)


def _token(token: str) -> str:
    return f"<ptz:PresetToken>{escape(token)}</ptz:PresetToken>"
