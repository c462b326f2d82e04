"""How messages are heard whose package is not installed: as bytes.

By whoever starts a robot: what makes such a class is the gateway's, which no simulator imports.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Callable

    from rclpy.node import Node

__all__ = ["RawListening"]


class RawListening(Protocol):
    """Subscribes to a topic by the name of its type."""

    def __call__(
        self, node: Node, topic: str, kind: tuple[str, str], hear: Callable[[bytes], None], /
    ) -> bool:
        """Hand each message on; false where this ROS takes no types by name.

        Args:
            node: subscribes.
            topic: of which.
            kind: ``package/msg/Name``, and the hash of its version.
            hear: is called where the node is spun.

        """
        ...
