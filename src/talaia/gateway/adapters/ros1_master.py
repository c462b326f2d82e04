"""Questions to a ROS 1 master (XML-RPC), each with a bound in time. Called on worker threads.

https://wiki.ros.org/ROS/Master_API
"""

from __future__ import annotations

import http.client

# The master is the robot itself; expat refuses entities that grow.
import xmlrpc.client
from typing import TYPE_CHECKING, NamedTuple, cast

from talaia.gateway.errors import AdapterLost

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["Graph", "Master"]

_WAIT_S = 1.0


class _Transport(xmlrpc.client.Transport):
    """HTTP that does not wait for ever."""

    def make_connection(self, host: tuple[str, dict[str, str]] | str) -> http.client.HTTPConnection:
        """Make one, and keep it so that it can be closed."""
        connection = http.client.HTTPConnection(
            host if isinstance(host, str) else host[0], timeout=_WAIT_S
        )
        self._connection = host, connection
        return connection


class Graph(NamedTuple):
    """What is there, each with its nodes: topics published, topics heard, and services."""

    published: Mapping[str, frozenset[str]]
    heard: Mapping[str, frozenset[str]]
    services: Mapping[str, frozenset[str]]


class Master:
    """A master at an address."""

    def __init__(self, uri: str) -> None:
        """Take ``http://host:port``."""
        self.uri = uri

    def _ask(self, method: str, *words: str) -> tuple[int, object]:
        try:
            # Anew for each question: an old connection may hang on a master that is gone.
            with xmlrpc.client.ServerProxy(self.uri, transport=_Transport()) as proxy:
                answer = getattr(proxy, method)("/talaia", *words)
            code, _, value = cast("tuple[int, str, object]", answer)
        except (OSError, http.client.HTTPException, xmlrpc.client.Error) as error:
            raise AdapterLost(f"no ROS master answers at {self.uri} ({error})") from error
        except (TypeError, ValueError) as error:
            raise AdapterLost(f"what answers at {self.uri} is no ROS master") from error
        return code, value

    def check(self) -> None:
        """Say that it is there.

        Raises:
            AdapterLost: it is not.

        """
        self._ask("getPid")

    def knows(self, node: str) -> bool:
        """Tell whether a node is registered; one that began anew knows none.

        Raises:
            AdapterLost: it is not there.

        """
        return self._ask("lookupNode", node)[0] == 1

    def lives(self, node: str) -> bool:
        """Ask a node itself, at the address that the master has of it.

        https://wiki.ros.org/ROS/Slave_API

        Raises:
            AdapterLost: the master is not there.

        """
        code, where = self._ask("lookupNode", node)
        if code != 1:
            return False
        try:
            with xmlrpc.client.ServerProxy(str(where), transport=_Transport()) as proxy:
                proxy.getPid("/talaia")
        except (OSError, ValueError, http.client.HTTPException, xmlrpc.client.Error):
            return False
        return True

    def graph(self) -> Graph:
        """Tell what is registered.

        Raises:
            AdapterLost: it is not there.

        """
        _, value = self._ask("getSystemState")
        try:
            parts = cast("list[list[tuple[str, list[str]]]]", value)
            return Graph(
                *({str(name): frozenset(map(str, nodes)) for name, nodes in part} for part in parts)
            )
        except (TypeError, ValueError) as error:
            raise AdapterLost(f"what answers at {self.uri} is no ROS master") from error
