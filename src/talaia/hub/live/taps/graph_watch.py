"""The nodes of robots, asked of a gateway while somebody wants to know them, under rights.

A node is shown to a person with those of its topics that this person may tap, and those of its
services that the person may call; one of which nothing is left is not shown at all.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.wire.frames import RobotGraph, RobotNode

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from talaia.hub.auth.permissions import Grants
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.live.taps.taker import TapTaker

__all__ = ["GraphWatch"]

# A question waits so long for a gateway that was not asked before; and for a time after it another
# one is answered at once (s).
_WAIT_S, _HOLD_S = 3.0, 15.0
_UNKNOWN = RobotGraph()


class GraphWatch:
    """The graphs of all sites. On the event loop."""

    def __init__(
        self,
        sites: Sites,
        *,
        ask_soon: Callable[[str], None],
        allows: Callable[[Grants | None, LiveSite, str], bool],
        wait_s: float = _WAIT_S,
        hold_s: float = _HOLD_S,
    ) -> None:
        """Watch nothing yet.

        Args:
            sites: all there are.
            ask_soon: has the gateway of a site asked for what is wanted now.
            allows: tells whether somebody may tap a topic of a site.
            wait_s: a question waits so long for a gateway that was not asked before.
            hold_s: after a question the gateway is asked for news so long.

        """
        self._sites = sites
        self._ask_soon = ask_soon
        self._allows = allows
        self._wait_s, self._hold_s = wait_s, hold_s
        # By site: what its gateway said last, who is told of changes, and until when a question
        # holds.
        self._graphs: dict[str, RobotGraph] = {}
        self._followers: dict[str, set[TapTaker]] = {}
        self._holds: dict[str, asyncio.TimerHandle] = {}
        self._arrived: dict[str, asyncio.Event] = {}
        # Gateways that did not answer on this link, and are not waited for again: older ones.
        self._silent: set[str] = set()

    def is_wanted(self, site: str) -> bool:
        """Tell whether anybody wants to know a site's nodes."""
        return bool(self._followers.get(site)) or site in self._holds

    def follow_graph(self, site: str, taker: TapTaker) -> None:
        """Tell a taker by `GraphChanged` when `visible_graph` may give something else."""
        self._followers.setdefault(site, set()).add(taker)
        self._ask_soon(site)

    def unfollow_graph(self, site: str, taker: TapTaker) -> None:
        """Tell a taker no more."""
        followers = self._followers.get(site, set())
        if taker in followers:
            followers.discard(taker)
            self._rest_if_unwanted(site)

    def remove_taker(self, taker: TapTaker) -> None:
        """Tell a taker of no site any more."""
        for site in list(self._followers):
            self.unfollow_graph(site, taker)

    async def ask_graph(
        self, site: str, grants: Grants | None, services: Collection[str]
    ) -> RobotGraph:
        """Give what `visible_graph` does, after a wait where the gateway is asked only now."""
        loop = asyncio.get_running_loop()
        if (hold := self._holds.get(site)) is not None:
            hold.cancel()
        self._holds[site] = loop.call_later(self._hold_s, self._end_hold, site)
        self._ask_soon(site)
        live = self._sites.find_site(site)
        there = live is not None and live.link is not None
        if there and site not in self._graphs and site not in self._silent:
            try:
                async with asyncio.timeout(self._wait_s):
                    await self._arrived.setdefault(site, asyncio.Event()).wait()
            except TimeoutError:
                self._silent.add(site)
        return self.visible_graph(site, grants, services)

    def visible_graph(
        self, site: str, grants: Grants | None, services: Collection[str]
    ) -> RobotGraph:
        """Give the nodes of a site as far as somebody may see them; none while they are unknown.

        Args:
            site: short name.
            grants: the person's; None for the hub itself.
            services: those that the person may call.

        """
        live, graph = self._sites.find_site(site), self._graphs.get(site)
        if live is None or graph is None:
            return _UNKNOWN
        names = {name for node in graph.nodes for name in (*node.publishes, *node.subscribes)}
        seen = {name for name in names if self._allows(grants, live, name)}
        nodes = [
            RobotNode(
                name=node.name,
                publishes=[name for name in node.publishes if name in seen],
                subscribes=[name for name in node.subscribes if name in seen],
                serves=[name for name in node.serves if name in services],
            )
            for node in graph.nodes
        ]
        shown = [node for node in nodes if node.publishes or node.subscribes or node.serves]
        return RobotGraph(nodes=shown, distro=graph.distro)

    # ── for `TapFanout` ──

    def receive_graph(self, site: str, graph: RobotGraph) -> None:
        """Take what a gateway says; what was on its way when nobody wanted it is let go."""
        if not self.is_wanted(site):
            return
        self._graphs[site] = graph
        self._silent.discard(site)
        if (arrived := self._arrived.pop(site, None)) is not None:
            arrived.set()
        self.report_change(site)

    def report_change(self, site: str) -> None:
        """Tell followers that what they may see may be something else."""
        for taker in self._followers.get(site, ()):
            taker.report_graph(site)

    def end_link(self, site: str) -> None:
        """Forget what holds only while a link stands; who wants it is told with the next."""
        self._graphs.pop(site, None)
        self._silent.discard(site)

    # ── inside ──

    def _end_hold(self, site: str) -> None:
        del self._holds[site]
        self._rest_if_unwanted(site)

    def _rest_if_unwanted(self, site: str) -> None:
        if not self.is_wanted(site):
            # Soon no longer so.
            self._graphs.pop(site, None)
            self._ask_soon(site)
