"""A message or request of the robot's types, as a client wrote it: JSON, or CDR. Pure."""

from __future__ import annotations

from talaia.wire.nested_json import decode_nested

__all__ = ["read_fields", "read_published"]


def read_fields(data: bytes) -> dict[str, object]:
    """Read JSON: fields by name; nothing is a message of which nothing is filled.

    Raises:
        ValueError: it is no such JSON.

    """
    try:
        read = decode_nested(data or b"{}")
    except ValueError as error:
        raise ValueError(f"not the fields of a message, by name: {str(error)[:200]}") from error
    if not isinstance(read, dict | None):
        raise ValueError(f"not the fields of a message, by name: {repr(read)[:100]}")  # noqa: TRY004 - of what a client said
    return read or {}


def read_published(encoding: str, kind: str, data: bytes) -> dict[str, object]:
    """Read a message in a client's encoding (``json`` or ``cdr``).

    Raises:
        ValueError: it is none, or of a type that is not known here and no JSON.

    """
    match encoding:
        case "json":
            return read_fields(data)
        case "cdr":
            return _read_cdr(kind, data)
        case _:
            raise ValueError(f"messages are read as json or cdr, not as {encoding[:100]!r}")


def _read_cdr(kind: str, data: bytes) -> dict[str, object]:
    from talaia.hub.clients.rosbridge.ros_types import read_known_message
    from talaia.hub.live.taps.type_texts import MessageUnreadable

    try:
        return read_known_message(kind, data)
    except MessageUnreadable as error:
        raise ValueError(str(error)) from error
