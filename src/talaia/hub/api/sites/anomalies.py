"""Anomaly detectors: what they say now, and a person's "not an anomaly"."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request

from talaia.hub.anomaly.runner import score_address
from talaia.hub.api.access import address_of, live_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.anomaly_schemas import (
    AnomalyList,
    AnomalyShape,
    ForgiveAnswer,
    ForgiveAsk,
)
from talaia.hub.auth.permissions import Right, sees_signal

if TYPE_CHECKING:
    from talaia.hub.anomaly.runner import DetectorRunner
    from talaia.hub.live.detection.anomaly_service import AnomalyService
    from talaia.hub.store.audit import Audit

__all__ = ["AnomalyPages"]


class AnomalyPages:
    """The routes of anomaly detectors."""

    def __init__(self, watching: AnomalyService, audit: Audit) -> None:
        """Answer from ``watching``; what a person says is noted in ``audit``."""
        self._watching = watching
        self._audit = audit

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/anomalies"
        router.get(at)(self.overview)
        router.post(at + "/forgiven")(self.forgive)
        return router

    async def overview(self, site: str, request: Request) -> AnomalyList:
        """List the detectors of a site, and what each says now."""
        live, grants = live_of(request), who_of(request).grants
        return AnomalyList(
            detectors=[
                _anomaly_schema(runner)
                for runner in self._watching.detectors_of(site)
                if sees_signal(grants, live.description, *runner.address.split("/", 1))
            ],
            may_forgive=grants.has_right(Right.USE, site),
            skipped=self._watching.skipped,
        )

    async def forgive(self, site: str, asked: ForgiveAsk, request: Request) -> ForgiveAnswer:
        """Say that the latest peak of a detector was no anomaly, so that it learns."""
        # None: there is no such detector. False: it is one that cannot learn.
        learned = self._watching.dismiss_peak(site, asked.address, asked.detector)
        if learned is None:
            raise ApiProblem(404, "unknown", "no such detector is at work on this signal")
        said = f"{asked.address}, {asked.detector}" + (
            f": {asked.comment}" if asked.comment else ""
        )
        self._audit.append_record(
            "anomaly forgiven",
            who=who_of(request).name,
            address=address_of(request),
            site=site,
            device=asked.address.partition("/")[0],
            message=said,
        )
        return ForgiveAnswer(learned=learned)


def _anomaly_schema(watched: DetectorRunner) -> AnomalyShape:
    detector = watched.word
    return AnomalyShape(
        address=watched.address,
        detector=detector,
        name=watched.kind.name,
        bar=watched.episodes.bar,
        score=watched.score,
        scores=score_address(watched.address, detector),
        began_us=watched.episodes.began_us,
        from_us=watched.from_us,
        to_us=watched.to_us,
        why=watched.why,
        forgiven=watched.forgiven,
        learns=watched.kind.learns,
        learning=watched.learning,
        late=watched.late,
    )
