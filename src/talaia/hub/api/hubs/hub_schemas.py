"""What an admin sees of the hubs."""

from __future__ import annotations

from talaia.hub.api.schemas.common import Schema

__all__ = ["HubList", "HubShape", "ShardShape"]


class HubShape(Schema):
    """One hub. Times in µs (UTC).

    ``role``: ``leads``: it keeps and decides everything; ``waits``: it hands through what comes to
    it, and takes over when the one that leads is gone; ``leaves``: it ends; ``gone``: it was not
    heard a moment ago. ``gateways`` and ``sockets`` came in there. ``cpu`` is a share of a core,
    ``database_ms`` how long the database took to answer there, 0 where that is not known, and
    ``silent_s`` for how long it was not heard. ``shards`` are those that it leads; none where sites
    are not divided.
    """

    name: str
    version: str
    role: str
    own: bool
    since_us: int
    cpu: float
    memory_bytes: int
    database_ms: float
    gateways: int
    sockets: int
    silent_s: float
    shards: list[str]


class ShardShape(Schema):
    """A shard: sites with a lead of their own, and the hub that leads them; empty: none does."""

    name: str
    lead: str
    sites: list[str]


class HubList(Schema):
    """All hubs that are one. ``problems`` say in words what is wrong; empty: all is well.

    ``shards`` is empty where sites are not divided: one hub leads them all.
    """

    clustered: bool
    bus: bool
    epoch: int
    hubs: list[HubShape]
    shards: list[ShardShape]
    problems: list[str]
