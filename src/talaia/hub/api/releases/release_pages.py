"""Releases of gateways: which there are, how gateways stand, and handing one out; for admins."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from fastapi import APIRouter, Request

from talaia.hub.api.access import address_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.releases.release_schemas import (
    GatewayReleaseShape,
    ReleaseList,
    ReleaseShape,
    RolloutAsk,
    RolloutShape,
    RolloutSiteShape,
)
from talaia.hub.live.releases.rollout_service import RolloutRefused

if TYPE_CHECKING:
    from talaia.hub.live.releases.rollout import Rollout
    from talaia.hub.live.releases.rollout_service import RolloutService
    from talaia.hub.live.sites import Sites
    from talaia.hub.store.audit import Audit

__all__ = ["ReleasePages"]


class ReleasePages:
    """The routes of releases."""

    def __init__(self, rollouts: RolloutService, *, sites: Sites, audit: Audit) -> None:
        """Hand out by ``rollouts``; write down in ``audit`` who asks for it."""
        self._rollouts = rollouts
        self._sites = sites
        self._audit = audit

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/releases")(self.list_releases)
        router.post("/api/rollouts", status_code=201)(self.begin_rollout)
        router.post("/api/rollouts/stop", status_code=204)(self.stop_rollout)
        return router

    async def list_releases(self) -> ReleaseList:
        """List releases, how gateways stand, and how the last rollout went."""
        kept = await asyncio.to_thread(self._rollouts.folder.list_releases)
        rollout = self._rollouts.rollout
        return ReleaseList(
            releases=[ReleaseShape(**release._asdict()) for release in kept],
            gateways=self._list_gateways(),
            rollout=None if rollout is None else _shape_rollout(rollout),
        )

    async def begin_rollout(self, asked: RolloutAsk, request: Request) -> RolloutShape:
        """Begin to hand a release out, stage by stage."""
        sites = list(dict.fromkeys(asked.sites))
        who = who_of(request).name
        try:
            rollout = await self._rollouts.begin_rollout(
                asked.version, sites, who=who, first=asked.first, at_once=asked.at_once
            )
        except RolloutRefused as error:
            raise ApiProblem(409, "refused", str(error)) from error
        except OSError as error:
            raise ApiProblem(503, "disk", f"it cannot be written down: {error}") from error
        self._append_record(request, "release handed out", f"{asked.version}: {', '.join(sites)}")
        return _shape_rollout(rollout)

    async def stop_rollout(self, request: Request) -> None:
        """Offer it to nobody any more; what a gateway has installed it goes on with."""
        if not await self._rollouts.stop_rollout(who_of(request).name):
            raise ApiProblem(409, "idle", "no rollout is under way")
        self._append_record(request, "release no longer handed out", "")

    def _list_gateways(self) -> list[GatewayReleaseShape]:
        found = []
        for live in self._sites:
            report = self._rollouts.report_of(live.name)
            if report is not None:
                found.append(
                    GatewayReleaseShape(
                        site=live.name,
                        current=report.current,
                        phase=report.phase,
                        candidate=report.candidate,
                        waits=report.waits,
                        fetched=report.fetched,
                        failed=report.failed,
                    )
                )
        return found

    def _append_record(self, request: Request, kind: str, message: str) -> None:
        name, address = who_of(request).name, address_of(request)
        self._audit.append_record(kind, who=name, address=address, message=message[:2000])


def _shape_rollout(rollout: Rollout) -> RolloutShape:
    return RolloutShape(
        version=rollout.version,
        who=rollout.who,
        began_us=rollout.began_us,
        first=rollout.first,
        at_once=rollout.at_once,
        runs=rollout.runs,
        stopped=rollout.stopped,
        sites=[
            RolloutSiteShape(site=name, stage=site.stage, why=site.why)
            for name, site in rollout.sites.items()
        ],
    )
