"""``talaia demo-indi``: INDI's own simulators, a gateway, the hub and the dashboard, in one go."""

from __future__ import annotations

import asyncio
import contextlib
import random
import shutil
import socket
import time
from typing import TYPE_CHECKING

from msgspec.structs import replace

from talaia.cli.child_processes import ChildProcess, run_together, start_program, start_talaia
from talaia.cli.demo.session import data_folder, find_example, make_logins, print_greeting
from talaia.cli.errors import CliError
from talaia.cli.local_machine import free_port, has_screen, open_page
from talaia.hub import accounts
from talaia.hub.settings import Settings
from talaia.model.yaml_text.load import dump_site, read_site
from talaia.sim.observatory.models.weather import Weather
from talaia.sim.observatory.night import at_night

if TYPE_CHECKING:
    import argparse
    from pathlib import Path

    from talaia.model.site import Site

__all__ = ["run_indi_demo"]

EXAMPLE = "indi"
DRIVERS = (
    *(
        f"indi_simulator_{kind}"
        for kind in ("telescope", "dome", "ccd", "weather", "focus", "wheel", "rotator")
    ),
    # A real driver that reads a file, for the humidity, which the weather simulator has not.
    "indi_watcher_weather",
)
# Seconds between two measurements; the seed of the weather and of its noise.
STATION_EVERY_S, STATION_SEED = 2.0, 1


def run_indi_demo(options: argparse.Namespace) -> int:
    """Run until Ctrl-C; everything it started is ended and removed again.

    Args:
        options: as `talaia.cli.demo.indi_command_line` reads them.

    """
    missing = [program for program in ("indiserver", *DRIVERS) if not shutil.which(program)]
    if missing:
        raise CliError(f"{', '.join(missing)} missing; run: apt install indi-bin")
    began = time.monotonic()
    with data_folder(options.data, "talaia-demo-indi-") as data:
        asyncio.run(_run_demo(options, data, began))
    return 0


async def _run_demo(options: argparse.Namespace, data: Path, began: float) -> None:
    measuring = asyncio.create_task(_write_measurements(_station_file(data)))
    try:
        await run_together(lambda parts: _start_parts(options, data, parts, began))
    finally:
        measuring.cancel()


def _station_file(data: Path) -> Path:
    return data / "station.txt"


async def _write_measurements(station: Path) -> None:
    """Write what a station at the dome measures, as the driver `Weather Watcher` reads it."""
    weather, noise = Weather(STATION_SEED, time.time()), random.Random(STATION_SEED)  # noqa: S311
    next_file = station.with_suffix(".next")
    while True:
        weather.step(STATION_EVERY_S, time.time())
        # A disk that takes nothing leaves the old values, which the rules then take for unknown.
        with contextlib.suppress(OSError):
            temperature = weather.temperature + noise.gauss(0.0, 0.05)
            humidity = min(100.0, weather.humidity + noise.gauss(0.0, 0.1))
            next_file.write_text(f"temperature={temperature:.2f}\nhumidity={humidity:.2f}\n")
            # Renamed into place: the driver must never read half a file.
            next_file.replace(station)
        await asyncio.sleep(STATION_EVERY_S)


async def _start_parts(
    options: argparse.Namespace, data: Path, parts: list[ChildProcess], began: float
) -> None:
    port, indi = free_port(options.port), _any_port()
    # Drivers keep their settings in a home of their own, gone with the demo.
    home = data / "indi"
    home.mkdir(exist_ok=True)
    # indiserver knows no other address than all of them: on a shared network, fence it.
    words = ["indiserver", "-v", "-p", str(indi), "-u", str(home / "socket"), *DRIVERS]
    parts.append(await start_program("INDI server", words, data / "indi.log", {"HOME": str(home)}))
    # Before the gateway, which would only warn of a server that is still starting.
    await parts[0].wait_line("listening to port", 30)
    settings = Settings(
        data=data, host="127.0.0.1", port=port, plain=True, database_url=Settings.url_from()
    )
    logins = await make_logins(settings)
    site = data / "site.yaml"
    here = _at_night(read_site(find_example(EXAMPLE)), time.time())
    here = _reading_station(here, _station_file(data))
    site.write_text(dump_site(_at_port(here, indi)))
    key = data / "gateway.key"
    key.write_text(await accounts.create_gateway(settings, EXAMPLE))
    # Whoever can read it can speak as this gateway.
    key.chmod(0o600)
    hub = ["hub", "--data", str(data), "--host", "127.0.0.1", "--port", str(port), "--plain"]
    gateway = [
        "gateway",
        str(site),
        "--hub",
        f"ws://127.0.0.1:{port}",
        "--key-file",
        str(key),
        "--allow-plain",
        "--data",
        str(data / "gateway"),
    ]
    parts.append(await start_talaia("hub", hub, data / "hub.log", restart=True))
    parts.append(await start_talaia("gateway", gateway, data / "gateway.log", restart=True))
    await asyncio.gather(parts[1].wait_line("ready", 60), parts[2].wait_line("linked to", 60))
    print_greeting(f"http://localhost:{port}", logins, data=data, took=time.monotonic() - began)
    if not options.no_browser and has_screen():
        await asyncio.to_thread(open_page, f"http://localhost:{port}")


def _at_night(site: Site, unix_s: float) -> Site:
    """Stand where it is night now, so that the roof may open; the mount is told, too."""
    site = at_night(site, unix_s)
    place, mount = site.place, site.devices["telescope"]
    if place is None:
        return site
    # INDI counts longitude from 0 to 360° east.
    where = {"LAT": place.latitude, "LONG": place.longitude % 360.0, "ELEV": place.elevation}
    mount = replace(mount, setup={**mount.setup, "GEOGRAPHIC_COORD": {**where}})
    return replace(site, devices={**site.devices, "telescope": mount})


def _reading_station(site: Site, station: Path) -> Site:
    device = site.devices["station"]
    device = replace(device, setup={**device.setup, "WATCH_SOURCE": {"URL": str(station)}})
    return replace(site, devices={**site.devices, "station": device})


def _at_port(site: Site, port: int) -> Site:
    connections = {
        name: replace(connection, port=port) for name, connection in site.connections.items()
    }
    return replace(site, connections=connections)


def _any_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        # Free a moment ago; somebody else may take it, and then the server says so.
        return int(probe.getsockname()[1])
