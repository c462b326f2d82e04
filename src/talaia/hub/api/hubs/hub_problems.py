"""What is wrong with hubs that are one, in words. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.hub.api.hubs.hub_schemas import HubShape, ShardShape

__all__ = ["find_problems"]

# A database that takes longer slows everything (ms).
_SLOW_MS = 250.0


def find_problems(
    hubs: Sequence[HubShape], shards: Sequence[ShardShape] = (), *, bus: bool
) -> list[str]:
    """Say what is wrong; ``bus``: whether the hubs can hear each other at all."""
    problems = []
    if not bus:
        problems.append("NATS is away: pages and gateways reach this hub only where it is itself")
    living = [hub for hub in hubs if hub.role != "gone"]
    problems += [
        f"{hub.name} has not been heard for {hub.silent_s:.0f}\u202fs"
        for hub in hubs
        # Without the bus nobody can be heard, and nothing is known of them.
        if hub.role == "gone" and bus
    ]
    if len(living) == 1 and bus:
        problems.append("No other hub is there to take over")
    if len({hub.version for hub in living}) > 1:
        problems.append("The hubs are of different versions; go on with the upgrade")
    problems += [
        f"The database is slow for {hub.name}: {hub.database_ms:.0f}\u202fms"
        for hub in living
        if hub.database_ms > _SLOW_MS
    ]
    if bus:
        problems += _shard_problems(living, shards)
    return problems


def _shard_problems(living: Sequence[HubShape], shards: Sequence[ShardShape]) -> list[str]:
    problems = [f"No hub leads the shard {shard.name}" for shard in shards if not shard.lead]
    idle = [hub for hub in living if hub.role == "waits"]
    problems += [
        f"{hub.name} leads {len(hub.shards)} shards and {idle[0].name} none: restart {hub.name}"
        " to divide them"
        for hub in living
        if len(hub.shards) > 1 and idle
    ]
    if shards and not idle and len(living) > 1:
        problems.append("Every hub leads: one more would take over sooner when one is gone")
    return problems
