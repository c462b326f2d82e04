"""Offers a release to gateways, stage by stage, and writes down what becomes of it."""

from __future__ import annotations

import asyncio
import logging
import secrets
from typing import TYPE_CHECKING

import msgspec

from talaia.clock import SECOND
from talaia.errors import TalaiaError
from talaia.hub.live.releases.rollout import (
    Rollout,
    SiteProgress,
    SiteStage,
    advance_rollout,
    due_sites,
)
from talaia.wire.frames import ReleaseOffer

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.clock import Clock
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.live.releases.release_folder import ReleaseFolder
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.wire.frames import ReleaseState

__all__ = ["RolloutRefused", "RolloutService"]

log = logging.getLogger(__name__)
_LOOK_S = 1.0
# An offer that a gateway has not begun with is said again: its line was lost, or its disk full.
_AGAIN_S = 30.0


class RolloutRefused(TalaiaError):
    """A rollout cannot be begun, and why."""


class RolloutService:
    """See the module. For the loop's thread."""

    def __init__(
        self, *, folder: ReleaseFolder, sites: Sites, reporting: RobotEvents, clock: Clock
    ) -> None:
        """Hand out what is in ``folder`` to the gateways of ``sites``."""
        self.folder = folder
        self._sites, self._reporting, self._clock = sites, reporting, clock
        self._rollout: Rollout | None = None
        # When each site was offered it last (monotonic ns), and on which link.
        self._offered: dict[str, tuple[int, object]] = {}

    @property
    def rollout(self) -> Rollout | None:
        """The last rollout; it may be over."""
        return self._rollout

    def report_of(self, site: str) -> ReleaseState | None:
        """Give what a site's gateway has said of its releases on this link."""
        live = self._sites.find_site(site)
        return None if live is None or live.link is None else live.gateway.releases

    async def open(self) -> None:
        """Go on with the rollout of before."""
        try:
            self._rollout = await asyncio.to_thread(self.folder.read_rollout)
        except (OSError, msgspec.DecodeError) as error:
            log.warning("the rollout of before is not gone on with: %s", error)

    async def begin_rollout(
        self, version: str, sites: Sequence[str], *, who: str, first: int, at_once: int
    ) -> Rollout:
        """Begin to offer a release.

        Raises:
            RolloutRefused: another one runs, there is no such release, or a site cannot take it.

        """
        if self._rollout is not None and self._rollout.runs:
            raise RolloutRefused(
                f"the rollout of {self._rollout.version} is under way; stop it before another"
            )
        for site in sites:
            if self.report_of(site) is None:
                raise RolloutRefused(
                    f"{site}: its gateway is not connected, or takes no releases from its hub"
                )
            if await asyncio.to_thread(self.folder.find_release, version, site) is None:
                raise RolloutRefused(f"{site}: there is no release {version} for it in the folder")
        rollout = Rollout(
            id=secrets.token_hex(8),
            version=version,
            who=who,
            began_us=self._clock.wall_ns() // 1000,
            first=first,
            at_once=at_once,
            sites={site: SiteProgress() for site in sites},
        )
        self._offered.clear()
        await self._keep_rollout(rollout)
        return rollout

    async def stop_rollout(self, who: str) -> bool:
        """Offer it to nobody any more; give whether one was under way.

        What a gateway has installed already it goes on with.
        """
        rollout = self._rollout
        if rollout is None or rollout.stopped or not rollout.runs:
            return False
        sites = {
            name: SiteProgress() if site.stage is SiteStage.OFFERED else site
            for name, site in rollout.sites.items()
        }
        await self._keep_rollout(
            msgspec.structs.replace(rollout, stopped=f"{who} stopped it", sites=sites)
        )
        return True

    async def run(self) -> None:
        """Go on with what runs, until cancelled."""
        told = ""
        while True:
            await asyncio.sleep(_LOOK_S)
            try:
                await self._advance_due()
                told = ""
            except OSError as error:
                if str(error) != told:
                    log.warning("the rollout does not go on: %s", error)
                told = str(error)

    async def _advance_due(self) -> None:
        rollout = self._rollout
        if rollout is None or not rollout.runs:
            return
        offered = set()
        for site in due_sites(rollout):
            live = self._sites.find_site(site)
            if live is not None and await self._offer_release(rollout, live):
                offered.add(site)
        # A person may have stopped it while a digest was reckoned.
        if self._rollout is not rollout:
            return
        reports = {
            site: report for site in rollout.sites if (report := self.report_of(site)) is not None
        }
        advanced = advance_rollout(rollout, frozenset(offered), reports)
        if advanced is not rollout:
            await self._keep_rollout(advanced)
            self._report_ends(rollout, advanced)

    async def _offer_release(self, rollout: Rollout, live: LiveSite) -> bool:
        """Offer it to a site that is there and takes releases; give whether it was, at any time."""
        link, report = live.link, live.gateway.releases
        if link is None or report is None or report.current == rollout.version:
            return False
        now_ns = self._clock.monotonic_ns()
        before_ns, on_link = self._offered.get(live.name, (0, None))
        if on_link is link and now_ns - before_ns < _AGAIN_S * SECOND:
            return True
        release = await asyncio.to_thread(self.folder.find_release, rollout.version, live.name)
        if release is None:
            raise FileNotFoundError(f"release {rollout.version} is in the folder no longer")
        digest = await asyncio.to_thread(self.folder.digest_of, release)
        self._offered[live.name] = now_ns, link
        link.send(
            ReleaseOffer(id=rollout.id, version=rollout.version, size=release.size, digest=digest)
        )
        return True

    def _report_ends(self, before: Rollout, after: Rollout) -> None:
        for name, site in after.sites.items():
            live = self._sites.find_site(name)
            if live is None or site.stage is before.sites[name].stage:
                continue
            if site.stage is SiteStage.DONE:
                said = f"it runs {after.version}"
                self._reporting.report_event(live, "gateway updated", message=said, who=after.who)
            elif site.stage is SiteStage.FAILED:
                said = f"{after.version} was left: {site.why}"[:2000]
                self._reporting.report_event(
                    live, "gateway not updated", message=said, who=after.who, good=False
                )

    async def _keep_rollout(self, rollout: Rollout) -> None:
        await asyncio.to_thread(self.folder.write_rollout, rollout)
        self._rollout = rollout
