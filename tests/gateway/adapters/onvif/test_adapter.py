"""The ONVIF adapter in a gateway, driven and commanded as by pages; its camera may lie."""

from __future__ import annotations

import asyncio
import itertools
import math
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest
from fake_hub import FakeHub, fake_hub
from gateway_bench import addresses_of
from onvif_camera import OnvifCamera, fault, serving_camera
from patience import PATIENCE_S, stays

from talaia.gateway.run import serve_gateway
from talaia.gateway.settings import GatewaySettings, HubAddress
from talaia.model.checks.site_checks import raise_first
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import (
    CommandPhase,
    CommandRequest,
    CommandState,
    DeviceState,
    DriveFrame,
    DriveState,
    Event,
    LeaseOp,
    LeaseRequest,
    LeaseState,
    ResetRequest,
    ResetToken,
    StopRequest,
    StopState,
)

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterator
    from pathlib import Path

FINAL = frozenset(CommandPhase) - {CommandPhase.ACCEPTED, CommandPhase.RUNNING}
SITE = """
talaia: 1
site: test
name: Test
connections:
  gate:
    kind: onvif
    url: http://127.0.0.1:%d/onvif/device_service
    here: true
    timeout: 1
    poll: 0.2
%s
devices:
  gate:
    name: Gate
    kind: camera
    signals:
      pan: {name: Pan, source: {ptz: pan}}
      moving: {name: Moves, source: {ptz: moving}}
      presets: {name: Presets, type: text, source: {ptz: presets}}
    commands:
      goto:
        name: Go to preset
        kind: onvif
        target: GotoPreset
        timeout: 5
        arguments: {preset: {type: text, field: preset}}
      keep:
        name: Keep as preset
        kind: onvif
        target: SetPreset
        arguments: {preset: {type: text, field: preset}}
      forget:
        name: Forget preset
        kind: onvif
        target: RemovePreset
        arguments: {preset: {type: text, field: preset}}
      home: {name: Home, kind: onvif, target: GotoHomePosition}
      stop: {name: Stop, kind: onvif, target: Stop}
    drive:
      message: ptz
      joints: {pan: {max_speed: 1}, tilt: {max_speed: 1}, zoom: {max_speed: 1}}
      max_joint_acceleration: 20
      stop: {confirmed_by: [gate/moving]}
"""
SIGNED = "    user: operator\n    password_file: secret"
MOVES_ON = "it goes on moving after Stop, and is told again"
SEQ = itertools.count(1)


class Bench:
    """A gateway with a camera, and the hub it speaks to."""

    def __init__(self, hub: FakeHub) -> None:  # noqa: D107
        self.hub = hub
        self._count = 0

    async def begin(self, command: str, who: str = "Ada", **args: object) -> str:
        self._count += 1
        ask = CommandRequest(
            id=f"ask-{self._count}",
            device="gate",
            command=command,
            args=args,
            ttl_ms=5000,
            who=who,
        )
        await self.hub.send(ask)
        return ask.id

    async def end_of(self, ask_id: str) -> CommandState:
        return await self.hub.next(
            CommandState, lambda each: each.id == ask_id and each.phase in FINAL
        )

    async def does(self, command: str, who: str = "Ada", **args: object) -> CommandState:
        return await self.end_of(await self.begin(command, who, **args))

    async def lease(self, op: LeaseOp, who: str = "Ada") -> None:
        await self.hub.send(LeaseRequest(device="gate", session=who, who=who, op=op))

    async def take(self, who: str = "Ada") -> LeaseState:
        await self.lease(LeaseOp.TAKE, who)
        state = await self.hub.next(LeaseState, lambda each: each.asked == who)
        await self.hub.until(lambda: self.hub.tick >= 0, "a tick")
        return state

    async def push(self, epoch: int, *joints: float, who: str = "Ada") -> None:
        await self.hub.send(
            DriveFrame(
                device="gate",
                session=who,
                epoch=epoch,
                seq=next(SEQ),
                tick=self.hub.tick,
                linear=0.0,
                angular=0.0,
                joints=list(joints),
            )
        )

    @asynccontextmanager
    async def held(self, epoch: int, *joints: float) -> AsyncIterator[None]:
        """Hold a button, as a page does."""

        async def hold() -> None:
            while True:
                await self.lease(LeaseOp.RENEW)
                await self.push(epoch, *joints)
                await asyncio.sleep(0.05)

        holding = asyncio.ensure_future(hold())
        try:
            yield
        finally:
            holding.cancel()
            await asyncio.gather(holding, return_exceptions=True)

    async def until(self, holds: Callable[[], object], what: str) -> None:
        await self.hub.until(holds, what)

    async def until_reached(self) -> None:
        await self.until(lambda: self.newest("gate/pan") is not None, "how it stands")

    def newest(self, address: str) -> float | str | None:
        values = self.hub.values(address)
        return values[-1] if values else None

    def events(self) -> list[str]:
        return [event.message for event in self.hub.of(Event)]


