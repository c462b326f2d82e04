"""Nights to be lived through: a place and a date with a short dark time, and what is asked."""

from __future__ import annotations

import calendar
import random
from pathlib import Path

from msgspec.structs import replace

from talaia.clock import SECOND, HandClock
from talaia.gateway.night.target_place import sun_altitude
from talaia.model.interlocks.enclosure import Place
from talaia.model.observing.requests import Configuration, Request, RequestGroup, Urgency, Window
from talaia.model.observing.targets import IcrsTarget
from talaia.model.site import Site
from talaia.model.units import astronomy
from talaia.model.yaml_text.load import load_site

EXAMPLE = Path(__file__).parents[3] / "examples" / "observatory" / "site.yaml"


def site_at(latitude: float) -> Site:
    """Give the example at another latitude: in June a night is as short as one likes."""
    site = load_site(EXAMPLE.read_text())
    assert site.night is not None
    # Pictures of these nights are too small for stars: focus and centring have tests of their own.
    night = replace(site.night, focuser=None, centring=None)
    place = Place(latitude=latitude, longitude=0.73, elevation=500.0)
    return replace(site, place=place, night=night)


def dawn_of(place: Place, month: int, day: int, sun: float) -> float:
    """Give when the Sun has risen to that altitude in the morning (s since the epoch)."""
    time = float(calendar.timegm((2026, month, day, 0, 30, 0)))
    while sun_altitude(place, time) < sun:
        time += 60.0
    return time


def dusk_of(place: Place, month: int, day: int, sun: float) -> float:
    """Give when the Sun has sunk to that altitude in the evening before (s since the epoch)."""
    time = float(calendar.timegm((2026, month, day, 0, 0, 0)))
    while sun_altitude(place, time) < sun:
        time -= 60.0
    return time


def clock_at(unix: float) -> HandClock:
    # Monotonic time does not begin with nothing: a machine has run before its gateway.
    return HandClock(round(unix * SECOND), 1000 * SECOND)


def asked(
    name: str,
    at: float,
    place: Place,
    *,
    frames: int = 3,
    seconds: float = 60.0,
    hours_east: float = 1.0,
    dec: float = 45.0,
    urgency: Urgency = Urgency.NORMAL,
    priority: float = 10.0,
) -> RequestGroup:
    """Ask for frames of a place that stands so far east of the meridian then."""
    hours = astronomy.sidereal_hours(astronomy.julian_day(at), place.longitude)
    return RequestGroup(
        id=f"g-{name}",
        proposal="school",
        urgency=urgency,
        priority=priority,
        requests=(
            Request(
                id=name,
                target=IcrsTarget(name=name, ra=(hours + hours_east) % 24.0 * 15.0, dec=dec),
                configurations=(Configuration(exposure=seconds, count=frames),),
                windows=(Window(start=at - 86_400.0, end=at + 86_400.0),),
            ),
        ),
    )


def some_requests(
    dice: random.Random, dusk: float, place: Place, hours: float
) -> list[RequestGroup]:
    """Give some that may be observed in such a night, most of them."""
    # Enough for most of it, and of a short night for all of it.
    count = dice.randint(6, 10) + round(dice.uniform(1.0, 3.0) * max(0.0, hours - 3.0))
    last = max(4.0, hours)
    return [
        asked(
            f"r{number:02d}",
            dusk + dice.uniform(1.0, last) * 3600.0,
            place,
            frames=dice.randint(2, 6),
            seconds=dice.choice((30.0, 60.0, 120.0, 240.0)),
            hours_east=dice.uniform(-2.0, 2.0),
            dec=dice.uniform(10.0, 80.0),
            priority=dice.uniform(1.0, 30.0),
        )
        for number in range(count)
    ]
