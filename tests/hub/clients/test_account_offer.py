"""What an account is offered, by its rights alone, and that no protocol offers it anything else."""

from __future__ import annotations

import pytest

from talaia.hub.auth.permissions import Grants, Permission, Right
from talaia.hub.clients.account_offer import make_account_offer
from talaia.hub.clients.foxglove.offer import make_foxglove_offer
from talaia.hub.clients.rosbridge.offer import make_rosbridge_offer
from talaia.hub.clients.socketio.offer import make_socketio_offer
from talaia.model.yaml_text.load import load_site

DEVICE = """
  {device}:
    name: {device}
    signals:
      open: {{name: Open, visibility: public,
              source: {{topic: /a, type: std_msgs/msg/Float64, field: data}}}}
      place: {{name: Place, type: position,
               source: {{topic: /o, type: nav_msgs/msg/Odometry, field: pose.pose}}}}
    streams:
      shown: {{name: Shown, visibility: public,
               source: {{topic: /i, type: sensor_msgs/msg/Image}}}}
      eye: {{name: Eye, source: {{topic: /j, type: sensor_msgs/msg/Image}}}}
    commands:
      turn: {{name: Turn, target: /turn, type: std_srvs/srv/Trigger}}
    drive: {{topic: /v, max_speed: 1, max_turn: 2}}
"""
SITE = load_site(
    "talaia: 1\nsite: agv\nname: Vehicle\nros2: {}\ndevices:"
    + "".join(DEVICE.format(device=device) for device in ("base", "arm"))
)
PUBLIC = {"arm/open", "arm/shown", "base/open", "base/shown"}
BASE = {"base/eye", "base/place"}

# Written by hand: what may be seen beside the public, called, stopped, and driven with leave.
OFFERED = {
    (): (set(), set(), set(), set()),
    (Permission(Right.VIEW, "agv", "base"),): (BASE, set(), {"base"}, set()),
    (Permission(Right.USE, "agv", "base"),): (BASE, {"base/turn"}, {"base"}, {"base"}),
    (Permission(Right.TAP),): (set(), set(), set(), set()),
    (Permission(Right.METRICS),): (set(), set(), set(), set()),
    (Permission(Right.ADMIN, "another"),): (set(), set(), set(), set()),
    (Permission(Right.VIEW, "agv", "base"), Permission(Right.USE, "agv", "arm")): (
        BASE | {"arm/eye", "arm/place"},
        {"arm/turn"},
        {"base", "arm"},
        {"arm"},
    ),
}


@pytest.mark.parametrize("permissions", OFFERED)
def test_account_is_offered_what_is_public_and_what_its_rights_name(permissions) -> None:
    seen, called, stopped, driven = OFFERED[permissions]
    offer = make_account_offer(SITE, Grants(frozenset(permissions)))
    views = {view.address for view in (*offer.signals, *offer.cameras)}
    assert views == PUBLIC | seen
    assert {f"{command.device}/{command.name}" for command in offer.commands} == called
    assert {drive.device for drive in offer.drives} == stopped
    assert {drive.device for drive in offer.drives if drive.usable} == driven


@pytest.mark.parametrize("permissions", OFFERED)
def test_no_protocol_offers_anything_else(permissions) -> None:
    grants = Grants(frozenset(permissions))
    seen, called, stopped, driven = OFFERED[permissions]
    seen = PUBLIC | seen
    services = called | {f"{device}/drive/stop" for device in stopped}
    # The robot's own name for what may be called.
    services |= {"turn"} if called else set()
    cameras = {address for address in seen if address.endswith(("/eye", "/shown"))}
    signals = seen - cameras

    foxglove = make_foxglove_offer(SITE, grants)
    assert {topic[1:].removesuffix("/frame") for topic in foxglove.signals} == signals
    # Each as single pictures and as a film.
    films = {f"{camera}/video" for camera in cameras}
    assert {topic[1:] for topic in foxglove.cameras} == cameras | films
    assert {name[1:] for name in foxglove.services} == services
    assert set(foxglove.driven.values()) == stopped

    rosbridge = make_rosbridge_offer(SITE, grants)
    assert {address.partition(".")[0] for address in rosbridge.addresses} == signals
    assert {name.removeprefix("/talaia/").strip("/") for name in rosbridge.services} == services
    for offer in (foxglove, rosbridge):
        robot = offer.services["/turn"].robot.commands if called else ()
        assert {f"{command.device}/{command.name}" for command in robot} == called
    assert {topic.device for topic in rosbridge.driven.values()} == stopped
    assert rosbridge.parameters == foxglove.parameters

    socketio = make_socketio_offer(SITE, grants)
    assert {address.partition(".")[0] for address in socketio.sensors} == signals
    assert set(socketio.cameras) == cameras
    assert (set(socketio.driven), set(socketio.stopped)) == (driven, stopped)


def test_robots_own_topic_drives_the_first_device_and_each_has_a_name_of_ours() -> None:
    offer = make_account_offer(SITE, Grants(frozenset({Permission(Right.VIEW)})))
    devices = {topic: driven.device for topic, driven in offer.driven_topics("/ours").items()}
    assert devices == {"/v": "base", "/ours/base/drive": "base", "/ours/arm/drive": "arm"}
