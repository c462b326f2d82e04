"""What is true of a site now, for clients that know no ages: a value, or nothing. Pure.

What is stale, not reached or said by a gateway that is away is nothing; and `unsafe_reason` takes
nothing for unsafe. Alpaca's clients open roofs by it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.hub.auth.permissions import sees_signal
from talaia.model.discovery.role_proposal import meanings_of, with_roles
from talaia.model.roles import SignalRole, StateMeaning
from talaia.model.site import SignalType

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.hub.auth.permissions import Grants
    from talaia.hub.live.sites import LiveSite
    from talaia.model.site import Device, Signal

__all__ = ["SiteValues"]


class SiteValues:
    """One site as one account sees it, at one moment."""

    def __init__(self, live: LiveSite, grants: Grants, now_ns: int) -> None:
        """Read ``live`` for an account; ``now_ns`` is monotonic."""
        self.live = live
        self._grants, self._now_ns = grants, now_ns
        self._places = {channel.address: at for at, channel in enumerate(live.channels)}

    def devices(self) -> Iterator[tuple[str, Device]]:
        """Go through the devices, with the roles that are proposed for them."""
        for name, device in self.live.description.devices.items():
            yield name, with_roles(device)

    def signals_of(self, device: str, role: SignalRole) -> list[tuple[str, Signal]]:
        """Give the signals of a device that have a role and that the account sees."""
        described = self.live.description.devices.get(device)
        if described is None:
            return []
        return [
            (name, signal)
            for name, signal in with_roles(described).signals.items()
            if signal.role is role
            and sees_signal(self._grants, self.live.description, device, name)
        ]

    def number(self, device: str, role: SignalRole) -> tuple[float, str] | None:
        """Give a number and its unit; none while it is not known."""
        for name, signal in self.signals_of(device, role):
            value = self._value(device, name, signal)
            if value is not None and signal.type is SignalType.NUMBER:
                return value, signal.unit
        return None

    def age_s(self, device: str, role: SignalRole) -> float | None:
        """Tell how old a signal's value is (s); none where none is known."""
        for name, signal in self.signals_of(device, role):
            if self._value(device, name, signal) is not None:
                arrived = int(self.live.latest.arrived_ns[self._places[f"{device}/{name}"]])
                return (self._now_ns - arrived) / SECOND
        return None

    def meaning(self, device: str, role: SignalRole) -> StateMeaning | None:
        """Give what a state means; none while it is not known, or means nothing that is known."""
        for name, signal in self.signals_of(device, role):
            value = self._value(device, name, signal)
            meanings = meanings_of(signal, signal.role)
            if value is not None and 0 <= value < len(meanings):
                return meanings[int(value)]
        return None

    def truth(self, device: str, role: SignalRole) -> bool | None:
        """Give a state of two as a truth: its second is yes; none while it is not known."""
        for name, signal in self.signals_of(device, role):
            value = self._value(device, name, signal)
            if value is not None and len(signal.states) == 2:
                return int(value) == 1
        return None

    def unsafe_reason(self) -> str:
        """Say why it is not safe; empty only where everything that judges safety says that it is.

        Interlocks count whoever may see them: what an account may not see must not look safe.
        """
        live = self.live
        if not live.online:
            return "the site's gateway is not connected"
        judges = 0
        for device, described in self.devices():
            for name, signal in described.signals.items():
                if signal.role is not SignalRole.WEATHER_SAFETY:
                    continue
                judges += 1
                value = self._value(device, name, signal)
                meanings = meanings_of(signal, signal.role)
                if value is None:
                    return f"{device}/{name} is not known"
                if not 0 <= value < len(meanings) or meanings[int(value)] is not StateMeaning.SAFE:
                    return f"{device}/{name} does not say safe"
        for name in live.description.interlocks:
            judges += 1
            told = live.current.interlocks.get(name)
            if told is None:
                return f"how the interlock {name} stands is not known"
            state = told[0]
            # Also one that is overridden: a person answers for that, and no program does.
            if state.locked or state.unsafe or state.unknown:
                return f"the interlock {name}: {state.why or 'it locks'}"
        for name in live.description.enclosures:
            judges += 1
            why = live.retained.enclosures.get(name)
            if why is None:
                return f"how the enclosure {name} stands is not known"
            if why:
                return f"the enclosure {name}: {why}"
        return "" if judges else "the site has nothing that judges safety"

    def _value(self, device: str, name: str, signal: Signal) -> float | None:
        at = self._places.get(f"{device}/{name}")
        live = self.live
        if at is None or not live.online or device in live.current.unreached:
            return None
        arrived = int(live.latest.arrived_ns[at])
        if arrived < 0 or (self._now_ns - arrived) / SECOND > signal.stale_after:
            return None
        value = float(live.latest.value[at])
        return value if math.isfinite(value) else None
