"""How often the detectors of a site may cry, and which of their anomalies were real."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request

from talaia.hub.api.access import address_of, live_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.anomaly_schemas import BudgetAsk, BudgetShape, ConfirmAsk
from talaia.hub.auth.permissions import Right
from talaia.model.ai_services import FEWEST_A_WEEK

if TYPE_CHECKING:
    from talaia.hub.live.detection.alarm_budget import AlarmBudgets
    from talaia.hub.live.detection.anomaly_service import AnomalyService
    from talaia.hub.store.audit import Audit

__all__ = ["AlarmBudgetPages"]


class AlarmBudgetPages:
    """The routes of budgets of false alarms."""

    def __init__(self, budgets: AlarmBudgets, watching: AnomalyService, audit: Audit) -> None:
        """Answer from ``budgets``; what a person says is noted in ``audit``."""
        self._budgets, self._watching, self._audit = budgets, watching, audit

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/anomalies"
        router.get(at + "/budget")(self.show)
        router.put(at + "/budget")(self.change)
        router.post(at + "/confirmed", status_code=204)(self.confirm)
        return router

    async def show(self, site: str, request: Request) -> BudgetShape:
        """Say how often the detectors of a site may cry, and what that stands on."""
        standing = self._budgets.standing_of(live_of(request))
        may_change = who_of(request).grants.has_right(Right.USE, site)
        return BudgetShape(**standing._asdict(), may_change=may_change)

    async def change(self, site: str, asked: BudgetAsk, request: Request) -> BudgetShape:
        """Say how often the detectors of a site may cry."""
        if asked.a_week and asked.a_week < FEWEST_A_WEEK:
            problem = f"expected 0 or at least {FEWEST_A_WEEK:g} a week, found {asked.a_week:g}"
            raise ApiProblem(422, "invalid", problem)
        await self._budgets.set_budget(live_of(request), asked.a_week)
        said = "as described" if asked.a_week is None else f"{asked.a_week:g} a week"
        self._append_record("false alarms allowed", request, site=site, device="", message=said)
        return await self.show(site, request)

    async def confirm(self, site: str, asked: ConfirmAsk, request: Request) -> None:
        """Say that the newest anomaly of a detector was real, so that it is no false alarm."""
        stretch = self._watching.confirm_newest(site, asked.address, asked.detector)
        if stretch is None:
            raise ApiProblem(404, "unknown", "this detector has told of no anomaly")
        await self._budgets.confirm_stretch(live_of(request), *stretch)
        about = f"{asked.address}, {asked.detector}"
        self._append_record(
            "anomaly confirmed",
            request,
            site=site,
            device=asked.address.partition("/")[0],
            message=f"{about}: {asked.comment}" if asked.comment else about,
        )

    def _append_record(
        self, kind: str, request: Request, *, site: str, device: str, message: str
    ) -> None:
        self._audit.append_record(
            kind,
            who=who_of(request).name,
            address=address_of(request),
            site=site,
            device=device,
            message=message,
        )
