"""Looks at ONVIF cameras: their pictures, and what of them moves. Moves and sets nothing."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING
from urllib.parse import urlsplit
from xml.sax.saxutils import escape

import msgspec

from talaia.gateway.adapters.alpaca.probe import is_here
from talaia.gateway.adapters.http.fetching import FetchFailed
from talaia.gateway.adapters.onvif.answers import (
    parse_axes,
    parse_presets,
    parse_profiles,
    parse_status,
    parse_uri,
)
from talaia.gateway.adapters.onvif.camera_server import OnvifServer
from talaia.gateway.adapters.onvif.discovery import CameraFindings, FoundStream, device_of
from talaia.gateway.adapters.onvif.soap import CameraFault, shown_words
from talaia.gateway.adapters.onvif.xml_nodes import UnreadableXml
from talaia.gateway.errors import AdapterLost
from talaia.model.connection import OnvifConnection
from talaia.model.connections.onvif import host_of
from talaia.model.discovery.probe_report import (
    FORMAT,
    DeviceFound,
    ElementFound,
    Found,
    PropertyFound,
)
from talaia.model.discovery.ros_units import word_of
from talaia.model.discovery.topic_words import free_word

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from talaia.gateway.adapters.onvif.answers import CameraProfile
    from talaia.gateway.adapters.onvif.search import FoundCamera

__all__ = ["probe_cameras"]

# Of a camera's profiles: the picture in full, a small one, and some.
_MOST_STREAMS = 4
# One after the other would take as many seconds as there are silent ones.
_AT_ONCE = 8
_TIMEOUT_S = 5.0


def probe_cameras(
    cameras: Sequence[FoundCamera],
    folder: Path,
    *,
    user: str = "",
    password_file: str = "",
    ca: str = "",
) -> Found:
    """Ask cameras what they have.

    Args:
        cameras: which.
        folder: relative paths begin there.
        user: who signs in; only where a person has named the camera.
        password_file: a file with that user's password.
        ca: file of certificate authorities, for ``https://``; empty takes the system's.

    Raises:
        AdapterLost: the only one does not answer.
        SettingsError: the password cannot be read.

    """
    login = OnvifConnection(
        url="", user=user, password_file=password_file, timeout=_TIMEOUT_S, ca=ca
    )
    return asyncio.run(_probe_all(cameras, folder, login))


async def _probe_all(cameras: Sequence[FoundCamera], folder: Path, login: OnvifConnection) -> Found:
    began = time.monotonic()
    slots = asyncio.Semaphore(_AT_ONCE)

    async def look_at(camera: FoundCamera) -> CameraFindings:
        here = is_here(urlsplit(camera.url).hostname or "")
        settings = msgspec.structs.replace(login, url=camera.url, here=here)
        async with slots:
            return await _look_at(camera, settings, folder)

    findings = await asyncio.gather(*(look_at(camera) for camera in cameras))
    if len(findings) == 1 and findings[0].problem:
        raise AdapterLost(f"the camera {cameras[0].url}: {findings[0].problem}")
    words: list[str] = []
    devices = []
    for found in findings:
        words.append(free_word(word_of(found.name or found.model or "camera"), words))
        devices.append(_device_found(found, words[-1]))
    one = cameras[0].url if len(cameras) == 1 else ""
    return Found(
        talaia_probe=FORMAT,
        protocol="onvif",
        where=f"ONVIF camera {one}" if one else "ONVIF cameras of the network",
        seconds=round(time.monotonic() - began, 1),
        url=one,
        user=login.user,
        password_file=login.password_file,
        ca=login.ca,
        devices=tuple(devices),
    )


async def _look_at(camera: FoundCamera, settings: OnvifConnection, folder: Path) -> CameraFindings:
    found = CameraFindings(camera.url, camera.name, camera.hardware)
    server = OnvifServer(settings, folder)
    try:
        await server.begin()
        found = await _with_model(server, found)
        profiles = parse_profiles(await server.ask("media", "GetProfiles"))
        found = found._replace(streams=await _streams_of(server, profiles, camera.url))
        moved = next((profile for profile in profiles if profile.moves), None)
        return found if moved is None else await _with_motion(server, found, moved)
    except CameraFault as fault:
        why = str(fault)
        if fault.unauthorized:
            why = (
                "it wants a user: talaia init --onvif "
                f"{camera.url} --user NAME --password-file FILE"
            )
        return found._replace(problem=why)
    except (FetchFailed, UnreadableXml) as error:
        return found._replace(problem=str(error))
    finally:
        server.close()


async def _with_model(server: OnvifServer, found: CameraFindings) -> CameraFindings:
    try:
        told = await server.ask("device", "GetDeviceInformation")
    except CameraFault:
        # Told to nobody who has not signed in; what it has is asked for next.
        return found
    words = [shown_words(told.text_at(key))[:60] for key in ("Manufacturer", "Model")]
    return found._replace(model=" ".join(word for word in words if word) or found.model)


async def _streams_of(
    server: OnvifServer, profiles: list[CameraProfile], url: str
) -> tuple[FoundStream, ...]:
    found = []
    for profile in profiles[:_MOST_STREAMS]:
        token = f"<media:ProfileToken>{escape(profile.token)}</media:ProfileToken>"
        setup = (
            "<media:StreamSetup><tt:Stream>RTP-Unicast</tt:Stream><tt:Transport>"
            "<tt:Protocol>RTSP</tt:Protocol></tt:Transport></media:StreamSetup>"
        )
        try:
            address = parse_uri(await server.ask("media", "GetStreamUri", setup + token))
        except CameraFault as fault:
            found.append(FoundStream(profile, "", str(fault)))
            continue
        problem = "" if address else "it tells no address of it"
        if address and host_of(address) != host_of(url):
            # Whoever is there would be sent the camera's password.
            problem = f"its picture is said to be at {host_of(address)}, and not at the camera's"
        found.append(FoundStream(profile, address, problem))
    return tuple(found)


async def _with_motion(
    server: OnvifServer, found: CameraFindings, profile: CameraProfile
) -> CameraFindings:
    token = f"<ptz:ProfileToken>{escape(profile.token)}</ptz:ProfileToken>"
    try:
        axes, has_home = parse_axes(await server.ask("ptz", "GetNodes"), profile.node)
        found = found._replace(profile=profile.token, axes=axes, has_home=has_home)
        presets = parse_presets(await server.ask("ptz", "GetPresets", token))
        found = found._replace(presets=tuple(preset.name for preset in presets), has_presets=True)
        return found._replace(status=parse_status(await server.ask("ptz", "GetStatus", token)))
    except CameraFault:
        # Simple cameras have no presets, or no status; the rest was found.
        return found


def _device_found(found: CameraFindings, word: str) -> DeviceFound:
    rows = [("picture", stream.profile.token, stream.address) for stream in found.streams]
    rows += [("axis", axis, "") for axis in found.axes]
    rows += [("preset", name, "") for name in found.presets]
    return DeviceFound(
        found.name or found.url,
        found.model,
        connected=not found.problem,
        properties=tuple(
            PropertyFound(name, kind, elements=(ElementFound("", "", value),))
            for kind, name, value in rows
        ),
        word=word,
        described=None if found.problem else device_of(found, word),
        address=found.url,
        profile=found.profile,
        problem=found.problem,
        left_out=tuple(
            f"{stream.profile.name}: {stream.problem}" for stream in found.streams if stream.problem
        ),
    )
