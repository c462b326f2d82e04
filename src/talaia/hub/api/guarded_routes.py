"""Routes behind the hub's guards: who asks, and how much, is settled before anything is read.

FastAPI would take the guards as dependencies of the routers that are included; it then builds every
route a second time, at the first request, which is a third of what it takes to start a hub.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fastapi.routing import APIRoute

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Coroutine

    from fastapi import APIRouter, FastAPI, Request, Response

    Guard = Callable[[Request], Awaitable[None]]

__all__ = ["GuardedRoute", "add_guarded", "set_guards"]


class GuardedRoute(APIRoute):
    """A route that asks its application's guards first; without guards it serves nobody."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Give what answers a request."""
        # FastAPI's own: reads body and query, and calls the function.
        handle = super().get_route_handler()

        async def handle_guarded(request: Request) -> Response:
            # Before the body is read: a stranger's costs nothing, and learns nothing.
            for guard in request.app.state.guards:
                await guard(request)
            return await handle(request)

        return handle_guarded


def set_guards(app: FastAPI, *guards: Guard) -> None:
    """Let each request of a guarded route pass these, in their order; each refuses by raising."""
    app.state.guards = guards


def add_guarded(app: FastAPI, router: APIRouter) -> None:
    """Serve a router's routes.

    Raises:
        TypeError: one of them would not ask the guards.

    """
    for route in router.routes:
        # At the start: a route that is open by mistake must never serve.
        if not isinstance(route, GuardedRoute):
            raise TypeError(f"{route!r} does not ask the guards; GuardedRoute does")
    # The very routes; `include_router` would build each of them once more.
    app.router.routes.extend(router.routes)
