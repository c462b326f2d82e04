"""Proposals and requests in the world in which every right is tried."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

from talaia.hub.observing.alert_rules import AlertRule
from talaia.hub.observing.proposal_access import ProposalRole
from talaia.hub.observing.quotas import ProposalLimits
from talaia.hub.store.observing.alert_store import AlertStore, KeptRule
from talaia.hub.store.observing.proposals import KeptProposal
from talaia.hub.store.observing.request_rows import KeptGroup
from talaia.model.observing.requests import Configuration, Request, RequestGroup, Window
from talaia.model.observing.states import RequestState
from talaia.wire.alerts.filters import AlertFilter

if TYPE_CHECKING:
    from .world import World

# In the year 2100.
_LATER = 4_102_444_800
_NUMBERS = itertools.count()
ALERT_RULE = {"name": "bursts", "configurations": [{"exposure": 1}]}
ASKED = {
    "configurations": [{"exposure": 1}],
    "windows": [{"start_us": _LATER * 10**6, "end_us": (_LATER + 1) * 10**6}],
}


async def make_proposal(world: World, site: str) -> str:
    """Make a proposal that is not open, with all of its members who may ask at the site."""
    name, store = f"P{next(_NUMBERS)}", world.hub.hub.observing.proposals
    await store.add_proposal(
        KeptProposal(
            site=site, id=name, title="Stars", share=0.5, limits=ProposalLimits(hours=9.0),
            is_open=False, needs_approval=True,
        )
    )  # fmt: skip
    for member in ("operator", "keeper", "admin"):
        await store.set_member(site, name, member, ProposalRole.MEMBER)
    return name


async def kept_proposal(world: World, site: str) -> str:
    """Give one proposal of a site for all requests: each more row is read again and again."""
    if site not in world.proposals:
        world.proposals[site] = await make_proposal(world, site)
    return world.proposals[site]


async def make_alert_rule(world: World, site: str, proposal: str) -> str:
    """Make a rule over alerts, in the admin's name."""
    person = await world.hub.people.find_by_name("admin")
    rule = AlertRule(
        name="bursts", filter=AlertFilter(), configurations=(Configuration(exposure=1.0),)
    )
    kept = KeptRule(site=site, proposal=proposal, user=person.id, rule=rule)
    core = world.hub.hub.core
    return str(await AlertStore(core.database, core.clock).write_rule(kept))


async def make_group(
    world: World, site: str, state: RequestState = RequestState.DRAFT, *, submitted: bool = False
) -> tuple[str, str]:
    """Have the operator ask for something; give the numbers of the group and its request."""
    person = await world.hub.people.find_by_name("operator")
    request = Request(
        id="new",
        configurations=(Configuration(exposure=1.0),),
        windows=(Window(start=_LATER, end=_LATER + 1),),
        state=state,
    )
    proposal = await kept_proposal(world, site)
    group = RequestGroup(id="new", proposal=proposal, requester="operator", requests=(request,))
    kept = KeptGroup(
        group=group, site=site, user=person.id, charges=(1.0,), submitted_us=int(submitted)
    )
    store = world.hub.hub.observing.requests
    number = await store.add_group(kept, None)
    found = await store.find_group(site, number)
    return str(number), found.group.requests[0].id
