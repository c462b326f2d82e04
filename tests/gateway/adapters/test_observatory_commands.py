"""The contract's command file with the real clients and servers, of ROS 2 and of ROS 1."""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import io
import json
import math
import os
import select
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from astropy.io import fits
from fake_hub import fake_hub
from fork_server import ForkedProcess, open_program
from gateway_bench import addresses_of, running
from msgspec.structs import replace
from observatory_site import as_ros1
from patience import PATIENCE_S, Stopwatch
from ports import free_port

import talaia
from talaia.model.discovery.command_file import site_of
from talaia.model.site import Argument, ArgumentType, Command, CommandKind
from talaia.model.yaml_text.load import dump_site, read_site
from talaia.sim import ros_domain
from talaia.wire.frames import (
    CommandPhase,
    CommandRequest,
    CommandState,
    DeviceState,
    Event,
    ReconnectRequest,
)  # fmt: skip

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from typing import IO

    from fake_hub import FakeHub

    from talaia.wire.frames import Scalar

pytestmark = pytest.mark.robot
EXAMPLE = Path(__file__).parents[3] / "examples" / "observatory" / "site.yaml"
CLASSIC = Path(__file__).parents[2] / "wire" / "recorded" / "observatory_commands.json"
SOURCE = str(Path(talaia.__file__).parents[1])


def missing(what: str) -> None:
    if os.environ.get("TALAIA_REQUIRE_ALL") == "1":
        pytest.fail(f"{what} is missing, and TALAIA_REQUIRE_ALL=1")
    pytest.skip(f"needs {what}")


