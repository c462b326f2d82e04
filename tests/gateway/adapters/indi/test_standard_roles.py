"""Standard properties of INDI's own simulators have their roles, by property and not by label."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from talaia.gateway.adapters.indi.discovery import devices_of
from talaia.gateway.adapters.indi.protocol import BlobEnd, BlobHead, BlobPart, IndiParser
from talaia.gateway.adapters.indi.standard_roles import with_standard_roles
from talaia.gateway.adapters.indi.state import IndiDeviceTree
from talaia.model.discovery.role_proposal import roles_of
from talaia.model.roles import CommandRole, SignalRole

RECORDED = Path(__file__).parent / "recorded" / "simulators.xml"


@pytest.fixture
def devices():
    tree, reader = IndiDeviceTree(), IndiParser()
    for event in reader.parse_data(RECORDED.read_bytes()):
        if not isinstance(event, BlobHead | BlobPart | BlobEnd):
            tree.apply_event(event, 0)
    return devices_of(tree, "indi")


def without_roles(device, name: str = ""):
    """Give a device as it was described before there were roles; ``name`` instead of all names."""
    replace = msgspec.structs.replace
    return replace(
        device,
        signals={
            f"{name or key}{at}" if name else key: replace(
                signal, role=SignalRole.AUTO, name=name or signal.name
            )
            for at, (key, signal) in enumerate(device.signals.items())
        },
        commands={
            f"{name or key}{at}" if name else key: replace(
                command, role=CommandRole.AUTO, name=name or command.name
            )
            for at, (key, command) in enumerate(device.commands.items())
        },
    )


def said(device) -> dict[str, str]:
    items = {**{f"{key}()": item for key, item in device.commands.items()}, **device.signals}
    return {key: item.role.value for key, item in items.items() if item.role.value != "auto"}


def test_the_simulators_are_described_with_roles(devices) -> None:
    assert said(devices["dome_simulator"]) == {
        "shutter": "dome.shutter",
        "parked": "dome.parked",
        "azimuth": "dome.azimuth",
        "open()": "dome.open",
        "close()": "dome.close",
        "goto()": "dome.goto",
        "park()": "dome.park",
        "unpark()": "dome.unpark",
        "stop()": "dome.stop",
    }
    telescope = said(devices["telescope_simulator"])
    assert telescope["ra"] == "telescope.ra"
    assert telescope["goto()"] == "telescope.goto"
    assert "sync()" not in telescope
    assert said(devices["ccd_simulator"])["expose()"] == "camera.expose"
    assert said(devices["weather_simulator"])["safety"] == "weather.safety"


def test_what_was_found_before_roles_gets_the_same_by_its_words(devices) -> None:
    for device in devices.values():
        before = roles_of(without_roles(device))
        now = roles_of(device)
        if device.kind.value != "other":
            assert (before.signals, before.commands) == (now.signals, now.commands)


def test_no_word_of_a_driver_need_be_understood(devices) -> None:
    for key in ("dome_simulator", "telescope_simulator", "weather_simulator"):
        nameless = with_standard_roles(without_roles(devices[key], "x"))
        assert sorted(said(nameless).values()) == sorted(said(devices[key]).values())
