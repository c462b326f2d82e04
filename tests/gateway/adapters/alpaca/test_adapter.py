"""The Alpaca adapter with PyPI's alpaca-simulators, and with a stand-in for what they lack."""

from __future__ import annotations

import asyncio
import io
import math
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import httpx
import pytest
from astropy.io import fits
from fake_hub import FakeHub, fake_hub
from gateway_bench import addresses_of
from patience import PATIENCE_S
from stand_in import AlpacaStandIn, image_bytes, serving_alpaca

from talaia.gateway.run import serve_gateway
from talaia.gateway.settings import GatewaySettings, HubAddress
from talaia.model.checks.site_checks import raise_first
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import CommandPhase, CommandRequest, CommandState, DeviceState, Event

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterator
    from pathlib import Path

    from talaia.model.site import Site

FINAL = frozenset(CommandPhase) - {CommandPhase.ACCEPTED, CommandPhase.RUNNING}
BARE = """
talaia: 1
site: test
name: Test observatory
connections: {alpaca: {kind: alpaca, host: 127.0.0.1, port: %d, here: true, poll: 0.1}}
"""
# The dome may not open while the safety monitor does not say that it is safe.
GUARDED = (
    BARE.replace("poll: 0.1", "poll: 0.1, timeout: 0.5, discover: false")
    + """
devices:
  dome:
    name: Dome
    kind: dome
    signals:
      shutter:
        name: Shutter
        type: state
        states: [open, closed, opening, closing, error]
        source: {property: dome/0/shutterstatus}
    commands:
      open: {name: Open, kind: alpaca, target: dome/0/openshutter, timeout: 1}
      close: {name: Close, kind: alpaca, target: dome/0/closeshutter}
  safety:
    name: Safety
    signals:
      safe:
        name: Safe
        type: state
        states: [unsafe, safe]
        source: {property: safetymonitor/0/issafe}
  weather:
    name: Weather
    signals:
      wind:
        name: Wind
        unit: m/s
        source: {property: observingconditions/0/windspeed, age: timesincelastupdate}
  camera:
    name: Camera
    kind: camera
    commands:
      expose:
        name: Expose
        kind: alpaca
        target: camera/0/startexposure
        fixed: {Light: true, binx/BinX: 2}
        arguments:
          seconds: {type: number, field: Duration, unit: s}
          target: {type: text, field: fits/OBJECT, default: none}
interlocks:
  unsafe:
    name: Not safe
    when: [{signal: safety/safe, is: [unsafe]}]
    refuse: [dome/open]
    dwell: 0
"""
)


class Bench:
    """A gateway and the hub it speaks to."""

    def __init__(self, hub: FakeHub) -> None:  # noqa: D107
        self.hub = hub
        self._count = 0

    @property
    def site(self) -> Site:
        return load_site(self.hub.hellos[-1].description)

    async def begin(self, device: str, command: str, **args: object) -> str:
        self._count += 1
        ask = CommandRequest(
            id=f"ask-{self._count}",
            device=device,
            command=command,
            args=args,
            ttl_ms=5000,
            who="Ada",
        )
        await self.hub.send(ask)
        return ask.id

    async def does(self, device: str, command: str, **args: object) -> CommandState:
        ask_id = await self.begin(device, command, **args)
        return await self.hub.next(
            CommandState, lambda each: each.id == ask_id and each.phase in FINAL
        )

    def newest(self, address: str) -> float | str | None:
        values = self.hub.values(address)
        return values[-1] if values else None

    def state(self, address: str) -> str:
        value = self.newest(address)
        device, signal = address.split("/")
        if not isinstance(value, float):
            return ""
        if math.isnan(value):
            return "unknown"
        return self.site.devices[device].signals[signal].states[int(value)]

    async def until_state(self, address: str, word: str) -> None:
        await self.hub.until(lambda: self.state(address) == word, f"{address} is {word}")


@asynccontextmanager
async def gateway_for(port: int, data: Path, text: str = BARE) -> AsyncIterator[Bench]:
    site = raise_first(load_site(text % port))
    ended = asyncio.Event()
    async with fake_hub(addresses_of) as hub:
        address = HubAddress.from_text(hub.url, allow_plain=True)
        settings = GatewaySettings(hub=address, key="test-key", data=data)
        task = asyncio.ensure_future(serve_gateway(site, settings, ended))
        try:
            yield Bench(hub)
        finally:
            ended.set()
            await asyncio.wait_for(task, PATIENCE_S)


