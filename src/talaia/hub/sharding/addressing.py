"""What a request says about which site it is about. Pure."""

from __future__ import annotations

import re
from enum import Enum, auto
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import parse_qsl

from talaia.wire.gateway_proof import read_proof

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from typing import Any

__all__ = ["Address", "AskedObject", "read_address"]

_SITE_ROUTE = re.compile(r"/api/sites/([^/]+)(?:/.*)?")
_CLIENT_SOCKET = re.compile(r"/clients/[^/]+/([^/]+)")
_GATEWAY_ROUTE = re.compile(r"/api/gateways/([0-9]{1,18})/.*")
_MEDIA = ("/ws/media", "/ws/media/unblurred", "/ws/topic")
# Its client says its site in the query, at each request of a session.
_SOCKETIO = "/socket.io/"
# Of a query that names a site.
_MOST_QUERY = 8_192


class AskedObject(Enum):
    """What a request is about."""

    # Whatever is done once for all sites.
    HUB = auto()
    # A site, by its name.
    SITE = auto()
    # A site whose gateway comes, by its name; it may be new.
    NEW_SITE = auto()
    # A site, by the key that its gateway says.
    KEY = auto()
    # A site, by the number of its gateway.
    GATEWAY = auto()
    # All sites: a page's socket.
    PAGE = auto()


class Address(NamedTuple):
    """What a request is about, and the name, key or number by which it says so."""

    about: AskedObject
    name: str = ""


def read_address(scope: Mapping[str, Any]) -> Address:
    """Tell what an ASGI request is about, by its path, its query or who comes.

    Routes of the hub that are merged of what all shards answer are `AskedObject.HUB` here.
    """
    path: str = scope["path"]
    if path.startswith("/gateway/"):
        return _read_gateway(scope.get("headers", ()))
    if scope["type"] == "websocket":
        if path == "/ws":
            return Address(AskedObject.PAGE)
        if path in _MEDIA or path == _SOCKETIO:
            return _of_site(_site_of_query(scope.get("query_string", b"")))
        found = _CLIENT_SOCKET.fullmatch(path)
        return _of_site(found[1] if found else "")
    if path == _SOCKETIO:
        return _of_site(_site_of_query(scope.get("query_string", b"")))
    # Servers give the path decoded; a slash in a name would be none of ours.
    for pattern, about in ((_SITE_ROUTE, AskedObject.SITE), (_GATEWAY_ROUTE, AskedObject.GATEWAY)):
        found = pattern.fullmatch(path)
        if found:
            return Address(about, found[1])
    return Address(AskedObject.HUB)


def _of_site(name: str) -> Address:
    return Address(AskedObject.SITE, name) if name else Address(AskedObject.HUB)


def _read_gateway(headers: Iterable[tuple[bytes, bytes]]) -> Address:
    said = next((value for name, value in headers if name == b"authorization"), b"")
    header = said.decode("latin-1")
    proof = read_proof(header)
    if proof is not None:
        return Address(AskedObject.NEW_SITE, proof.site)
    kind, _, key = header.partition(" ")
    if kind.lower() == "bearer" and key.strip():
        return Address(AskedObject.KEY, key.strip())
    return Address(AskedObject.HUB)


def _site_of_query(query: bytes) -> str:
    if len(query) > _MOST_QUERY:
        return ""
    pairs = parse_qsl(query.decode("latin-1"), keep_blank_values=True)
    # As the routes read it: the last of several counts.
    return dict(pairs).get("site", "")
