"""Lists of all sites, put together of what each shard answers for its own. Pure.

Each takes the bodies of all that answered, the main shard's first, and gives one as a hub with all
sites would. Rows stay the bytes they are, but for those of which several make one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

__all__ = [
    "join_client_protocols",
    "join_commands",
    "join_devices",
    "join_gateways",
    "join_releases",
    "join_rollouts",
    "join_sites",
    "join_storage",
    "read_rollout",
]

# As JSON has it: what is not looked at is handed on.
_Row = dict[str, Any]


class _OfSite(msgspec.Struct):
    """Of a row: which site it is about, and its number where rows have one."""

    site: str
    id: str = "0"


class _DeviceList(msgspec.Struct):
    devices: list[msgspec.Raw]


class _GatewayList(msgspec.Struct):
    gateways: list[msgspec.Raw]
    codes: list[msgspec.Raw]


class _ProtocolList(msgspec.Struct):
    protocols: list[_Row]
    drivers: list[msgspec.Raw]


class _CommandList(msgspec.Struct):
    commands: list[_Row]


class _ReleaseList(msgspec.Struct):
    releases: list[_Row]
    gateways: list[msgspec.Raw]
    rollout: _Row | None


class _NumberedRow(NamedTuple):
    site: str
    number: int
    raw: msgspec.Raw


_encode = msgspec.json.Encoder().encode


def join_sites(bodies: Sequence[bytes]) -> bytes:
    """Join lists of sites, by name."""
    rows = [row for body in bodies for row in msgspec.json.decode(body, type=list[msgspec.Raw])]
    return _encode(_by_site(rows))


def join_devices(bodies: Sequence[bytes]) -> bytes:
    """Join lists of devices, by the names of their sites."""
    read = [msgspec.json.decode(body, type=_DeviceList) for body in bodies]
    return _encode(_DeviceList(_by_site(row for one in read for row in one.devices)))


def join_gateways(bodies: Sequence[bytes]) -> bytes:
    """Join lists of gateways, by site and the newest first, and of codes, the newest first."""
    read = [msgspec.json.decode(body, type=_GatewayList) for body in bodies]
    gateways = [_numbered(row) for one in read for row in one.gateways]
    codes = [_numbered(row) for one in read for row in one.codes]
    return _encode(
        _GatewayList(
            [row.raw for row in sorted(gateways, key=lambda row: (row.site, -row.number))],
            [row.raw for row in sorted(codes, key=lambda row: -row.number)],
        )
    )


def join_commands(bodies: Sequence[bytes]) -> bytes:
    """Join commands that sites have in common: the same one of several shards becomes one."""
    alike: dict[object, list[_Row]] = {}
    for body in bodies:
        for row in msgspec.json.decode(body, type=_CommandList).commands:
            alike.setdefault(_command_key(row), []).append(row)
    joined = [_join_alike(rows) if len(rows) > 1 else rows[0] for rows in alike.values()]
    # Last by their first site: so a hub with all sites meets them.
    joined.sort(
        key=lambda row: (
            -len(row["sites"]),
            row["device"],
            row["command"]["id"],
            _first_site(row),
        )
    )
    return _encode(_CommandList(joined))


def join_client_protocols(bodies: Sequence[bytes]) -> bytes:
    """Join which protocols are open: the main shard's word, with clients and brokers of all."""
    joined, *others = (msgspec.json.decode(body, type=_ProtocolList) for body in bodies)
    for other in others:
        theirs = {row["protocol"]: row for row in other.protocols}
        for row in joined.protocols:
            # A shard of another version may not know it.
            if same := theirs.get(row["protocol"]):
                row["connected"] += same["connected"]
                row["brokers"] += same["brokers"]
    return _encode(joined)


def join_storage(bodies: Sequence[bytes]) -> bytes:
    """Join what histories take, in whole or in short: the room of all, and the nearest end."""
    read = [msgspec.json.decode(body, type=_Row) for body in bodies]
    joined = dict(read[0])
    # Where something is full first, that is what is told of the future.
    ends = [one for one in read if one["full_us"] is not None]
    soonest = min(ends, key=lambda one: one["full_us"], default=read[0])
    for name in ("full_us", "by_limit", "oldest_us"):
        if name in joined:
            joined[name] = soonest[name]
    for name, join in _STORAGE.items():
        if name in joined:
            joined[name] = join([one[name] for one in read])
    return _encode(joined)


