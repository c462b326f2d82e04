"""What every hub is, whatever its features are: it opens and closes them, and serves their API."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from talaia.hub.api.application import web_application
from talaia.hub.api.server.request_guard import RequestGuard
from talaia.hub.features.feature import Core, Feature
from talaia.hub.lifecycle import open_features

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterable, Iterator, Sequence

    from fastapi import FastAPI
    from starlette.types import ASGIApp

    from talaia.clock import Clock
    from talaia.hub.api.guarded_routes import Guard
    from talaia.hub.ports import ClusterSeat
    from talaia.hub.settings import Settings

__all__ = ["AssembledHub"]


class AssembledHub:
    """A hub that is put together. Serve `asgi`; it starts and ends with the server's lifespan.

    Attributes:
        core: what every feature may use.
        features: all of them, in the order in which they open; they close in the reverse order.
        app: routes of all features; ``asgi``: the same, behind what guards every request.

    """

    features: tuple[Feature, ...]
    app: FastAPI
    asgi: ASGIApp

    def __init__(
        self, settings: Settings, clock: Clock, *, seat: ClusterSeat | None = None
    ) -> None:
        """Make what belongs to no feature and is open before all of them."""
        self.settings = settings
        self.core = Core(settings=settings, clock=clock, seat=seat)

    def serve_features(
        self, guards: Sequence[Guard], *, picture_origins: Callable[[], Sequence[str]] = tuple
    ) -> None:
        """Take as features all attributes that are some, in the order in which they were set.

        So none can be forgotten. ``picture_origins``: whom pages may ask for pictures besides us.
        """
        self.features = tuple(_features_among(vars(self).values()))
        self.app = web_application(self.features, guards, self.running)
        self.asgi = RequestGuard(self.app, self.settings, picture_origins)

    @asynccontextmanager
    async def running(self, _app: FastAPI | None = None) -> AsyncIterator[None]:
        """Open the hub, and close it at the end.

        Raises:
            StoreError: the database cannot be opened.
            CannotStart: the key that seals secrets cannot be read.

        """
        async with open_features(self.core, self.features):
            yield

    def is_driven(self) -> bool:
        """Tell whether somebody has control of a device anywhere."""
        # A lease with a session is held by somebody; one without is free.
        return any(
            state.session for live in self.core.sites for state, _ in live.current.leases.values()
        )

    async def hand_over(self) -> None:
        """Do nothing: a hub that is alone has nobody to send its pages and gateways to."""


def _features_among(parts: Iterable[object]) -> Iterator[Feature]:
    for part in parts:
        # A table of them is one part.
        yield from (
            feature
            for feature in (part if isinstance(part, tuple) else (part,))
            if isinstance(feature, Feature)
        )
