"""The adapter and the gateway against a real indiserver with Debian's simulators."""

# ruff: noqa: ASYNC110, SIM117 - a server is asked; in it stands what speaks to it
from __future__ import annotations

import asyncio
import math
import re
import time
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from fake_hub import FakeHub, fake_hub
from gateway_bench import addresses_of
from patience import PATIENCE_S

from talaia.gateway.run import serve_gateway
from talaia.gateway.settings import GatewaySettings, HubAddress
from talaia.model.checks.site_checks import raise_first
from talaia.model.yaml_text.load import load_site
from talaia.sim.observatory.night import at_night
from talaia.wire.frames import (
    CommandCancel,
    CommandPhase,
    CommandRequest,
    CommandState,
    DeviceState,
)

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from talaia.model.site import Site

pytestmark = pytest.mark.robot
FINAL = frozenset(CommandPhase) - {CommandPhase.ACCEPTED, CommandPhase.RUNNING}
BARE = """
talaia: 1
site: test
name: Test observatory
connections: {indi: {kind: indi, port: %d}}
"""


class Bench:
    """A gateway that knows nothing but where the server is, and the hub it speaks to."""

    def __init__(self, hub: FakeHub) -> None:  # noqa: D107
        self.hub = hub
        self._count = 0

    @property
    def site(self) -> Site:
        return load_site(self.hub.hellos[-1].description)

    async def described(self, *devices: str) -> None:
        await self.hub.until(
            lambda: self.hub.hellos and all(each in self.site.devices for each in devices),
            f"{devices} in the description",
        )
        # A new description begins the adapter anew: until the drivers have defined themselves to
        # it, the server has none of them.
        for device in devices:
            await self.hub.until(
                lambda device=device: any(
                    self.hub.values(f"{device}/{signal}")
                    for signal in self.site.devices[device].signals
                ),
                f"a value of {device}",
            )

    async def ask(self, device: str, command: str, **args: object) -> str:
        self._count += 1
        ask_id = f"ask-{self._count}"
        await self.hub.send(
            CommandRequest(
                id=ask_id, device=device, command=command, args=args, ttl_ms=5000, who="Ada"
            )
        )
        return ask_id

    async def does(self, device: str, command: str, **args: object) -> CommandState:
        ask_id = await self.ask(device, command, **args)
        return await self.ended(ask_id)

    async def ended(self, ask_id: str) -> CommandState:
        return await self.hub.next(
            CommandState, lambda each: each.id == ask_id and each.phase in FINAL
        )

    def newest(self, address: str) -> float | str | None:
        values = self.hub.values(address)
        return values[-1] if values else None

    def state(self, address: str) -> str:
        value = self.newest(address)
        device, signal = address.split("/")
        if not isinstance(value, float) or math.isnan(value):
            return ""
        return self.site.devices[device].signals[signal].states[int(value)]

    async def until_state(self, address: str, word: str) -> None:
        await self.hub.until(lambda: self.state(address) == word, f"{address} is {word}")


@asynccontextmanager
async def bench(port: int, data: Path, text: str = BARE) -> AsyncIterator[Bench]:
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


async def test_devices_are_found_by_themselves_with_their_signals_and_commands(
    indi: Callable, tmp_path: Path
) -> None:
    drivers = ("dome", "telescope", "ccd", "weather", "focus", "wheel", "rotator")
    async with indi(*(f"indi_simulator_{each}" for each in drivers)) as server:
        async with bench(server.port, tmp_path / "data") as one:
            await one.described("dome_simulator", "telescope_simulator", "weather_simulator")
            devices = one.site.devices
            kinds = {name: str(device.kind) for name, device in devices.items()}
            assert kinds == {
                "dome_simulator": "dome",
                "telescope_simulator": "telescope",
                "ccd_simulator": "camera",
                "weather_simulator": "weather",
                "focuser_simulator": "other",
                "filter_simulator": "other",
                "rotator_simulator": "other",
            }
            assert {"shutter", "azimuth", "parked"} <= devices["dome_simulator"].signals.keys()
            assert {"goto", "sync", "park", "track", "stop"} <= (
                devices["telescope_simulator"].commands.keys()
            )
            assert {"expose", "abort", "cool", "filter"} <= devices["ccd_simulator"].commands.keys()
            assert devices["weather_simulator"].signals["wind"].unit == "km/h"
            assert raise_first(one.site)
            await one.hub.until(
                lambda: one.newest("weather_simulator/temperature") == 15.0, "a temperature"
            )
            await one.until_state("weather_simulator/safety", "safe")