def put(port: int, address: str, **fields: object) -> None:
    """Do what a simulator lets one do by hand."""
    url = f"http://127.0.0.1:{port}/api/v1/{address}"
    httpx.put(url, data=fields, timeout=PATIENCE_S).raise_for_status()


def read(port: int, address: str) -> Any:
    """Ask a simulator beside the gateway."""
    url = f"http://127.0.0.1:{port}/api/v1/{address}"
    return httpx.get(url, timeout=PATIENCE_S).raise_for_status().json()["Value"]


@pytest.fixture
def observatory() -> Iterator[tuple[int, AlpacaStandIn]]:
    """A stand-in whose sky is clear."""
    with serving_alpaca() as (port, stand_in):
        for device in ("dome/0", "safetymonitor/0", "observingconditions/0", "camera/0"):
            stand_in.values[f"{device}/connected"] = True
        stand_in.values |= {
            "dome/0/shutterstatus": 1,
            "safetymonitor/0/issafe": True,
            "observingconditions/0/windspeed": 3.5,
            "observingconditions/0/timesincelastupdate?SensorName=windspeed": 1.0,
            "camera/0/camerastate": 0,
            "camera/0/imageready": False,
        }
        yield port, stand_in


async def test_a_server_without_a_list_of_devices_is_found_out_and_told_what_to_do(
    simulators: int, tmp_path: Path
) -> None:
    async with gateway_for(simulators, tmp_path) as bench:
        await bench.hub.until(
            lambda: bench.hub.hellos and len(bench.site.devices) == 10, "ten devices"
        )
        await bench.until_state("safetymonitor_0/issafe", "safe")
        await bench.until_state("dome_0/shutterstatus", "closed")
        await bench.hub.until(
            lambda: bench.newest("observingconditions_0/temperature") is not None, "weather"
        )
        opened = await bench.does("dome_0", "open")
        assert (opened.phase, opened.message) == (CommandPhase.SUCCEEDED, "Shutter: open")
        await bench.until_state("dome_0/shutterstatus", "open")
        assert (await bench.does("dome_0", "close")).phase is CommandPhase.SUCCEEDED
        selected = await bench.does("filterwheel_0", "select", position=2)
        assert selected.phase is CommandPhase.SUCCEEDED
        await bench.until_state("filterwheel_0/position", "Blue")
        # Both axes, and the whole chip in the new pixels: it refuses a frame that is larger.
        binned = await bench.does("camera_0", "binning", factor=2)
        assert binned.phase is CommandPhase.SUCCEEDED
        await bench.hub.until(lambda: bench.newest("camera_0/binx") == 2, "binned")
        names = ("biny", "startx", "starty", "numx", "numy")
        sizes = [read(simulators, f"camera/0/camera{axis}size") // 2 for axis in "xy"]
        assert [read(simulators, f"camera/0/{name}") for name in names] == [2, 0, 0, *sizes]
        focused = await bench.does("focuser_0", "move", position=1000)
        assert focused.phase is CommandPhase.SUCCEEDED
        put(simulators, "telescope/0/park")
        await bench.until_state("telescope_0/atpark", "yes")
        refused = await bench.does("telescope_0", "goto", ra=1.0, dec=10.0)
        assert refused.phase is CommandPhase.REFUSED
        assert "0x408" in refused.message
        # It was refused, and nothing is latched by that.
        assert (await bench.does("telescope_0", "unpark")).phase is CommandPhase.SUCCEEDED
        switched = await bench.does("switch_0", "set_switch_0", on=True)
        assert (switched.phase, switched.message) == (CommandPhase.SUCCEEDED, "on")
        dimmed = await bench.does("switch_0", "set_switch_1", value=0.7)
        assert (dimmed.phase, dimmed.message) == (CommandPhase.SUCCEEDED, "0.7")
        put(simulators, "safetymonitor/0/issafe", IsSafe=False)
        await bench.until_state("safetymonitor_0/issafe", "unsafe")
        put(simulators, "safetymonitor/0/issafe", IsSafe=True)


async def test_a_device_that_was_late_once_is_found_when_it_is_asked_again(
    observatory: tuple[int, AlpacaStandIn], tmp_path: Path
) -> None:
    port, stand_in = observatory
    stand_in.silent.add("dome/0/shutterstatus")
    async with gateway_for(
        port, tmp_path, BARE.replace("port: %d", "port: %d, timeout: 1")
    ) as bench:
        await bench.hub.until(lambda: stand_in.asked["dome/0/shutterstatus"], "it is asked")
        assert not bench.site.devices
        stand_in.silent.clear()
        await bench.until_state("dome_0/shutterstatus", "closed")
        assert {"dome_0", "safetymonitor_0", "camera_0"} < set(bench.site.devices)


def _break_error(stand_in: AlpacaStandIn) -> None:
    stand_in.errors["safetymonitor/0/issafe"] = (0x500, "no rain sensor")


def _break_connection(stand_in: AlpacaStandIn) -> None:
    stand_in.values["safetymonitor/0/connected"] = False
    stand_in.errors["PUT safetymonitor/0/connected"] = (0x500, "no such port")


def _break_property(stand_in: AlpacaStandIn) -> None:
    del stand_in.values["safetymonitor/0/issafe"]


def _break_answer(stand_in: AlpacaStandIn) -> None:
    stand_in.values["safetymonitor/0/issafe"] = None


def _break_status(stand_in: AlpacaStandIn) -> None:
    stand_in.errors["safetymonitor/0/issafe"] = (500, "crashed")


def _break_silence(stand_in: AlpacaStandIn) -> None:
    stand_in.silent.add("safetymonitor/0/issafe")


@pytest.mark.parametrize(
    "damage",
    [
        _break_error,
        _break_connection,
        _break_property,
        _break_answer,
        _break_status,
        _break_silence,
    ],
)
async def test_a_safety_monitor_that_does_not_say_safe_is_unsafe(
    observatory: tuple[int, AlpacaStandIn],
    tmp_path: Path,
    damage: Callable[[AlpacaStandIn], None],
) -> None:
    port, stand_in = observatory
    stand_in.on_put["dome/0/openshutter"] = lambda _: stand_in.values.update(
        {"dome/0/shutterstatus": 0}
    )
    async with gateway_for(port, tmp_path, GUARDED) as bench:
        await bench.until_state("safety/safe", "safe")
        await bench.until_state("dome/shutter", "closed")
        assert (await bench.does("dome", "open")).phase is CommandPhase.SUCCEEDED
        damage(stand_in)
        await bench.until_state("safety/safe", "unknown")
        refused = await bench.does("dome", "open")
        assert refused.phase is CommandPhase.REFUSED
        assert "Not safe" in refused.message
        assert stand_in.calls("dome/0/openshutter") == 1
        # What is on another device of the same server goes on.
        await bench.until_state("dome/shutter", "open")


async def test_a_call_without_an_answer_is_unknown_and_never_made_again(
    observatory: tuple[int, AlpacaStandIn], tmp_path: Path
) -> None:
    port, stand_in = observatory
    stand_in.silent.add("PUT dome/0/closeshutter")
    text = GUARDED.replace("closeshutter}", "closeshutter, timeout: 0.5}")
    async with gateway_for(port, tmp_path, text) as bench:
        await bench.until_state("dome/shutter", "closed")
        ended = await bench.does("dome", "close")
        assert ended.phase is CommandPhase.UNKNOWN
        assert "is not sent again" in ended.message
        # While the device is read ten times more anything that repeats would have repeated.
        last = stand_in.asked["dome/0/shutterstatus"] + 10
        await bench.hub.until(lambda: stand_in.asked["dome/0/shutterstatus"] > last, "ten more")
        assert stand_in.calls("dome/0/closeshutter") == 1


async def test_a_refusal_and_a_failure_are_told_apart_in_the_drivers_words(
    observatory: tuple[int, AlpacaStandIn], tmp_path: Path
) -> None:
    port, stand_in = observatory
    async with gateway_for(port, tmp_path, GUARDED) as bench:
        await bench.until_state("dome/shutter", "closed")
        stand_in.errors["PUT dome/0/closeshutter"] = (0x409, "the mount has it")
        refused = await bench.does("dome", "close")
        stand_in.errors["PUT dome/0/closeshutter"] = (0x501, "motor jammed")
        failed = await bench.does("dome", "close")
        stand_in.errors["PUT dome/0/closeshutter"] = (400, "unreadable")
        unread = await bench.does("dome", "close")
        del stand_in.errors["PUT dome/0/closeshutter"]
        stand_in.values["dome/0/shutterstatus"] = 4
        wrong = await bench.does("dome", "close")
    assert (refused.phase, failed.phase) == (CommandPhase.REFUSED, CommandPhase.FAILED)
    assert (unread.phase, wrong.phase) == (CommandPhase.REFUSED, CommandPhase.FAILED)
    assert "the mount has it" in refused.message
    assert "motor jammed" in failed.message
    assert "error of its shutter" in wrong.message


async def test_an_old_value_of_a_weather_station_is_unknown_however_often_it_comes(
    observatory: tuple[int, AlpacaStandIn], tmp_path: Path
) -> None:
    port, stand_in = observatory
    age = "observingconditions/0/timesincelastupdate?SensorName=windspeed"
    async with gateway_for(port, tmp_path, GUARDED) as bench:
        await bench.hub.until(lambda: bench.newest("weather/wind") == 3.5, "wind")
        stand_in.values[age] = 7.0
        await bench.hub.until(lambda: bench.newest("weather/wind") != 3.5, "unknown wind")
        said = await bench.hub.next(Event, lambda event: event.kind == "unreadable")
        assert "its value is 7 s old" in said.message
        stand_in.values[age] = 0.5
        await bench.hub.until(lambda: bench.newest("weather/wind") == 3.5, "wind again")


async def test_a_picture_comes_as_fits_with_what_was_asked_for(
    observatory: tuple[int, AlpacaStandIn], tmp_path: Path
) -> None:
    port, stand_in = observatory
    stand_in.picture = image_bytes([[1, 2], [300, 400]])
    stand_in.values["camera/0/name"] = "Stand-in camera"
    stand_in.on_put["camera/0/startexposure"] = lambda _: stand_in.values.update(
        {"camera/0/imageready": True}
    )
    async with gateway_for(port, tmp_path, GUARDED) as bench:
        await bench.until_state("dome/shutter", "closed")
        ended = await bench.does("camera", "expose", seconds=0.5, target="M 31")
        assert (ended.phase, ended.message) == (CommandPhase.SUCCEEDED, "the picture has come")
        await bench.hub.until(lambda: any(bench.hub.files.values()), "a file")
        offer = bench.hub.offers[-1]
        await bench.hub.until(lambda: len(bench.hub.files[offer.id]) == offer.size, "all of it")
    # What is set before goes first.
    assert [call[0] for call in stand_in.puts] == [
        "camera/0/binx",
        "camera/0/biny",
        "camera/0/startexposure",
    ]
    with fits.open(io.BytesIO(bench.hub.files[offer.id])) as opened:
        opened.verify("exception")
        assert opened[0].data.tolist() == [[1, 300], [2, 400]]
        assert opened[0].header["OBJECT"] == "M 31"
        assert opened[0].header["INSTRUME"] == "Stand-in camera"
        assert opened[0].header["EXPTIME"] == 0.5


async def test_with_its_server_everything_is_unknown_at_once(tmp_path: Path) -> None:
    with serving_alpaca() as (port, stand_in):
        stand_in.values |= {"dome/0/connected": True, "dome/0/shutterstatus": 1}
        async with gateway_for(port, tmp_path, GUARDED) as bench:
            await bench.until_state("dome/shutter", "closed")
            stand_in.silent.add("PUT dome/0/closeshutter")
            asked = await bench.begin("dome", "close")
            await bench.hub.until(lambda: stand_in.calls("dome/0/closeshutter"), "the call")
            stand_in.end()
            # What was under way is told first.
            ended = await bench.hub.next(
                CommandState, lambda each: each.id == asked and each.phase in FINAL
            )
            assert ended.phase is CommandPhase.UNKNOWN
            lost = await bench.hub.next(
                DeviceState, lambda each: each.device == "dome" and not each.reached
            )
            assert "Alpaca server" in lost.why
            await bench.until_state("dome/shutter", "unknown")
            refused = await bench.does("dome", "close")
            assert refused.phase is CommandPhase.REFUSED
