"""What programs send in an event: values, sensors by name, pictures. Pure."""

from __future__ import annotations

import ast
import base64
import binascii
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.gateway.adapters.json_signals import JsonText
from talaia.gateway.errors import FieldError
from talaia.gateway.video.jpeg import jpeg_size, pixels_in
from talaia.gateway.video.pixels import MOST_PIXELS
from talaia.model.connections.json_path import parse_json_path
from talaia.wire.nested_json import check_depth, decode_nested
from talaia.wire.socketio.founding_namespaces import SENSED

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from talaia.gateway.video.pixels import Pixels

__all__ = ["data_of", "event_key", "payload_of", "pixels_of_event", "place_of", "sensors_in"]

# Checked before it is read: `literal_eval` of long nested text can exhaust the stack.
_LONGEST_LITERAL = 4096
# A dictionary is packed at the most so: in a list, of a ``std_msgs/String``.
_DEEPEST = 3
_MOST_SENSORS = 1000
_PNG = b"\x89PNG"


class _Encoded(NamedTuple):
    """A picture as `jpeg_size` takes it."""

    format: str
    data: bytes


def place_of(namespace: str) -> str:
    """Give a namespace as descriptions write it: without its slash, and in one spelling."""
    if f"/{namespace.strip('/')}" in SENSED:
        return SENSED[0].strip("/")
    return namespace.strip("/") or "/"


def event_key(place: str, event: str = "", name: str = "") -> str:
    """Give the key of signals that are read from an event; see `JsonSignals`.

    In quotes, so that no two keys are the same text.
    """
    return place + (f" event={event!r}" if event else "") + (f" name={name!r}" if name else "")


def data_of(args: Sequence[object]) -> object:
    """Give what an event carries as one value; text that is JSON or Python's as what it means."""
    data = args[0] if len(args) == 1 else list(args)
    return _read_text(data) if isinstance(data, str) else data


def payload_of(data: object) -> JsonText:
    """Give a value as signals read it."""
    if isinstance(data, str):
        return JsonText(data, None, is_json=False)
    try:
        text = msgspec.json.encode(data).decode()
    # What only Python writes: a set of a set, a number of hundreds of digits.
    except (TypeError, ValueError, OverflowError, RecursionError):
        text = str(data)[:_LONGEST_LITERAL]
    return JsonText(text, data, is_json=True)


def sensors_in(data: object) -> Iterator[tuple[str, JsonText]]:
    """Give each ``{'name': …, 'magnitude': …}`` in a value, with its name."""
    found = data if isinstance(data, list | tuple) else [data]
    for item in found[:_MOST_SENSORS]:
        sensor = _unpack_sensor(item)
        name = sensor.get("name") if isinstance(sensor, dict) else None
        if isinstance(name, str) and name.strip():
            yield name.strip(), payload_of(sensor)


def pixels_of_event(data: object, path: str) -> Pixels:
    """Read the picture in a value: JPEG or PNG, as bytes or base64.

    Raises:
        FieldError: there is none.

    """
    for step in parse_json_path(path):
        try:
            data = data[step]  # type: ignore[index]
        except (LookupError, TypeError):
            raise FieldError(path, "is not in the event") from None
    if isinstance(data, list | tuple) and len(data) == 1:
        data = data[0]
    if isinstance(data, str):
        # As a browser writes it, ``data:image/jpeg;base64,…``, and as Python does, ``b'…'``.
        text = data.rpartition(",")[2].removeprefix("b'").rstrip("'")
        try:
            data = base64.b64decode(text, validate=True)
        except (binascii.Error, ValueError):
            raise FieldError(path, "a picture is bytes or base64") from None
    if not isinstance(data, bytes):
        raise FieldError(path, "a picture is bytes or base64")
    if data.startswith(_PNG):
        return _png_pixels(data)
    # By its head alone, before anything is made of the size that it claims.
    jpeg_size(_Encoded("jpeg", data))
    return pixels_in(data)


def _png_pixels(data: bytes) -> Pixels:
    try:
        from talaia.gateway.video.h264 import png_pixels
    except ImportError:
        raise FieldError("format", "PNG needs PyAV: install talaia[camera]") from None
    # Its size stands at the same place in every PNG; checked before anything is made of it.
    width, height = int.from_bytes(data[16:20]), int.from_bytes(data[20:24])
    if width * height > MOST_PIXELS:
        raise FieldError("data", f"{width}x{height} pixels are more than {MOST_PIXELS}")
    return png_pixels(data)


def _unpack_sensor(item: object) -> object:
    for _ in range(_DEEPEST):
        if isinstance(item, str):
            item = _read_text(item)
        match item:
            case {"name": _}:
                break
            case {"data": inner} | [inner]:
                item = inner
            case _:
                break
    return item


def _read_text(text: str) -> object:
    """Read JSON, or a list or dictionary as Python writes it; other text stays what it is."""
    try:
        return decode_nested(text)
    except ValueError:
        pass
    if len(text) > _LONGEST_LITERAL or not text.lstrip().startswith(("{", "[")):
        return text
    try:
        # Literals only: names and calls are refused, so nothing of it is run.
        read: object = ast.literal_eval(text.strip())
        check_depth(text, read)
    except (ValueError, SyntaxError, TypeError, MemoryError, RecursionError):
        return text
    return read
