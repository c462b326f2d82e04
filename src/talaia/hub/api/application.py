"""The web application of the hub's features: their sockets first, then their guarded routes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import FastAPI

from talaia.hub.api.guarded_routes import add_guarded, set_guards
from talaia.hub.api.problems import answer_problems

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence
    from contextlib import AbstractAsyncContextManager
    from typing import Protocol

    from fastapi import APIRouter

    from talaia.hub.api.guarded_routes import Guard

    class Routed(Protocol):
        """What brings routes, such as a feature."""

        @property
        def routers(self) -> Sequence[APIRouter]:
            """HTTP routes, which are guarded here."""

        @property
        def sockets(self) -> Sequence[APIRouter]:
            """WebSocket routes, which admit by themselves."""


__all__ = ["web_application"]


def web_application(
    features: Iterable[Routed],
    guards: Sequence[Guard],
    lifespan: Callable[[FastAPI], AbstractAsyncContextManager[None]],
) -> FastAPI:
    """Join the routes of ``features``; every HTTP request passes all ``guards`` first."""
    app = FastAPI(
        title="Talaia hub",
        # The browser's own pages speak to it; the description is made by the docs.
        openapi_url=None,
        lifespan=lifespan,
        redirect_slashes=False,
    )
    answer_problems(app)
    set_guards(app, *guards)
    for feature in features:
        for socket in feature.sockets:
            # Before the route that takes every path, whichever feature brings that.
            app.router.routes[0:0] = socket.routes
        for router in feature.routers:
            add_guarded(app, router)
    return app
