"""Raw topics of one Foxglove client: offered with their schemas, sent as the robot wrote them."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.hub.clients.foxglove.schemas import NamedSchema
from talaia.hub.errors import TapRefused
from talaia.hub.live.taps.tapped import GraphChanged, TapBegun, TapDelivery, TapTrouble

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Collection

    from talaia.hub.auth.permissions import Grants
    from talaia.hub.live.taps.tap_fanout import TapFanout
    from talaia.hub.live.taps.tapped import TappedMessage, TapTopic
    from talaia.wire.frames import RobotGraph, TapSchema

__all__ = ["TappedChannels"]


class TappedChannels:
    """What one client may tap of a site and does; call `serve_topics`, then `end_taps`."""

    def __init__(
        self,
        fanout: TapFanout,
        site: str,
        grants: Grants,
        *,
        changed: Callable[[], Awaitable[None]],
        graph_changed: Callable[[], Awaitable[None]],
        deliver: Callable[[TappedMessage], Awaitable[None]],
        warn: Callable[[str], Awaitable[None]],
    ) -> None:
        """Take from ``fanout`` what ``grants`` allow.

        Args:
            fanout: see above.
            site: short name.
            grants: see above.
            changed: called when `offered` is another one.
            graph_changed: called when `robot_graph` may give something else; see `follow_graph`.
            deliver: sends a message; the next one waits for it.
            warn: tells the person why messages are missing.

        """
        # Asks the gateway once for all who take.
        self._fanout = fanout
        self._site = site
        # Never others: a change of rights ends the connection.
        self._grants = grants
        self._changed = changed
        self._graph_changed = graph_changed
        self._deliver = deliver
        self._warn = warn
        # Bounded: what a slow client does not take is left out, the oldest first.
        self._taker = fanout.taker(grants)
        # By type, as told last: a link that was lost does not take channels away.
        self._schemas: dict[str, TapSchema] = {}
        # By topic: how its messages are read, of those of which it is known.
        self.offered: dict[str, NamedSchema] = {}

    async def serve_topics(self) -> None:
        """Offer what may be tapped, and hand over what is, until cancelled."""
        self._fanout.follow_topics(self._site, self._taker)
        await self._update_offer()
        while True:
            match await self._taker.next_event():
                case TapDelivery() as delivery:
                    await self._deliver(delivery.message)
                case TapBegun() as begun:
                    # The gateway may have another definition of the type than it had.
                    if begun.schema != self._schemas.get(begun.schema.type):
                        self._schemas[begun.schema.type] = begun.schema
                        await self._update_offer()
                case TapTrouble() as trouble:
                    await self._warn(f"{trouble.tap.topic}: {trouble.why}")
                case GraphChanged():
                    await self._graph_changed()
                case _:
                    # The list has changed, or a right was lost, and with it a topic.
                    await self._update_offer()

    def end_taps(self) -> None:
        """End all that is taken."""
        self._fanout.remove_taker(self._taker)

    def subscribe_topic(self, topic: str) -> str:
        """Have a topic's messages; give why not, if so."""
        try:
            self._fanout.subscribe(self._site, topic, self._taker)
        except TapRefused as error:
            return str(error)
        return ""

    def unsubscribe_topic(self, topic: str) -> None:
        """Have them no more."""
        # None of one that ended by itself.
        tap = self._taker.taps.get((self._site, topic))
        if tap is not None:
            self._fanout.unsubscribe(tap)

    def follow_graph(self, *, wanted: bool) -> None:
        """Have the robot's nodes, or no more."""
        if wanted:
            self._fanout.graphs.follow_graph(self._site, self._taker)
        else:
            self._fanout.graphs.unfollow_graph(self._site, self._taker)

    def robot_graph(self, services: Collection[str]) -> RobotGraph:
        """Give the robot's nodes as far as they may be seen; ``services`` may be called."""
        return self._fanout.graphs.visible_graph(self._site, self._grants, services)

    async def _update_offer(self) -> None:
        # What may not be tapped is not in it.
        topics = self._fanout.topics(self._site, self._grants)
        # Side by side: a gateway that does not answer costs one wait, not one for each.
        await asyncio.gather(*(self._learn_schema(topic) for topic in topics))
        offered = {}
        for topic in topics:
            schema = self._schemas.get(topic.type)
            # Without a definition no client could read it.
            if schema is not None and schema.definition:
                # ROS 1 itself, and what reads its messages, knows no middle part.
                ros1 = schema.encoding == "ros1msg"
                name = topic.type.replace("/msg/", "/") if ros1 else topic.type
                offered[topic.topic] = NamedSchema(
                    name, schema.definition, schema.encoding, schema.message_encoding
                )
        # A list that says the same, such as after a lost link, is no news for the client.
        if offered != self.offered:
            self.offered = offered
            await self._changed()

    async def _learn_schema(self, topic: TapTopic) -> None:
        if topic.type in self._schemas:
            return
        try:
            schema = await self._fanout.schema(self._site, topic.topic, self._grants)
        except TapRefused:
            # Gone meanwhile, or its gateway is: there will be another list.
            return
        self._schemas[schema.type] = schema
