"""Link-loss policies over time: what is due without the hub, and which roofs that closes. Pure.

A policy that gives the closing command of an enclosure does not give it once and hope: the roof is
wanted closed from then on, with the guard's order, retries, end switches and alarm, until the link
is back.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia.clock import SECOND

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.model.interlocks.interlock import LinkLossPolicy
    from talaia.model.site import Site

__all__ = ["LinkLosses"]


class LinkLosses:
    """All policies of a site.

    Attributes:
        lost_ns: since when there is no link (monotonic); none while there is one.
        attended: whether something at the gateway looks after a device without the hub, so that
            its policy waits.

    """

    def __init__(self, site: Site, now_ns: int) -> None:
        """Start without a link."""
        # From the start: a gateway that never finds its hub is as alone as one that lost it.
        self.lost_ns: int | None = now_ns
        self.attended: Callable[[str], bool] = lambda _device: False
        self._site = site  # Its enclosures, to know which commands are theirs.
        self._policies = _link_policies(site)  # By device; those without a policy are not in it.
        # Devices whose policy has been carried out in this loss: each is, once.
        self._acted: set[str] = set()
        # Why a roof is wanted closed, by enclosure, until the link is back.
        self._closing: dict[str, str] = {}

    @property
    def idle(self) -> bool:
        """Whether nothing can become due."""
        # `lost_ns` None means there is a link: nothing is counted.
        return self.lost_ns is None or not self._policies.keys() - self._acted

    def redescribe(self, site: Site) -> None:
        """Go by another description; what has acted does not act again before the next loss."""
        self._site = site
        self._policies = _link_policies(site)
        self._closing = {
            name: why for name, why in self._closing.items() if name in site.enclosures
        }

    def link_up(self) -> None:
        """Call off what was to follow, and want no roof closed for it any more."""
        self.lost_ns = None
        self._acted.clear()
        self._closing.clear()

    def link_lost(self, now_ns: int) -> None:
        """Count from now."""
        self.lost_ns = now_ns

    def due_policies(self, age_ns: Callable[[int], int]) -> list[tuple[str, LinkLossPolicy]]:
        """Give what is due now, each once: the device, and what of its policy is left to run.

        Args:
            age_ns: says how long ago a moment was (ns), as the gateway judges ages.

        """
        if self.lost_ns is None:
            return []
        lost_for, found = age_ns(self.lost_ns), []
        for device, policy in self._policies.items():
            if self.attended(device):
                continue
            if device not in self._acted and lost_for >= round(policy.after * SECOND):
                # Marked before it is run: what fails is not begun again by the next look; roofs
                # have their guards for that.
                self._acted.add(device)
                found.append((device, self._without_closing(policy)))
        return found

    def closing_reason(self, enclosure: str) -> str:
        """Say why a roof has to be closed, if a policy wants it; empty otherwise."""
        return self._closing.get(enclosure, "")

    def _without_closing(self, policy: LinkLossPolicy) -> LinkLossPolicy:
        """Hand the closing of roofs to their guards; give what else is to be done."""
        steps = policy.run
        for name, rule in self._site.enclosures.items():
            if all(step.command != rule.close.command for step in steps):
                continue
            self._closing[name] = f"no hub for {policy.after:g} s"
            # Abort, park and close are what the guard does in its own order; run here as well they
            # would cross it.
            guards = {rule.close.command, *(step.command for step in rule.abort)}
            if rule.park is not None:
                guards.add(rule.park.command)
            steps = tuple(step for step in steps if step.command not in guards)
        return msgspec.structs.replace(policy, run=steps)


def _link_policies(site: Site) -> dict[str, LinkLossPolicy]:
    return {
        name: device.link_loss
        for name, device in site.devices.items()
        if device.link_loss is not None
    }
