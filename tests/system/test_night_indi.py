"""A short night on INDI's own simulators: armed, observed, interrupted by weather, disarmed.

And twilight flats on them, by the same executor, where the Sun stands as at dusk just now.
"""

from __future__ import annotations

import asyncio
import sys
import time
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
import yaml
from msgspec.structs import replace

sys.path.insert(0, str(Path(__file__).parents[1] / "gateway"))
sys.path.insert(0, str(Path(__file__).parents[1] / "gateway/adapters/indi"))
from fake_hub import KEY, FakeHub, fake_hub
from indi_server import server_of

from talaia.gateway.night.target_place import sun_altitude
from talaia.gateway.run import serve_gateway
from talaia.gateway.settings import GatewaySettings, HubAddress
from talaia.imaging.frame_tasks import measure_level
from talaia.model.checks.site_checks import raise_first
from talaia.model.observing.requests import (
    Configuration,
    ImageType,
    Proposal,
    Request,
    RequestGroup,
    Window,
)
from talaia.model.observing.states import ObservationState
from talaia.model.observing.targets import IcrsTarget
from talaia.model.units import astronomy
from talaia.model.yaml_text.load import load_site
from talaia.sim.observatory.night import at_night
from talaia.wire.frames import (
    CommandRequest,
    Event,
    NightArmRequest,
    NightDisarmRequest,
    NightPhase,
    NightPlan,
    NightState,
    ObservationUpdate,
    RequestRevision,
    RequestSync,
)

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from talaia.model.night_frames import NightFlats
    from talaia.model.site import Site

pytestmark = pytest.mark.robot
EXAMPLE = Path(__file__).parents[2] / "examples" / "indi" / "site.yaml"
DRIVERS = tuple(
    f"indi_simulator_{name}" for name in ("telescope", "ccd", "dome", "weather", "rotator")
)
WITHIN_S = 120.0
# Where the top of the pictures is asked to point (°).
ANGLE = 25.0
S = ObservationState


# Its sky glow for a night is 19.5 mag, of which a tenth counts in its flats: with that they are
# white at once. This one gives about the right level in a second.
TWILIGHT_MAG = 67.0


def described(port: int) -> Site:
    """Give the example without its second station, with short dwells, where it is night now."""
    return at_night(raise_first(load_site(described_text(port))), time.time())


def described_text(port: int, **setup: object) -> str:
    text = yaml.safe_load(EXAMPLE.read_text())
    text["connections"]["indi"] |= {"port": port, "discover": False}
    del text["devices"]["station"]
    interlocks = text["interlocks"]
    interlocks["weather"]["when"] = [
        rule for rule in interlocks["weather"]["when"] if "humidity" not in rule
    ]
    for rule in interlocks.values():
        rule["dwell"] = 3
    text["devices"]["weather"]["setup"]["WEATHER_UPDATE"]["PERIOD"] = 1
    text["night"]["filter"] = None
    text["night"]["times"] = {"settle": 1, "slew_rate": 3}
    del text["night"]["filter"]
    if setup:
        text["devices"]["camera"]["setup"] = setup
    return yaml.safe_dump(text, allow_unicode=True)


def at_twilight(site: Site) -> Site:
    """Give a site where the Sun sinks through the middle of what flats are taken in just now."""
    assert site.place is not None
    now = time.time()

    def sun_at(longitude: float, after: float = 0.0) -> float:
        assert site.place is not None
        return sun_altitude(replace(site.place, longitude=longitude), now + after)

    dusk = [
        east / 2.0 for east in range(-360, 360) if sun_at(east / 2.0) > sun_at(east / 2.0, 60.0)
    ]
    longitude = min(dusk, key=lambda east: abs(sun_at(east) + 9.5))
    return replace(site, place=replace(site.place, longitude=longitude))


