"""How a publisher of ROS 1 describes what it publishes, asked without a subscription.

The header that comes before any message is read, and then the connection is closed: the master is
told of no subscriber. https://wiki.ros.org/ROS/TCPROS
"""

from __future__ import annotations

import http.client
import socket
import struct
import xmlrpc.client
from typing import TYPE_CHECKING, NamedTuple, cast

from talaia.gateway.adapters.ros1.master import WAIT_S, Transport, fields_of, header_of, read_rest

if TYPE_CHECKING:
    from talaia.gateway.adapters.ros1.master import RosMaster

__all__ = ["Publication", "ask_publisher"]

# The longest definitions have some hundred thousand letters.
_MOST_HEADER = 1024 * 1024
_SIZE = struct.Struct("<I")


class Publication(NamedTuple):
    """What a publisher says of a topic.

    Attributes:
        type: ``package/Name``.
        md5: of the type's definition.
        definition: its text and those of the types in it; empty where the publisher has none.
        latched: who comes later gets its last message, too.

    """

    type: str
    md5: str
    definition: str
    latched: bool


def ask_publisher(master: RosMaster, node: str, topic: str) -> Publication | None:
    """Ask a node what it publishes under a topic; None where it does not answer.

    Raises:
        AdapterLost: the master is not there.

    """
    where = master.find_node(node)
    if not where:
        return None
    try:
        with xmlrpc.client.ServerProxy(where, transport=Transport()) as proxy:
            answer = proxy.requestTopic("/talaia", topic, [["TCPROS"]])
        code, _, offered = cast("tuple[int, str, tuple[str, str, int]]", answer)
        if code != 1:
            return None
        _, host, port = offered
        with socket.create_connection((host, port), WAIT_S) as asked:
            fields = {"callerid": "/talaia", "topic": topic, "md5sum": "*", "type": "*"}
            asked.sendall(header_of(fields))
            size = _SIZE.unpack(read_rest(asked, _SIZE.size))[0]
            said = fields_of(read_rest(asked, min(size, _MOST_HEADER)))
    except (OSError, TypeError, ValueError, struct.error):
        return None
    except (http.client.HTTPException, xmlrpc.client.Error):
        return None
    if "md5sum" not in said or "/" not in said.get("type", ""):
        return None
    return Publication(
        said["type"],
        said["md5sum"],
        said.get("message_definition", ""),
        said.get("latching", "0") == "1",
    )