def join_releases(bodies: Sequence[bytes]) -> bytes:
    """Join what is known of releases: files by name, gateways by site, and the last rollout."""
    read = [msgspec.json.decode(body, type=_ReleaseList) for body in bodies]
    files = {row["name"]: row for one in reversed(read) for row in one.releases}
    # Hubs may share the folder, and each lists it in its own order: the main shard's goes first.
    order = dict.fromkeys(row["name"] for one in read for row in one.releases)
    gateways = _by_site(row for one in read for row in one.gateways)
    rollouts = [one.rollout for one in read if one.rollout is not None]
    joined = _ReleaseList([files[name] for name in order], gateways, join_rollouts(rollouts))
    return _encode(joined)


def read_rollout(body: bytes) -> _Row | None:
    """Give the last rollout that a shard's answer about releases has."""
    return msgspec.json.decode(body, type=_ReleaseList).rollout


def _by_site(rows: Iterable[msgspec.Raw]) -> list[msgspec.Raw]:
    numbered = [_numbered(row) for row in rows]
    return [row.raw for row in sorted(numbered, key=lambda row: row.site)]


def _numbered(raw: msgspec.Raw) -> _NumberedRow:
    about = msgspec.json.decode(raw, type=_OfSite)
    return _NumberedRow(about.site, int(about.id), raw)


def _command_key(row: _Row) -> object:
    """Tell by what commands are the same: see `list_shared_commands`."""
    arguments = (
        (argument["id"], argument["type"], argument["unit"])
        for argument in row["command"]["arguments"]
    )
    return row["device"], row["command"]["id"], tuple(sorted(arguments))


def _first_site(row: _Row) -> str:
    first: str = min(row["sites"] + row["barred"])
    return first


def _join_alike(alike: list[_Row]) -> _Row:
    """Make one of the same command of several shards: what all their sites take."""
    # Names are those of the first site, as where one hub has all.
    first = min(alike, key=_first_site)
    shapes = [row["command"] for row in alike]
    arguments = [
        _join_arguments(argument, [_argument_of(shape, argument["id"]) for shape in shapes])
        for argument in first["command"]["arguments"]
    ]
    shape = {
        **first["command"],
        "arguments": arguments,
        "confirm": any(shape["confirm"] for shape in shapes),
        "cancellable": all(shape["cancellable"] for shape in shapes),
        "timeout": max(shape["timeout"] for shape in shapes),
    }
    return {
        **first,
        "command": shape,
        "sites": sorted(site for row in alike for site in row["sites"]),
        "barred": sorted(site for row in alike for site in row["barred"]),
    }


def _argument_of(shape: _Row, name: str) -> _Row:
    found: _Row = next(argument for argument in shape["arguments"] if argument["id"] == name)
    return found


def _join_arguments(first: _Row, alike: list[_Row]) -> _Row:
    least = [argument["minimum"] for argument in alike if argument["minimum"] is not None]
    most = [argument["maximum"] for argument in alike if argument["maximum"] is not None]
    same = all(argument["default"] == first["default"] for argument in alike)
    return {
        **first,
        "minimum": max(least, default=None),
        "maximum": min(most, default=None),
        "max_length": min(argument["max_length"] for argument in alike),
        "default": first["default"] if same else None,
    }


def join_rollouts(rollouts: list[_Row]) -> _Row | None:
    """Make one of what was asked for at once, of the newest release that was handed out."""
    if not rollouts:
        return None
    newest = max(rollouts, key=lambda one: one["began_us"])
    same = [one for one in rollouts if one["version"] == newest["version"]]
    return {
        **newest,
        "began_us": min(one["began_us"] for one in same),
        "runs": any(one["runs"] for one in same),
        "stopped": next((one["stopped"] for one in same if one["stopped"]), ""),
        "sites": [site for one in same for site in one["sites"]],
    }


def _worst_warning(warnings: list[str]) -> str:
    """Give the first of the words of `Warn` that is said by any, the worst first."""
    return next(word for word in ("full", "soon", "limit", "") if word in warnings)


def _join_sentences(said: list[str]) -> str:
    return "; ".join(dict.fromkeys(sentence for sentence in said if sentence))


def _join_channels(lists: list[list[Any]]) -> list[Any]:
    return [channel for one in lists for channel in one]


def _least_known(numbers: list[float | None]) -> float | None:
    return min((number for number in numbers if number is not None), default=None)


_STORAGE: dict[str, Callable[[list[Any]], object]] = {
    "place": _join_sentences,
    "database_bytes": sum,
    "spare_bytes": sum,
    "blocks_bytes": sum,
    # Each history has its own.
    "limit_bytes": sum,
    "day_bytes": sum,
    "kept_days": _least_known,
    "warn": _worst_warning,
    "trouble": _join_sentences,
    "files_trouble": _join_sentences,
    "channels": _join_channels,
}