def asked(site: Site, name: str, frames: int, seconds: float, hours_east: float) -> RequestGroup:
    assert site.place is not None
    now = time.time()
    hours = astronomy.sidereal_hours(astronomy.julian_day(now), site.place.longitude)
    ra = (hours + hours_east) % 24.0 * 15.0
    return RequestGroup(
        id=f"g-{name}",
        proposal="school",
        requests=(
            Request(
                id=name,
                target=IcrsTarget(name=name, ra=ra, dec=40.0, position_angle=ANGLE),
                configurations=(Configuration(exposure=seconds, count=frames),),
                windows=(Window(start=now - 60.0, end=now + 7200.0),),
            ),
        ),
    )


def asked_bias() -> RequestGroup:
    now = time.time()
    request = Request(
        id="bias",
        configurations=(Configuration(type=ImageType.BIAS, exposure=0.0, count=2),),
        windows=(Window(start=now - 60.0, end=now + 7200.0),),
    )
    return RequestGroup(id="g-bias", proposal="school", requests=(request,))


@asynccontextmanager
async def gateway_of(site: Site, hub: FakeHub, data: Path) -> AsyncIterator[None]:
    ended = asyncio.Event()
    settings = GatewaySettings(
        hub=HubAddress.from_text(hub.url, allow_plain=True), key=KEY, data=data
    )
    task = asyncio.ensure_future(serve_gateway(site, settings, ended))
    try:
        yield
    finally:
        ended.set()
        await asyncio.wait_for(task, WITHIN_S)


async def until(hub: FakeHub, holds, what: str) -> None:
    ends = time.monotonic() + WITHIN_S
    while not holds():
        assert time.monotonic() < ends, f"{what}: {hub.of(NightState)[-3:]} {hub.of(Event)[-6:]}"
        await asyncio.sleep(0.1)


def phase(hub: FakeHub) -> NightPhase:
    return hub.of(NightState)[-1].phase if hub.of(NightState) else NightPhase.DISARMED


def states(hub: FakeHub, name: str) -> list[ObservationState]:
    return [one.state for one in hub.of(ObservationUpdate) if one.request == name]


def frames(hub: FakeHub, name: str) -> int:
    told = [one.frames_done for one in hub.of(ObservationUpdate) if one.request == name]
    return sum(told[-1]) if told else 0


async def weather(hub: FakeHub, count: int, **changes: float) -> None:
    args = {"wind": 5.0, "rain": 0.0} | changes
    await hub.send(
        CommandRequest(
            id=f"weather-{count}", device="weather", command="simulate", args=args,
            ttl_ms=5000, who="ada",
        )
    )  # fmt: skip


async def test_a_short_night_on_the_simulators_of_indi(tmp_path: Path) -> None:
    async with server_of(tmp_path, *DRIVERS) as indi:
        site = described(indi.port)
        addresses = [channel.address for channel in site.channels()]
        async with fake_hub(lambda _hello: addresses) as hub:
            hub.takes = ["night_state"]
            async with gateway_of(site, hub, tmp_path / "gateway"):
                await the_night(hub, site)


