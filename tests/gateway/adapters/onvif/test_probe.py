"""What a camera says that it has becomes a description that runs as it is."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from onvif_camera import OnvifCamera, serving_camera

from talaia.gateway.adapters.onvif.probe import probe_cameras
from talaia.gateway.adapters.onvif.search import FoundCamera
from talaia.gateway.errors import AdapterLost
from talaia.model.checks.site_checks import check_site
from talaia.model.discovery.generate_description import DescriptionProposal, propose_description
from talaia.model.roles import CommandRole, SignalRole
from talaia.model.site import DriveMessage
from talaia.model.yaml_text.load import load_site
from talaia.model.yaml_text.write import write_description

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture
def served() -> Iterator[tuple[FoundCamera, OnvifCamera]]:
    with serving_camera() as (port, camera):
        camera.presets = {"1": ("Gate", {"pan": 0.3, "tilt": 0.1, "zoom": 0.0})}
        yield FoundCamera(f"http://127.0.0.1:{port}/onvif/device_service", "Yard", "D1"), camera


def proposed(*cameras: FoundCamera, user: str = "", folder: Path = Path()) -> DescriptionProposal:
    named = "secret" if user else ""
    found = probe_cameras(cameras, folder, user=user, password_file=named)
    return propose_description(found, "site", "Site", "UTC")


def test_a_camera_that_turns_is_proposed_whole(served: tuple[FoundCamera, OnvifCamera]) -> None:
    made = proposed(served[0])
    assert check_site(made.site) == []
    assert made.left_out == ()
    # It asks, and moves and sets nothing.
    asked = set(served[1].asked)
    assert not asked & {"ContinuousMove", "Stop", "SetPreset", "GotoPreset", "GotoHomePosition"}
    device = made.site.devices["yard"]
    assert {name: stream.source.url for name, stream in device.streams.items()} == {
        "main": "rtsp://127.0.0.1/main",
        "sub": "rtsp://127.0.0.1/main",
    }
    drive = device.drive
    assert drive is not None
    assert (drive.message, list(drive.joints)) == (DriveMessage.PTZ, ["pan", "tilt", "zoom"])
    assert (drive.picture, drive.stop.confirmed_by) == ("yard/main", ("yard/moving",))
    # Careful, until the owner says more.
    assert {joint.max_speed for joint in drive.joints.values()} == {0.5}
    assert device.signals["presets"].role is SignalRole.CAMERA_PRESETS
    roles = {name: command.role for name, command in device.commands.items()}
    assert roles["goto_preset"] is CommandRole.CAMERA_GOTO_PRESET
    assert roles["stop"] is CommandRole.CAMERA_ABORT
    # Written, and read again, it is the same.
    assert load_site(write_description(made.site, [])) == made.site


def test_a_camera_that_stands_still_has_pictures_alone(
    served: tuple[FoundCamera, OnvifCamera],
) -> None:
    served[1].fixed = True
    device = proposed(served[0]).site.devices["yard"]
    assert (len(device.streams), device.drive, device.commands, device.signals) == (2, None, {}, {})


def test_a_picture_that_is_said_to_be_elsewhere_is_left_out(
    served: tuple[FoundCamera, OnvifCamera],
) -> None:
    served[1].stream = "rtsp://user:secret@192.0.2.66/main"
    made = proposed(served[0])
    assert made.site.devices["yard"].streams == {}
    assert "192.0.2.66" in made.left_out[0]
    assert "secret" not in "".join(made.left_out)
    # A camera may write the password into its own address: that stands in no description.
    served[1].stream = "rtsp://user:secret@127.0.0.1/main"
    assert "secret" not in write_description(proposed(served[0]).site, [])


def test_a_camera_that_wants_a_user_is_told_of_and_signed_in_at_only_when_named(
    served: tuple[FoundCamera, OnvifCamera], tmp_path: Path
) -> None:
    camera = served[1]
    camera.user = "operator:s3cret"
    (tmp_path / "secret").write_text("s3cret\n")
    with serving_camera() as (port, _):
        other = FoundCamera(f"http://127.0.0.1:{port}/onvif/device_service", "", "")
        made = proposed(served[0], other)
    # The one that lets in is proposed, the other is left out with what to do.
    assert list(made.site.devices) == ["nobody_dome_1"]
    assert "--user NAME --password-file FILE" in made.left_out[0]
    assert not [line for line in camera.log if "Password" in line]
    with pytest.raises(AdapterLost, match="it wants a user"):
        proposed(served[0])
    signed = proposed(served[0], user="operator", folder=tmp_path).site
    assert len(signed.devices["yard"].streams) == 2
    assert "s3cret" not in write_description(signed, [])


def test_a_server_that_is_no_camera_is_told_so(served: tuple[FoundCamera, OnvifCamera]) -> None:
    served[1].answers["GetSystemDateAndTime"] = b"<html>hello</html>"
    with pytest.raises(AdapterLost, match="expected an envelope of SOAP, found <html>"):
        proposed(served[0])
