"""Lines of a robot's own log (``/rosout``) that are kept: searched, page by page."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Query

from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.records.query_params import Time, Word  # noqa: TC001 - FastAPI reads it
from talaia.hub.api.records.robot_log_schemas import LogLineShape, LogNodeList, LogPageShape
from talaia.hub.store.sites.robot_log import LogFilter, LogPlace

if TYPE_CHECKING:
    from talaia.hub.store.sites.robot_log import KeptLogLine, RobotLogStore

__all__ = ["RobotLogPages"]

_Place = Annotated[str, Query(max_length=40, pattern=r"^[0-9]{1,16}-[0-9]{1,18}$")]


class RobotLogPages:
    """The routes of robots' logs."""

    def __init__(self, store: RobotLogStore) -> None:
        """Answer from ``store``."""
        self._store = store

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/log"
        router.get(at)(self.find)
        router.get(at + "/nodes")(self.nodes)
        return router

    async def find(
        self,
        *,
        site: str,
        from_us: Time = 0,
        to_us: Time = 2**53,
        level: Annotated[int, Query(ge=0, le=255)] = 0,
        node: Word = "",
        text: Word = "",
        before: _Place | None = None,
        limit: Annotated[int, Query(ge=1, le=1000)] = 200,
    ) -> LogPageShape:
        """List the kept lines of a robot's log, the newest first.

        ``level``: from this one on. ``node``: its whole name. ``text``: each of its words stands
        somewhere in the line or the node's name; a search for words looks through a bounded number
        of lines, so that a page may be short, or empty, and still have a next one. Lines that say
        how many were not kept are of every level and node.
        """
        place = None
        if before is not None:
            time_us, _, number = before.partition("-")
            place = LogPlace(int(time_us), int(number))
        wanted = LogFilter(
            from_us=from_us, to_us=to_us, level=level, node=node, text=text, before=place
        )
        page = await self._store.find_lines(site, wanted, limit)
        after = page.after
        return LogPageShape(
            lines=[_line_shape(line) for line in page.lines],
            next=None if after is None else f"{after.time_us}-{after.id}",
        )

    async def nodes(self, site: str) -> LogNodeList:
        """List the nodes of which lines are kept."""
        return LogNodeList(nodes=await self._store.list_nodes(site))


def _line_shape(kept: KeptLogLine) -> LogLineShape:
    return LogLineShape(id=str(kept.id), **kept.body._asdict())
