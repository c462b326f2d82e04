"""Several robot protocols behind one gateway: each serves its own devices, none ends another."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import msgspec
import pytest
from fake_hub import fake_hub
from gateway_bench import Peer, addresses_of, filled, running
from patience import PATIENCE_S

from talaia.clock import SystemClock
from talaia.gateway.adapters.connection_scope import scopes_of
from talaia.gateway.adapters.connectivity import DeviceReachability
from talaia.gateway.adapters.multi_adapter import ConnectionStatus, MultiAdapter
from talaia.gateway.adapters.null_adapter import NullAdapter
from talaia.gateway.errors import AdapterLost
from talaia.gateway.ports import ChannelReading
from talaia.gateway.reload.discovered_devices import add_discovered, keep_found, with_kept
from talaia.model.connection import IndiSource
from talaia.model.site import Device, Signal
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import CommandPhase, CommandRequest, CommandState, DeviceState

if TYPE_CHECKING:
    from pathlib import Path

TWO = filled("""
talaia: 1
site: two
name: Two robots
connections:
  left: {kind: ros2, domain: %d}
  right: {kind: ros2, domain: %d, node: talaia_right}
devices:
  a:
    name: A
    connection: left
    signals:
      pose: {name: P, type: position, source: {topic: /odom, type: nav_msgs/msg/Odometry,
             field: pose.pose.position}}
      <number>
  b:
    name: B
    connection: right
    signals:
      <number>
    commands:
      <wander>
""")


@pytest.mark.robot
async def test_two_robots_of_one_site_are_heard_and_told_each_for_itself(
    peer: Peer, other_peer: Peer, ros_domain: int, other_domain: int, tmp_path: Path
) -> None:
    text = TWO % (ros_domain, other_domain)
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path, text):
        await hub.until(lambda: hub.hellos, "a hello")
        await peer.until_heard_by(1)
        await other_peer.until_heard_by(1)
        await peer.do("count", **{"from": 100, "to": 103, "hz": 100})
        await other_peer.do("count", **{"from": 200, "to": 203, "hz": 100})
        await hub.until(lambda: len(hub.values("a/number")) == 3, "samples of the left one")
        await hub.until(lambda: len(hub.values("b/number")) == 3, "samples of the right one")
        assert hub.values("a/number") == [100.0, 101.0, 102.0]
        assert hub.values("b/number") == [200.0, 201.0, 202.0]
        assert hub.values("a/pose.x") == []
        ask = CommandRequest(
            id="1", device="b", command="wander", args={"active": True}, ttl_ms=5000, who="Ada"
        )
        await hub.send(ask)
        await hub.next(CommandState, lambda each: each.phase is CommandPhase.SUCCEEDED)
        assert other_peer.heard("wander") == [True]
        assert peer.heard("wander") == []


class Fragile(NullAdapter):
    """A robot's side that is there when it is told, and has one reading."""

    def __init__(self, post: ConnectionStatus, told: Told) -> None:  # noqa: D107
        self.post, self.told = post, told
        self.there = asyncio.Event()
        self.loss: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.runs = 0

    async def run(self) -> None:
        self.runs += 1
        self.told.changed.set()
        if not self.there.is_set():
            raise AdapterLost("nobody answers")
        self.loss = asyncio.get_running_loop().create_future()
        self.post.up()
        await self.loss

    def latest(self, address: str) -> ChannelReading | None:
        return ChannelReading(1.0, 0)


class Told:
    """An `EventSink` and all else that is told, with a way to wait for it."""

    def __init__(self) -> None:  # noqa: D107
        self.events: list[tuple[str, str]] = []
        self.states: list[DeviceState] = []
        self.lost: list[str] = []
        self.back: list[str] = []
        self.changed = asyncio.Event()

    def report_event(
        self, kind: str, message: str, *, device: str = "", good: bool = False
    ) -> None:
        self.events.append((kind, message))
        self.changed.set()

    def say(self, state: DeviceState) -> None:
        self.states.append(state)
        self.changed.set()

    async def until(self, holds) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not holds():
                self.changed.clear()
                await self.changed.wait()


