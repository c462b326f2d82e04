"""Rules by which notices of transients become rapid requests, tried out and acted upon."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
from fastapi import APIRouter, Request

from talaia.hub.api.access import address_of, live_of, number_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.observing.group_lookup import access_of
from talaia.hub.api.observing.request_forms import read_group, request_shape
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.alert_notice_schemas import (
    AlertAnswer,
    AlertFilterShape,
    AlertNoticeAsk,
    AlertOutcomeShape,
    AlertPreview,
    AlertPreviewLine,
    AlertRuleAsk,
    AlertRuleList,
    AlertRuleShape,
)
from talaia.hub.api.schemas.observing_schemas import GroupAsk, RequestAsk, WindowShape
from talaia.hub.observing.alert_rules import AlertRule, judge_notice
from talaia.hub.store.observing.alert_store import AlertAsker, KeptRule
from talaia.model.observing.requests import Request as ObservingRequest, Window
from talaia.model.observing.states import RequestState
from talaia.wire.alerts.filters import AlertFilter
from talaia.wire.alerts.read_notice import parse_notice
from talaia.wire.errors import PeerError

if TYPE_CHECKING:
    from talaia.hub.live.observing.alert_intake import AlertIntake
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.observing.alert_store import AlertStore, KeptNotice
    from talaia.hub.store.observing.proposals import KeptProposal, ProposalStore

__all__ = ["AlertPages"]

_PREVIEWED = 50
_MOST_RULES = 50
_SECOND = 1_000_000


class AlertPages:
    """The routes of alert rules and notices."""

    def __init__(
        self,
        *,
        alerts: AlertStore,
        proposals: ProposalStore,
        intake: AlertIntake,
        audit: Audit,
    ) -> None:
        """Keep rules in ``alerts``; notices go to ``intake``."""
        self._alerts = alerts
        self._proposals = proposals
        self._intake = intake
        self._audit = audit

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/proposals/{proposal}"
        router.get(at + "/alert-rules")(self.rules)
        router.post(at + "/alert-rules", status_code=201)(self.add)
        router.put(at + "/alert-rules/{rule}", status_code=204)(self.change)
        router.delete(at + "/alert-rules/{rule}", status_code=204)(self.remove)
        router.post(at + "/alert-preview")(self.preview)
        router.post("/api/sites/{site}/alert-notices")(self.receive)
        return router

    async def rules(self, site: str, proposal: str, request: Request) -> AlertRuleList:
        """List a proposal's rules; they say what it is after, so only its people see them."""
        found = await self._find_proposal(site, proposal, request)
        names = {member.user: member.name for member in found.members}
        return AlertRuleList(
            rules=[
                _rule_shape(kept, names.get(kept.user, ""))
                for kept in await self._alerts.list_rules(site, proposal)
            ],
            may_change=_may_change(found, request),
        )

    async def add(
        self, site: str, proposal: str, asked: AlertRuleAsk, request: Request
    ) -> AlertRuleShape:
        """Make a rule, in your name."""
        await self._changed_proposal(site, proposal, request)
        if len(await self._alerts.list_rules(site, proposal)) >= _MOST_RULES:
            raise ApiProblem(409, "state", f"a proposal has up to {_MOST_RULES} rules")
        kept = _kept_rule(site, proposal, asked, request)
        number = await self._alerts.write_rule(kept)
        self._record(request, site, "alert rule added", f"{number} of {proposal}: {asked.name}")
        return AlertRuleShape(id=str(number), maker=who_of(request).name, **asked.model_dump())

    async def change(
        self, site: str, proposal: str, rule: str, *, asked: AlertRuleAsk, request: Request
    ) -> None:
        """Write a rule anew; from then on it asks in your name."""
        await self._changed_proposal(site, proposal, request)
        number = number_of(rule, "rule")
        if not await self._alerts.write_rule(
            _kept_rule(site, proposal, asked, request, number=number)
        ):
            raise ApiProblem(404, "unknown", "there is no such rule")
        self._record(request, site, "alert rule changed", f"{number} of {proposal}: {asked.name}")

    async def remove(self, site: str, proposal: str, rule: str, request: Request) -> None:
        """Remove a rule; what it has asked for stays."""
        await self._changed_proposal(site, proposal, request)
        number = number_of(rule, "rule")
        if not await self._alerts.remove_rule(site, proposal, number):
            raise ApiProblem(404, "unknown", "there is no such rule")
        self._record(request, site, "alert rule removed", f"{number} of {proposal}")

    async def preview(
        self, site: str, proposal: str, asked: AlertRuleAsk, request: Request
    ) -> AlertPreview:
        """Try a rule on the newest notices, as of when each came. Nothing is kept."""
        await self._changed_proposal(site, proposal, request)
        rule = _read_rule(asked)
        kept = await self._alerts.list_notices(site, who_of(request).user, _PREVIEWED)
        lines: list[AlertPreviewLine] = []
        events: set[tuple[str, str]] = set()
        # The oldest first: a later notice of an event asks for nothing more.
        for one in reversed(kept):
            line = _preview_line(rule, one, events)
            lines.append(line)
            if line.passes:
                events.add((one.notice.source, one.notice.event))
        passing = sum(line.passes for line in lines)
        message = (
            f"of the last {len(lines)} notices {passing} would have become requests"
            if lines
            else "no notice has come yet"
        )
        return AlertPreview(message=message, notices=lines[::-1])

    async def receive(self, asked: AlertNoticeAsk, request: Request) -> AlertAnswer:
        """Act upon a notice that a program has brought, with a token."""
        who = who_of(request)
        if not who.script:
            raise ApiProblem(403, "forbidden", "notices are brought by programs, with a token")
        try:
            notice = parse_notice(asked.text.encode())
        except PeerError as error:
            raise ApiProblem(422, "invalid", str(error)) from error
        asker = AlertAsker(who.user, who.name, who.grants)
        found = await self._intake.take_notice(live_of(request), notice, asker=asker)
        return AlertAnswer(
            id=notice.id,
            known=found.known,
            outcomes=[
                AlertOutcomeShape(
                    rule=str(one.rule),
                    name=one.name,
                    proposal=one.proposal,
                    group=str(one.group) if one.group else "",
                    why=one.why,
                )
                for one in found.outcomes
            ],
            canceled=[str(group) for group in found.canceled],
        )

    async def _find_proposal(self, site: str, proposal: str, request: Request) -> KeptProposal:
        """Find a proposal for its people; for others, of an open one too, there is none."""
        found = await self._proposals.find_proposal(site, proposal)
        access = access_of(found, request) if found is not None else None
        if found is None or access is None or not (access.asks or access.leads or access.approves):
            raise ApiProblem(404, "unknown", "there is no such proposal")
        return found

    async def _changed_proposal(self, site: str, proposal: str, request: Request) -> None:
        found = await self._find_proposal(site, proposal, request)
        if not _may_change(found, request):
            raise ApiProblem(403, "forbidden", "who leads the proposal and is in it may do this")

    def _record(self, request: Request, site: str, kind: str, message: str) -> None:
        self._audit.append_record(
            kind,
            who=who_of(request).name,
            address=address_of(request),
            site=site,
            message=message,
        )


