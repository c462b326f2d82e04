"""A rack power distribution unit with eight switched outlets. Pure: time is given."""

from __future__ import annotations

from talaia.sim.observatory.models.ticket import Ticket

__all__ = ["OUTLETS", "Power"]

OUTLETS = ("Dome", "Telescope", "Camera", "Cooling", "Dew heater", "Lamp", "CCTV", "Spare")
# What each one's device draws (W).
_WATT = (120.0, 60.0, 25.0, 40.0, 30.0, 20.0, 8.0, 0.0)


class Power:
    """Outlets 1 to 8. Turning one off is always allowed."""

    REBOOT_S = 5.0

    def __init__(self) -> None:
        """Start as an observatory is left: everything on but lamp and spare."""
        self.on = [name not in ("Lamp", "Spare") for name in OUTLETS]
        # Outlets that are being rebooted, with the time until each is on again (s).
        self._again: dict[int, float] = {}

    @property
    def watt(self) -> float:
        """Give what all outlets draw (W)."""
        return sum(watt for watt, on in zip(_WATT, self.on, strict=True) if on)

    def switch_outlet(self, outlet: int, *, on: bool) -> Ticket:
        """Switch an outlet, counted from 1."""
        if not 1 <= outlet <= len(OUTLETS):
            return Ticket.refused(f"outlet {outlet}: expected 1 to {len(OUTLETS)}")
        # Whoever switches it by hand ends a reboot.
        self._again.pop(outlet, None)
        self.on[outlet - 1] = on
        return Ticket.done(f"outlet {outlet} ({OUTLETS[outlet - 1]}) is {'on' if on else 'off'}")

    def reboot_outlet(self, outlet: int) -> Ticket:
        """Switch an outlet off, and on again after some seconds."""
        ticket = self.switch_outlet(outlet, on=False)
        if ticket.good:
            self._again[outlet] = self.REBOOT_S
        return ticket

    def step(self, seconds: float) -> None:
        """Let time pass."""
        for outlet, left in list(self._again.items()):
            self._again[outlet] = left - seconds
            if left <= seconds:
                self.switch_outlet(outlet, on=True)

    def outlet_words(self) -> str:
        """Give all outlets in one line."""
        return " ".join(f"{n}:{'on' if on else 'off'}" for n, on in enumerate(self.on, 1))