async def test_a_lost_connection_is_told_once_comes_back_by_itself_and_hurts_no_other() -> None:
    told, of = Told(), {"dome": "left", "lamp": "left", "weather": "right"}
    reach = DeviceReachability(of, SystemClock(), told.say)
    loop = asyncio.get_running_loop()
    posts = {name: ConnectionStatus(name, loop, reach) for name in ("left", "right")}
    left, right = Fragile(posts["left"], told), Fragile(posts["right"], told)
    right.there.set()
    adapters = {"left": (left, posts["left"]), "right": (right, posts["right"])}
    many = MultiAdapter(of=of, adapters=adapters, reach=reach, events=told, again_s=0.01)
    many.subscribe_losses(lost=told.lost.extend, back=told.back.extend)
    running = asyncio.ensure_future(many.run())
    await told.until(lambda: len(told.states) == 2 and left.runs > 3)
    assert told.events == [("connection lost", "left: nobody answers")]
    assert [(each.device, each.reached, each.why) for each in told.states] == [
        ("dome", False, "nobody answers"),
        ("lamp", False, "nobody answers"),
    ]
    assert many.latest("dome/shutter") is None
    assert many.latest("weather/rain") is not None
    left.there.set()
    await told.until(lambda: len(told.events) == 2)
    assert told.events[1:] == [("connection back", "left")]
    assert [(each.device, each.reached) for each in told.states[2:]] == [
        ("dome", True),
        ("lamp", True),
    ]
    assert (told.lost, told.back) == (["dome", "lamp"], ["dome", "lamp"])
    posts["right"].device("weather", there=False, why="the server hangs")
    posts["right"].device("weather", there=False, why="the server hangs")
    await told.until(lambda: len(told.states) == 5)
    assert many.latest("weather/rain") is None
    assert right.runs == 1
    running.cancel()
    with pytest.raises(asyncio.CancelledError):
        await running


async def test_what_an_adapter_cannot_help_ends_the_gateway() -> None:
    reach = DeviceReachability({}, SystemClock(), lambda _state: None)

    class Broken(NullAdapter):
        async def run(self) -> None:
            raise ZeroDivisionError("a defect")

    post = ConnectionStatus("x", asyncio.get_running_loop(), reach)
    many = MultiAdapter(of={}, adapters={"x": (Broken(), post)}, reach=reach, events=Told())
    with pytest.raises(ZeroDivisionError, match="a defect"):
        await asyncio.wait_for(many.run(), PATIENCE_S)


def test_each_share_has_its_own_devices_and_the_places_of_their_channels_in_the_whole() -> None:
    left, right = scopes_of(load_site(TWO % (1, 2)))
    assert (left.name, list(left.devices)) == ("left", ["a"])
    assert left.channel == {"a/pose": 0, "a/number": 3}
    assert right.channel == {"b/number": 4}


def test_devices_that_are_found_join_the_description_and_stay(tmp_path: Path) -> None:
    site = load_site("talaia: 1\nsite: s\nname: S\nconnections: {sky: {kind: indi}}\n")
    signal = Signal(name="RA", source=IndiSource(property="EQUATORIAL_EOD_COORD", element="RA"))
    mount = Device(name="Mount", indi="Telescope Simulator", signals={"ra": signal})
    unfit = msgspec.structs.replace(mount, name="")
    both = add_discovered(site, "sky", {"mount": mount, "bad name": mount, "unfit": unfit})
    assert list(both.devices) == ["mount"]
    assert both.devices["mount"].connection == "sky"
    keep_found(tmp_path, "sky", {"mount": mount})
    assert with_kept(tmp_path, site) == both
    named = msgspec.structs.replace(site, devices={"mount": Device(name="By hand")})
    assert add_discovered(named, "sky", {"mount": mount}).devices["mount"].name == "By hand"
    (tmp_path / "found" / "sky.json").write_text("{")
    assert with_kept(tmp_path, site) == site
