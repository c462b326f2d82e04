"""What of an ASGI request crosses to another hub, and by which lane. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from talaia.hub.cluster.bus import BusLane

if TYPE_CHECKING:
    from starlette.types import Scope

__all__ = ["lane_of", "pack_scope", "takes_shared", "unpack_scope"]

# Sockets of pictures, files and raw topics: whatever is large.
_LARGE = ("/ws/media", "/ws/topic", "/gateway/media", "/gateway/files")
# What is sent in answer to a socket that is not let in, as an HTTP answer.
_DENIAL = "websocket.http.response"
_WORDS = tuple(
    "type http_version method scheme path root_path raw_path query_string".split()  # noqa: SIM905
)


def lane_of(scope: Scope) -> BusLane:
    """Choose the lane: links of gateways, pages and clients drive robots, the rest is large."""
    is_urgent = scope["type"] == "websocket" and not scope["path"].startswith(_LARGE)
    return BusLane.URGENT if is_urgent else BusLane.BULK


def pack_scope(scope: Scope) -> dict[str, Any]:
    """Take what another hub needs to answer a request as if it had come there."""
    packed: dict[str, Any] = {word: scope[word] for word in _WORDS if word in scope}
    packed["headers"] = [list(header) for header in scope["headers"]]
    # The real asker, and the address that was dialled: limits and rules of hosts go by them.
    for word in ("client", "server"):
        packed[word] = list(scope[word]) if scope.get(word) else None
    packed["subprotocols"] = list(scope.get("subprotocols", ()))
    packed["denial"] = _DENIAL in scope.get("extensions", {})
    # Hubs of before this word know no frames that many sockets share.
    packed["shared"] = scope["type"] == "websocket"
    return packed


def takes_shared(packed: dict[str, Any]) -> bool:
    """Tell whether the hub that handed a request over hands frames on that many sockets share."""
    return packed.get("shared") is True


def unpack_scope(packed: dict[str, Any]) -> Scope:
    """Make an ASGI scope of what another hub has packed.

    Raises:
        KeyError: it is none.
        TypeError: the same.

    """
    scope: dict[str, Any] = {word: packed[word] for word in _WORDS if word in packed}
    kind = scope["type"]
    if kind not in {"http", "websocket"} or not isinstance(scope["path"], str):
        raise KeyError(kind)
    scope["asgi"] = {"version": "3.0", "spec_version": "2.4"}
    scope["headers"] = [(bytes(name), bytes(value)) for name, value in packed["headers"]]
    for word in ("client", "server"):
        scope[word] = tuple(packed[word]) if packed[word] else None
    if kind == "websocket":
        scope["subprotocols"] = packed["subprotocols"]
    scope["extensions"] = {_DENIAL: {}} if packed["denial"] else {}
    scope["state"] = {}
    return scope
