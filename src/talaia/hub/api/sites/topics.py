"""Raw topics that may be tapped."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request

from talaia.hub.api.access import live_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.schemas.tap_schemas import (
    GraphNodeShape,
    GraphShape,
    TopicShape,
    TopicTable,
)
from talaia.hub.auth.permissions import seen_camera
from talaia.model.topics import TopicRight

if TYPE_CHECKING:
    from talaia.hub.live.taps.tap_fanout import TapFanout

__all__ = ["TopicPages"]


class TopicPages:
    """The routes of raw topics."""

    def __init__(self, taps: TapFanout) -> None:
        """Answer from what gateways list."""
        self._taps = taps

    def router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/sites/{site}/topics")(self.overview)
        router.get("/api/sites/{site}/graph")(self.graph)
        return router

    async def overview(self, site: str, request: Request) -> TopicTable:
        """List the raw topics of a site that you may tap, by name.

        While its gateway is away, those that it listed last.
        """
        live, grants = live_of(request), who_of(request).grants
        description = live.description
        return TopicTable(
            online=live.online,
            topics=[
                TopicShape(
                    topic=found.topic,
                    type=found.type,
                    latched=found.latched,
                    max_rate=found.max_rate,
                    problem=found.why,
                    described=found.rule is not None,
                    right=found.rule.right if found.rule else TopicRight.TAP,
                    device=found.rule.device if found.rule else "",
                    rate=found.rate,
                    camera=seen_camera(grants, description, found.topic, found.type),
                )
                for found in self._taps.topics(site, grants)
            ],
        )

    async def graph(self, site: str, request: Request) -> GraphShape:
        """Tell which of the robot's nodes publish and subscribe to what, as far as you may tap it.

        The robot is asked for it while somebody asks here; the first answer takes up to three
        seconds. While its gateway is away there are no nodes.
        """
        graph = await self._taps.ask_graph(site, who_of(request).grants, ())
        return GraphShape(
            online=live_of(request).online,
            nodes=[
                GraphNodeShape(name=node.name, publishes=node.publishes, subscribes=node.subscribes)
                for node in sorted(graph.nodes, key=lambda node: node.name)
            ],
        )
