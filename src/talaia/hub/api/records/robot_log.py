"""Lines of a robot's own log (``/rosout``) that are kept: searched, page by page."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Query
from pydantic import BaseModel, Field

from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.records.query_params import Time, Word  # noqa: TC001 - FastAPI reads it
from talaia.hub.store.sites.robot_log import LogFilter, LogPlace

if TYPE_CHECKING:
    from talaia.hub.store.sites.robot_log import KeptLogLine, RobotLogStore

__all__ = ["LogLineShape", "LogNodeList", "LogPageShape", "RobotLogPages"]

_Place = Annotated[str, Query(max_length=40, pattern=r"^[0-9]{1,16}-[0-9]{1,18}$")]


class LogLineShape(BaseModel):
    """One line of a robot's log."""

    id: str
    time_us: int = Field(description="when it was said (µs, UTC)")
    level: int = Field(
        description="10 debug, 20 info, 30 warning, 40 error, 50 fatal, as ROS 2 counts"
    )
    node: str = Field(description="who said it")
    text: str = Field(description="may have several lines; nothing unseen is in it")
    function: str = Field(description="in which it was said; empty: unknown")
    file: str = Field(description="of the source; empty: unknown")
    line: int = Field(description="of that file; 0: unknown")
    left_out: int = Field(description="so many lines were not kept, and ``text`` says why; 0: none")


class LogPageShape(BaseModel):
    """Lines, the newest first."""

    lines: list[LogLineShape]
    next: str | None = Field(description="``before`` of the next page; none: there is no more")


class LogNodeList(BaseModel):
    """Nodes of which lines are kept."""

    nodes: list[str]


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