async def test_dome_opens_and_closes_and_each_end_is_the_shutters_own(
    indi: Callable, tmp_path: Path
) -> None:
    async with indi("indi_simulator_dome") as server:
        async with bench(server.port, tmp_path / "data") as one:
            await one.described("dome_simulator")
            await one.until_state("dome_simulator/shutter", "closed")
            opened = await one.does("dome_simulator", "open")
            assert opened.phase is CommandPhase.SUCCEEDED, opened.message
            await one.until_state("dome_simulator/shutter", "open")
            words = [
                one.site.devices["dome_simulator"].signals["shutter"].states[int(each)]
                for each in one.hub.values("dome_simulator/shutter")
            ]
            assert list(dict.fromkeys(words)) == ["closed", "opening", "open"]
            closed = await one.does("dome_simulator", "close")
            assert closed.phase is CommandPhase.SUCCEEDED, closed.message
            await one.until_state("dome_simulator/shutter", "closed")
            turned = await one.does("dome_simulator", "goto", azimuth=20)
            assert turned.phase is CommandPhase.SUCCEEDED, turned.message
            await one.hub.until(lambda: one.newest("dome_simulator/azimuth") == 20.0, "azimuth 20")


async def test_killed_server_shows_unknown_at_once_and_is_back_by_itself(
    indi: Callable, tmp_path: Path
) -> None:
    async with indi("indi_simulator_telescope") as server:
        async with bench(server.port, tmp_path / "data") as one:
            await one.described("telescope_simulator")
            await one.hub.until(lambda: one.newest("telescope_simulator/ra") is not None, "RA")
            unparked = await one.does("telescope_simulator", "unpark")
            assert unparked.phase is CommandPhase.SUCCEEDED
            slew = await one.ask("telescope_simulator", "goto", ra=3.0, dec=10.0)
            await one.hub.next(
                CommandState, lambda each: each.id == slew and each.phase is CommandPhase.RUNNING
            )
            loop = asyncio.get_running_loop()
            killed = loop.time()
            await server.kill()
            state = await one.ended(slew)
            assert state.phase is CommandPhase.UNKNOWN
            assert "went away" in state.message
            away = await one.hub.next(DeviceState, lambda each: not each.reached)
            assert away.device == "telescope_simulator"
            await one.hub.until(
                lambda: math.isnan(one.newest("telescope_simulator/ra")), "unknown RA"
            )
            assert loop.time() - killed < 2.0
            refused = await one.does("telescope_simulator", "park")
            assert refused.phase is CommandPhase.REFUSED
            await server.start()
            await one.hub.next(DeviceState, lambda each: each.reached)
            await one.hub.until(
                lambda: not math.isnan(one.newest("telescope_simulator/ra")), "RA again"
            )


async def test_bad_input_is_refused_with_a_reason_and_nothing_moves(
    indi: Callable, tmp_path: Path
) -> None:
    drivers = ("indi_simulator_telescope", "indi_simulator_ccd", "indi_simulator_dome")
    async with indi(*drivers) as server:
        async with bench(server.port, tmp_path / "data") as one:
            await one.described("telescope_simulator", "ccd_simulator", "dome_simulator")
            for device, command, args, reason in (
                ("telescope_simulator", "goto", {"ra": 25.0, "dec": 0.0}, "25.0 is above 24"),
                ("telescope_simulator", "goto", {"ra": 1.0, "dec": -91.0}, "-91.0 is below -90"),
                ("telescope_simulator", "goto", {"ra": math.nan, "dec": 0.0}, "finite"),
                ("telescope_simulator", "goto", {"ra": "1; rm -rf /", "dec": 0.0}, "a number"),
                ("ccd_simulator", "expose", {"seconds": -1.0}, "-1.0 is below"),
                ("ccd_simulator", "expose", {"seconds": 1.0, "frame": "; rm -rf"}, "is none of"),
                ("nowhere", "open", {}, "not a command of this site"),
                ("dome_simulator", "explode", {}, "not a command of this site"),
            ):
                state = await one.does(device, command, **args)
                assert state.phase is CommandPhase.REFUSED, (device, command, args)
                assert reason in state.message
            assert one.hub.values("ccd_simulator/exposure") in ([], [0.0], [1.0])
            assert set(one.hub.values("dome_simulator/azimuth")) <= {0.0}


async def test_parked_dome_refuses_to_turn_in_words_and_says_what_to_do(
    indi: Callable, tmp_path: Path
) -> None:
    async with indi("indi_simulator_dome") as server:
        async with bench(server.port, tmp_path / "data") as one:
            await one.described("dome_simulator")
            parked = await one.does("dome_simulator", "park")
            assert parked.phase is CommandPhase.SUCCEEDED, parked.message
            # It says parked while its shutter still moves; the command waits for both.
            assert one.state("dome_simulator/shutter") == "closed"
            state = await one.does("dome_simulator", "goto", azimuth=10.0)
            assert state.phase is CommandPhase.REFUSED
            assert "parked; unpark it first" in state.message


