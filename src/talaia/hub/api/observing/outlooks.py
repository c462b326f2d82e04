"""What would become of requests: checked before they are handed in, read from files, forecast."""

from __future__ import annotations

from typing import TYPE_CHECKING
from zoneinfo import ZoneInfo

import msgspec
from fastapi import APIRouter, Request

from talaia.hub.api.access import live_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.observing.admission import group_problems
from talaia.hub.api.observing.night_forms import plan_shape, why_not_shape
from talaia.hub.api.observing.nights import seen_requests
from talaia.hub.api.observing.outlook_schemas import (
    FileProblemShape,
    ForecastReason,
    ForecastShape,
    ImportAnswer,
    ImportAsk,
    RequestChanceShape,
    RequestOutlookShape,
    SkyCurveShape,
    ValidationShape,
    WeekNightShape,
    WeekShape,
)
from talaia.hub.api.observing.request_forms import group_ask, read_group
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.observing_schemas import GroupAsk, RequestAsk
from talaia.hub.errors import HubBusy
from talaia.hub.live.observing.forecast_service import ForecastFailed
from talaia.hub.live.observing.observing_sites import instrument_of, is_observatory
from talaia.hub.observing.charging import request_charge
from talaia.hub.observing.newcomer import NewcomerChances
from talaia.hub.observing.quotas import quota_problems
from talaia.hub.request_files.imported import ImportDefaults
from talaia.hub.request_files.readers import read_request_file
from talaia.model.observing.states import RequestState

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.hub.api.observing.group_lookup import GroupLookup
    from talaia.hub.live.observing.forecast_service import ForecastService, KeptForecast
    from talaia.hub.live.observing.outlook_service import OutlookService
    from talaia.hub.observing.outlook import RequestOutlook
    from talaia.hub.store.observing.proposals import ProposalStore
    from talaia.hub.store.observing.request_queries import PlannedRequest
    from talaia.hub.store.observing.request_store import RequestStore
    from talaia.planner.week import NightForecast

__all__ = ["OutlookPages"]

_HOUR = 3600.0
# Reasons that one forecast gives.
_MOST_REASONS = 500
# Who asks for the first forecast of a site waits so long for it, and then comes again (s).
_PATIENCE_S = 20.0


