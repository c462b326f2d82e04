"""The WebSocket on which a page follows one raw topic."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from fastapi import APIRouter, WebSocket

from talaia.hub.api.access import address_of, deny_socket
from talaia.hub.api.sockets.socket_admission import speaks_json
from talaia.hub.live.taps.topic_viewer import (
    DEFAULT_RATE,
    MOST_RATE,
    MOST_RAW_RATE,
    TopicViewer,
)
from talaia.hub.live.taps.tree_lane import TreeLane

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.api.sockets.socket_admission import SocketAdmission
    from talaia.hub.auth.permissions import Who
    from talaia.hub.live.pages.session_registry import SocketSessions
    from talaia.hub.live.sites import Sites
    from talaia.hub.live.taps.tap_fanout import TapFanout
    from talaia.hub.store.audit import Audit

__all__ = ["TopicSockets"]

# Of a topic's name, as the wire has it (characters).
_MOST_NAME = 200
# Points of a cloud for a page: unless it asks for fewer or more, and at the most.
_DEFAULT_POINTS, _MOST_POINTS = 100_000, 400_000


class TopicSockets:
    """Serves raw topics to those who may tap them."""

    def __init__(
        self,
        *,
        admission: SocketAdmission,
        sites: Sites,
        seats: SocketSessions,
        taps: TapFanout,
        clock: Clock,
        audit: Audit,
    ) -> None:
        """Messages come from ``taps``; ``seats`` ends a socket with its session."""
        self._admission = admission
        self._sites = sites
        self._seats = seats
        self._taps = taps
        self._clock = clock
        self._audit = audit
        # All pages together: what one looks at must not take the others' time.
        self._lane = TreeLane(clock)

    def router(self) -> APIRouter:
        """Give the socket's route."""
        router = APIRouter()
        router.websocket("/ws/topic")(self.serve)
        return router

    async def serve(self, socket: WebSocket) -> None:
        """Serve the messages of one topic to one page."""
        async with self._admission.admit_person(socket) as who:
            if who is not None:
                await self._serve(socket, who)

    async def _serve(self, socket: WebSocket, who: Who) -> None:
        site, topic = (socket.query_params.get(key, "") for key in ("site", "topic"))
        live = self._sites.find_site(site)
        # The same words for a topic that is not this person's and one that cannot be there.
        if (
            live is None
            or not topic.startswith("/")
            or len(topic) > _MOST_NAME
            or not self._taps.allows(who.grants, live, topic)
        ):
            message = "there is no such topic that you may tap"
            await deny_socket(socket, status=404, code="unknown", message=message)
            return
        await socket.accept()
        points = _points_of(socket)
        # Nothing is awaited between the look at the rights and the tap.
        viewer = TopicViewer(
            socket,
            who=who,
            site=site,
            topic=topic,
            taps=self._taps,
            lane=self._lane,
            clock=self._clock,
            text=speaks_json(socket),
            points=points,
        )
        address = address_of(socket)
        self._seats.add(viewer)
        self._append_record("topic opened", who, site=site, topic=topic, address=address)
        try:
            await viewer.serve(_rate_of(socket, MOST_RAW_RATE if points else MOST_RATE))
        finally:
            self._seats.remove(viewer)
            self._append_record("topic closed", who, site=site, topic=topic, address=address)

    def _append_record(self, kind: str, who: Who, *, site: str, topic: str, address: str) -> None:
        self._audit.append_record(kind, who=who.name, address=address, site=site, message=topic)


def _rate_of(socket: WebSocket, most: float) -> float:
    """Give how often the page wants messages at the most (Hz)."""
    try:
        asked = float(socket.query_params.get("rate", ""))
    except ValueError:
        return DEFAULT_RATE
    return min(asked, most) if math.isfinite(asked) and asked > 0 else DEFAULT_RATE


def _points_of(socket: WebSocket) -> int:
    """Give how many points of a cloud a page wants that reads the bytes itself; 0: it does not."""
    if socket.query_params.get("as") != "bytes":
        return 0
    try:
        asked = int(socket.query_params.get("points", ""))
    except ValueError:
        return _DEFAULT_POINTS
    return min(max(1, asked), _MOST_POINTS)
