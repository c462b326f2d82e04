"""Notices of transients become rapid requests by the rules of proposals; retractions end these."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, NamedTuple, Protocol

from talaia.hub.live.observing.observing_sites import instrument_of, is_observatory
from talaia.hub.observing.alert_rules import judge_notice, request_of_notice
from talaia.hub.observing.changes import ImpossibleChange
from talaia.hub.observing.charging import request_charge
from talaia.hub.observing.proposal_access import ProposalAccess, proposal_access
from talaia.hub.store.observing.request_queries import GroupRefused, GroupStep
from talaia.hub.store.observing.request_rows import KeptGroup
from talaia.model.observing.states import RequestState

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.live.observing.observing_sites import ObservingNews
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.observing.alert_store import AlertAsker, AlertStore, KeptNotice, KeptRule
    from talaia.hub.store.observing.proposals import KeptProposal, ProposalStore
    from talaia.hub.store.observing.request_queries import Admission
    from talaia.hub.store.observing.request_store import RequestStore
    from talaia.model.site import Site
    from talaia.wire.alerts.notice import AlertNotice

__all__ = ["AlertIntake", "IntakeResult", "MakeAdmission", "RuleOutcome"]

# States of a request that a retraction ends.
_OPEN = frozenset({RequestState.DRAFT, RequestState.PENDING, RequestState.FAILURE_LIMIT_REACHED})


class MakeAdmission(Protocol):
    """Gives what decides on one group, by a site's description and the time (s, UTC)."""

    def __call__(self, kept: KeptGroup, site: Site, now: float) -> Admission:
        """Give it."""
        ...


class RuleOutcome(NamedTuple):
    """What one rule made of a notice; ``group`` is 0 where it asked for nothing."""

    rule: int
    name: str
    proposal: str
    group: int
    why: str


class IntakeResult(NamedTuple):
    """What became of a notice.

    Attributes:
        known: it had come before; nothing was done again.
        outcomes: by each rule that was asked.
        canceled: groups that a retraction ended.

    """

    known: bool
    outcomes: tuple[RuleOutcome, ...] = ()
    canceled: tuple[int, ...] = ()


