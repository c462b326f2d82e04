"""What an admin sees and asks of releases of gateways."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from talaia.hub.api.schemas.common import Schema
from talaia.hub.live.releases.rollout import MOST_SITES

__all__ = [
    "GatewayReleaseShape",
    "ReleaseList",
    "ReleaseShape",
    "RolloutAsk",
    "RolloutShape",
    "RolloutSiteShape",
]


class ReleaseShape(Schema):
    """A file in the folder ``releases`` of the hub's data. ``changed_us`` is UTC (µs).

    ``site`` is the gateway it is for, empty for all; ``problem`` says why it cannot be handed out.
    Who has signed it is not judged here: each gateway does.
    """

    name: str
    version: str
    site: str
    size: int
    changed_us: int
    problem: str


class GatewayReleaseShape(Schema):
    """How releases stand at a site's gateway, as it says itself.

    ``phase``: ``idle``, ``fetching``, ``installing``, ``waiting`` for rest, ``allowed`` or
    ``trying``. ``waits`` is why the candidate is not tried yet; ``failed`` are releases that were
    left, and why.
    """

    site: str
    current: str
    phase: str
    candidate: str
    waits: str
    fetched: int
    failed: dict[str, str]


class RolloutSiteShape(Schema):
    """One site of a rollout: ``queued``, ``offered``, ``begun``, ``done`` or ``failed``."""

    site: str
    stage: str
    why: str


class RolloutShape(Schema):
    """A release on its way to gateways, or the last one that was.

    ``first`` gateways are the first stage, ``at_once`` each that follows; ``stopped`` says why
    nobody is offered it any more.
    """

    version: str
    who: str
    began_us: int
    first: int
    at_once: int
    runs: bool
    stopped: str
    sites: list[RolloutSiteShape]


class ReleaseList(Schema):
    """Releases, the gateways that take them from this hub, and the last rollout."""

    releases: list[ReleaseShape]
    gateways: list[GatewayReleaseShape]
    rollout: RolloutShape | None


class RolloutAsk(Schema):
    """Hand a release out. ``sites`` have their turn in this order."""

    version: Annotated[str, Field(min_length=1, max_length=40)]
    sites: Annotated[
        list[Annotated[str, Field(min_length=1, max_length=63)]],
        Field(min_length=1, max_length=MOST_SITES),
    ]
    first: Annotated[int, Field(ge=1, le=MOST_SITES)] = 1
    at_once: Annotated[int, Field(ge=1, le=MOST_SITES)] = 10