@asynccontextmanager
async def gateway_for(port: int, data: Path, more: str = "") -> AsyncIterator[Bench]:
    (data / "secret").write_text("s3cret\n")
    site = raise_first(load_site(SITE % (port, more)))
    ended = asyncio.Event()
    async with fake_hub(addresses_of) as hub:
        address = HubAddress.from_text(hub.url, allow_plain=True)
        settings = GatewaySettings(hub=address, key="test-key", data=data, folder=data)
        task = asyncio.ensure_future(serve_gateway(site, settings, ended))
        try:
            await hub.until(lambda: hub.hellos, "a hello")
            yield Bench(hub)
        finally:
            ended.set()
            await asyncio.wait_for(task, PATIENCE_S)


@pytest.fixture
def served() -> Iterator[tuple[int, OnvifCamera]]:
    with serving_camera() as (port, camera):
        camera.presets = {
            "1": ("Gate", {"pan": 0.3, "tilt": 0.1, "zoom": 0.0}),
            "2": ("Twin", {"pan": -0.3, "tilt": 0.0, "zoom": 0.0}),
            "3": ("Twin", {"pan": -0.2, "tilt": 0.0, "zoom": 0.0}),
        }
        yield port, camera


async def test_a_held_button_moves_it_and_letting_go_stops_it(
    served: tuple[int, OnvifCamera], tmp_path: Path
) -> None:
    port, camera = served
    async with gateway_for(port, tmp_path) as bench:
        await bench.until_reached()
        epoch = (await bench.take()).epoch
        before = len(camera.stops)
        async with bench.held(epoch, 0.6, -9.0, 0.0):
            # Longer than one Move lives: it is renewed.
            await bench.until(lambda: camera.place()["pan"] > 0.5, "it has turned")
        await bench.until(lambda: len(camera.stops) > before, "Stop")
        await bench.until(lambda: not camera.is_moving(), "rest")
        await bench.until(lambda: bench.newest("gate/moving") == 0.0, "told that it rests")
        # By the end of the hold, and not because it was seen moving on.
        assert MOVES_ON not in bench.events()
    velocities = [velocity for _, velocity in camera.moves]
    assert max(pan for pan, _, _ in velocities) == pytest.approx(0.6)
    # No further than the description lets it, whatever a page asks for.
    assert min(tilt for _, tilt, _ in velocities) == -1.0
    # The frames ceased without a zero: what stopped it is the gateway.
    assert camera.asked["Stop"] > 0


async def test_a_driver_whose_link_is_cut_leaves_it_stopped(
    served: tuple[int, OnvifCamera], tmp_path: Path
) -> None:
    port, camera = served
    async with gateway_for(port, tmp_path) as bench:
        await bench.until_reached()
        epoch = (await bench.take()).epoch
        async with bench.held(epoch, 0.2, 0.0, 0.0):
            await bench.until(lambda: bool(camera.moves), "a Move")
        before = len(camera.stops)
        bench.hub.cut()
        await bench.until(lambda: len(camera.stops) > before, "Stop")
        assert not camera.is_moving()