class AlertIntake:
    """Takes one notice at a time, each once (by its IVORN)."""

    def __init__(
        self,
        *,
        alerts: AlertStore,
        proposals: ProposalStore,
        requests: RequestStore,
        admission: MakeAdmission,
        news: ObservingNews,
        audit: Audit,
        clock: Clock,
    ) -> None:
        """Ask in ``requests``, held to quotas by ``admission``; gateways are told by ``news``."""
        self._alerts = alerts
        self._proposals = proposals
        self._requests = requests
        self._admission = admission
        self._news = news
        self._audit = audit
        self._clock = clock
        # Two copies of one notice must not both be the first.
        self._turn = asyncio.Lock()

    async def take_notice(
        self,
        live: LiveSite,
        notice: AlertNotice,
        *,
        asker: AlertAsker | None = None,
    ) -> IntakeResult:
        """Let the rules of a site's proposals act upon a notice.

        Args:
            live: the site.
            notice: as it was read.
            asker: who brought it; only the rules of proposals in which they may ask are asked.
                None: the hub found it in its folder, which is its administrator's: all are.

        Raises:
            StoreDown: nothing can be kept now; the notice must come again.

        """
        site = live.description.site
        if not is_observatory(live.description):
            return IntakeResult(known=False)
        async with self._turn:
            # One that somebody made up must not hide the true one: each bringer's are known apart.
            user = asker.user if asker is not None else 0
            kept = await self._alerts.keep_notice(site, notice, user)
            if kept.handled:
                return IntakeResult(known=True)
            listed = {one.id: one for one in await self._proposals.list_proposals(site)}
            rules = [
                (rule, listed[rule.proposal])
                for rule in await self._alerts.list_rules(site)
                if rule.proposal in listed
                and (asker is None or _access_of(asker, listed[rule.proposal]).asks)
            ]
            if notice.retracts:
                ended = await self._end_requests(live, kept, {one.id for one, _ in rules}, asker)
                result = IntakeResult(known=False, canceled=tuple(ended))
            else:
                before = await self._alerts.asked_of_event(site, notice)
                outcomes = [
                    await self._ask_rule(
                        live, kept, rule=rule, proposal=proposal, before=before.get(rule.id, 0)
                    )
                    for rule, proposal in rules
                    if rule.rule.active
                ]
                result = IntakeResult(known=False, outcomes=tuple(outcomes))
            # Last: a notice whose handling was cut off is handled when it comes again.
            await self._alerts.mark_handled(kept.id)
        return result

    async def _ask_rule(
        self,
        live: LiveSite,
        kept: KeptNotice,
        *,
        rule: KeptRule,
        proposal: KeptProposal,
        before: int,
    ) -> RuleOutcome:
        """Hand one rule's request in, if the notice passes and its maker still may ask."""

        def outcome(why: str, group: int = 0) -> RuleOutcome:
            return RuleOutcome(rule.id, rule.rule.name, proposal.id, group, why)

        now = self._clock.wall_ns() / 1e9
        verdict = judge_notice(rule.rule, kept.notice, now)
        if verdict.window is None:
            return outcome(verdict.why)
        if before:
            return outcome(f"of its event there is request group {before} already")
        maker = await self._alerts.find_maker(rule.user)
        access = _access_of(maker, proposal)
        if maker is None or not access.asks:
            return outcome("who made the rule may not ask in this proposal any more")
        waits = proposal.needs_approval and not access.approves
        group = request_of_notice(
            rule.rule,
            kept.notice,
            verdict.window,
            proposal=proposal.id,
            requester=maker.name,
            state=RequestState.DRAFT if waits else RequestState.PENDING,
        )
        instrument = instrument_of(live.description)
        asked = KeptGroup(
            group=group,
            site=rule.site,
            user=maker.user,
            charges=tuple(request_charge(one, instrument) for one in group.requests),
            submitted_us=round(now * 1e6),
        )
        admit = self._admission(asked, live.description, now)
        try:
            number = await self._requests.add_group(
                asked, admit, self._alerts.link_group(kept, rule)
            )
        except GroupRefused as error:
            self._audit.append_record(
                "alert refused",
                who=maker.name,
                site=rule.site,
                message=f"{kept.notice.id}: {error}",
                good=False,
            )
            return outcome(str(error))
        said = f"{number} of {proposal.id} by rule {rule.rule.name!r}: {kept.notice.id}"
        self._record("request by alert", maker.name, rule.site, said)
        self._news.requests_changed(rule.site)
        return outcome(verdict.why, number)

    async def _end_requests(
        self, live: LiveSite, kept: KeptNotice, rules: set[int], asker: AlertAsker | None
    ) -> list[int]:
        """End what was asked for an event that its sender has taken back."""
        site, ended = live.description.site, []
        who = asker.name if asker is not None else ""
        step = GroupStep(
            states=_OPEN,
            after=RequestState.CANCELED,
            who=who,
            why=f"its alert was retracted by {kept.notice.id}",
        )
        for rule, group in (await self._alerts.asked_of_event(site, kept.notice)).items():
            if rule not in rules:
                continue
            try:
                await self._requests.change_group(site, group, step)
            # Observed already, or ended by a person.
            except ImpossibleChange:
                continue
            ended.append(group)
            self._record("alert retracted", who, site, f"{group}: {step.why}")
        if ended:
            self._news.requests_changed(site)
        return ended

    def _record(self, kind: str, who: str, site: str, message: str) -> None:
        self._audit.append_record(kind, who=who, site=site, message=message)


def _access_of(maker: AlertAsker | None, proposal: KeptProposal) -> ProposalAccess:
    """Give what the maker of a rule may with its proposal now, not when it was made."""
    if maker is None:
        return ProposalAccess()
    role = proposal.role_of(maker.user)
    return proposal_access(maker.grants, proposal.site, role, is_open=proposal.is_open)
