"""Proposals, requests and observations in each kind of database."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import pytest
from sqlalchemy import insert

from talaia.clock import SECOND, HandClock
from talaia.hub.alarms.rules import Rule
from talaia.hub.errors import NameTaken, UnknownPerson
from talaia.hub.notify.message import compose_message
from talaia.hub.observing.changes import ImpossibleChange
from talaia.hub.observing.proposal_access import ProposalRole
from talaia.hub.observing.quotas import ProposalLimits, quota_problems
from talaia.hub.store.accounts.people import People
from talaia.hub.store.accounts.roles import Roles
from talaia.hub.store.alarm_tables import notify_ways
from talaia.hub.store.alarms.notification_channels import NotifyStore
from talaia.hub.store.alarms.notification_outbox import NotificationOutbox
from talaia.hub.store.database import Database
from talaia.hub.store.observing.observations import ObservationStore
from talaia.hub.store.observing.proposals import KeptProposal, ProposalInUse, ProposalStore
from talaia.hub.store.observing.request_queries import (
    GroupRefused,
    GroupStep,
    RequestFilter,
)
from talaia.hub.store.observing.request_rows import KeptGroup
from talaia.hub.store.observing.request_store import RequestStore
from talaia.model.alarms.alarm import Severity
from talaia.model.observing.requests import (
    Configuration,
    GroupOperator,
    Request,
    RequestGroup,
    Window,
)
from talaia.model.observing.states import ObservationState, RequestState
from talaia.model.observing.targets import IcrsTarget
from talaia.wire.gateway_messages.night import ObservationUpdate

from ...databases import database_with_tables

SITE = "dome"
CANCEL = GroupStep(
    states=frozenset({RequestState.PENDING}), after=RequestState.CANCELED, who="ada", why="no more"
)


@pytest.fixture
def clock() -> HandClock:
    return HandClock()


class Office:
    """The stores of one hub, a person and a proposal of one hour."""

    def __init__(self, database, clock) -> None:
        """Work on ``database``."""
        self.database, self.clock = database, clock
        self.proposals = ProposalStore(database, clock)
        self.requests = RequestStore(database, clock)
        self.observations = ObservationStore(database, clock)
        self.ada = 0

    async def begin(self) -> Office:
        people = People(self.database, self.clock)
        self.ada = await people.add_person("ada", "x", "operator")
        await self.proposals.add_proposal(proposal())
        await self.proposals.set_member(SITE, "P1", "ada", ProposalRole.MEMBER)
        return self

    def kept(self, *, state=RequestState.PENDING, many=1, charge=600.0, name="M 42") -> KeptGroup:
        now = self.clock.wall_ns() / SECOND
        one = Request(
            id="new",
            target=IcrsTarget(name=name, ra=83.8, dec=-5.4),
            configurations=(Configuration(filter="R", exposure=60.0, count=3),),
            windows=(Window(start=now, end=now + 3600.0),),
            state=state,
        )
        group = RequestGroup(
            id="new", proposal="P1", name="Orion", requester="ada",
            operator=GroupOperator.MANY, requests=(one,) * many,
        )  # fmt: skip
        submitted = 1 if state is RequestState.PENDING else 0
        return KeptGroup(
            group=group, site=SITE, user=self.ada, charges=(charge,) * many, submitted_us=submitted
        )

    def report(self, number, state, request, *, id="o1", **more) -> ObservationUpdate:  # noqa: A002
        return ObservationUpdate(
            number=number, id=id, request=str(request), state=state,
            time=self.clock.wall_ns() / SECOND, **more,
        )  # fmt: skip

    async def state_of(self, request) -> RequestState:
        kept, at = await self.requests.find_request(SITE, int(request))
        return kept.group.requests[at].state


def proposal(**changed) -> KeptProposal:
    limits = ProposalLimits(hours=1.0)
    plain = {
        "site": SITE, "id": "P1", "title": "Nebulae", "share": 0.5, "limits": limits,
        "is_open": False, "needs_approval": False,
    }  # fmt: skip
    return KeptProposal(**{**plain, **changed})


@pytest.fixture
def file_url(tmp_path):
    with database_with_tables("sqlite", tmp_path) as url:
        yield url


@pytest.fixture
async def office(file_url, clock):
    # One kind of database; the last test is held against each.
    kept = Database(file_url)
    yield await Office(kept, clock).begin()
    await kept.close()


async def test_what_was_asked_is_found_as_it_was_asked(office) -> None:
    asked = office.kept(many=2)
    number = await office.requests.add_group(asked, None)
    found = await office.requests.find_group(SITE, number)
    bare = [msgspec.structs.replace(one, id="new") for one in found.group.requests]
    assert tuple(bare) == asked.group.requests
    assert (found.charge, found.group.operator) == (1200.0, GroupOperator.MANY)
    assert await office.requests.find_group("other", number) is None
    (line,) = await office.requests.read_log(int(found.group.requests[0].id))
    assert (line.who, line.before, line.after) == ("ada", "", "PENDING")


async def test_ten_who_ask_at_once_cannot_promise_the_same_hour(office) -> None:
    def admit(kept, person):
        return quota_problems(
            asked.group, asked.charge, kept.limits, proposal=kept.account, person=person
        )

    asked = office.kept(charge=1500.0)
    for _ in range(2):
        await office.requests.add_group(asked, admit)
    with pytest.raises(GroupRefused, match=r"0\.17 h left: 0\.00 h used and 0\.83 h asked for"):
        await office.requests.add_group(asked, admit)
    # A draft promises nothing.
    await office.requests.add_group(office.kept(state=RequestState.DRAFT), None)
    assert (await office.proposals.find_proposal(SITE, "P1")).account == (0.0, 3000.0)


async def test_a_report_counts_once_however_often_it_comes(office) -> None:
    number = await office.requests.add_group(office.kept(), None)
    request = (await office.requests.find_group(SITE, number)).group.requests[0].id
    begun = office.report(1, ObservationState.IN_PROGRESS, request, frames_done=[1], files=["a"])
    failed = office.report(2, ObservationState.FAILED, request, block_s=100.0, files=["b"])
    await office.observations.store_reports(SITE, [begun])
    for _ in range(2):
        stored = await office.observations.store_reports(SITE, [failed, begun])
    assert stored == ([], [], [], [])
    (kept,) = await office.observations.observations_of(SITE, int(request))
    assert (kept.state, kept.files, kept.block_s) == (ObservationState.FAILED, ["a", "b"], 100.0)
    found = (await office.requests.find_group(SITE, number)).group.requests[0]
    assert (found.state, found.failures) == (RequestState.PENDING, 1)
    assert (await office.proposals.find_proposal(SITE, "P1")).account.used == 100.0


async def test_the_third_failure_ends_a_request_and_a_late_success_completes_it(office) -> None:
    number = await office.requests.add_group(office.kept(), None)
    request = (await office.requests.find_group(SITE, number)).group.requests[0].id
    for at in range(3):
        stored = await office.observations.store_reports(
            SITE,
            [office.report(at, ObservationState.FAILED, request, id=f"o{at}", why="no star")],
        )
    (ended,) = stored.ended
    assert (ended.state, ended.user) == (RequestState.FAILURE_LIMIT_REACHED, office.ada)
    assert "no star" in ended.why
    late = office.report(9, ObservationState.COMPLETED, request, id="o9")
    await office.observations.store_reports(SITE, [late])
    assert await office.state_of(request) is RequestState.COMPLETED
    bad = office.report(10, ObservationState.BAD_DATA, request, id="o9")
    await office.observations.store_reports(SITE, [bad])
    assert await office.state_of(request) is RequestState.PENDING
    # It is to be observed once more, which its gateway has to be told.
    assert (await office.requests.pending_set(SITE)).revision == 3


async def test_whoever_asked_is_told_of_each_end_once_by_the_rules_that_want_it(office) -> None:
    async with office.database.write() as connection:
        way = {"name": "m", "kind": "mail", "settings": "{}", "sealed": "", "changed_us": 0}
        await connection.execute(insert(notify_ways).values(id=1, **way))
    channels = NotifyStore(office.database, lambda: None)
    rule = Rule(
        id=0, user=office.ada, site="*", way=1, target="a@b.c", least=Severity.CRITICAL, over=False,
        quiet_from=0, quiet_to=0, quiet_least=Severity.CRITICAL, zone="UTC", group_s=0,
    )  # fmt: skip
    await channels.add_rule(rule)
    wanted = await channels.add_rule(replace(rule, own_requests=True))
    number = await office.requests.add_group(office.kept(many=2), None)
    first = (await office.requests.find_group(SITE, number)).group.requests[0].id
    done = office.report(1, ObservationState.COMPLETED, first, why="all frames kept")
    for _ in range(2):
        await office.observations.store_reports(SITE, [done])
    office.clock.advance(3601 * SECOND)
    await office.requests.expire_requests()
    outbox = NotificationOutbox(office.database)
    message = await outbox.claim_due(office.clock.wall_ns() // 1000)
    # Nobody's right to view is asked: it is their own.
    assert (message.rule, message.target) == (wanted, "a@b.c")
    assert [notice.title for notice in message.notices] == [
        "dome: M 42 is observed", "dome: M 42 was not observed in its windows",
    ]  # fmt: skip
    assert "all frames kept" in message.notices[0].text
    assert compose_message("k", message.notices, "UTC").open == "/"
    assert await outbox.claim_due(office.clock.wall_ns() // 1000) is None


async def test_a_report_of_an_unknown_request_is_kept_and_said(office) -> None:
    for request in ("77", "r00412", "9" * 19, "٣"):
        report = office.report(1, ObservationState.COMPLETED, request, id=request)
        stored = await office.observations.store_reports(SITE, [report])
        assert "nobody made" in stored.oddities[0]
    assert await office.observations.observations_of(SITE, 0) != []


async def test_what_is_over_expires_and_is_pending_no_more(office) -> None:
    number = await office.requests.add_group(office.kept(), None)
    assert await office.requests.expire_requests() == []
    office.clock.advance(3601 * SECOND)
    (ended,) = await office.requests.expire_requests()
    assert (ended.state, ended.target) == (RequestState.WINDOW_EXPIRED, "M 42")
    assert (await office.requests.pending_set(SITE)).groups == []
    with pytest.raises(ImpossibleChange, match="WINDOW_EXPIRED"):
        await office.requests.change_group(SITE, number, CANCEL)


async def test_lists_come_in_pages_and_only_of_the_proposals_that_are_seen(office) -> None:
    await office.requests.add_group(office.kept(many=5), None)
    await office.requests.add_group(office.kept(name="%_\\"), None)
    seen = RequestFilter(proposals={"P1"})
    first, more = await office.requests.list_requests(SITE, seen, 4)
    rest, end = await office.requests.list_requests(
        SITE, RequestFilter(proposals={"P1"}, before=first[-1].id), 4
    )
    assert (len(first), more, len(rest), end) == (4, True, 2, False)
    assert await office.requests.list_requests(SITE, RequestFilter(proposals=()), 9) == ([], False)
    wild = RequestFilter(proposals={"P1"}, text="%_\\")
    assert [one.target for one in (await office.requests.list_requests(SITE, wild, 9))[0]] == [
        "%_\\"
    ]
    done = RequestFilter(proposals={"P1"}, states={RequestState.COMPLETED})
    assert (await office.requests.list_requests(SITE, done, 9))[0] == []


async def test_a_draft_is_written_anew_and_one_that_was_handed_in_is_not(office) -> None:
    number = await office.requests.add_group(office.kept(state=RequestState.DRAFT, many=3), None)
    anew = office.kept(state=RequestState.DRAFT, name="M 1")
    assert await office.requests.replace_draft(number, anew, "ada")
    found = await office.requests.find_group(SITE, number)
    assert [one.target.name for one in found.group.requests] == ["M 1"]
    step = GroupStep(
        states=frozenset({RequestState.DRAFT}), after=RequestState.PENDING, who="ada",
        why="handed in", submitted=True,
    )  # fmt: skip
    await office.requests.change_group(SITE, number, step)
    assert not await office.requests.replace_draft(number, office.kept(), "ada")
    assert len((await office.requests.find_group(SITE, number)).group.requests) == 1
    (ended,) = await office.requests.change_group(SITE, number, CANCEL)
    assert ended.state is RequestState.CANCELED


async def test_proposals_are_changed_and_one_that_was_used_is_not_removed(office) -> None:
    with pytest.raises(NameTaken):
        await office.proposals.add_proposal(proposal(id="p1"))
    with pytest.raises(UnknownPerson):
        await office.proposals.set_member(SITE, "P1", "nobody", ProposalRole.MEMBER)
    assert not await office.proposals.set_member(SITE, "P9", "ada", ProposalRole.MEMBER)
    assert await office.proposals.change_proposal(proposal(title="Stars", is_open=True))
    found = await office.proposals.find_proposal(SITE, "P1")
    assert (found.title, found.is_open, found.role_of(office.ada)) == ("Stars", True, "member")
    assert (await office.requests.pending_set(SITE)).revision == 2
    await office.requests.add_group(office.kept(state=RequestState.DRAFT), None)
    with pytest.raises(ProposalInUse):
        await office.proposals.remove_proposal(SITE, "P1")
    await office.proposals.add_proposal(proposal(id="P2"))
    assert await office.proposals.remove_proposal(SITE, "P2")


async def test_operators_may_ask_and_arm_and_to_approve_is_the_admin_s(database, clock) -> None:
    # In each kind of database: the rights that came with it, and a request from start to end.
    operator = next(role for role in await Roles(database).list_roles() if role.name == "operator")
    held = {one.right.value for one in operator.grants.permissions}
    assert held == {"view", "use", "request", "arm"}
    office = await Office(database, clock).begin()
    number = await office.requests.add_group(office.kept(many=2), lambda *_: [])
    first, second = (await office.requests.find_group(SITE, number)).group.requests
    done = office.report(1, ObservationState.COMPLETED, first.id, block_s=7.5, frames_done=[3])
    for _ in range(2):
        await office.observations.store_reports(SITE, [done])
    office.clock.advance(3601 * SECOND)
    assert [one.id for one in await office.requests.expire_requests()] == [int(second.id)]
    asked = RequestFilter(proposals={"P1"}, user=office.ada, text="ORION")
    found, _ = await office.requests.list_requests(SITE, asked, 9)
    assert [one.state for one in found] == ["WINDOW_EXPIRED", "COMPLETED"]
    log = await office.requests.read_log(int(first.id))
    assert [line.after for line in log] == ["PENDING", "COMPLETED"]
    assert (await office.proposals.find_proposal(SITE, "P1")).account == (7.5, 0.0)
