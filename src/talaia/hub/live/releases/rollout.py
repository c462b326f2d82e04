"""A release on its way to several gateways, some at a time. Pure.

    queued ── its stage has come ──▸ offered ── it is installed there ──▸ begun ──▸ done
                                        │ it was refused                    │ it was left
                                        └────────────────▸ failed ◂─────────┘

The first that fails stops the rollout: nobody is offered it any more who was not. A gateway that
is away holds its stage up, and with it all that follow.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import msgspec
from msgspec import Meta

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.wire.frames import ReleaseState

__all__ = ["MOST_SITES", "Rollout", "SiteProgress", "SiteStage", "advance_rollout", "due_sites"]

MOST_SITES = 10_000


class SiteStage(StrEnum):
    """How far a site is."""

    QUEUED = "queued"
    OFFERED = "offered"
    BEGUN = "begun"
    DONE = "done"
    FAILED = "failed"


class SiteProgress(msgspec.Struct, frozen=True, kw_only=True):
    """One site of a rollout.

    Attributes:
        stage: how far it is.
        why: it has failed; else empty.

    """

    stage: SiteStage = SiteStage.QUEUED
    why: str = ""


class Rollout(msgspec.Struct, frozen=True, kw_only=True):
    """See the module.

    Attributes:
        id: names this wish of an admin.
        version: the release.
        who: wants it.
        began_us: since when (UTC).
        first: so many sites are the first stage.
        at_once: and so many each one after it.
        sites: in the order in which they have their turn.
        stopped: why nobody is offered it any more; empty: it goes on, or all have it.

    """

    id: str
    version: str
    who: str
    began_us: int
    first: Annotated[int, Meta(ge=1)]
    at_once: Annotated[int, Meta(ge=1)]
    sites: Annotated[dict[str, SiteProgress], Meta(min_length=1, max_length=MOST_SITES)]
    stopped: str = ""

    @property
    def runs(self) -> bool:
        """Whether anything may follow of it."""
        waits = (SiteStage.OFFERED, SiteStage.BEGUN)
        if self.stopped:
            # Those that have it already come to their end.
            return any(site.stage in waits for site in self.sites.values())
        return any(site.stage is not SiteStage.DONE for site in self.sites.values())


def due_sites(rollout: Rollout) -> list[str]:
    """Give the sites that may be offered the release now, or be offered it again."""
    if rollout.stopped:
        return []
    names = list(rollout.sites)
    begin, size = 0, rollout.first
    while begin < len(names):
        stage = names[begin : begin + size]
        if any(rollout.sites[name].stage is not SiteStage.DONE for name in stage):
            open_stages = (SiteStage.QUEUED, SiteStage.OFFERED)
            return [name for name in stage if rollout.sites[name].stage in open_stages]
        begin, size = begin + size, rollout.at_once
    return []


def advance_rollout(
    rollout: Rollout, offered: frozenset[str], reports: Mapping[str, ReleaseState]
) -> Rollout:
    """Judge each site by what its gateway has said.

    Args:
        rollout: as it was.
        offered: sites that are offered the release now.
        reports: what gateways that are linked have said last, by site.

    """
    sites = {name: _judge_site(rollout, name, offered, reports.get(name)) for name in rollout.sites}
    stopped = rollout.stopped
    failed = [name for name, site in sites.items() if site.stage is SiteStage.FAILED]
    if failed and not stopped:
        stopped = f"{failed[0]}: {sites[failed[0]].why}"
    if sites == rollout.sites and stopped == rollout.stopped:
        return rollout
    return msgspec.structs.replace(rollout, sites=sites, stopped=stopped)


def _judge_site(
    rollout: Rollout, name: str, offered: frozenset[str], report: ReleaseState | None
) -> SiteProgress:
    before, version = rollout.sites[name], rollout.version
    now = before
    if before.stage is SiteStage.QUEUED and name in offered:
        now = SiteProgress(stage=SiteStage.OFFERED)
    if now.stage in (SiteStage.DONE, SiteStage.FAILED) or report is None:
        return now
    # Also of one that was never offered it: somebody has installed it by hand.
    if report.current == version:
        return SiteProgress(stage=SiteStage.DONE)
    if now.stage is SiteStage.QUEUED:
        return now
    if report.candidate == version and report.phase != "fetching":
        return SiteProgress(stage=SiteStage.BEGUN)
    # What was left before it was offered says nothing of this time.
    its_word = now.stage is SiteStage.BEGUN or report.answered == rollout.id
    if its_word and version in report.failed and report.candidate != version:
        return SiteProgress(stage=SiteStage.FAILED, why=report.failed[version])
    return now