async def test_only_one_has_it_in_hand_whether_driven_or_commanded(
    served: tuple[int, OnvifCamera], tmp_path: Path
) -> None:
    port, camera = served
    async with gateway_for(port, tmp_path) as bench:
        await bench.until_reached()
        epoch = (await bench.take("Ada")).epoch
        refused = await bench.does("goto", "Bob", preset="Gate")
        assert (refused.phase, refused.message) == (CommandPhase.REFUSED, "Ada drives it")
        # Whoever has it may, and what makes safe needs no asking.
        assert (await bench.does("goto", "Ada", preset="Gate")).phase is CommandPhase.SUCCEEDED
        assert (await bench.does("stop", "Bob")).phase is CommandPhase.SUCCEEDED
        await bench.push(epoch, 0.0, 0.0, 0.0)
        await bench.lease(LeaseOp.FREE, "Ada")
        going = await bench.begin("goto", "Bob", preset="2")
        await bench.until(camera.is_moving, "on its way")
        epoch = (await bench.take("Ada")).epoch
        moves = len(camera.moves)
        await bench.push(epoch, 0.5, 0.0, 0.0)
        state = await bench.hub.next(DriveState, lambda each: each.why != "")
        assert "Bob is acting on Gate: Go to preset" in state.why
        assert (await bench.end_of(going)).phase is CommandPhase.SUCCEEDED
        assert len(camera.moves) == moves


async def test_stop_latches_until_it_is_reset_and_is_confirmed_by_the_camera(
    served: tuple[int, OnvifCamera], tmp_path: Path
) -> None:
    port, camera = served
    async with gateway_for(port, tmp_path) as bench:
        await bench.until_reached()
        epoch = (await bench.take()).epoch
        async with bench.held(epoch, 0.3, 0.0, 0.0):
            await bench.until(camera.is_moving, "it moves")
            await bench.hub.send(StopRequest(device="gate", id="halt", who="Bob"))
            await bench.hub.next(StopState, lambda each: each.confirmed)
            moves = len(camera.moves)
            assert not camera.is_moving()
        refused = await bench.does("goto", preset="Gate")
        assert (refused.phase, refused.message) == (CommandPhase.REFUSED, "STOP is on")
        reset = ResetRequest(device="gate", session="Ada", epoch=epoch, who="Ada")
        await bench.hub.send(reset)
        token = (await bench.hub.next(ResetToken)).token
        reset = ResetRequest(device="gate", session="Ada", epoch=epoch, who="Ada", token=token)
        await bench.hub.send(reset)
        await bench.hub.next(StopState, lambda each: not each.latched)
        assert len(camera.moves) == moves
        assert (await bench.does("goto", preset="Gate")).phase is CommandPhase.SUCCEEDED


async def test_a_gateway_that_starts_anew_stops_what_the_one_before_moved(
    served: tuple[int, OnvifCamera], tmp_path: Path
) -> None:
    port, camera = served
    # As after a crash: the camera was told to move, and does not end that by itself.
    camera.ends_moves = False
    camera.move((0.5, 0.0, 0.0), 60.0)
    async with gateway_for(port, tmp_path) as bench:
        await bench.until(lambda: bool(camera.stops), "Stop")
        assert not camera.is_moving()
        await bench.until_reached()
        epoch = (await bench.take()).epoch
        async with bench.held(epoch, 0.5, 0.0, 0.0):
            await bench.until(camera.is_moving, "it moves")
        # It ends while somebody drives.
    assert not camera.is_moving()