def _may_change(proposal: KeptProposal, request: Request) -> bool:
    # A rule asks in its maker's name, so that a maker who may not ask would make a dead one.
    access = access_of(proposal, request)
    return access.leads and access.asks


def _read_rule(asked: AlertRuleAsk) -> AlertRule:
    # Through the form of a request, so that configurations are read as all others are.
    standing: ObservingRequest = read_group(
        GroupAsk(
            proposal="rule",
            requests=[
                RequestAsk(
                    configurations=asked.configurations,
                    constraints=asked.constraints,
                    windows=[WindowShape(start_us=0, end_us=_SECOND)],
                )
            ],
        ),
        "",
        RequestState.DRAFT,
    ).requests[0]
    said = asked.filter
    return AlertRule(
        name=asked.name,
        filter=AlertFilter(
            sources=tuple(said.sources),
            roles=tuple(said.roles),
            largest_error=said.largest_error,
            declinations=(said.lowest_declination, said.highest_declination),
            least=said.least,
            most=said.most,
            equal={name: tuple(patterns) for name, patterns in said.equal.items()},
        ),
        configurations=standing.configurations,
        constraints=standing.constraints,
        hours=asked.hours,
        priority=asked.priority,
        active=asked.active,
    )


def _kept_rule(
    site: str, proposal: str, asked: AlertRuleAsk, request: Request, *, number: int = 0
) -> KeptRule:
    return KeptRule(
        id=number,
        site=site,
        proposal=proposal,
        user=who_of(request).user,
        rule=_read_rule(asked),
    )


def _rule_shape(kept: KeptRule, maker: str) -> AlertRuleShape:
    rule, said = kept.rule, kept.rule.filter
    standing = request_shape(
        ObservingRequest(
            id="rule",
            configurations=rule.configurations,
            constraints=rule.constraints,
            windows=(Window(start=0, end=1),),
        ),
        0.0,
    )
    plain = {
        name: value
        for name, value in msgspec.structs.asdict(said).items()
        if name != "declinations"
    }
    low, high = said.declinations
    return AlertRuleShape(
        id=str(kept.id),
        maker=maker,
        name=rule.name,
        filter=AlertFilterShape(**plain, lowest_declination=low, highest_declination=high),
        configurations=standing.configurations,
        constraints=standing.constraints,
        hours=rule.hours,
        priority=rule.priority,
        active=rule.active,
    )


def _preview_line(
    rule: AlertRule, kept: KeptNotice, events: set[tuple[str, str]]
) -> AlertPreviewLine:
    notice = kept.notice
    verdict = judge_notice(rule, notice, kept.received_us / _SECOND)
    again = (notice.source, notice.event) in events
    passes = verdict.window is not None and not again
    why = verdict.why
    if again and verdict.window is not None:
        why = "an earlier notice of its event has become a request"
    return AlertPreviewLine(
        id=notice.id,
        event=notice.event,
        source=notice.source,
        received_us=kept.received_us,
        ra=notice.ra,
        dec=notice.dec,
        passes=passes,
        why=why,
    )
