"""Which kind of source stands in a description: told by the device's connection, never written.

The model has one shape of source for each protocol, told apart by a tag; a person's file has none,
for the connection says it already. So the tag is put in when a description is read and taken out
when it is written.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, get_args

import msgspec

from talaia.model.base import FOREIGN_KEYS, SOURCE_TAG
from talaia.model.connection import (
    RULES,
    ConnectionKind,
    DerivedSource,
    DetectionSource,
    Source,
    SourceShape,
    own_keys,
)
from talaia.model.site import Device, Signal, Site, Stream

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

__all__ = [
    "SOURCES",
    "SOURCE_KEYS",
    "connection_kinds",
    "devices_of_plain",
    "kind_of_device",
    "plain_of",
    "source_of_plain",
    "with_tags",
]

SOURCES: tuple[type[SourceShape], ...] = get_args(Source)
SOURCE_KEYS = frozenset(key for shape in SOURCES for key in own_keys(shape))
# Keys whose source, where they say something, does not go by the connection.
_OF_DETECTION = ("stream", "sees")
_OF_DERIVATION = "expression"
# As good as not written.
_EMPTY: tuple[object, ...] = ("", {}, False, None)


def with_tags(document: dict[str, object]) -> dict[str, object]:
    """Give the plain values of a description with a tag in each source.

    What is not of the right shape is left as it is: whoever makes a `Site` of it complains.
    """
    if not isinstance(document.get("devices"), dict):
        return document
    tag_device = _device_with(connection_kinds(document))
    return {**document, "devices": _map_values(document["devices"], tag_device)}


def devices_of_plain(document: object) -> dict[str, Device]:
    """Make devices, by name, of plain values; each source is what its own keys say.

    Raises:
        msgspec.ValidationError: they are none.

    """
    return msgspec.convert(_map_values(document, _device_with({})), dict[str, Device])


def connection_kinds(document: Mapping[str, object]) -> dict[str, ConnectionKind]:
    """Tell the protocol of each connection by name, of those where it is clear."""
    kinds = {"ros2": ConnectionKind.ROS2} if document.get("ros2") is not None else {}
    connections = document.get("connections")
    for name, connection in (connections if isinstance(connections, dict) else {}).items():
        said = connection.get("kind") if isinstance(connection, dict) else None
        if said in RULES:
            kinds[name] = ConnectionKind(said)
    return kinds


def kind_of_device(device: object, kinds: Mapping[str, ConnectionKind]) -> ConnectionKind | None:
    """Tell by which protocol a device is reached; none where that is not clear."""
    named = device.get("connection") if isinstance(device, dict) else None
    if named:
        return kinds.get(named) if isinstance(named, str) else None
    return next(iter(kinds.values())) if len(kinds) == 1 else None


def source_of_plain(source: dict[str, object], kind: ConnectionKind | None) -> Source:
    """Make a source of plain values, as it would be read from a file.

    Raises:
        msgspec.ValidationError: it is none.

    """
    made: Source = msgspec.convert(_tag_source(source, kind), Source)
    return made


def _device_with(kinds: Mapping[str, ConnectionKind]) -> Callable[[object], object]:
    def tagged(device: object) -> object:
        if not isinstance(device, dict):
            return device
        kind = kind_of_device(device, kinds)

        def sourced(thing: object) -> object:
            if not isinstance(thing, dict) or not isinstance(thing.get("source"), dict):
                return thing
            return {**thing, "source": _tag_source(thing["source"], kind)}

        made = dict(device)
        for group in ("signals", "streams"):
            if group in made:
                made[group] = _map_values(made[group], sourced)
        if isinstance(made.get("frames"), dict):
            made["frames"] = _tag_source(made["frames"], kind)
        return made

    return tagged


def _map_values(mapping: object, change: Callable[[object], object]) -> object:
    if not isinstance(mapping, dict):
        return mapping
    return {key: change(value) for key, value in mapping.items()}


def _tag_source(source: dict[str, object], kind: ConnectionKind | None) -> dict[str, object]:
    # A key of another protocol that says nothing was never an error.
    said = {key for key in source.keys() & SOURCE_KEYS if source[key] not in _EMPTY}
    if not said and _OF_DERIVATION in source:
        # An empty expression says what was meant.
        said = {_OF_DERIVATION}
    shape = _shape_for(said, kind)
    own = own_keys(shape)
    foreign = {key: value for key, value in source.items() if key in said and key not in own}
    more: dict[str, object] = {FOREIGN_KEYS: foreign} if foreign else {}
    # What no protocol knows stays, and msgspec complains of it.
    mine = {key: value for key, value in source.items() if key in own or key not in SOURCE_KEYS}
    return {SOURCE_TAG: shape.__struct_config__.tag, **mine, **more}


def _shape_for(said: set[str], kind: ConnectionKind | None) -> type[SourceShape]:
    """Choose the source of the connection, unless all that is said is another one's.

    A device that is moved to another connection is so still read, and `check` says of each key
    that it does not fit.
    """
    if said.intersection(_OF_DETECTION):
        return DetectionSource
    if _OF_DERIVATION in said:
        return DerivedSource
    # Where it is not clear which connection is meant, ROS is the likeliest.
    usual = SOURCES[0] if kind is None else RULES[kind].source
    if said <= set(own_keys(usual)):
        return usual
    return next((shape for shape in SOURCES if said <= set(own_keys(shape))), usual)


def plain_of(value: object) -> object:
    """Give a site, or a part of it, as plain values for YAML and JSON, as people write them."""
    plain: object = msgspec.to_builtins(value)
    _untag_sources(value, plain)
    return plain


def _untag_sources(value: object, plain: object) -> None:
    if not isinstance(plain, dict):
        return
    # Only where sources can be: walking all of a large site would take far longer.
    match value:
        case Site():
            _untag_sources(value.devices, plain.get("devices", {}))
        case Device():
            _untag_sources(value.signals, plain.get("signals", {}))
            _untag_sources(value.streams, plain.get("streams", {}))
            _untag_sources(value.frames, plain.get("frames"))
        case Signal() | Stream():
            _untag_sources(value.source, plain["source"])
        case SourceShape():
            del plain[SOURCE_TAG]
            # Back beside the others, as they were written.
            plain.update(plain.pop(FOREIGN_KEYS, {}))
        case dict():
            for key, inner in value.items():
                _untag_sources(inner, plain[key])
        case _:
            pass
