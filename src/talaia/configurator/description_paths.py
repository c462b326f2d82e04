"""Places in a description: a path of keys, the value there, and a description with another.

A `Path` is ``("devices", "base", "signals", "speed", "unit")``, as findings write it
``$.devices.base.signals.speed.unit``. The empty path is the whole site.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, cast

import msgspec

from talaia.configurator.errors import NoSuchPlace
from talaia.model.connection import RosSource, SourceShape, kind_of, rules_of
from talaia.model.yaml_text.source_tags import SOURCE_KEYS, plain_of, source_of_plain

if TYPE_CHECKING:
    from talaia.model.site import Site, Source

__all__ = ["Path", "Spot", "find_spot", "new_source", "remove_value", "value_at", "with_value"]

Path = tuple[str, ...]


class Spot(NamedTuple):
    """Where a finding points.

    Attributes:
        node: path of the thing (a device, a signal …; empty for the site), which a tree can select.
        field: path inside the thing: ``("source", "topic")``; empty for the thing as a whole.

    """

    node: Path
    field: Path


def value_at(site: Site, path: Path) -> object:
    """Give the value at a path.

    Raises:
        NoSuchPlace: there is none.

    """
    value: object = site
    for step in path:
        value = _child_at(value, step, path)
    return value


def _child_at(value: object, step: str, path: Path) -> object:
    if isinstance(value, dict) and step in value:
        inner: object = value[step]
        return inner
    if isinstance(value, msgspec.Struct) and step in value.__struct_fields__:
        return getattr(value, step)
    raise NoSuchPlace(f"the description has nothing at {'.'.join(('$', *path))}")


def with_value(site: Site, path: Path, value: object) -> Site:
    """Give the site with ``value`` at ``path``; a new key of a mapping comes last.

    Raises:
        NoSuchPlace: what the path goes through is not there.

    """
    made = _replace_value(site, path, value, path)
    assert isinstance(made, type(site))  # noqa: S101 - the same type comes out
    return _with_fitting_sources(made, path)


def _replace_value(value: object, rest: Path, new: object, path: Path) -> object:
    if not rest:
        return new
    step, *more = rest
    last = len(rest) == 1
    if isinstance(value, dict) and (last or step in value):
        # A copy with one key changed: all sites of before stay what they are, for undo.
        return {**value, step: _replace_value(value.get(step), tuple(more), new, path)}
    # A source's keys depend on its protocol, and another key may make another protocol of it.
    if isinstance(value, SourceShape) and last:
        if step not in SOURCE_KEYS:
            raise NoSuchPlace(f"the description has nothing at {'.'.join(('$', *path))}")
        return _source_with(value, step, new)
    inner = _replace_value(_child_at(value, step, path), tuple(more), new, path)
    assert isinstance(value, msgspec.Struct)  # noqa: S101 - `_child_at` knows dicts and structs
    return msgspec.structs.replace(value, **{step: inner})


def new_source(site: Site, device: str) -> Source:
    """Give an empty source of the connection by which a device is reached."""
    link = site.links().get(site.connection_of(device)) if device in site.devices else None
    shape = RosSource if link is None else rules_of(link).source
    return cast("Source", shape())


def _source_with(source: SourceShape, key: str, new: object) -> Source:
    """Give a source with another value, whichever protocol's key it is."""
    plain = cast("dict[str, object]", plain_of(source))
    return source_of_plain({**plain, key: msgspec.to_builtins(new)}, None)


def _with_fitting_sources(site: Site, path: Path) -> Site:
    """Let what a change touched be sources of their device's connection, as when it is read."""
    if len(path) < 3 or path[0] != "devices":
        return site
    device = site.devices[path[1]]
    link = site.links().get(site.connection_of(path[1]))
    # One key of one source: devices, its name, the group, its name, source, the key.
    if len(path) == 6 and path[4] == "source":
        places: list[Path] = [path[:5]]
    # Another connection: every source of the device may mean something else now.
    elif path[2:] == ("connection",):
        places = [("devices", path[1], "signals", signal, "source") for signal in device.signals]
        places += [("devices", path[1], "streams", stream, "source") for stream in device.streams]
    else:
        return site
    # As if the file were read again: the keys decide, and a source left empty follows the
    # connection.
    for place in places:
        plain = cast("dict[str, object]", plain_of(value_at(site, place)))
        source = source_of_plain(plain, None if link is None else kind_of(link))
        made = _replace_value(site, place, source, place)
        assert isinstance(made, type(site))  # noqa: S101 - the same type comes out
        site = made
    return site


def remove_value(site: Site, path: Path) -> Site:
    """Give the site without the key of a mapping, or with none where a shape may be left out.

    Raises:
        NoSuchPlace: there is nothing.

    """
    # Only to be refused when there is nothing.
    value_at(site, path)
    parent = value_at(site, path[:-1])
    if isinstance(parent, dict):
        return with_value(
            site, path[:-1], {key: child for key, child in parent.items() if key != path[-1]}
        )
    # A key of a shape is not taken out but set to none, which the model writes as left out.
    return with_value(site, path, None)


def find_spot(site: Site, where: str) -> Spot:
    """Find the thing and the field that a finding's ``where`` points to.

    As much of it as is there: a finding about a missing key leads to the thing that misses it.
    Keys are followed as they are, with dots in them if they have some.
    """
    rest = where.removeprefix("$")
    value: object = site
    node: Path = ()
    field: Path = ()
    while rest.startswith("."):
        rest = rest[1:]
        step = _matching_key(value, rest)
        if step is None:
            word = rest.split(".", 1)[0].split("[", 1)[0]
            # A key of the thing that is not set, or one that no shape has.
            field = (*field, word) if word and isinstance(value, msgspec.Struct) else field
            break
        rest = rest[len(step) :]
        # A thing is what a mapping holds, or a shape of `_OWN`; all else is a field of it.
        was, value = value, _child_at(value, step, (step,))
        field = (*field, step)
        if isinstance(was, dict) or (isinstance(value, msgspec.Struct) and step in _OWN):
            node, field = (*node, *field), ()
    return Spot(node, _without_mapping(value, field))


# Shapes inside a shape that a tree shows as things of their own.
_OWN = frozenset({"drive", "ros2"})


def _without_mapping(value: object, field: Path) -> Path:
    """A whole mapping (``signals``) is no field; its thing is what can be shown."""
    inner = next(iter(value.values()), None) if isinstance(value, dict) else None
    return field[:-1] if isinstance(inner, msgspec.Struct) else field


def _matching_key(value: object, rest: str) -> str | None:
    keys = value if isinstance(value, dict) else getattr(value, "__struct_fields__", ())
    fits = [
        key
        for key in keys
        if rest.startswith(key) and rest[len(key) : len(key) + 1] in ("", ".", "[")
    ]
    # The longest: of the keys "a" and "a.b" the second is meant where both fit.
    return max(fits, key=len, default=None)