async def test_slew_can_be_cancelled_and_the_mount_rests(indi: Callable, tmp_path: Path) -> None:
    async with indi("indi_simulator_telescope") as server:
        async with bench(server.port, tmp_path / "data") as one:
            await one.described("telescope_simulator")
            await one.does("telescope_simulator", "unpark")
            slew = await one.ask("telescope_simulator", "goto", ra=3.0, dec=10.0)
            await one.hub.next(CommandState, lambda each: each.id == slew and 0 < each.progress < 1)
            await one.hub.send(CommandCancel(id=slew, device="telescope_simulator", who="Ada"))
            state = await one.ended(slew)
            assert state.phase is CommandPhase.CANCELLED


async def test_device_of_a_driver_that_comes_later_is_added_and_kept_for_the_next_start(
    indi: Callable, tmp_path: Path
) -> None:
    data = tmp_path / "data"
    async with indi("indi_simulator_wheel") as server:
        async with bench(server.port, data) as one:
            await one.described("filter_simulator")
    async with indi("indi_simulator_wheel", "indi_simulator_focus") as server:
        async with bench(server.port, data) as one:
            await one.hub.until(lambda: one.hub.hellos, "a hello")
            assert "filter_simulator" in load_site(one.hub.hellos[0].description).devices
            await one.described("filter_simulator", "focuser_simulator")
            moved = await one.does("focuser_simulator", "focus", position=50_500)
            assert moved.phase is CommandPhase.SUCCEEDED, moved.message
            chosen = await one.does("filter_simulator", "filter", slot=3)
            assert chosen.phase is CommandPhase.SUCCEEDED, chosen.message
            await one.until_state("filter_simulator/filter", "Blue")


@pytest.mark.parametrize("cause", ["gusts", "dew"])
async def test_unsafe_weather_parks_and_closes_without_a_hub_within_the_bound(
    indi: Callable, tmp_path: Path, cause: str
) -> None:
    example = Path(__file__).parents[4] / "examples" / "indi" / "site.yaml"
    drivers = [f"indi_simulator_{name}" for name in ("telescope", "dome", "ccd", "weather")]
    station = tmp_path / "station.txt"
    station.write_text("temperature=12.0\nhumidity=60\n")
    async with indi(*drivers, "indi_watcher_weather") as server:
        text = example.read_text().replace("port: 7624", f"port: {server.port}")
        text = text.replace("/run/talaia-station.txt", str(station))
        text = text.replace("frozen_after: 120", "frozen_after: 3600")
        text = text.replace("dwell: 60", "dwell: 1").replace("dwell: 15", "dwell: 1")
        # Nobody is there: the example's own rules are all that acts.
        nowhere = HubAddress.from_text("ws://127.0.0.1:9", allow_plain=True)
        settings = GatewaySettings(hub=nowhere, key="test-key", data=tmp_path / "data")
        ended = asyncio.Event()
        # It may be open by night only; tests run by day, too.
        site = raise_first(at_night(load_site(text), time.time()))
        task = asyncio.ensure_future(serve_gateway(site, settings, ended))
        watcher = Watcher(server.port)
        try:
            await watcher.until("Weather Simulator", "CONNECTION", CONNECT="On")
            await watcher.until("Weather Watcher", "CONNECTION", CONNECT="On")
            await watcher.until("Dome Simulator", "DOME_SHUTTER", SHUTTER_CLOSE="On")
            await watcher.set("Weather Simulator.WEATHER_UPDATE.PERIOD=2")
            # INDI hinders nobody to open; what is opened before the weather is known is closed.
            while await watcher.value("Dome Simulator.DOME_SHUTTER.SHUTTER_OPEN") != "On":
                await watcher.set("Dome Simulator.DOME_SHUTTER.SHUTTER_OPEN=On")
                await watcher.until("Dome Simulator", "DOME_SHUTTER")
            await watcher.set("Telescope Simulator.TELESCOPE_PARK.UNPARK=On")
            await watcher.until("Telescope Simulator", "TELESCOPE_PARK", UNPARK="On")
            ledger = await Ledger.of(server.port)
            if cause == "dew":
                # 12 °C at 97 % are 11.5 °C of dew point.
                station.write_text("temperature=12.0\nhumidity=97\n")
                await watcher.set("Weather Watcher.WEATHER_REFRESH.REFRESH=On")
            else:
                gusts = "Weather;Temperature;Wind;Gust;Precip=0;15;80;50;0"
                await watcher.set(f"Weather Simulator.WEATHER_CONTROL.{gusts}")
                await watcher.set("Weather Simulator.WEATHER_REFRESH.REFRESH=On")
            loop = asyncio.get_running_loop()
            began = loop.time()
            await watcher.until("Dome Simulator", "DOME_SHUTTER", SHUTTER_CLOSE="On")
            # mount_within, and one closing of move_within.
            assert loop.time() - began < 60
            assert await watcher.value("Telescope Simulator.TELESCOPE_PARK.PARK") == "On"
            assert await ledger.parked_and_closed() == [
                ("Telescope Simulator", "PARK"),
                ("Dome Simulator", "SHUTTER_CLOSE"),
            ]
        finally:
            ended.set()
            await asyncio.wait_for(task, PATIENCE_S)


