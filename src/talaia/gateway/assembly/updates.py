"""What a gateway does for its updates: says that its link is there, and ends when it is at rest."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.uplink.hub_releases import HubReleases
from talaia.updates.errors import UpdateError
from talaia.updates.slot_folder import SlotFolder
from talaia.updates.slots import SlotPhase, slot_to_run

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from talaia.gateway.assembly.description import DescriptionPart
    from talaia.gateway.assembly.foundation import FoundationPart
    from talaia.gateway.assembly.uplink import UplinkPart
    from talaia.gateway.settings import UpdateSettings

__all__ = ["UpdatesPart"]

log = logging.getLogger(__name__)
_LOOK_S = 1.0


class UpdatesPart(GatewayPart):
    """Where the settings name the folder of releases (`talaia update run` does)."""

    def __init__(
        self, *, base: FoundationPart, description: DescriptionPart, uplink: UplinkPart
    ) -> None:
        """Look at everything that may move."""
        self._base, self._description = base, description
        self._uplink = uplink
        self._settings: UpdateSettings | None = base.settings.updates
        self._from_hub: HubReleases | None = None
        if self._settings is not None:
            self._from_hub = HubReleases(
                root=self._settings.releases,
                site=description.site.site,
                offers=uplink.releases,
                hub=uplink.hub,
                lanes=base.lanes,
            )

    def tasks(self) -> Mapping[str, Callable[[], Awaitable[None]]]:
        """Watch for a release that waits, and take those that the hub offers."""
        if self._from_hub is None:
            return {}
        return {"watch": self._watch_releases, "from hub": self._from_hub.take_offers}

    def unrest_reason(self) -> str:
        """Say why the gateway may not end now in favour of another release; empty: it may."""
        now_ns = self._base.clock.monotonic_ns()
        actuation = self._uplink.actuation
        if actuation.is_busy():
            return "it is driven, or a command runs"
        night = self._uplink.night.service
        if night is not None and night.is_armed:
            return "the night is armed"
        enclosures = actuation.actuation.interlocks.enclosures
        for name in self._description.site.enclosures:
            # A roof that says nothing may be open.
            if enclosures.read_enclosure(name, now_ns).closed is not True:
                return f"the enclosure {name} is not certainly closed"
        return ""

    async def _watch_releases(self) -> None:
        """End, and the gateway with it, once a release waits and nothing has moved for a while."""
        if self._settings is None or self._from_hub is None:
            return
        folder = SlotFolder(self._settings.releases)
        linked, rest = _Lasting(self._settings.linked_s), _Lasting(self._settings.rest_s)
        marked, told = False, ""
        while True:
            await asyncio.sleep(_LOOK_S)
            now_ns = self._base.clock.monotonic_ns()
            try:
                state = await asyncio.to_thread(folder.read_state)
                # A link that breaks at once is none.
                is_linked = self._uplink.dispatcher.linked.is_set()
                if linked.has_lasted(now_ns, so=is_linked) and not marked:
                    # By the name of its folder: what the program calls itself may be another.
                    await asyncio.to_thread(folder.mark_linked, slot_to_run(state))
                    marked = True
                why = self.unrest_reason() if state.phase is SlotPhase.WAITING else "none waits"
                if state.phase is SlotPhase.WAITING and why != told:
                    log.info("release %s waits: %s", state.candidate, why or "nothing moves")
                told = why
                waits = state.phase is SlotPhase.WAITING
                await self._from_hub.report_state(state, told if waits else "")
                if not rest.has_lasted(self._base.clock.monotonic_ns(), so=not why):
                    continue
                await asyncio.to_thread(folder.allow_trial)
                # What began while the disk was written wins.
                if not self.unrest_reason():
                    log.info("the gateway ends in favour of release %s", state.candidate)
                    return
                await asyncio.to_thread(folder.withdraw_trial)
            except (UpdateError, OSError) as error:
                # A damaged folder of releases must not end a gateway that works.
                if str(error) != told:
                    log.warning("updates: %s", error)
                told = str(error)


class _Lasting:
    """Tells whether something has been so without a break for a while."""

    def __init__(self, seconds: float) -> None:
        self._least_ns = seconds * SECOND
        # Since when (monotonic); none while it is not so.
        self._since_ns: int | None = None

    def has_lasted(self, now_ns: int, *, so: bool) -> bool:
        """Hear how it is now."""
        if not so:
            self._since_ns = None
            return False
        if self._since_ns is None:
            self._since_ns = now_ns
        return now_ns - self._since_ns >= self._least_ns
