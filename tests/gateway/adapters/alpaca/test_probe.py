"""What a probe finds at Alpaca servers, and the description that is made of it."""

from __future__ import annotations

import socket
import threading
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from stand_in import serving_alpaca

from talaia.gateway.adapters.alpaca.probe import probe_alpaca
from talaia.gateway.adapters.alpaca.search import search_servers
from talaia.gateway.adapters.indi.discovery import devices_of
from talaia.gateway.adapters.indi.protocol import BlobEnd, BlobHead, BlobPart, IndiParser
from talaia.gateway.adapters.indi.state import IndiDeviceTree
from talaia.gateway.errors import AdapterLost
from talaia.model.checks.site_checks import check_site
from talaia.model.discovery.generate_description import propose_description
from talaia.model.discovery.role_proposal import roles_of
from talaia.model.roles import CommandRole, SignalRole
from talaia.model.site import ArgumentType
from talaia.model.yaml_text.load import load_site
from talaia.model.yaml_text.write import write_description

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Device

OBSERVATORY = Path(__file__).parents[4] / "examples" / "observatory" / "site.yaml"
INDI_SIMULATORS = Path(__file__).parents[1] / "indi" / "recorded" / "simulators.xml"


def test_the_simulators_become_a_description_that_runs(simulators: int) -> None:
    found = probe_alpaca("127.0.0.1", simulators, connect=True)
    made = propose_description(found, "roof", "Roof", "UTC")
    assert made.left_out == ()
    assert not check_site(made.site)
    # It was probed on this computer, and says so.
    again = load_site(write_description(made.site, []))
    assert again.connections["alpaca"].here is True
    dome = again.devices["dome_0"]
    assert dome.signals["shutterstatus"].role is SignalRole.DOME_SHUTTER
    assert dome.commands["close"].role is CommandRole.DOME_CLOSE
    camera = again.devices["camera_0"].commands
    assert camera["binning"].arguments["factor"].maximum == 8
    # Its ten gains have names, and one is chosen by its place.
    gain = camera["gain"].arguments["gain"]
    assert (gain.minimum, gain.maximum) == (0, 9)
    wheel = again.devices["filterwheel_0"].commands["select"]
    assert wheel.description == "0 Red, 1 Green, 2 Blue, 3 Clear, 4 Luminance"
    # The second goes from 0 to 1 as well, in steps of a tenth: no switch, but a dimmer.
    power, dimmer = (again.devices["switch_0"].commands[f"set_switch_{at}"] for at in (0, 1))
    assert power.role is CommandRole.POWER_SWITCH
    assert power.arguments["on"].type is ArgumentType.BOOLEAN
    value = dimmer.arguments["value"]
    assert (value.type, value.minimum, value.maximum) == (ArgumentType.NUMBER, 0.0, 1.0)


# What a person may ask of instruments by hand, whatever they are reached by.
_BY_HAND = {
    CommandRole.CAMERA_EXPOSE,
    CommandRole.CAMERA_ABORT,
    CommandRole.CAMERA_COOL,
    CommandRole.CAMERA_BINNING,
    CommandRole.CAMERA_GAIN,
    CommandRole.CAMERA_FILTER,
    CommandRole.FOCUSER_GOTO,
}
_SEEN = {
    SignalRole.CAMERA_TEMPERATURE,
    SignalRole.CAMERA_COOLER,
    SignalRole.CAMERA_BINNING,
    SignalRole.CAMERA_GAIN,
    SignalRole.CAMERA_FILTER,
    SignalRole.FOCUSER_POSITION,
    SignalRole.FOCUSER_TEMPERATURE,
}


def _indi_devices() -> list[Device]:
    """What INDI's own simulators said once, as it is found."""
    tree, reader = IndiDeviceTree(), IndiParser()
    for event in reader.parse_data(INDI_SIMULATORS.read_bytes()):
        if not isinstance(event, BlobHead | BlobPart | BlobEnd):
            tree.apply_event(event, 0)
    return list(devices_of(tree, "indi").values())