SWITCHED = re.compile(
    r'<setSwitchVector device="([^"]+)" name="(?:TELESCOPE_PARK|DOME_SHUTTER)".*?'
    r'<oneSwitch name="(PARK|SHUTTER_CLOSE)">\s*On\s*<.*?</setSwitchVector>',
    re.DOTALL,
)


class Ledger:
    """What the devices became from now on, in the order in which the server says it."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:  # noqa: D107
        self._reader, self._writer = reader, writer

    @classmethod
    async def of(cls, port: int) -> Ledger:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        writer.write(b'<getProperties version="1.7"/>')
        return cls(reader, writer)

    async def parked_and_closed(self) -> list[tuple[str, str]]:
        """Which device was asked for what first, once both were."""
        said = ""
        async with asyncio.timeout(PATIENCE_S):
            while True:
                said += (await self._reader.read(65536)).decode()
                # A vector that says it anew is the same news.
                whole = said[: said.rfind("</setSwitchVector>") + 18]
                order = list(dict.fromkeys(_switched(whole)))
                if len(order) == 2:
                    self._writer.close()
                    return order


def _switched(said: str) -> list[tuple[str, str]]:
    vectors = re.findall(r"<setSwitchVector.*?</setSwitchVector>", said, re.DOTALL)
    return [found.groups() for each in vectors if (found := SWITCHED.match(each))]


class Watcher:
    """Somebody else at the server, with INDI's own tools."""

    def __init__(self, port: int) -> None:  # noqa: D107
        self._port = str(port)

    async def _run(self, *words: str) -> str:
        process = await asyncio.create_subprocess_exec(
            words[0], "-p", self._port, *words[1:],
            stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.DEVNULL,
        )  # fmt: skip
        out, _ = await process.communicate()
        return out.decode().strip()

    async def set(self, what: str) -> None:
        await self._run("indi_setprop", what)

    async def value(self, what: str) -> str:
        return await self._run("indi_getprop", "-1", "-t", "1", what)

    async def until(self, device: str, name: str, **wanted: str) -> None:
        """Wait until a switch is as wanted and rests."""
        async with asyncio.timeout(PATIENCE_S):
            while await self.value(f"{device}.{name}._STATE") in ("Busy", "") or any(
                [await self.value(f"{device}.{name}.{each}") != wanted[each] for each in wanted]
            ):
                await asyncio.sleep(0.2)


async def test_a_person_sets_filter_focus_binning_and_gain_by_hand(
    indi: Callable, tmp_path: Path
) -> None:
    names = ("ccd", "focus", "wheel")
    async with indi(*(f"indi_simulator_{name}" for name in names)) as server:
        async with bench(server.port, tmp_path / "data") as one:
            await one.described("ccd_simulator", "focuser_simulator", "filter_simulator")

            async def ask_by_role(device: str, role: str, *values: float) -> None:
                commands = one.site.devices[device].commands
                name = next(key for key, found in commands.items() if found.role == role)
                args = dict(zip(commands[name].arguments, values, strict=True))
                state = await one.does(device, name, **args)
                assert state.phase is CommandPhase.SUCCEEDED, (role, state.message)

            async def until_reads(device: str, role: str, value: float) -> None:
                signals = one.site.devices[device].signals
                name = next(key for key, found in signals.items() if found.role == role)

                await one.hub.until(
                    lambda: one.newest(f"{device}/{name}") == value, f"{role} reads {value}"
                )

            await ask_by_role("filter_simulator", "camera.filter", 3)
            await until_reads("filter_simulator", "camera.filter", 3)
            await ask_by_role("focuser_simulator", "focuser.goto", 50_600)
            await until_reads("focuser_simulator", "focuser.position", 50_600)
            await ask_by_role("focuser_simulator", "focuser.in", 100)
            await until_reads("focuser_simulator", "focuser.position", 50_500)
            await ask_by_role("ccd_simulator", "camera.binning", 2, 2)
            await until_reads("ccd_simulator", "camera.binning", 2)
            await ask_by_role("ccd_simulator", "camera.gain", 42)
            await until_reads("ccd_simulator", "camera.gain", 42)
