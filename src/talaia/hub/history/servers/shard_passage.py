"""What a shard's lead needs for sites that go to other shards, or come."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.history.servers.shard_holds import ShardHolds
from talaia.hub.history.servers.shard_move import ANSWER_S, ShardArrivals
from talaia.hub.history.servers.site_copy import GATE_S

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.hub.history.servers.late_descriptions import LateDescriptions
    from talaia.hub.history.servers.server_file import HistoryServersFile
    from talaia.hub.history.servers.site_places import SitePlaces
    from talaia.hub.store.history_servers.history_homes import HistoryHomes
    from talaia.hub.store.history_servers.shard_handover import ShardHandover

__all__ = ["ShardPassage"]


class ShardPassage(NamedTuple):
    """The way between a shard and all others.

    Attributes:
        handover: what the leads of two shards say to each other.
        own_url: of the accounts' database, which has histories as well.
        begin_anew: lets this lead close and open again, with the sites that it has by then.
        gate_s: a site is held so long at the most.
        answer_s: another lead is waited for so long.

    """

    handover: ShardHandover
    own_url: str
    begin_anew: Callable[[], None]
    gate_s: float = GATE_S
    answer_s: float = ANSWER_S

    def make_arrivals(
        self,
        places: SitePlaces,
        descriptions: LateDescriptions,
        homes: HistoryHomes,
        named: HistoryServersFile,
    ) -> ShardArrivals:
        """Make what brings sites of other shards to ``places``."""
        return ShardArrivals(
            places,
            descriptions,
            homes,
            handover=self.handover,
            named=named,
            own_url=self.own_url,
            begin_anew=self.begin_anew,
            answer_s=self.answer_s,
        )

    def make_holds(self, places: SitePlaces, homes: HistoryHomes) -> ShardHolds:
        """Make what answers the leads of other shards."""
        return ShardHolds(
            places, homes, self.handover, begin_anew=self.begin_anew, gate_s=self.gate_s
        )
