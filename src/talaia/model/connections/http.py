"""A server that answers with JSON or plain text, asked again and again."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from talaia.model.base import Shape, SourceShape
from talaia.model.camera_addresses import NO_ADDRESS, why_no_camera
from talaia.model.checks.identifiers import Finding
from talaia.model.closed_lists import SignalType
from talaia.model.connections.addresses import url_fits
from talaia.model.connections.json_path import json_path_fits
from talaia.model.connections.kinds import ConnectionKind
from talaia.model.connections.rules import KindRules

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Signal

__all__ = ["HttpConnection", "HttpRules", "HttpSource"]

# What stands in the first line of a request: no blank, no control character, no second host.
_REQUEST = re.compile(r"/(?!/)[!-~]{0,999}\Z")
_POLL_S = (0.1, 86_400)
_TIMEOUT_S = (0.1, 120)


class HttpConnection(Shape, frozen=True, kw_only=True, tag_field="kind", tag="http"):
    """A server whose addresses are asked for with GET, again and again.

    Attributes:
        url: its root, ``https://station.local``, to which a source's ``get`` is added; without a
            password.
        poll: each address is asked for so often (s).
        timeout: what has not answered whole by then counts as failed (s).
        user: whom the server asks for (HTTP basic); empty for nobody.
        password_file: a file that holds that user's password.
        token_file: a file that holds what is sent as ``Authorization: Bearer``; empty for none.
        token_env: a variable that holds it, instead of a file.
        ca: file of certificate authorities for ``https://``; empty takes the system's.
        here: the server may run on the gateway's own computer (``127.0.0.1``), which is refused
            otherwise.

    """

    url: str
    poll: float = 5.0
    timeout: float = 5.0
    user: str = ""
    password_file: str = ""
    token_file: str = ""
    token_env: str = ""
    ca: str = ""
    here: bool = False


class HttpSource(SourceShape, frozen=True, kw_only=True, tag="http"):
    """Where a signal comes from that a server answers.

    Attributes:
        get: what is asked for, ``/api/weather?units=metric``; asking it must change nothing.
        path: the field of the JSON in the answer, ``wind.speed`` or ``$.sensors[0].value``; empty
            where the whole answer is the value.

    """

    get: str = ""
    path: str = ""


class HttpRules(KindRules[HttpConnection, HttpSource]):
    """Checks what is described of a server that is asked."""

    kind = ConnectionKind.HTTP
    source = HttpSource
    example = "get: /api/weather, path: wind.speed"

    def __init__(self, connection: HttpConnection) -> None:
        """Answer for this connection."""
        super().__init__(connection, HttpSource)

    def own_findings(self, where: str) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        connection = self.connection
        findings = [
            *url_fits(f"{where}.url", connection.url, ("http", "https"), example="station.local")
        ]
        yield from findings
        if not findings:
            yield from self._root_fits(f"{where}.url", connection.url)
        for key, (low, high) in (("poll", _POLL_S), ("timeout", _TIMEOUT_S)):
            found = getattr(connection, key)
            # Written so that NaN is found as well.
            if not low <= found <= high:
                yield Finding(f"{where}.{key}", f"expected {low:g} to {high:g} s, found {found:g}")
        secrets = [
            key for key in ("password_file", "token_file", "token_env") if getattr(connection, key)
        ]
        # Which of two secrets was meant nobody can tell.
        if len(secrets) > 1:
            yield Finding(f"{where}.{secrets[1]}", f"{secrets[0]} is given, too", "leave one out")
        if bool(connection.user) is not bool(connection.password_file):
            missing = "password_file" if connection.user else "user"
            yield Finding(f"{where}.{missing}", "user and password_file go together", "write both")
        if ":" in connection.user:
            yield Finding(f"{where}.user", "no user of HTTP basic has a colon in the name")
        if connection.ca and not connection.url.startswith("https:"):
            problem = "only https:// has certificates"
            yield Finding(f"{where}.ca", problem, "write https:// in the url, or leave it out")

    def _root_fits(self, where: str, url: str) -> Iterator[Finding]:
        parts = urlsplit(url)
        if parts.query or parts.fragment or not _REQUEST.match(parts.path or "/"):
            yield Finding(where, "it is not the root of a server", "write: https://station.local")
        # A name is looked up, and checked likewise, each time it is asked.
        why = why_no_camera(parts.hostname or "", here=self.connection.here)
        if why and why != NO_ADDRESS:
            remedy = "write here: true at the connection, if it is meant"
            yield Finding(where, f"no server is asked at {parts.hostname}, {why}", remedy)

    def signal_fits(self, where: str, signal: Signal, source: HttpSource) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        if signal.type is SignalType.POSITION:
            yield self.no_positions(where)
        if not _REQUEST.match(source.get):
            problem = f"{source.get[:80]!r} is not what can be asked for"
            # Often the whole address, whose root stands at the connection.
            behind = source.get.partition("://")[2].partition("/")[2] or source.get
            near = f"/{behind}" if _REQUEST.match(f"/{behind}") else ""
            as_written = near if near.strip("/") else "/api/weather?units=metric"
            if not source.get:
                problem = "which address of the server is meant?"
            remedy = f"write it behind the server's root: get: {as_written}"
            yield Finding(f"{where}.get", problem, remedy)
        yield from json_path_fits(f"{where}.path", source.path)