async def test_a_camera_that_moves_on_after_stop_is_told_again_and_people_are_told(
    served: tuple[int, OnvifCamera], tmp_path: Path
) -> None:
    port, camera = served
    camera.ends_moves = False
    async with gateway_for(port, tmp_path) as bench:
        await bench.until_reached()
        epoch = (await bench.take()).epoch
        async with bench.held(epoch, 0.1, 0.0, 0.0):
            await bench.until(camera.is_moving, "it moves")
            camera.obeys_stop = False
        await bench.until(lambda: MOVES_ON in bench.events(), "told")
        stops = len(camera.stops)
        await bench.until(lambda: len(camera.stops) > stops + 1, "Stop, again and again")
        assert bench.newest("gate/moving") == 1.0
        await bench.hub.send(StopRequest(device="gate", id="halt", who="Bob"))
        await bench.hub.next(StopState, lambda each: each.latched)
        stops = len(camera.stops)
        await bench.until(lambda: len(camera.stops) > stops + 2, "Stop, again and again")
        # STOP was sent, and nobody says that it was obeyed.
        assert not any(state.confirmed for state in bench.hub.of(StopState))
        camera.obeys_stop = True
        await bench.hub.next(StopState, lambda each: each.confirmed)


@pytest.mark.parametrize("tells_moving", [True, False])
async def test_a_camera_is_seen_moving_by_its_place_whatever_it_says(
    served: tuple[int, OnvifCamera],
    tmp_path: Path,
    tells_moving: bool,  # noqa: FBT001
) -> None:
    port, camera = served
    # It says IDLE all the time, or nothing.
    camera.tells_moving = tells_moving
    camera.is_moving = lambda: False  # type: ignore[method-assign]
    async with gateway_for(port, tmp_path) as bench:
        await bench.until_reached()
        epoch = (await bench.take()).epoch
        async with bench.held(epoch, 0.2, 0.0, 0.0):
            await bench.until(lambda: bench.newest("gate/moving") == 1.0, "it moves")
        await bench.until(lambda: bench.newest("gate/moving") == 0.0, "it rests")


async def test_presets_are_listed_kept_gone_to_and_forgotten(
    served: tuple[int, OnvifCamera], tmp_path: Path
) -> None:
    port, camera = served
    async with gateway_for(port, tmp_path) as bench:
        # Two are called alike: each goes by its token then.
        await bench.until(lambda: bench.newest("gate/presets") == "Gate\n2\n3", "presets")
        went = await bench.does("goto", preset="Gate")
        assert (went.phase, went.message) == (CommandPhase.SUCCEEDED, "")
        assert camera.place()["pan"] == pytest.approx(0.3, abs=0.02)
        assert (await bench.does("keep", preset="Yard <1>")).phase is CommandPhase.SUCCEEDED
        await bench.until(lambda: bench.newest("gate/presets") == "Gate\n2\n3\nYard <1>", "it")
        # The same name again is the same preset.
        assert (await bench.does("keep", preset="Yard <1>")).phase is CommandPhase.SUCCEEDED
        assert len(camera.presets) == 4
        assert (await bench.does("forget", preset="Yard <1>")).phase is CommandPhase.SUCCEEDED
        assert len(camera.presets) == 3
        for wrong in ("Roof", "Twin"):
            refused = await bench.does("goto", preset=wrong)
            assert refused.phase is CommandPhase.REFUSED
        assert camera.asked["GotoPreset"] == 1
        nowhere = await bench.does("home")
        assert nowhere.phase is CommandPhase.REFUSED
        assert "NoHomePosition" in nowhere.message


async def test_a_preset_that_leads_elsewhere_has_failed(
    served: tuple[int, OnvifCamera], tmp_path: Path
) -> None:
    port, camera = served
    camera.goes_wrong = True
    async with gateway_for(port, tmp_path) as bench:
        await bench.until_reached()
        went = await bench.does("goto", preset="Gate")
    assert went.phase is CommandPhase.FAILED
    assert went.message == (
        "it rests elsewhere: pan -0.30, tilt -0.10, zoom 0.00 instead of "
        "pan 0.30, tilt 0.10, zoom 0.00"
    )


