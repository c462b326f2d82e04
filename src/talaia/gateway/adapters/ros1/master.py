"""Questions to a ROS 1 master (XML-RPC), each with a bound in time. Called on worker threads.

https://wiki.ros.org/ROS/Master_API
"""

from __future__ import annotations

import http.client
import socket
import struct

# The master is the robot itself; expat refuses entities that grow.
import xmlrpc.client
from typing import TYPE_CHECKING, NamedTuple, cast
from urllib.parse import urlsplit

from talaia.gateway.errors import AdapterLost

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = [
    "WAIT_S",
    "GraphState",
    "RosMaster",
    "Transport",
    "fields_of",
    "header_of",
    "read_rest",
]

# For each answer (s).
WAIT_S = 1.0
_MAX_HEADER = 64 * 1024
_SIZE = struct.Struct("<I")


class Transport(xmlrpc.client.Transport):
    """HTTP that does not wait for ever."""

    def make_connection(self, host: tuple[str, dict[str, str]] | str) -> http.client.HTTPConnection:
        """Make one, and keep it so that it can be closed."""
        connection = http.client.HTTPConnection(
            host if isinstance(host, str) else host[0], timeout=WAIT_S
        )
        self._connection = host, connection
        return connection


class GraphState(NamedTuple):
    """What is there, each with its nodes: topics published, topics heard, and services."""

    published: Mapping[str, frozenset[str]]
    heard: Mapping[str, frozenset[str]]
    services: Mapping[str, frozenset[str]]


class RosMaster:
    """A master at an address."""

    def __init__(self, uri: str) -> None:
        """Take ``http://host:port``."""
        self.uri = uri

    def _call_master(self, method: str, *words: str) -> tuple[int, object]:
        try:
            # Anew for each question: an old connection may hang on a master that is gone.
            with xmlrpc.client.ServerProxy(self.uri, transport=Transport()) as proxy:
                answer = getattr(proxy, method)("/talaia", *words)
            code, _, value = cast("tuple[int, str, object]", answer)
        except (OSError, http.client.HTTPException, xmlrpc.client.Error) as error:
            raise AdapterLost(f"no ROS master answers at {self.uri} ({error})") from error
        except (TypeError, ValueError) as error:
            raise AdapterLost(f"what answers at {self.uri} is no ROS master") from error
        return code, value

    def check_master(self) -> None:
        """Say that it is there.

        Raises:
            AdapterLost: it is not.

        """
        self._call_master("getPid")

    def knows_node(self, node: str) -> bool:
        """Tell whether a node is registered; one that began anew knows none.

        Raises:
            AdapterLost: it is not there.

        """
        return self._call_master("lookupNode", node)[0] == 1

    def find_node(self, node: str) -> str:
        """Give a node's own address; empty when the master knows none.

        Raises:
            AdapterLost: the master is not there.

        """
        code, where = self._call_master("lookupNode", node)
        return str(where) if code == 1 else ""

    def ping_node(self, node: str) -> bool:
        """Ask a node itself, at the address that the master has of it.

        https://wiki.ros.org/ROS/Slave_API

        Raises:
            AdapterLost: the master is not there.

        """
        where = self.find_node(node)
        if not where:
            return False
        try:
            with xmlrpc.client.ServerProxy(where, transport=Transport()) as proxy:
                proxy.getPid("/talaia")
        except (OSError, ValueError, http.client.HTTPException, xmlrpc.client.Error):
            return False
        return True

    def read_graph(self) -> GraphState:
        """Tell what is registered.

        Raises:
            AdapterLost: it is not there.

        """
        _, value = self._call_master("getSystemState")
        try:
            parts = cast("list[list[tuple[str, list[str]]]]", value)
            return GraphState(
                *({str(name): frozenset(map(str, nodes)) for name, nodes in part} for part in parts)
            )
        except (TypeError, ValueError) as error:
            raise AdapterLost(f"what answers at {self.uri} is no ROS master") from error

    def read_types(self) -> dict[str, str]:
        """Tell the types of topics, ``package/Name``; those that nobody has told are left out.

        Raises:
            AdapterLost: it is not there.

        """
        _, value = self._call_master("getTopicTypes")
        try:
            found = {str(topic): str(kind) for topic, kind in cast("list", value)}  # type: ignore[type-arg]
        except (TypeError, ValueError) as error:
            raise AdapterLost(f"what answers at {self.uri} is no ROS master") from error
        return {topic: kind for topic, kind in found.items() if kind != "*"}

    def parameter_names(self) -> tuple[str, ...]:
        """Tell the absolute names of all parameters.

        Raises:
            AdapterLost: it is not there.

        """
        _, value = self._call_master("getParamNames")
        if not isinstance(value, list):
            raise AdapterLost(f"what answers at {self.uri} is no ROS master")
        return tuple(str(name) for name in value)

    def read_parameter(self, name: str) -> tuple[bool, object]:
        """Tell whether a parameter is set, and its value.

        Raises:
            AdapterLost: the master is not there.

        """
        code, value = self._call_master("getParam", name)
        return code == 1, value

    def service_type(self, service: str) -> str:
        """Ask a service for its type, ``package/Name``; empty when it does not answer.

        Raises:
            AdapterLost: the master is not there.

        """
        code, uri = self._call_master("lookupService", service)
        where = urlsplit(str(uri))
        try:
            if code != 1 or not where.hostname or not where.port:
                return ""
            with socket.create_connection((where.hostname, where.port), WAIT_S) as asked:
                # ``probe``: only the header is exchanged, nothing is called.
                asked.sendall(
                    header_of(
                        {"callerid": "/talaia", "md5sum": "*", "probe": "1", "service": service}
                    )
                )
                size = _SIZE.unpack(read_rest(asked, _SIZE.size))[0]
                said = fields_of(read_rest(asked, min(size, _MAX_HEADER)))
        except (OSError, ValueError, struct.error):
            return ""
        return said.get("type", "")


def header_of(fields: dict[str, str]) -> bytes:
    """Write a connection header (https://wiki.ros.org/ROS/Connection%20Header)."""
    rows = [f"{key}={value}".encode() for key, value in fields.items()]
    body = b"".join(_SIZE.pack(len(row)) + row for row in rows)
    return _SIZE.pack(len(body)) + body


def fields_of(body: bytes) -> dict[str, str]:
    """Read a connection header without its size; what is damaged is left out."""
    found, at = {}, 0
    while at + _SIZE.size <= len(body):
        (size,) = _SIZE.unpack_from(body, at)
        at += _SIZE.size
        key, _, value = body[at : at + size].decode(errors="replace").partition("=")
        found[key] = value
        at += size
    return found


def read_rest(asked: socket.socket, size: int) -> bytes:
    """Read so many bytes; an `OSError` where they do not come."""
    data = b""
    while len(data) < size:
        more = asked.recv(size - len(data))
        if not more:
            raise OSError("it was cut short")
        data += more
    return data