def test_camera_focuser_and_wheel_offer_by_hand_what_they_offer_over_ros_and_indi(
    simulators: int,
) -> None:
    found = probe_alpaca("127.0.0.1", simulators, connect=True)
    alpaca = list(propose_description(found, "roof", "Roof", "UTC").site.devices.values())
    ros = list(load_site(OBSERVATORY.read_text("utf-8")).devices.values())
    for devices in (alpaca, ros, _indi_devices()):
        roles = [roles_of(device) for device in devices]
        assert {role for one in roles for role in one.commands.values()} >= _BY_HAND
        assert {role for one in roles for role in one.signals.values()} >= _SEEN
    # INDI has one command with the kind of frame among its arguments.
    for devices in (alpaca, ros):
        assert {"dark", "bias", "flat"} <= {name for one in devices for name in one.commands}


def test_a_focuser_that_does_not_know_where_it_stands_moves_by_steps() -> None:
    with serving_alpaca() as (port, stand_in):
        answers = {"connected": True, "absolute": False, "maxstep": 500, "ismoving": False}
        stand_in.values |= {f"focuser/0/{name}": value for name, value in answers.items()}
        (focuser,) = probe_alpaca("127.0.0.1", port).devices
    assert focuser.described is not None
    commands = focuser.described.commands
    assert {one.role for one in commands.values()} == {
        CommandRole.FOCUSER_MOVE,
        CommandRole.FOCUSER_STOP,
    }
    by = commands["move_by"].arguments["position"]
    assert (by.minimum, by.maximum) == (-500, 500)


def test_a_gain_that_is_a_number_is_asked_for_within_the_cameras_range() -> None:
    with serving_alpaca() as (port, stand_in):
        answers = {
            "connected": True,
            "gain": 100,
            "gainmin": 0,
            "gainmax": 300,
            "exposuremin": 0.01,
        }
        stand_in.values |= {f"camera/0/{name}": value for name, value in answers.items()}
        (camera,) = probe_alpaca("127.0.0.1", port).devices
    assert camera.described is not None
    gain = camera.described.commands["gain"].arguments["gain"]
    assert (gain.minimum, gain.maximum) == (0, 300)
    # A bias is as short as the camera can.
    assert camera.described.commands["bias"].arguments["seconds"].default == 0.01
    # Nothing that it does not know is offered.
    assert "binning" not in camera.described.commands


def test_a_probe_connects_nothing_unless_it_is_told_to() -> None:
    with serving_alpaca() as (port, stand_in):
        stand_in.values |= {"dome/0/connected": False, "dome/0/shutterstatus": 1}
        stand_in.on_put["dome/0/connected"] = lambda _: stand_in.values.update(
            {"dome/0/connected": True}
        )
        (dome,) = probe_alpaca("127.0.0.1", port).devices
        assert (dome.connected, dome.described, stand_in.puts) == (False, None, [])
        (dome,) = probe_alpaca("127.0.0.1", port, connect=True).devices
        assert dome.connected
        assert dome.described is not None
        assert stand_in.calls("dome/0/connected") == 1


def test_what_is_no_alpaca_server_is_told(simulators: int) -> None:
    with socket.create_server(("127.0.0.1", 0)) as nobody:
        port = nobody.getsockname()[1]
    with pytest.raises(AdapterLost, match="none answers"):
        probe_alpaca("127.0.0.1", port)


@pytest.fixture
def answering() -> Iterator[tuple[int, list[bytes]]]:
    """A port at which discovery is answered with what a test has put there."""
    answers: list[bytes] = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("", 0))

        def answer() -> None:
            data, asker = line.recvfrom(100)
            assert data == b"alpacadiscovery1"
            for said in answers:
                line.sendto(said, asker)

        thread = threading.Thread(target=answer)
        thread.start()
        yield line.getsockname()[1], answers
        thread.join()


def test_servers_that_answer_a_broadcast_are_found_and_nonsense_is_not(
    answering: tuple[int, list[bytes]],
) -> None:
    port, answers = answering
    answers += [b"\xff", b'{"AlpacaPort": 99999}', b'{"AlpacaPort": 11111}', b"{}"]
    found = search_servers(0.5, at=port)
    assert {server.port for server in found} == {11111}