async def the_night(hub: FakeHub, site: Site) -> None:
    await until(hub, lambda: hub.links, "a link")
    groups = [asked(site, "field", 4, 5.0, 0.5), asked_bias()]
    school = Proposal(id="school", share=1.0, hours_allocated=10.0)
    await hub.send(RequestSync(revision=7, proposals=[school], groups=groups))
    await until(hub, lambda: 7 in [one.revision for one in hub.of(RequestRevision)], "requests")
    # Nobody has armed it: nothing opens.
    assert phase(hub) is NightPhase.DISARMED
    await hub.send(NightArmRequest(id="arm-1", who="ada"))
    await until(hub, lambda: phase(hub) is NightPhase.OBSERVING, "it observes")
    assert hub.of(NightPlan)
    await until(hub, lambda: frames(hub, "field") >= 1, "a frame")
    # The camera was turned before it, by INDI's own rotator.
    assert hub.values("rotator/angle")[-1] == pytest.approx(ANGLE, abs=0.3)
    # Rain: suspended, and closed by the roof's own guard.
    await weather(hub, 1, rain=5.0)
    await until(hub, lambda: phase(hub) is NightPhase.CLOSED, "closed by rain")
    await until(hub, lambda: states(hub, "field")[-1] is S.SUSPENDED, "suspended")
    # Meanwhile the biases that were asked for, under the closed roof.
    await until(hub, lambda: S.COMPLETED in states(hub, "bias"), "biases")
    assert frames(hub, "bias") == 2
    await weather(hub, 2)
    await until(hub, lambda: S.COMPLETED in states(hub, "field"), "the rest")
    assert S.FAILED not in states(hub, "field")
    done = [one for one in hub.of(ObservationUpdate) if one.state is S.COMPLETED]
    assert [one.frames_done for one in done] == [[2], [4]]
    numbers = [one.number for one in hub.of(ObservationUpdate)]
    assert numbers == sorted(set(numbers))
    assert len({one.id for one in hub.of(ObservationUpdate)}) == 2
    await hub.send(NightDisarmRequest(id="arm-2", who="ada", why="enough"))
    await until(hub, lambda: phase(hub) is NightPhase.DISARMED, "disarmed")
    for address, word in (("dome/shutter", "closed"), ("telescope/parked", "parked")):
        signal = site.signal(address)
        assert signal is not None
        assert signal.states[int(hub.values(address)[-1])] == word
    kinds = [one.kind for one in hub.of(Event)]
    assert "night_fault" not in kinds
    assert "night_planner_failed" not in kinds


async def test_flats_of_the_twilight_on_the_simulators_of_indi(tmp_path: Path) -> None:
    async with server_of(tmp_path, *DRIVERS) as indi:
        text = described_text(indi.port, SIMULATOR_SETTINGS={"SIM_SKYGLOW": TWILIGHT_MAG})
        site = at_twilight(raise_first(load_site(text)))
        addresses = [channel.address for channel in site.channels()]
        async with fake_hub(lambda _hello: addresses) as hub:
            hub.takes = ["night_state"]
            async with gateway_of(site, hub, tmp_path / "gateway"):
                await the_flats(hub, site)


async def the_flats(hub: FakeHub, site: Site) -> None:
    await until(hub, lambda: hub.links, "a link")
    now = time.time()
    flats = Configuration(type=ImageType.SKY_FLAT, exposure=1.0, count=2)
    request = Request(
        id="flats",
        configurations=(flats,),
        windows=(Window(start=now - 60.0, end=now + 7200.0),),
    )
    school = Proposal(id="school", share=1.0, hours_allocated=10.0)
    group = RequestGroup(id="g-flats", proposal="school", requests=(request,))
    await hub.send(RequestSync(revision=3, proposals=[school], groups=[group]))
    await until(hub, lambda: 3 in [one.revision for one in hub.of(RequestRevision)], "requests")
    await hub.send(NightArmRequest(id="arm-3", who="ada"))
    await until(hub, lambda: S.COMPLETED in states(hub, "flats"), "the flats")
    assert frames(hub, "flats") == 2
    # Only those of a right level count: the files are measured, not believed.
    night = site.night
    assert night is not None
    assert night.flats is not None
    flats_of = night.flats
    await until(hub, lambda: len(right_levels(hub, flats_of)) >= 2, "the files of the flats")
    # They were taken under the open roof, of the sky.
    shutter = site.signal("dome/shutter")
    assert shutter is not None
    assert "open" in {shutter.states[int(value)] for value in hub.values("dome/shutter")}


def right_levels(hub: FakeHub, flats: NightFlats) -> list[float]:
    """Measure the flats that came whole, and give the levels that count."""
    whole = [hub.files[offer.id] for offer in hub.offers if offer.size == len(hub.files[offer.id])]
    levels = [measure_level(data) for data in whole if b"'Flat Frame'" in data[:11520]]
    return [level for level in levels if level and flats.least <= level <= flats.most]