@pytest.fixture(params=["ros2", "ros1"])
def ros(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The variables of a ROS of its own for servers and clients."""
    monkeypatch.setenv("PYTHONPATH", SOURCE)
    if request.param == "ros1":
        probe = [
            "/usr/bin/python3", "-c", "import rospy, rosgraph, geometry_msgs.msg, sensor_msgs.msg"
        ]  # fmt: skip
        clean = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "LD_LIBRARY_PATH")}
        if (
            not Path("/usr/bin/rosmaster").exists()
            or subprocess.run(probe, env=clean, capture_output=True, check=False).returncode
        ):
            missing("Debian's ROS 1 (python3-rospy, python3-rosmaster)")
        monkeypatch.setenv("ROS_MASTER_URI", f"http://localhost:{free_port()}")
        monkeypatch.setenv("ROS_IP", "127.0.0.1")
        yield "ros1"
        return
    if importlib.util.find_spec("rclpy") is None:
        missing("ROS 2 (rclpy)")
    # A parser that ROS brings along is older than the Python it runs on; not ours to fail for.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        for name in ("rclpy.node", "lark"):
            importlib.import_module(name)
    with ros_domain.reserve_domain() as reservation:
        for name, value in ros_domain.domain_environment(reservation.domain).items():
            monkeypatch.setenv(name, value)
        yield "ros2"


@pytest.fixture
def ledger(ros: str, tmp_path: Path) -> Iterator[Path]:
    """A running observatory, ten times as fast; gives what it writes down."""
    log = tmp_path / "ledger.jsonl"
    words = ["-m", "talaia", "sim", "observatory", "--speed", "10", "--log", str(log)]
    words += ["--ros1"] if ros == "ros1" else ["--domain", os.environ["ROS_DOMAIN_ID"]]
    process, printed = open_program(words)
    line = printed.readline() if select.select([printed], [], [], PATIENCE_S)[0] else b""
    try:
        assert json.loads(line)["ready"] is True
        yield log
    finally:
        process.send_signal(signal.SIGCONT)
        process.terminate()
        assert process.wait(20) == 0
        close_pipes(process, printed)


def asked(ledger: Path) -> list[tuple[str, str, str]]:
    rows = [json.loads(line) for line in ledger.read_text().splitlines()]
    # Where the roof really was stands there, too; that is the enclosure table's.
    return [(row["device"], row["asked"], row["phase"]) for row in rows if row["phase"] != "truth"]


async def do(hub: FakeHub, device: str, what: str, **args: Scalar) -> CommandState:
    under_way = (CommandPhase.ACCEPTED, CommandPhase.RUNNING)
    deadline = time.monotonic() + PATIENCE_S
    while True:
        ask = CommandRequest(
            id=f"{what}-{time.monotonic_ns()}", device=device, command=what, args=args,
            ttl_ms=5000, who="Ada",
        )  # fmt: skip
        await hub.send(ask)
        while True:
            assert time.monotonic() < deadline, f"{device}/{what} has not ended"
            with contextlib.suppress(TimeoutError):
                ended = await hub.next(
                    CommandState,
                    lambda each, ask=ask: each.id == ask.id and each.phase not in under_way,
                )
                break
        # Topics are found before services are, so the first question may come too early.
        if ended.phase != "refused" or "does not offer" not in ended.message:
            return ended


async def test_the_command_file_opens_and_closes_a_real_dome(
    ros: str, ledger: Path, tmp_path: Path
) -> None:
    launcher = f"{sys.executable} -m talaia sim run" + (" --ros1" if ros == "ros1" else "")
    text = CLASSIC.read_text().replace("ros2 run", launcher)
    site = dump_site(site_of(text, "observatory"))
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path / "data", site):
        await hub.until(lambda: 1.0 in hub.values("dome/status"), "closed")
        opened = await do(hub, "dome", "open")
        assert (opened.phase, opened.message) == ("succeeded", "the dome is opened")
        await hub.until(lambda: hub.values("dome/status")[-1] == 0.0, "opened")
        # The telescope's own refusal, in its words, and a goto that the gateway does not even ask.
        refused = await do(hub, "telescope", "goto", ra=2.5, dec=60.0)
        assert (refused.phase, refused.message) == (
            "failed", "the telescope is parked; unpark it first",
        )  # fmt: skip
        assert (await do(hub, "telescope", "goto", ra=25.0, dec=0.0)).phase == "refused"
        closed = await do(hub, "dome", "close")
        assert (closed.phase, closed.message) == ("succeeded", "the dome is closed")
        for address in ("telescope/altitude", "dome/rt", "weather/status"):
            await seen(hub, lambda address=address: hub.values(address), address)
        assert hub.values("telescope/altitude")[0] == 10.0
        assert hub.values("dome/rt")[0] == "Invalid dome action"
        assert str(hub.values("weather/status")[0]).startswith("['Cl")
        assert hub.of(DeviceState) == []
    did = [(what, phase) for device, what, phase in asked(ledger) if device == "dome"]
    moves = [each for each in did if each[0] in ("open", "close")]
    assert moves == [("open", "asked"), ("open", "done"), ("close", "asked"), ("close", "done")]


@pytest.mark.parametrize("ros", ["ros2"], indirect=True)
async def test_bad_input_is_refused_with_a_reason_and_nothing_is_asked_of_a_server(
    ros: str, ledger: Path, tmp_path: Path
) -> None:
    site = replace(read_site(EXAMPLE), interlocks={}, enclosures={}, alarms={}, night=None)
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path / "data", dump_site(site)):
        await seen(hub, lambda: hub.values("dome/shutter"), "the dome")
        for device, command, args, said in (
            ("roof", "open", {}, "roof/open is not a command of this site"),
            ("dome", "explode", {}, "dome/explode is not a command of this site"),
            ("telescope", "goto", {"ra": 25.0, "dec": 0.0}, "ra: 25.0 is above 24"),
            ("telescope", "goto", {"ra": 1.0, "dec": -91.0}, "dec: -91.0 is below -90"),
            ("telescope", "goto", {"ra": "1; rm -rf /", "dec": 0.0}, "ra: expected a number"),
            ("camera", "expose", {"seconds": -1.0}, "seconds: -1.0 is below 0.04"),
            ("camera", "expose", {"seconds": math.nan}, "seconds: expected a finite number"),
            ("camera", "expose", {"seconds": 1.0, "target": "x" * 61}, "60"),
            ("dome", "goto", {"azimuth": 361.0}, "azimuth: 361.0 is above 360"),
        ):
            refused = await do(hub, device, command, **args)
            assert refused.phase == "refused", (device, command, args)
            assert said in refused.message
    assert asked(ledger) == []


@pytest.mark.parametrize("ros", ["ros2"], indirect=True)
async def test_power_of_an_open_dome_is_not_cut_and_a_dome_without_power_is_silent(
    ros: str, ledger: Path, tmp_path: Path
) -> None:
    site = read_site(EXAMPLE)
    rain = replace(site.interlocks["rain"], dwell=0.0)
    rain = replace(rain, when=tuple(replace(each, dwell=0.0) for each in rain.when))
    dome = replace(site.enclosures["dome"], unsafe=("rain",), follow=None)
    site = replace(site, interlocks={"rain": rain}, enclosures={"dome": dome}, alarms={})
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path / "data", dump_site(site)):
        await seen(hub, lambda: hub.values("weather/raining"), "the weather")
        await seen(hub, lambda: hub.values("dome/closed"), "the dome")
        opened = await do(hub, "dome", "open")
        assert opened.phase == "succeeded", opened.message
        for command, args in (("outlet1", {"active": False}), ("reboot", {"outlet": 1})):
            refused = await do(hub, "power", command, **args)
            assert (refused.phase, refused.message) == (
                "refused", "Dome needs its power: Dome is not closed",
            )  # fmt: skip
        assert (await do(hub, "dome", "close")).phase == "succeeded"
        await seen(hub, lambda: hub.values("dome/closed")[-1] == 1.0, "closed")
        await seen(hub, lambda: hub.values("dome/position")[-1] < 1, "closed by its position, too")
        cut = await do(hub, "power", "outlet1", active=False)
        assert cut.phase == "succeeded", cut.message
        # Its controller is dead: nothing comes any more, and what is asked of it fails.
        failed = await do(hub, "dome", "open")
        assert (failed.phase, "has no power" in failed.message) == ("failed", True)
        count = len(hub.values("dome/closed"))
        # Ten of the weather's, which come as often as the dome's.
        weather = len(hub.values("weather/wind")) + 10
        await seen(hub, lambda: len(hub.values("weather/wind")) >= weather, "more weather")
        assert len(hub.values("dome/closed")) <= count + 1
    assert [each for each in asked(ledger) if each[0] == "pdu"] == [
        ("pdu", "outlet1 False", "answered")
    ]


@pytest.mark.parametrize("ros", ["ros2"], indirect=True)
async def test_an_exposure_begins_when_telescope_and_dome_are_in_place(
    ros: str, ledger: Path, tmp_path: Path
) -> None:
    site = read_site(EXAMPLE)
    rain = replace(site.interlocks["rain"], dwell=0.0)
    rain = replace(rain, when=tuple(replace(each, dwell=0.0) for each in rain.when))
    dome = replace(site.enclosures["dome"], unsafe=("rain",))
    site = replace(site, interlocks={"rain": rain}, enclosures={"dome": dome})
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path / "data", dump_site(site)):
        await seen(hub, lambda: hub.values("weather/raining"), "the weather")
        refused = await do(hub, "camera", "expose", seconds=0.1)
        assert (refused.phase, refused.message) == ("refused", "Dome: it is closed")
        assert (await do(hub, "dome", "open")).phase == "succeeded"
        assert (await do(hub, "telescope", "unpark")).phase == "succeeded"
        # High in the north, and nearly opposite of where the dome's slit is parked.
        slewed = await do(hub, "telescope", "goto_altaz", alt=70.0, az=330.0)
        assert slewed.phase == "succeeded", slewed.message
        assert (await do(hub, "telescope", "track", active=True)).phase == "succeeded"
        taken = await do(hub, "camera", "expose", seconds=0.1)
        assert taken.phase == "succeeded", taken.message
    rows = asked(ledger)
    turned = next(i for i, row in enumerate(rows) if row[1][:4] == "goto" and row[0] == "dome"
                  and row[2] == "done")  # fmt: skip
    exposed = next(i for i, row in enumerate(rows) if row[0] == "camera")
    assert turned < exposed


async def test_a_picture_comes_into_the_archive_once_and_astropy_finds_nothing_wrong(
    ros: str, ledger: Path, tmp_path: Path
) -> None:
    site = replace(read_site(EXAMPLE), interlocks={}, enclosures={}, alarms={}, night=None)
    if ros == "ros1":
        # The simulator takes an exposure's length from a topic there.
        site = as_ros1(site)
        seconds = Argument(type=ArgumentType.NUMBER, field="data")
        expose = Command(
            name="Expose", kind=CommandKind.TOPIC, target="/camera/expose",
            type="std_msgs/msg/Float64", arguments={"seconds": seconds},
        )  # fmt: skip
        camera = replace(site.devices["camera"], commands={"expose": expose})
        site = replace(site, devices={**site.devices, "camera": camera})
    text, target = dump_site(site), {"target": "M 31"} if ros == "ros2" else {}

    async def expose_one(hub: FakeHub, files: int) -> None:
        before = len(hub.values("camera/state"))
        await seen(hub, lambda: len(hub.hellos) == files, "the gateway")
        await seen(hub, lambda: len(hub.values("camera/state")) > before, "the camera")
        deadline = time.monotonic() + PATIENCE_S
        while True:
            taken = await do(hub, "camera", "expose", seconds=0.1, **target)
            # The gateway has just begun and may not have found what takes exposures.
            if taken.phase != "refused" or time.monotonic() > deadline:
                break
        assert taken.phase == "succeeded", taken.message
        await seen(hub, lambda: len(whole(hub)) >= files, f"file {files}")

    async with fake_hub(addresses_of) as hub:
        async with running(hub.url, tmp_path / "data", text):
            await expose_one(hub, 1)
        # The topic is latched: after a restart its newest file comes again.
        async with running(hub.url, tmp_path / "data", text):
            await expose_one(hub, 2)
        assert len(whole(hub)) == len({offer.digest for offer in hub.offers}) == 2
        assert {offer.device for offer in hub.offers} == {"camera"}
        for data in whole(hub):
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                with fits.open(io.BytesIO(data)) as hdus:
                    hdus.verify("exception")
                    header = hdus[0].header
                    assert hdus[0].data.shape == (header["NAXIS2"], header["NAXIS1"])
            assert header["OBJECT"] == target.get("target", "unknown")
            assert (header["ORIGIN"], header["TALAIADV"]) == ("Talaia", "camera")
            assert header["SITELAT"] == pytest.approx(site.place.latitude, abs=1.0)


@pytest.mark.parametrize("ros", ["ros2"], indirect=True)
async def test_where_files_come_from_may_be_described_while_the_gateway_runs(
    ros: str, ledger: Path, tmp_path: Path
) -> None:
    site = replace(read_site(EXAMPLE), interlocks={}, enclosures={}, alarms={}, night=None)
    camera = replace(site.devices["camera"], frames=None)
    without = replace(site, devices={**site.devices, "camera": camera})
    file = tmp_path / "site.yaml"
    async with (
        fake_hub(addresses_of) as hub,
        running(hub.url, tmp_path / "data", dump_site(without), file=file),
    ):
        await seen(hub, lambda: hub.values("camera/state"), "the camera")
        assert (await do(hub, "camera", "dark", seconds=0.1)).phase == "succeeded"
        assert hub.offers == []
        file.write_text(dump_site(site))
        await seen(hub, lambda: len(whole(hub)) == 1, "the file that is latched")
        # Connected anew it comes again, before the next one.
        await hub.send(ReconnectRequest(device="camera", who="Ada"))
        await hub.next(Event, lambda each: each.kind == "device reconnected")
        assert (await do(hub, "camera", "dark", seconds=0.1)).phase == "succeeded"
        await seen(hub, lambda: len(whole(hub)) >= 2, "the second file")
        assert len(whole(hub)) == len({offer.digest for offer in hub.offers}) == 2


def whole(hub: FakeHub) -> list[bytes]:
    """Give the files that the hub has all of."""
    sizes = {offer.id: offer.size for offer in hub.offers}
    return [data for name, data in hub.files.items() if len(data) == sizes[name]]


def close_pipes(process: ForkedProcess | subprocess.Popen[bytes], printed: IO[bytes]) -> None:
    assert process.stdin is not None
    process.stdin.close()
    printed.close()


Simulator = "tuple[ForkedProcess | subprocess.Popen[bytes], IO[bytes]]"


def simulator(ros: str, log: Path, *more: str) -> Simulator:
    words = ["-m", "talaia", "sim", "observatory", "--log", str(log), *more]
    words += ["--ros1"] if ros == "ros1" else ["--domain", os.environ["ROS_DOMAIN_ID"]]
    process, printed = open_program(words)
    assert json.loads(printed.readline())["ready"]
    return process, printed


async def test_a_server_killed_in_mid_slew_is_unknown_within_two_seconds_and_back_by_itself(
    ros: str, tmp_path: Path
) -> None:
    site = read_site(EXAMPLE)
    # Without locks: this is about the server, and not about the weather. Whatever is said of the
    # telescope is not its values' age, for these may be a minute old.
    patient = {
        name: replace(each, max_age=60.0)
        for name, each in site.devices["telescope"].signals.items()
    }
    telescope = replace(site.devices["telescope"], signals=patient)
    devices = {**site.devices, "telescope": telescope}
    site = replace(site, devices=devices, interlocks={}, enclosures={}, alarms={}, night=None)
    started: list[Simulator] = []

    def start(*devices: str) -> Simulator:
        only = [word for device in devices for word in ("--only", device)]
        started.append(simulator(ros, tmp_path / f"{devices[0]}.jsonl", *only))
        return started[-1]

    try:
        start("dome", "weather", "camera")
        server, _ = start("telescope")
        text = dump_site(as_ros1(site) if ros == "ros1" else site)
        async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path / "data", text):
            await seen(hub, lambda: hub.values("telescope/state"), "the telescope")
            await seen(hub, lambda: hub.values("dome/shutter"), "the dome")
            assert (await do(hub, "telescope", "unpark")).phase == "succeeded"
            await hub.send(
                CommandRequest(
                    id="slew", device="telescope", command="goto_altaz",
                    args={"alt": 80.0, "az": 0.0}, ttl_ms=5000, who="Ada",
                )
            )  # fmt: skip
            await seen(hub, lambda: 2.0 in hub.values("telescope/state"), "slewing")
            with Stopwatch() as watch:
                server.kill()
                server.wait()
                await seen(hub, lambda: away(hub) == ["telescope"], "it is not reached")
            assert watch.seconds < 2.0
            assert "telescope_server does not answer" in hub.of(DeviceState)[-1].why
            # The others of the same robot go on.
            others = len(hub.values("dome/shutter"))
            await seen(hub, lambda: len(hub.values("dome/shutter")) > others + 2, "the others")
            start("telescope")
            await seen(hub, lambda: not away(hub), "it is reached again")
            await seen(hub, lambda: hub.values("telescope/state")[-1] == 0.0, "it is parked")
            assert {each.device for each in hub.of(DeviceState)} == {"telescope"}
            assert (await do(hub, "telescope", "unpark")).phase == "succeeded"
    finally:
        for process, printed in reversed(started):
            process.terminate()
            process.wait(10)
            close_pipes(process, printed)


def away(hub: FakeHub) -> list[str]:
    """Which devices are not reached, by the newest that was told of each over this link."""
    return list(hub.away)


async def seen(hub: FakeHub, holds: Callable[[], object], what: str) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < deadline, what
        with contextlib.suppress(TimeoutError):
            await hub.until(holds, what)
