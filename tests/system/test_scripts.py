"""A script at the demo: it reads values and history, and drives the simulated vehicle."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

import httpx
import pytest
from patience import PATIENCE_S

from talaia.client import Client, DrivingRefused, ProtocolShut

from .conftest import Demo

pytestmark = pytest.mark.robot


@contextmanager
def signed_in(demo: Demo, name: str) -> Iterator[httpx.Client]:
    headers = {"Origin": demo.address}
    with httpx.Client(base_url=demo.address, headers=headers, timeout=PATIENCE_S) as client:
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
                # Half of 0.22 m/s at the most, and the robot itself says that it moves.
                assert reading.value < 0.13
                if reading.value > 0.01:
                    break
        for reading in hub.watch_values(["agv/base/speed"], every_s=0.0):
            if abs(reading.value) < 0.001:
                break
        table = hub.read_history(["agv/base/speed"], since=began)
        assert max(table.column("base/speed").to_pylist()) > 0.01
