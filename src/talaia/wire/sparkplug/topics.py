"""Topics of Sparkplug B: ``spBv1.0/<group>/<kind>/<edge node>[/<device>]``."""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

__all__ = ["SparkplugKind", "SparkplugTopics"]

_NAMESPACE = "spBv1.0"


class SparkplugKind(StrEnum):
    """What a message says."""

    NODE_BIRTH = "NBIRTH"
    NODE_DEATH = "NDEATH"
    NODE_COMMAND = "NCMD"
    DEVICE_BIRTH = "DBIRTH"
    DEVICE_DEATH = "DDEATH"
    DEVICE_DATA = "DDATA"
    DEVICE_COMMAND = "DCMD"


class SparkplugTopics(NamedTuple):
    """All topics of one edge node."""

    group: str
    node: str

    def of_node(self, kind: SparkplugKind) -> str:
        """Name a topic of the edge node itself."""
        return f"{_NAMESPACE}/{self.group}/{kind}/{self.node}"

    def of_device(self, kind: SparkplugKind, device: str) -> str:
        """Name a topic of a device; ``+`` stands for each."""
        return f"{self.of_node(kind)}/{device}"

    def commanded_device(self, topic: str) -> str | None:
        """Tell which device a topic asks something of; empty: the node. None: it asks nothing."""
        if topic == self.of_node(SparkplugKind.NODE_COMMAND):
            return ""
        start = self.of_device(SparkplugKind.DEVICE_COMMAND, "")
        return topic.removeprefix(start) or None if topic.startswith(start) else None
