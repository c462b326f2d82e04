"""The night as holder of its devices, and its giving way to people."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.gateway.commands.device_holders import DeviceHolder
from talaia.wire.frames import NightPhase

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.gateway.commands.command_service import CommandService
    from talaia.model.night_section import NightSection
    from talaia.model.site import Site

__all__ = ["NightHolds"]

_ACTING = frozenset(
    {NightPhase.OPENING, NightPhase.OBSERVING, NightPhase.CALIBRATING, NightPhase.PARKING}
)


class NightHolds:
    """Who acts on the devices of a night: it, or a person to whom it gives way.

    Attributes:
        devices: that it gives commands to.
        who: what its commands are asked in the name of.

    """

    def __init__(
        self, site: Site, night: NightSection, commands: CommandService, clock: Clock
    ) -> None:
        """Hear of each command of a person."""
        self._site, self._commands, self._clock = site, commands, clock
        self._hand_over_ns = round(night.hand_over * SECOND)
        rule = site.enclosures[night.enclosure]
        named = {*night.commands(), rule.close.command, *(step.command for step in rule.abort)}
        if rule.park is not None:
            named.add(rule.park.command)
        self.devices = frozenset(command.partition("/")[0] for command in named)
        self.who = "night"
        self._held = False
        # The last person who acted, and when it was seen last (monotonic).
        self._person, self._seen_ns = "", 0
        commands.holders.subscribe_commands(self._hear_command)

    def update_holds(self, phase: NightPhase, armed_by: str) -> None:
        """Hold the devices while the night acts on them, and let them go behind it."""
        wanted = phase in _ACTING and not self._person
        if armed_by and not self._held:
            self.who = f"night (armed by {armed_by})"[:200]
        if wanted == self._held:
            return
        self._held = wanted
        for device in sorted(self.devices):
            hold_id = f"night-{device}"
            if not wanted:
                self._commands.holders.release_holder(hold_id)
                continue
            doing = f"{self._site.devices[device].name}: observing by itself"
            now_ns = self._clock.monotonic_ns()
            self._commands.holders.add_holder(
                DeviceHolder(hold_id, device, doing, self.who, now_ns)
            )

    def person_at_work(self, now_ns: int) -> str:
        """Name the person who acts on a device of the night, or did a moment ago."""
        if acting := self._commands.holders.other_holder(self.devices, self.who):
            self._person, self._seen_ns = acting, now_ns
        elif self._person and now_ns - self._seen_ns >= self._hand_over_ns:
            self._person = ""
        return self._person

    def _hear_command(self, device: str, who: str) -> None:
        if device in self.devices and who != self.who:
            self._person, self._seen_ns = who, self._clock.monotonic_ns()
