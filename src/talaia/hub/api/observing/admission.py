"""Why a request group may not be handed in, in words: quotas, windows, filters. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.observing.request_forms import window_problems
from talaia.hub.live.observing.observing_sites import filters_of, is_observatory
from talaia.hub.observing.quotas import quota_problems
from talaia.hub.observing.site_abilities import site_problems
from talaia.model.observing.requests import GroupOperator

if TYPE_CHECKING:
    from talaia.hub.observing.quotas import TimeAccount
    from talaia.hub.store.observing.proposals import KeptProposal
    from talaia.hub.store.observing.request_rows import KeptGroup
    from talaia.model.observing.requests import RequestGroup
    from talaia.model.site import Site

__all__ = ["GroupAdmission", "group_problems"]


class GroupAdmission:
    """Decides on one group; see `RequestStore.add_group`."""

    def __init__(self, kept: KeptGroup, site: Site, now: float) -> None:
        """Decide by the site's description, at ``now`` (s since the epoch, UTC)."""
        self._kept = kept
        self._site = site
        self._now = now

    def __call__(self, proposal: KeptProposal, person: TimeAccount) -> list[str]:
        """List what is wrong, in words."""
        return quota_problems(
            self._kept.group,
            self._kept.charge,
            proposal.limits,
            proposal=proposal.account,
            person=person,
        ) + group_problems(self._kept.group, self._site, self._now)


def group_problems(group: RequestGroup, site: Site, now: float) -> list[str]:
    """List what of a group cannot be, whoever asks; ``now`` in s since the epoch (UTC)."""
    found = window_problems(group, now)
    if not is_observatory(site):
        found.append("this site does not observe by itself (its description has no night:)")
    if group.operator is GroupOperator.SINGLE and len(group.requests) > 1:
        found.append(f"a SINGLE group has one request, not {len(group.requests)}")
    filters = filters_of(site)
    if filters is not None:
        asked = {
            configuration.filter
            for request in group.requests
            for configuration in request.configurations
            if configuration.filter
        }
        found += [
            f"there is no filter {name!r}; there are {', '.join(filters)}"
            for name in sorted(asked - set(filters))
        ]
    return found + site_problems(group, site)
