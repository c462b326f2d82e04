"""Anomaly detectors: what they say now, and a person's "not an anomaly"."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request

from talaia.hub.anomaly.episode_runner import score_address
from talaia.hub.anomaly.groups.group_runner import GroupRunner
from talaia.hub.api.access import address_of, live_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.anomaly_schemas import (
    AnomalyList,
    AnomalyShape,
    ForgiveAnswer,
    ForgiveAsk,
    LearnAnswer,
    LearnAsk,
)
from talaia.hub.api.sites.anomaly_views import check_past_window, share_shapes
from talaia.hub.auth.permissions import Right, sees_signal
from talaia.hub.live.detection.stretch_learning import StretchRefused, learn_stretch

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.anomaly.episode_runner import EpisodeRunner
    from talaia.hub.live.detection.anomaly_service import AnomalyService
    from talaia.hub.ports import History
    from talaia.hub.store.audit import Audit

__all__ = ["AnomalyPages"]


class AnomalyPages:
    """The routes of anomaly detectors."""

    def __init__(
        self, *, watching: AnomalyService, history: History, audit: Audit, clock: Clock
    ) -> None:
        """Answer from ``watching``; what a person says is noted in ``audit``."""
        self._watching, self._history = watching, history
        self._audit, self._clock = audit, clock
        # Groups that learn from a stretch just now, by site and address: one at a time each.
        self._learning: set[tuple[str, str]] = set()

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/anomalies"
        router.get(at)(self.overview)
        router.post(at + "/forgiven")(self.forgive)
        router.post(at + "/learned")(self.learn)
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
        about = f"{asked.address}, {asked.detector}"
        device = asked.address.partition("/")[0]
        self._append_record(
            "anomaly forgiven",
            request,
            site=site,
            device=device,
            about=about,
            comment=asked.comment,
        )
        return ForgiveAnswer(learned=learned)

    async def learn(self, site: str, asked: LearnAsk, request: Request) -> LearnAnswer:
        """Let a group of signals learn what is usual from a stretch of the history."""
        runner = self._watching.find_group(site, asked.address)
        if runner is None:
            raise ApiProblem(404, "unknown", "no such group of signals is at work")
        check_past_window(asked.from_us, asked.to_us, self._clock)
        key = (site, asked.address)
        if key in self._learning:
            raise ApiProblem(409, "busy", "this group learns from a stretch already; wait for it")
        self._learning.add(key)
        try:
            learned = await learn_stretch(
                self._history, site, runner.group, from_us=asked.from_us, to_us=asked.to_us
            )
        except StretchRefused as error:
            raise ApiProblem(422, "invalid", str(error)) from error
        finally:
            self._learning.discard(key)
        # The description may have changed meanwhile: then it learned for nobody.
        if self._watching.find_group(site, asked.address) is not runner:
            raise ApiProblem(409, "changed", "the group was described anew meanwhile; try again")
        self._watching.take_learned(site, runner, learned.detector)
        about = f"{runner.group.name}: {learned.rows} steps"
        device = runner.group.device
        self._append_record(
            "anomalies learned",
            request,
            site=site,
            device=device,
            about=about,
            comment=asked.comment,
        )
        return LearnAnswer(rows=learned.rows, modes=learned.modes, still=learned.still)

    def _append_record(
        self, kind: str, request: Request, *, site: str, device: str, about: str, comment: str
    ) -> None:
        self._audit.append_record(
            kind,
            who=who_of(request).name,
            address=address_of(request),
            site=site,
            device=device,
            message=f"{about}: {comment}" if comment else about,
        )


def _anomaly_schema(watched: EpisodeRunner) -> AnomalyShape:
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
        confirmed=watched.confirmed,
        learns=watched.kind.learns,
        learning=watched.learning,
        late=watched.late,
        title=watched.group.name if isinstance(watched, GroupRunner) else "",
        signals=list(watched.members),
        step_s=watched.group.group.step if isinstance(watched, GroupRunner) else 0.0,
        mode=watched.mode,
        shares=share_shapes(watched, watched.shares),
    )
