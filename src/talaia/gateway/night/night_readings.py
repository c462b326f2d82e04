"""How things stand for a night, by what safety goes by: interlocks, end switches, the Sun."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.gateway.night.night_values import NightView
from talaia.gateway.night.target_place import sun_altitude

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.gateway.safety.interlocks import Interlocks
    from talaia.model.interlocks.enclosure import Place
    from talaia.model.night_section import NightSection
    from talaia.model.site import Site

__all__ = ["NightReadings"]


class NightReadings:
    """Looks at a moment; what is unknown or too old stays unknown."""

    def __init__(self, *, site: Site, place: Place, interlocks: Interlocks, clock: Clock) -> None:
        """Look at a site that has a night.

        Raises:
            ValueError: it has none.

        """
        if site.night is None:
            raise ValueError(f"{site.site} has no night")
        self._night: NightSection = site.night
        self._rule = site.enclosures[site.night.enclosure]
        self._place, self._interlocks, self._clock = place, interlocks, clock
        self._angles = site.night.angles(site.devices)

    def look_now(self, person: str, seeing: float | None = None) -> NightView:
        """Tell how things stand now; ``person`` is who acts on a device of the night.

        ``seeing`` is what the night measured itself (″); it counts where no signal tells it.
        """
        now_ns, time = self._clock.monotonic_ns(), self._clock.wall_ns() / SECOND
        night, rule = self._night, self._rule
        judge, enclosures = self._interlocks.conditions, self._interlocks.enclosures
        parked = judge.sighting_holds(rule.parked, now_ns) if rule.parked is not None else None
        tracking = night.tracking
        clouds = self._number(night.clouds, now_ns)
        if night.seeing:
            seeing = self._number(night.seeing, now_ns)
        return NightView(
            now=now_ns / SECOND,
            time=time,
            sun=sun_altitude(self._place, time),
            closing=self._interlocks.closing_reason(night.enclosure),
            barred=self._barred(now_ns),
            opened=judge.sighting_holds(night.opened, now_ns),
            closed=enclosures.read_enclosure(night.enclosure, now_ns).closed,
            parked=parked,
            pointing=self._pointing(now_ns),
            person=person,
            clouds=clouds,
            seeing=seeing,
            unread=self._unread(clouds, seeing),
            binning=self._number(night.binning.reading if night.binning else "", now_ns),
            gain=self._number(night.gain.reading if night.gain else "", now_ns),
            rotator=self._number(night.rotator.reading if night.rotator else "", now_ns),
            tracking=judge.sighting_holds(tracking, now_ns) if tracking is not None else None,
        )

    def _unread(self, clouds: float | None, seeing: float | None) -> frozenset[str]:
        """Name what nobody knows now, and what no field that is centred will tell either."""
        night = self._night
        unread = {"clouds"} if clouds is None else set()
        if seeing is None and (night.seeing or night.centring is None):
            unread.add("seeing")
        return frozenset(unread)

    def _pointing(self, now_ns: int) -> tuple[float, float] | None:
        altitude, azimuth = (self._number(address, now_ns) for address in self._angles)
        return None if altitude is None or azimuth is None else (altitude, azimuth)

    def _number(self, address: str, now_ns: int) -> float | None:
        judge = self._interlocks.conditions
        return judge.fresh_value(address, now_ns) if address else None

    def _barred(self, now_ns: int) -> str:
        for command in (self._night.open.command, self._night.unpark.command):
            device, _, name = command.partition("/")
            if why := self._interlocks.refusal_reason(device, name, now_ns):
                return why
        return ""
