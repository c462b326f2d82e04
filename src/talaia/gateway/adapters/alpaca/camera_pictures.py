"""Pictures of an Alpaca server's cameras, on their way into the archive.

Only what was exposed from here is fetched: a picture that another client asked for is its own.
"""

from __future__ import annotations

import asyncio
import math
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from talaia.gateway.adapters.alpaca.pictures import fits_of, pixels_of
from talaia.gateway.adapters.alpaca.protocol import AlpacaRefused
from talaia.gateway.adapters.http.fetching import FetchFailed
from talaia.gateway.errors import FieldError
from talaia.gateway.fits.header import HeaderCard
from talaia.gateway.ports import CommandOutcome
from talaia.model.connection import alpaca_device_of
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from talaia.gateway.adapters.alpaca.commands_under_way import AlpacaCall
    from talaia.gateway.adapters.alpaca.server import AlpacaServer
    from talaia.gateway.ports import FileSink

__all__ = ["CameraPictures", "header_cards"]

_OF_CAMERA = (
    "name",
    "ccdtemperature",
    "binx",
    "biny",
    "gain",
    "pixelsizex",
    "pixelsizey",
    "sensortype",
)
# Of the only device of a type that the server has; with two nobody knows which one is meant.
_OF_OTHERS = {
    "telescope": ("name", "rightascension", "declination", "equatorialsystem", "focallength"),
    "filterwheel": ("names", "position"),
    "focuser": ("position",),
}
# Of ``EquatorialSystem``.
_J2000 = 2


class CameraPictures:
    """All cameras of one server. On the event loop."""

    def __init__(self, devices: Iterable[str], files: FileSink | None) -> None:
        """Take the server's devices (``camera/0``), and who keeps files; none where nobody does."""
        self._devices, self._files = tuple(devices), files

    async def read_scene(self, server: AlpacaServer, call: AlpacaCall) -> dict[str, object]:
        """Ask what a header says of camera, mount, filter and focus; what is not told is missing.

        Returns:
            By type and property, ``telescope/rightascension``.

        """
        camera = alpaca_device_of(call.target)
        asked: dict[str, tuple[str, tuple[str, ...]]] = {"camera": (camera, _OF_CAMERA)}
        for kind, names in _OF_OTHERS.items():
            found = [device for device in self._devices if device.startswith(f"{kind}/")]
            if len(found) == 1:
                asked[kind] = (found[0], names)
        scene: dict[str, object] = {}
        for kind, (device, names) in asked.items():
            for name in names:
                try:
                    scene[f"{kind}/{name}"] = await server.ask_property(f"{device}/{name}")
                except AlpacaRefused:
                    continue
                except FetchFailed:
                    break
        return scene

    async def keep_picture(
        self, server: AlpacaServer, call: AlpacaCall, scene: Mapping[str, object], began_ns: int
    ) -> CommandOutcome:
        """Fetch a picture and hand it on as FITS; the outcome of its command.

        Args:
            server: whose camera has it.
            call: the exposure.
            scene: see `read_scene`.
            began_ns: when it began, by the wall clock.

        """
        if self._files is None:
            return CommandOutcome(CommandPhase.SUCCEEDED, "exposed; nobody here keeps pictures")
        try:
            data = await server.fetch_picture(alpaca_device_of(call.target))
            cards = header_cards(call.fields, call.cards, scene, began_ns)
            # Some tens of millions of pixels: not on the event loop.
            whole = await asyncio.to_thread(_convert_picture, data, cards)
        except (FetchFailed, AlpacaRefused, FieldError) as error:
            return CommandOutcome(CommandPhase.FAILED, f"the picture is of no use: {error}")
        self._files.keep_file(call.described, lambda: whole)
        return CommandOutcome(CommandPhase.SUCCEEDED, "the picture has come")


def _convert_picture(data: bytes, cards: list[HeaderCard]) -> bytes:
    return fits_of(pixels_of(data), cards)


def header_cards(
    fields: Mapping[str, object],
    asked: Mapping[str, object],
    scene: Mapping[str, object],
    began_ns: int,
) -> list[HeaderCard]:
    """Give a picture's cards.

    Args:
        fields: the exposure's parameters.
        asked: keywords that the asker gave, ``OBJECT``.
        scene: see `CameraPictures.read_scene`.
        began_ns: when it began (wall).

    """
    began = datetime.fromtimestamp(began_ns / 1e9, UTC).strftime("%Y-%m-%dT%H:%M:%S.%f")[:-3]
    cards = [
        HeaderCard("DATE-OBS", began, "UTC, begin, by the gateway's clock"),
        HeaderCard("EXPTIME", _number(fields.get("Duration")), "[s] as asked for"),
        HeaderCard("IMAGETYP", "Light" if fields.get("Light") is not False else "Dark"),
        HeaderCard("INSTRUME", _text(scene.get("camera/name")), "camera"),
        HeaderCard("CCD-TEMP", _number(scene.get("camera/ccdtemperature")), "[deg C] sensor"),
        HeaderCard("GAIN", _number(scene.get("camera/gain")), "of the driver"),
        HeaderCard("TELESCOP", _text(scene.get("telescope/name")), "mount"),
        HeaderCard("FOCUSPOS", _number(scene.get("focuser/position")), "[steps] focuser"),
        HeaderCard("FILTER", _filter_name(scene), "filter"),
    ]
    for axis in "xy":
        bins = _number(scene.get(f"camera/bin{axis}"))
        size = _number(scene.get(f"camera/pixelsize{axis}"))
        cards.append(HeaderCard(f"{axis.upper()}BINNING", None if bins is None else round(bins)))
        cards.append(
            HeaderCard(
                f"{axis.upper()}PIXSZ",
                None if size is None else size * (bins or 1.0),
                "[um] with binning",
            )
        )
    cards += _pointing_cards(scene)
    given = {
        key.upper()[:8]: value
        for key, value in asked.items()
        if isinstance(value, str | int | float)
    }
    # What the asker says wins: that a frame is a flat no camera knows.
    cards = [card for card in cards if card.key not in given and card.value is not None]
    return [*cards, *(HeaderCard(key, value) for key, value in given.items())]


def _pointing_cards(scene: Mapping[str, object]) -> list[HeaderCard]:
    hours = _number(scene.get("telescope/rightascension"))
    degrees = _number(scene.get("telescope/declination"))
    if hours is None or degrees is None:
        return []
    # As the mount has it: half a degree lies between the two in these years.
    is_j2000 = scene.get("telescope/equatorialsystem") == _J2000
    frame = "J2000" if is_j2000 else "of the date"
    return [
        HeaderCard("RA", hours * 15.0, f"[deg] {frame}, where the mount pointed"),
        HeaderCard("DEC", degrees, f"[deg] {frame}, where the mount pointed"),
        HeaderCard("RADESYS", "FK5" if is_j2000 else "GAPPT", "of RA and DEC"),
        *([HeaderCard("EQUINOX", 2000.0, "of RA and DEC")] if is_j2000 else []),
    ]


def _filter_name(scene: Mapping[str, object]) -> str | None:
    names, position = scene.get("filterwheel/names"), scene.get("filterwheel/position")
    if not isinstance(names, list) or isinstance(position, bool) or not isinstance(position, int):
        return None
    return str(names[position]) if 0 <= position < len(names) else None


def _number(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return None
    return value


def _text(value: object) -> str | None:
    return value if isinstance(value, str) and value else None