class OutlookPages:
    """The routes that keep nothing."""

    def __init__(
        self,
        *,
        outlooks: OutlookService,
        forecasts: ForecastService,
        proposals: ProposalStore,
        requests: RequestStore,
        lookup: GroupLookup,
    ) -> None:
        """Ask ``outlooks`` for the sky, ``forecasts`` for plans, stores for what is promised."""
        self._outlooks = outlooks
        self._forecasts = forecasts
        self._proposals = proposals
        self._requests = requests
        self._lookup = lookup

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}"
        router.post(at + "/request-groups/validate")(self.validate)
        router.post(at + "/request-groups/import")(self.read_file)
        router.get(at + "/night/forecast")(self.forecast)
        router.get(at + "/night/week")(self.week)
        return router

    async def validate(self, site: str, asked: GroupAsk, request: Request) -> ValidationShape:
        """Tell what a group would be charged, whether it may be handed in, when it can be seen."""
        proposal = await self._lookup.asked_proposal(site, asked.proposal, request)
        who, described = who_of(request), live_of(request).description
        group = read_group(asked, who.name, RequestState.DRAFT)
        instrument = instrument_of(described)
        charges = [request_charge(one, instrument) for one in group.requests]
        person = await self._proposals.person_account(site, proposal.id, who.user)
        limits, used = proposal.limits, proposal.account
        now = self._outlooks.now()
        problems = quota_problems(
            group, sum(charges), limits, proposal=used, person=person
        ) + group_problems(group, described, now)
        kept = await self._forecasts.look_up(described) if is_observatory(described) else None
        try:
            outlooks = await self._outlooks.work_out(described, group.requests)
            chances = (
                await self._outlooks.weigh_chances(described, group, kept)
                if kept is not None
                else [NewcomerChances(None)] * len(outlooks)
            )
        except HubBusy as error:
            raise ApiProblem(429, "busy", str(error), 3) from error
        return ValidationShape(
            problems=problems,
            charge_s=sum(charges),
            left_s=max(0.0, limits.hours * _HOUR - used.used - used.promised),
            person_left_s=max(0.0, limits.person_hours * _HOUR - person.used - person.promised)
            if limits.person_hours
            else None,
            forecast_us=_to_us(kept.week.made_at) if kept is not None else None,
            forecast_nights=len(kept.week.nights) if kept is not None else 0,
            requests=[
                _outlook_shape(outlook, charge, chance)
                for outlook, charge, chance in zip(outlooks, charges, chances, strict=False)
            ],
        )

    async def read_file(self, site: str, asked: ImportAsk, request: Request) -> ImportAnswer:
        """Read another program's file: what it asks, as drafts that are not kept yet."""
        await self._lookup.asked_proposal(site, asked.proposal, request)
        # Through the form of a group, so that what stands in is read as all else is.
        standing = read_group(
            GroupAsk(
                proposal=asked.proposal,
                requests=[
                    RequestAsk(
                        configurations=asked.configurations,
                        constraints=asked.constraints,
                        windows=[asked.window],
                    )
                ],
            ),
            "",
            RequestState.DRAFT,
        ).requests[0]
        defaults = ImportDefaults(
            proposal=asked.proposal,
            window=standing.windows[0],
            configurations=standing.configurations,
            constraints=standing.constraints,
            zone=ZoneInfo(live_of(request).description.zone),
        )
        found = read_request_file(asked.kind, asked.text, defaults)
        return ImportAnswer(
            groups=[group_ask(group) for group in found.groups],
            problems=[
                FileProblemShape(where=problem.where, message=problem.message)
                for problem in found.problems
            ],
        )

    async def forecast(self, request: Request) -> ForecastShape:
        """Give the night to come as it is planned with what waits, as if the sky were clear."""
        week = (await self._find_forecast(request)).week
        plan = week.nights[0].plan
        ids = [block.request for block in plan.blocks] + [one.request for one in week.reasons]
        seen = await seen_requests(self._proposals, self._requests, request, ids)
        reasons = [
            ForecastReason(request=one.request, target=seen[one.request].target, why_not=said)
            for one in week.reasons
            if one.request in seen and (said := why_not_shape(one)) is not None
        ]
        return ForecastShape(
            plan=plan_shape(msgspec.structs.replace(plan, made_at=week.made_at), seen),
            reasons=reasons[:_MOST_REASONS],
            more=len(reasons) > _MOST_REASONS,
        )

    async def week(self, request: Request) -> WeekShape:
        """Tell the chance of each request that waits, for tonight and six nights more."""
        week = (await self._find_forecast(request)).week
        ids = {name for night in week.nights for name in night.chances}
        seen = await seen_requests(self._proposals, self._requests, request, sorted(ids))
        return WeekShape(
            made_us=_to_us(week.made_at),
            renewing=self._forecasts.is_pending(live_of(request).name),
            open_share=week.open_share,
            nights=[_night_shape(night, week.made_at, seen) for night in week.nights],
        )

    async def _find_forecast(self, request: Request) -> KeptForecast:
        described = live_of(request).description
        if not is_observatory(described):
            raise ApiProblem(409, "no_night", "this site does not observe by itself")
        if described.place is None:
            raise ApiProblem(409, "no_place", "the description does not say where the site is")
        try:
            kept = await self._forecasts.wait_for(described, _PATIENCE_S)
        except ForecastFailed as error:
            raise ApiProblem(409, "no_forecast", str(error)) from error
        if kept is None:
            raise ApiProblem(429, "busy", "the week is still being worked out", 3)
        return kept


def _night_shape(
    night: NightForecast, made_at: float, seen: Mapping[str, PlannedRequest]
) -> WeekNightShape:
    plan = msgspec.structs.replace(night.plan, made_at=made_at)
    return WeekNightShape(
        start_us=_to_us(plan.night_start),
        end_us=_to_us(plan.night_end),
        # Of what is not one's own only how much of it there is, and when.
        planned=len(night.chances),
        plan=plan_shape(plan, seen),
        chances=[
            RequestChanceShape(
                request=name,
                proposal=seen[name].proposal,
                target=seen[name].target,
                chance=chance,
            )
            for name, chance in night.chances.items()
            if name in seen
        ],
    )


def _outlook_shape(
    outlook: RequestOutlook, charge: float, chances: NewcomerChances
) -> RequestOutlookShape:
    curve = outlook.curve
    return RequestOutlookShape(
        charge_s=charge,
        nights=outlook.nights,
        possible=outlook.possible,
        best_us=_to_us(outlook.best) if outlook.best is not None else None,
        message=outlook.sentence,
        tonight=chances.tonight,
        week=chances.week,
        curve=SkyCurveShape(
            times_us=[_to_us(time) for time in curve.times],
            altitude=curve.altitude,
            sun_altitude=curve.sun_altitude,
            moon_altitude=curve.moon_altitude,
            allowed=curve.allowed,
        )
        if curve is not None
        else None,
    )


def _to_us(seconds: float) -> int:
    return round(seconds * 1e6)