async def test_a_camera_that_tells_nothing_of_itself_says_so(
    served: tuple[int, OnvifCamera], tmp_path: Path
) -> None:
    port, camera = served
    camera.tells_moving = camera.tells_place = False
    async with gateway_for(port, tmp_path) as bench:
        await bench.until(lambda: bench.newest("gate/presets") is not None, "presets")
        went = await bench.does("goto", preset="Gate")
        assert went.phase is CommandPhase.SUCCEEDED
        assert went.message == "the camera took it; it does not tell when it is there"
        assert bench.newest("gate/pan") is None


async def test_a_way_to_a_preset_that_somebody_stops_is_cancelled(
    served: tuple[int, OnvifCamera], tmp_path: Path
) -> None:
    port, camera = served
    async with gateway_for(port, tmp_path) as bench:
        await bench.until_reached()
        camera.presets["9"] = ("Far", {"pan": 1.0, "tilt": 1.0, "zoom": 1.0})
        going = await bench.begin("goto", preset="Far")
        await bench.until(camera.is_moving, "on its way")
        assert (await bench.does("stop", "Bob")).phase is CommandPhase.SUCCEEDED
        assert (await bench.end_of(going)).phase is CommandPhase.CANCELLED
        assert not camera.is_moving()


async def test_a_refused_move_is_told_once_and_asked_anew_only_after_letting_go(
    served: tuple[int, OnvifCamera], tmp_path: Path
) -> None:
    port, camera = served
    camera.faults["ContinuousMove"] = ("SpaceNotSupported", "no such space")
    async with gateway_for(port, tmp_path) as bench:
        await bench.until_reached()
        epoch = (await bench.take()).epoch
        said = "to be moved: the camera refuses (SpaceNotSupported): no such space"
        async with bench.held(epoch, 0.5, 0.0, 0.0):
            await bench.until(lambda: said in bench.events(), "told")
            asked = camera.asked["ContinuousMove"]
            await stays(1.0, lambda: camera.asked["ContinuousMove"] == asked, "it is not repeated")
        camera.faults.clear()
        await bench.push(epoch, 0.0, 0.0, 0.0)
        await bench.until(lambda: camera.asked["Stop"] > 1, "Stop")
        async with bench.held(epoch, 0.5, 0.0, 0.0):
            await bench.until(camera.is_moving, "it moves")


async def test_a_camera_that_refuses_to_stop_is_told_of_once_and_takes_commands(
    served: tuple[int, OnvifCamera], tmp_path: Path
) -> None:
    port, camera = served
    camera.faults["Stop"] = ("ActionNotSupported", "no")
    async with gateway_for(port, tmp_path) as bench:
        await bench.until_reached()
        said = "to stop: the camera refuses (ActionNotSupported): no"
        await bench.until(lambda: said in bench.events(), "told")
        assert (await bench.does("goto", preset="Gate")).phase is CommandPhase.SUCCEEDED
        await bench.hub.send(StopRequest(device="gate", id="halt", who="Bob"))
        asked = camera.asked["Stop"]
        await bench.until(lambda: camera.asked["Stop"] > asked + 1, "STOP is repeated")
        # What came until the command ended is forgotten: it was told then, and is not told again.
        assert said not in bench.events()


async def test_stop_does_not_wait_for_a_move_without_an_answer_and_the_loss_ends_the_lease(
    served: tuple[int, OnvifCamera], tmp_path: Path
) -> None:
    port, camera = served
    async with gateway_for(port, tmp_path) as bench:
        await bench.until_reached()
        epoch = (await bench.take()).epoch
        camera.silent.add("ContinuousMove")
        before = len(camera.stops)
        async with bench.held(epoch, 0.5, 0.0, 0.0):
            await bench.until(lambda: camera.asked["ContinuousMove"] > 0, "a Move")
        # The Move has a second to be answered, and has not been.
        await bench.until(lambda: len(camera.stops) > before, "Stop")
        await bench.hub.next(DeviceState, lambda each: not each.reached)
        await bench.hub.next(LeaseState, lambda each: each.session == "")
        camera.silent.clear()
        await bench.hub.next(DeviceState, lambda each: each.reached)


