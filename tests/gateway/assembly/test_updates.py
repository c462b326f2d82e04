"""A gateway ends for another release only at rest: nothing driven, armed, open or under way."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from talaia.clock import SystemClock
from talaia.gateway.app import Gateway
from talaia.gateway.assembly.updates import UpdatesPart
from talaia.gateway.night.arming import NightArming
from talaia.gateway.night.night_store import NightStore
from talaia.gateway.settings import GatewaySettings, HubAddress
from talaia.model.yaml_text.load import load_site
from talaia.wire.gateway_messages.driving import LeaseOp, LeaseRequest

from ..night_observatory import SITE_FILE

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from talaia.model.site import Site

BRIDGE = 'connections: {bridge: {kind: rosbridge, url: "ws://127.0.0.1:9090"}}'
VEHICLE = f"""
talaia: 1
site: agv
name: Vehicle
{BRIDGE}
devices:
  base: {{name: Base, drive: {{topic: /cmd_vel, max_speed: 0.2, max_turn: 2}}}}
"""


def observatory() -> Site:
    """Give the example as it is behind a rosbridge server: no ROS is loaded into this process."""
    text = SITE_FILE.read_text()
    assert "ros2: {}" in text
    return load_site(text.replace("ros2: {}", BRIDGE))


@asynccontextmanager
async def updates_of(site: Site, data: Path) -> AsyncIterator[UpdatesPart]:
    """Build a gateway that is not started, and give what judges whether it may end."""
    hub = HubAddress.from_text("ws://127.0.0.1:1", allow_plain=True)
    settings = GatewaySettings(hub=hub, key="key", data=data)
    gateway = Gateway(site=site, settings=settings, clock=SystemClock())
    try:
        (updates,) = [part for part in gateway._parts if isinstance(part, UpdatesPart)]
        yield updates
    finally:
        await gateway.close()


async def test_who_holds_a_lease_is_not_cut_off(tmp_path: Path) -> None:
    async with updates_of(load_site(VEHICLE), tmp_path) as updates:
        assert updates.unrest_reason() == ""
        driving = updates._uplink.actuation.actuation.driving
        ask = LeaseRequest(device="base", session="tab", who="Ada", op=LeaseOp.TAKE)
        driving.handle_lease(ask)
        assert updates.unrest_reason() == "it is driven, or a command runs"
        driving.handle_lease(LeaseRequest(device="base", session="tab", who="Ada", op=LeaseOp.FREE))
        assert updates.unrest_reason() == ""


async def test_an_armed_night_or_one_that_has_opened_goes_on(tmp_path: Path) -> None:
    for number, arming in enumerate(
        [NightArming(armed_by="Ada"), NightArming(opened=True), NightArming()]
    ):
        data = tmp_path / str(number)
        (data / "night").mkdir(parents=True)
        NightStore(data / "night").write_arming(arming)
        async with updates_of(observatory(), data) as updates:
            armed = updates.unrest_reason() == "the night is armed"
            assert armed == (arming != NightArming())


async def test_a_roof_that_says_nothing_may_be_open(tmp_path: Path) -> None:
    async with updates_of(observatory(), tmp_path) as updates:
        assert updates.unrest_reason() == "the enclosure dome is not certainly closed"
