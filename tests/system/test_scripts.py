"""A script at the demo: it reads values and history, and drives the simulated vehicle."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest
from mcap.reader import make_reader
from patience import PATIENCE_S
from shared_trust import usual_trust

from talaia.client import Client, DrivingRefused, ProtocolShut

from .conftest import Demo

WHY = "slips on the ramp"

pytestmark = pytest.mark.robot


@contextmanager
def signed_in(demo: Demo, name: str) -> Iterator[httpx.Client]:
    headers = {"Origin": demo.address}
    with httpx.Client(
        base_url=demo.address, headers=headers, timeout=PATIENCE_S, verify=usual_trust()
    ) as client:
        asked = {"name": name, "password": demo.passwords[name]}
        assert client.post("/api/login", json=asked).status_code == 200
        yield client


def token_of(demo: Demo, name: str) -> str:
    with signed_in(demo, name) as person:
        asked = {
            "name": "a script",
            "ends_us": int((time.time() + 3600) * 1e6),
            "permissions": [{"right": "use", "site": "agv", "device": "*"}],
        }
        return str(person.post("/api/me/tokens", json=asked).json()["token"])


def test_script_records_the_robot_and_takes_the_recording_away_whole(
    demo: Demo, tmp_path: Path
) -> None:
    path = tmp_path / "ramp.mcap"
    with Client(demo.address, token_of(demo, "operator")) as hub:
        next(iter(hub.watch_values(["agv/base/speed"])))
        hub.start_recording("agv", why=WHY)
        for reading in hub.watch_values(["agv/base/speed"], every_s=0.0):
            if not reading.stale:
                break
        hub.stop_recording("agv")
        # Listed once the gateway has closed the file and begun to send it. Where somebody pressed
        # STOP just before, it is one recording with both reasons.
        ends = time.monotonic() + PATIENCE_S
        while not (found := [r.id for r in hub.list_recordings("agv").recordings if WHY in r.why]):
            assert time.monotonic() < ends, "no recording came to the hub"
            time.sleep(0.1)
        whole = hub.wait_recording("agv", found[0], timeout_s=PATIENCE_S)
        told: list[int] = []
        size = hub.download_recording("agv", whole.id, path, report=told.append)
        assert size == whole.size == path.stat().st_size == told[-1]
        assert whole.why.endswith(WHY)
    # As MCAP's own reader has it: every message that the gateway counted, with its schema.
    with path.open("rb") as file:
        reader = make_reader(file)
        read = Counter(channel.topic for _, channel, _ in reader.iter_messages())
        summary = reader.get_summary()
    assert sum(read.values()) == whole.messages > 0
    assert "/odom" in read
    assert summary is not None
    assert set(whole.topics) >= set(read)
    assert not list(tmp_path.glob("*.part"))


def test_history_is_a_frame_of_pandas_with_times_of_a_zone(demo: Demo) -> None:
    pandas = pytest.importorskip("pandas", reason="pandas is missing; run make setup")
    began = time.time()
    with Client(demo.address, token_of(demo, "operator")) as hub:
        ends = time.monotonic() + PATIENCE_S
        while True:
            # Committed some moments after it was heard.
            table = hub.read_history(["agv/base/speed", "agv/base/pose"], since=began)
            frame = table.to_pandas()
            if frame["base/speed"].count() > 3 and frame["base/pose.x"].count() > 3:
                break
            assert time.monotonic() < ends, frame
            time.sleep(0.2)
    assert isinstance(frame, pandas.DataFrame)
    assert len(frame) == table.num_rows
    (times,) = (frame[name] for name in frame.columns if "time" in name)
    assert str(times.dt.tz) == "UTC"
    assert times.is_monotonic_increasing
    assert times.min().timestamp() >= began - 1e-6
    # What people do with it: a mean for each second.
    means = frame.set_index(times).resample("1s")["base/speed"].mean()
    assert means.dropna().abs().max() < 1


def test_script_drives_the_simulated_vehicle_once_an_admin_lets_it(demo: Demo) -> None:
    with Client(demo.address, token_of(demo, "operator")) as hub:
        # The demo may be ready a moment before the vehicle has said anything.
        assert next(iter(hub.watch_values(["agv/base/speed"]))).address == "agv/base/speed"
        (speed,) = hub.read_values(["agv/base/speed"])
        assert (speed.unit, speed.stale) == ("m/s", "")
        with pytest.raises(ProtocolShut), hub.drive_device("agv/base"):
            pass
        with signed_in(demo, "admin") as admin:
            opened = admin.put("/api/client-protocols/scripts", json={"open": True, "origins": []})
            assert opened.status_code == 204
            with pytest.raises(DrivingRefused), hub.drive_device("agv/base"):
                pass
            people = admin.get("/api/people").json()["people"]
            (person,) = [one["id"] for one in people if one["name"] == "operator"]
            asked = {"person": person, "site": "agv", "device": "base", "allowed": True}
            assert admin.put("/api/client-drivers", json=asked).status_code == 204
        began = time.time()
        with hub.drive_device("agv/base") as drive:
            ends = time.monotonic() + PATIENCE_S
            for reading in hub.watch_values(["agv/base/speed"], every_s=0.0):
                assert time.monotonic() < ends, drive.report
                drive.set_velocity(0.1)
                # Half of 0.22 m/s at the most, and the robot itself says that it moves. What it did
                # by itself before somebody drove it ends with that.
                if 0.01 < reading.value < 0.13:
                    break
        for reading in hub.watch_values(["agv/base/speed"], every_s=0.0):
            if abs(reading.value) < 0.001:
                break
        # Committed some moments after it was heard.
        ends = time.monotonic() + PATIENCE_S
        while True:
            table = hub.read_history(["agv/base/speed"], since=began)
            if max(table.column("base/speed").to_pylist(), default=0.0) > 0.01:
                break
            assert time.monotonic() < ends, table
            time.sleep(0.1)