async def test_a_silent_camera_is_unknown_and_what_was_under_way_is_unknown(
    served: tuple[int, OnvifCamera], tmp_path: Path
) -> None:
    port, camera = served
    async with gateway_for(port, tmp_path) as bench:
        await bench.until_reached()
        camera.presets["9"] = ("Far", {"pan": 1.0, "tilt": 1.0, "zoom": 1.0})
        going = await bench.begin("goto", preset="Far")
        await bench.until(camera.is_moving, "on its way")
        camera.silent |= {"GetStatus", "GetPresets", "GetSystemDateAndTime"}
        assert (await bench.end_of(going)).phase is CommandPhase.UNKNOWN
        away = await bench.hub.next(DeviceState, lambda each: not each.reached)
        assert "has not answered" in away.why
        last = bench.newest("gate/pan")
        assert isinstance(last, float)
        assert math.isnan(last)
        assert camera.asked["GotoPreset"] == 1


HOSTILE = {
    "entities": b'<!DOCTYPE e [<!ENTITY a "aaaaaaaa"><!ENTITY b "&a;&a;&a;">]><e>&b;</e>',
    "external": b'<!DOCTYPE e [<!ENTITY a SYSTEM "file:///etc/hostname">]><e>&a;</e>',
    "huge": b"<e>" + b"a" * 2_000_000 + b"</e>",
    "deep": b"<e>" * 5000 + b"</e>" * 5000,
    "no XML": b"\x00\xff<html>",
    "another answer": fault("x", "y").replace(b"Fault>", b"Other>"),
}


@pytest.mark.parametrize("hostile", HOSTILE)
async def test_a_status_that_cannot_be_read_is_unknown_and_the_rest_goes_on(
    served: tuple[int, OnvifCamera], tmp_path: Path, hostile: str
) -> None:
    port, camera = served
    camera.answers["GetStatus"] = HOSTILE[hostile]
    async with gateway_for(port, tmp_path) as bench:
        await bench.until(lambda: camera.asked["GetStatus"] > 0, "it was asked")
        if hostile != "huge":
            await bench.until(lambda: bench.newest("gate/presets") is not None, "presets")
        assert bench.newest("gate/pan") is None


@pytest.mark.parametrize("signs", ["wsse", "digest"])
async def test_it_signs_by_the_cameras_own_clock_and_never_sends_the_password(
    served: tuple[int, OnvifCamera], tmp_path: Path, signs: str
) -> None:
    port, camera = served
    camera.user, camera.signs = "operator:s3cret", signs
    # A camera that has lost its clock, and one whose services are said to be elsewhere.
    camera.clock_off = -20 * 365 * 86_400.0
    camera.address = "http://192.0.2.7:8080"
    async with gateway_for(port, tmp_path, SIGNED) as bench:
        await bench.until_reached()
        # Its clock is set while we are there.
        camera.clock_off = 0.0
        assert (await bench.does("keep", preset="Now")).phase is CommandPhase.SUCCEEDED
    assert not [line for line in camera.log if "s3cret" in line]
    assert not [event for event in bench.events() if "s3cret" in event]


async def test_a_camera_that_wants_the_password_in_plain_does_not_get_it(
    served: tuple[int, OnvifCamera], tmp_path: Path
) -> None:
    port, camera = served
    camera.user, camera.signs = "operator:other", "basic"
    async with gateway_for(port, tmp_path, SIGNED) as bench:
        away = await bench.hub.next(DeviceState, lambda each: not each.reached)
    assert "it asks for the password in plain, and does not get it" in away.why
    assert not [line for line in camera.log if "Basic" in line or "s3cret" in line]
