"""Raw topics from gateways to all who take them: one copy on the line, rights at every turn.

Long, because those who take, the sites and the rights meet in one table.

For parts of the hub that take topics (clients of other protocols, pages, recorders)::

    taker = fanout.taker(who.grants)
    fanout.follow_topics("agv", taker)
    for topic in fanout.topics("agv", who.grants):
        schema = await fanout.schema("agv", topic.topic, who.grants)
    tap = fanout.subscribe("agv", "/scan", taker)
    while True:
        event = await taker.next_event()    # TapBegun, then TapDelivery; TapEnded, TopicsChanged
        await socket.send(...)              # only then the next: the line sets the pace
    fanout.remove_taker(taker)              # in a ``finally``

Nobody is heard on the robot but what somebody takes. While a gateway is away its topics stay listed
and taps stay; they go on when it is back.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.hub.auth.permissions import may_tap
from talaia.hub.errors import TapRefused
from talaia.hub.live.taps.graph_watch import GraphWatch
from talaia.hub.live.taps.site_topics import SiteTopics, TappedTopic
from talaia.hub.live.taps.taker import MOST_TAPS, TapTaker, TopicTap
from talaia.hub.live.taps.tapped import TapTopic
from talaia.model.topics import rule_of
from talaia.wire.frames import (
    RobotGraph,
    TapError,
    TapMessage,
    TapSchema,
    TapSubscription,
    TopicList,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from talaia.clock import Clock
    from talaia.hub.auth.permissions import Grants
    from talaia.hub.live.sites import LiveSite, Sites

__all__ = ["TapFanout", "TapFromGateway"]

TapFromGateway = TopicList | TapSchema | TapMessage | TapError | RobotGraph

# A gateway that is there tells a schema within this (s).
_SCHEMA_S = 5.0
_NOTHING = TapSubscription()
_NO_RIGHT = "you have no right to this topic any more"


class TapFanout:
    """All who take raw topics, and what the gateways are asked to send for them.

    On the event loop only. A `DescriptionFollower` of sites.

    Attributes:
        graphs: the robots' nodes, for those who may tap what these have.

    """

    def __init__(self, sites: Sites, clock: Clock, schema_s: float = _SCHEMA_S) -> None:
        """A schema that does not come within ``schema_s`` is told as missing."""
        self._sites = sites
        self._clock = clock
        self._schema_s = schema_s
        # Called with site, topic and type of each message, before its takers have it.
        self.on_message: Callable[[str, str, str], None] = lambda _site, _topic, _type: None
        self.graphs = GraphWatch(sites, ask_soon=self._ask_soon, allows=self.allows)
        # What is known and tapped, by site.
        self._known: dict[str, SiteTopics] = {}
        self._takers: set[TapTaker] = set()
        # By site: who is told of changes of its list.
        self._followers: dict[str, set[TapTaker]] = {}
        # What each gateway was asked for last on its link.
        self._asked: dict[str, TapSubscription] = {}
        # Sites whose gateway is to be asked in this turn of the loop.
        self._to_ask: set[str] = set()
        # By site and type: who waits for a schema.
        self._waiters: dict[tuple[str, str], asyncio.Event] = {}

    # ── for those who take ──

    def taker(self, grants: Grants | None, *, most_bytes: int | None = None) -> TapTaker:
        """Make one who takes; `remove_taker` ends it.

        Args:
            grants: the person's; None for the hub itself.
            most_bytes: that may wait for it beside the newest message; none: 4 MiB.

        """
        limits = {} if most_bytes is None else {"most_bytes": most_bytes}
        taker = TapTaker(grants, now_us=lambda: self._clock.monotonic_ns() // 1000, **limits)
        self._takers.add(taker)
        return taker

    def remove_taker(self, taker: TapTaker) -> None:
        """End all that somebody takes; topics that nobody else takes rest on the robot."""
        self._takers.discard(taker)
        self.graphs.remove_taker(taker)
        for followers in self._followers.values():
            followers.discard(taker)
        for tap in list(taker.taps.values()):
            self.unsubscribe(tap)

    def topics(self, site: str, grants: Grants | None) -> list[TapTopic]:
        """List the topics of a site that somebody may tap, by name; none of a site not known."""
        live, known = self._sites.find_site(site), self._known.get(site)
        if live is None or known is None:
            return []
        return [
            TapTopic(
                entry.topic,
                entry.type,
                entry.latched,
                self._most_rate(live, entry.topic),
                entry.why,
                rule_of(live.description.topics, entry.topic),
                known.measured_rate(entry.topic),
            )
            for entry in sorted(known.entries.values(), key=lambda entry: entry.topic)
            if self.allows(grants, live, entry.topic)
        ]

    def allows(self, grants: Grants | None, live: LiveSite, topic: str) -> bool:
        """Tell whether somebody may tap a topic, as far as its type is known; None is the hub."""
        return grants is None or _allows(grants, live, topic, self._known.get(live.name))

    async def ask_graph(
        self, site: str, grants: Grants | None, services: Collection[str]
    ) -> RobotGraph:
        """Give the robot's nodes as far as somebody may see them; see `GraphWatch`."""
        known = self._known.get(site)
        if known is None or not known.entries:
            # A robot without topics has no nodes, and is not waited for.
            return RobotGraph()
        return await self.graphs.ask_graph(site, grants, services)

    def follow_topics(self, site: str, taker: TapTaker) -> None:
        """Tell a taker by `TopicsChanged` when `topics` may give another list."""
        self._followers.setdefault(site, set()).add(taker)

    async def schema(self, site: str, topic: str, grants: Grants | None) -> TapSchema:
        """Give how messages of a topic are read; nothing is heard on the robot for it.

        A schema whose ``definition`` is empty says by its ``problem`` why.

        Raises:
            TapRefused: there is no such topic, or not for this person; or the gateway does not
                answer.

        """
        live, known = self._sites.find_site(site), self._known.get(site)
        entry = None if known is None else known.entries.get(topic)
        # What may not be had is as if it were not there.
        if live is None or known is None or entry is None or not self.allows(grants, live, topic):
            raise TapRefused(f"there is no topic {topic!r} that you may tap")
        if entry.type not in known.schemas:
            known.types.add(entry.type)
            self._ask_soon(site)
            arrived = self._waiters.setdefault((site, entry.type), asyncio.Event())
            try:
                async with asyncio.timeout(self._schema_s):
                    await arrived.wait()
            except TimeoutError:
                pass
        found = known.schemas.get(entry.type)
        if found is None:
            raise TapRefused(
                f"the gateway does not tell how {entry.type} is read", "try again later"
            )
        return found

    def subscribe(
        self, site: str, topic: str, taker: TapTaker, *, max_rate: float = 0.0
    ) -> TopicTap:
        """Let a taker have a topic: `TapBegun`, then its messages; again changes the rate.

        The topic need not be there yet: it begins when somebody publishes it.

        Args:
            site: short name.
            topic: absolute name.
            taker: of `taker`.
            max_rate: at most so many messages a second (Hz); 0: all that the description allows.

        Raises:
            TapRefused: the person may not have it, or takes too many.

        """
        live = self._sites.find_site(site)
        if live is None or not self.allows(taker.grants, live, topic):
            raise TapRefused(f"there is no topic {topic!r} that you may tap")
        before = taker.taps.get((site, topic))
        if before is None and len(taker.taps) >= MOST_TAPS:
            raise TapRefused(f"at most {MOST_TAPS} topics at once", "end some first")
        if before is not None:
            self._remove_tap(before)
        known = self._known.setdefault(site, SiteTopics())
        tap = TopicTap(site=site, topic=topic, taker=taker, max_rate=max_rate)
        taker.taps[site, topic] = tap
        tapped = known.tapped.setdefault(topic, TappedTopic())
        tapped.taps.add(tap)
        schema = known.schema_of(topic)
        if schema is not None:
            taker.begin_tap(tap, schema)
            # The robot says them once for the whole hub.
            for message in tapped.latched:
                taker.deliver_message(tap, message)
        self._ask_soon(site)
        return tap

    def unsubscribe(self, tap: TopicTap) -> None:
        """End a tap; what waits of it is forgotten. One that is over already stays so."""
        self._remove_tap(tap)
        tap.taker.forget_tap(tap)

    def change_grants(self, taker: TapTaker, grants: Grants | None) -> None:
        """Go by other rights from here on: taps that they do not allow end at once."""
        taker.grants = grants
        for tap in list(taker.taps.values()):
            self._check_right(tap)

    # ── from the sites ──

    def redescribe(self, now: LiveSite) -> None:
        """Go by another description: its rules may allow other taps."""
        known = self._known.get(now.name)
        if known is not None:
            self._check_taps(known)
            # Rates may be others, too.
            self._ask_soon(now.name)
        self._report_topics(now.name)
        self.graphs.report_change(now.name)

    def link_up(self, site: str) -> None:
        """Ask a gateway that has just connected for all that is wanted of it."""
        self._asked.pop(site, None)
        self.graphs.end_link(site)
        self._known.setdefault(site, SiteTopics()).end_link()
        self._ask_soon(site)

    def link_lost(self, site: str) -> None:
        """Wait for the gateway: taps stay."""
        self._asked.pop(site, None)
        self.graphs.end_link(site)
        if (known := self._known.get(site)) is not None:
            known.end_link()

    def media_lost(self, site: str) -> None:
        """Forget messages that were under way on the connection for pictures."""
        if (known := self._known.get(site)) is not None:
            known.end_media()

    def receive(self, site: str, message: TapFromGateway) -> None:
        """Take what a gateway says of its topics.

        Raises:
            PeerError: pieces that make no message.

        """
        known = self._known.setdefault(site, SiteTopics())
        match message:
            case TapMessage():
                whole = known.read_message(message, self._clock.monotonic_ns() // 1_000_000)
                if whole is not None:
                    self.on_message(site, whole.topic, known.entries[whole.topic].type)
                    for tap in known.tapped[whole.topic].taps:
                        tap.taker.deliver_message(tap, whole)
            case TapSchema():
                self._receive_schema(site, known, message)
            case TopicList():
                known.replace_entries(message.topics)
                self._check_taps(known)
                self._begin_taps(known)
                self._report_topics(site)
                self._ask_soon(site)
            case RobotGraph():
                self.graphs.receive_graph(site, message)
            case TapError():
                tapped = known.tapped.get(message.topic)
                for tap in () if tapped is None else tapped.taps:
                    tap.taker.report_trouble(tap, message.why)

    # ── inside ──

    def _receive_schema(self, site: str, known: SiteTopics, schema: TapSchema) -> None:
        known.schemas[schema.type] = schema
        waiter = self._waiters.pop((site, schema.type), None)
        if waiter is not None:
            waiter.set()
        self._check_taps(known)
        self._begin_taps(known)
        self._ask_soon(site)

    def _begin_taps(self, known: SiteTopics) -> None:
        """Tell takers how their topics are read, where that is new."""
        for topic, tapped in known.tapped.items():
            schema = known.schema_of(topic)
            if schema is not None:
                for tap in tapped.taps:
                    tap.taker.begin_tap(tap, schema)

    def _check_taps(self, known: SiteTopics) -> None:
        for tap in [tap for tapped in known.tapped.values() for tap in tapped.taps]:
            self._check_right(tap)

    def _check_right(self, tap: TopicTap) -> None:
        live = self._sites.find_site(tap.site)
        if live is None or not self.allows(tap.taker.grants, live, tap.topic):
            self._remove_tap(tap)
            tap.taker.forget_tap(tap, _NO_RIGHT)

    def _remove_tap(self, tap: TopicTap) -> None:
        known = self._known.get(tap.site)
        tapped = None if known is None else known.tapped.get(tap.topic)
        if known is None or tapped is None:
            return
        tapped.taps.discard(tap)
        if not tapped.taps:
            del known.tapped[tap.topic]
        self._ask_soon(tap.site)

    def _report_topics(self, site: str) -> None:
        for taker in self._followers.get(site, ()):
            taker.report_topics(site)

    def _ask_soon(self, site: str) -> None:
        """Ask the gateway at the end of this turn: a client subscribes to many at one blow."""
        if not self._to_ask:
            asyncio.get_running_loop().call_soon(self._ask_all)
        self._to_ask.add(site)

    def _ask_all(self) -> None:
        sites, self._to_ask = self._to_ask, set()
        for site in sites:
            live, known = self._sites.find_site(site), self._known.get(site)
            if live is None or known is None or live.link is None:
                continue
            wanted = known.subscription(
                lambda topic, live=live: self._most_rate(live, topic),  # type: ignore[misc]
                graph=self.graphs.is_wanted(site),
            )
            before = self._asked.get(site)
            # Nothing was asked on this link, and nothing is wanted: an older gateway is spared.
            if wanted != before and (before is not None or wanted != _NOTHING):
                self._asked[site] = wanted
                live.link.send(wanted)

    @staticmethod
    def _most_rate(live: LiveSite, topic: str) -> float:
        rule = rule_of(live.description.topics, topic)
        return 0.0 if rule is None else rule.max_rate


def _allows(grants: Grants, live: LiveSite, topic: str, known: SiteTopics | None) -> bool:
    entry = None if known is None else known.entries.get(topic)
    schema = None if known is None else known.schema_of(topic)
    return may_tap(
        grants,
        live.description,
        topic,
        type_name="" if entry is None else entry.type,
        definition="" if schema is None else schema.definition,
    )
