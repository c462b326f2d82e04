"""Releases from the hub: fetched, held against whom the gateway trusts, and installed to wait."""

from __future__ import annotations

import asyncio
import logging
from functools import partial
from typing import TYPE_CHECKING

from talaia.gateway.errors import KeyRefused, LinkLost
from talaia.gateway.uplink.releases import fetch_release
from talaia.updates.environment_builder import build_environment
from talaia.updates.errors import UpdateError, UpdateRefused
from talaia.updates.hub_source import read_hub_source
from talaia.updates.signed_release import open_release, public_key_of
from talaia.updates.slot_folder import SlotFolder
from talaia.updates.slots import SlotPhase
from talaia.wire.frames import ReleaseState

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.gateway.uplink.links import HubConnection
    from talaia.gateway.uplink.releases import OfferedReleases
    from talaia.gateway.uplink.send_lanes import SendLanes
    from talaia.updates.hub_source import HubSource
    from talaia.updates.slots import SlotState
    from talaia.wire.frames import ReleaseOffer

__all__ = ["HubReleases"]

log = logging.getLogger(__name__)
# Progress is told in steps of so much of the whole.
_STEPS = 20


class HubReleases:
    """Takes what the hub offers, and tells it how releases stand here."""

    def __init__(
        self,
        *,
        root: Path,
        site: str,
        offers: OfferedReleases,
        hub: HubConnection,
        lanes: SendLanes,
    ) -> None:
        """Keep releases below ``root``; take those for ``site``, or for all."""
        self._root, self._site = root, site
        self._folder = SlotFolder(root)
        self._offers, self._hub, self._lanes = offers, hub, lanes
        # What is being fetched, and how many bytes of it are there.
        self._fetching: ReleaseOffer | None = None
        self._fetched = 0
        # The last offer that came to nothing, and why; by the version.
        self._answered = ""
        self._refused: dict[str, str] = {}
        # What the hub was told last, and on which link.
        self._told: ReleaseState | None = None
        self._told_link = 0

    async def take_offers(self) -> None:
        """Fetch and install what is offered, until cancelled."""
        lost = ""
        while True:
            offer = await self._offers.wait_offer()
            try:
                await self._take_release(offer)
                lost = ""
            except (LinkLost, KeyRefused) as error:
                # The hub offers it again; what has come is kept.
                if not lost:
                    log.warning("release %s is fetched later: %s", offer.version, error)
                lost = str(error)
            except (UpdateError, OSError) as error:
                log.warning("release %s of the hub is left: %s", offer.version, error)
                self._refused[offer.version] = str(error)[:2000]
                self._answered = offer.id
            finally:
                self._fetching, self._fetched = None, 0

    async def report_state(self, state: SlotState, waits: str) -> None:
        """Tell the hub, if it is linked, wants to know, and does not know yet.

        Args:
            state: of the releases on disk.
            waits: why the candidate is not tried yet.

        """
        dispatcher = self._hub.dispatcher
        if not self._offers.takes or not dispatcher.linked.is_set():
            return
        try:
            if await asyncio.to_thread(read_hub_source, self._root) is None:
                return
        except UpdateError as error:
            self._refused["?"] = str(error)[:2000]
        message = self._make_state(state, waits)
        if message != self._told or dispatcher.links != self._told_link:
            self._told, self._told_link = message, dispatcher.links
            self._lanes.send(message)

    def _make_state(self, state: SlotState, waits: str) -> ReleaseState:
        phase, candidate = str(state.phase), state.candidate
        offer = self._fetching
        if offer is not None and state.phase in (SlotPhase.IDLE, SlotPhase.WAITING):
            phase, candidate, waits = "fetching", offer.version, ""
        said = {**state.failed, **self._refused}
        return ReleaseState(
            current=state.current,
            phase=phase,
            candidate=candidate,
            waits=waits[:2000],
            fetched=self._fetched,
            answered=self._answered,
            # The newest, if there are very many.
            failed={name[:40]: why[:2000] for name, why in list(said.items())[-100:]},
        )

    async def _take_release(self, offer: ReleaseOffer) -> None:
        source = await asyncio.to_thread(read_hub_source, self._root)
        if source is None:
            raise UpdateRefused("this gateway takes no releases from its hub")
        state = await asyncio.to_thread(self._folder.read_state)
        if state.phase not in (SlotPhase.IDLE, SlotPhase.WAITING):
            return
        # Offered again, because the hub has not heard yet that it is here.
        if offer.version in (state.current, state.candidate):
            return
        self._refused.pop(offer.version, None)
        self._fetching = offer
        step = max(1, offer.size // _STEPS)

        def note_progress(have: int) -> None:
            # Of the whole, so that the hub is not told of each piece.
            self._fetched = have if have == offer.size else have - have % step

        target = self._root / "from-hub" / "offered.release"
        await fetch_release(
            self._hub.trust,
            self._hub.prover,
            offer,
            target=target,
            rate=self._hub.settings.upload_bytes,
            progress=note_progress,
        )
        try:
            await asyncio.to_thread(self._install_release, target, offer.version, source)
        finally:
            await asyncio.to_thread(target.unlink, missing_ok=True)

    def _install_release(self, target: Path, version: str, source: HubSource) -> None:
        keys = [public_key_of(key) for key in source.publishers]
        release = open_release(target, keys, self._site)
        # The hub's word is not signed.
        if release.manifest.version != version:
            raise UpdateRefused(
                f"the hub offered {version}, and what was signed is {release.manifest.version}"
            )
        build = partial(build_environment, system_packages=source.system_packages)
        self._folder.install_release(release, build)
        log.info("release %s of the hub is installed; it waits for rest", version)
