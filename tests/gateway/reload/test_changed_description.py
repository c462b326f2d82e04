"""A gateway whose description changes while a real ROS 2 robot speaks to it."""

from __future__ import annotations

import asyncio
import hashlib
from contextlib import asynccontextmanager
from itertools import count
from typing import TYPE_CHECKING

import pytest
from fake_hub import KEY, FakeHub, fake_hub
from gateway_bench import SITE, Peer, addresses_of, running

from talaia.gateway.accepted_changes import AcceptedChanges
from talaia.wire.frames import (
    ChangePhase,
    ChangeRequest,
    ChangeState,
    DescriptionUpdate,
    DriveFrame,
    Event,
    LeaseOp,
    LeaseRequest,
    LeaseState,
)
from talaia.wire.sealing import compress_text, decompress_text, digest_of, seal_of

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

pytestmark = pytest.mark.robot
EXTRA = "      speed:\n"
SPEED = "{topic: /odom, type: nav_msgs/msg/Odometry, field: twist.twist.linear.x}"
NUMBER = "{topic: /number, type: std_msgs/msg/Float64, field: data}"
WEATHER = f"""
  weather:
    name: Weather
    signals:
      wind: {{name: Wind, source: {SPEED}}}
"""
IDS = count()


@asynccontextmanager
async def following(
    tmp_path: Path, accepts: AcceptedChanges = AcceptedChanges.NO
) -> AsyncIterator[tuple[FakeHub, Path]]:
    file = tmp_path / "site.yaml"
    async with (
        fake_hub(addresses_of) as hub,
        running(hub.url, tmp_path / "data", file=file, accepts=accepts),
    ):
        await hub.until(lambda: hub.hellos, "a hello")
        yield hub, file


def with_signal(text: str, name: str, source: str, more: str = "") -> str:
    line = f"      {name}: {{name: {name}, source: {source}{more}}}\n"
    return text.replace(EXTRA, line + EXTRA, 1)


def step(number: int) -> str:
    """Give the description of this step: each adds, removes, renames or moves something else."""
    text = SITE
    if number % 2:
        text = with_signal(text, f"extra{number}", SPEED)
    if number % 3 == 0:
        text = with_signal(text, "again", NUMBER)
    if number % 4 == 1:
        text = text.replace("      mode:", "      way:").replace(
            "name: Mode,", "name: W, was: mode,"
        )
    if number % 5 < 2:
        text += WEATHER
    if number % 7 == 3:
        text = text.replace("name: Base", f"name: Base {number}")
    return text.replace("name: Test robot", f"name: Test robot {number}")


async def test_twenty_changes_lose_and_double_no_sample_of_a_kept_sensor(
    peer: Peer, tmp_path: Path
) -> None:
    async with following(tmp_path) as (hub, file):
        await peer.until_heard_by(1)
        each, last = 130, 2_600
        for number in range(1, 21):
            # The robot counts on while the description changes, however long that takes.
            await peer.do("count", **{"from": each * (number - 1), "to": each * number, "hz": 100})
            told = len(hub.of(DescriptionUpdate))
            file.write_text(step(number))
            await hub.until(
                lambda told=told: len(hub.of(DescriptionUpdate)) > told, "the new description"
            )
        await hub.until(lambda: len(hub.values("base/number")) >= last, "the rest")
        assert hub.values("base/number") == [float(number) for number in range(last)]
        assert hub.doubles == 0
        # One process, one link, one boot: nothing was begun again.
        assert len(hub.hellos) == 1
        assert len(hub.samples) == 1


async def test_renamed_sensor_goes_on_under_its_new_name_without_a_hole(
    peer: Peer, tmp_path: Path
) -> None:
    async with following(tmp_path) as (hub, file):
        await peer.until_heard_by(1)
        await peer.do("count", **{"from": 0, "to": 400, "hz": 100})
        await hub.until(lambda: len(hub.values("base/number")) > 20, "samples")
        renamed = SITE.replace("number: {name: N,", "amount: {name: N, was: number,")
        file.write_text(renamed)
        told = await hub.next(DescriptionUpdate)
        assert told.renamed == {"base/number": "base/amount"}
        assert decompress_text(told.source) == renamed
        await peer.until(lambda: peer.heard("counted"))

        def both() -> list[object]:
            return hub.values("base/number") + hub.values("base/amount")

        await hub.until(lambda: len(both()) >= 400, "the rest")
        assert both() == [float(each) for each in range(400)]
        assert hub.values("base/amount")


async def test_added_sensor_is_live_and_a_removed_one_is_silent(peer: Peer, tmp_path: Path) -> None:
    async with following(tmp_path) as (hub, file):
        await peer.until_heard_by(1)
        file.write_text(with_signal(SITE, "wind", SPEED))
        await hub.next(DescriptionUpdate)
        while not hub.values("base/wind"):
            await peer.do("odom", speed=0.5)
            await asyncio.sleep(0.1)
        assert hub.values("base/wind")[0] == 0.5
        file.write_text(SITE)
        await hub.next(DescriptionUpdate)
        before = len(hub.values("base/wind"))
        await peer.do("odom", speed=0.75)
        await hub.until(lambda: 0.75 in hub.values("base/speed"), "the speed")
        assert len(hub.values("base/wind")) == before


async def test_bad_file_is_refused_with_path_and_remedy_and_the_last_good_one_runs_on(
    peer: Peer, tmp_path: Path
) -> None:
    async with following(tmp_path) as (hub, file):
        await peer.until_heard_by(1)
        wrong = SITE.replace("unit: m/s", "unti: m/s\n        deadband: much")
        file.write_text(wrong)
        told = await hub.next(ChangeState)
        assert told.phase is ChangePhase.REFUSED
        # All of them, though the first kept the rest from being read.
        assert [each.where.rpartition(".")[2] for each in told.problems] == ["unti", "deadband"]
        assert told.problems[0].where == "$.devices.base.signals.speed.unti"
        assert told.problems[0].remedy.startswith("did you mean")
        at = wrong.splitlines().index("        unti: m/s") + 1
        assert [(each.line, each.column) for each in told.problems] == [(at, 9), (at + 1, 9)]
        # And in the logbook each with its line, as `talaia check` has it.
        refused = "description_refused"
        events = [await hub.next(Event, lambda each: each.kind == refused) for _ in range(2)]
        assert [each.message.partition(": ")[0] for each in events] == [
            f"site.yaml:{at}:9",
            f"site.yaml:{at + 1}:9",
        ]
        await peer.do("count", **{"from": 0, "to": 5, "hz": 100})
        await hub.until(lambda: len(hub.values("base/number")) == 5, "numbers")
        file.write_text(SITE)
        assert (await hub.next(ChangeState)).phase is ChangePhase.APPLIED
        assert not hub.of(DescriptionUpdate)


async def test_a_field_that_no_type_has_is_told_in_the_logbook(peer: Peer, tmp_path: Path) -> None:
    async with following(tmp_path) as (hub, file):
        await peer.until_heard_by(1)
        text = with_signal(SITE, "wind", SPEED.replace("linear", "linaer"))
        file.write_text(text)
        told = await hub.next(Event, lambda each: each.kind == "description_doubtful")
        line = next(at for at, said in enumerate(text.splitlines(), 1) if "linaer" in said)
        assert told.message.startswith(f"site.yaml:{line}:")
        assert ": no field linaer in " in told.message
        assert told.message.endswith("did you mean linear?")


async def drive(hub: FakeHub, session: str = "tab") -> None:
    await hub.send(LeaseRequest(device="base", session=session, who="Ada", op=LeaseOp.TAKE))
    state = await hub.next(LeaseState, lambda each: each.asked == session)
    await hub.until(lambda: hub.tick >= 0, "a tick")
    for seq in range(3):
        frame = DriveFrame(
            device="base", session=session, epoch=state.epoch, seq=seq, tick=hub.tick,
            linear=0.2, angular=0.0,
        )  # fmt: skip
        await hub.send(frame)
        await asyncio.sleep(0.05)


async def test_change_ends_the_driving_of_a_device_that_it_touches_with_zeros_first(
    peer: Peer, tmp_path: Path
) -> None:
    async with following(tmp_path) as (hub, file):
        await peer.until_heard_by(1)
        await drive(hub)
        await peer.until(lambda: [0.2, 0.0] in peer.heard("cmd"))
        file.write_text(SITE.replace("max_speed: 0.2", "max_speed: 0.1"))
        ended = await hub.next(LeaseState, lambda each: not each.session)
        assert ended.device == "base"
        assert not hub.of(DescriptionUpdate), "the change waits for the zeros"
        await hub.next(DescriptionUpdate)
        # A second of explicit zeros at the control rate came before the change.
        zeros = [each for each in peer.heard("cmd") if each == [0.0, 0.0]]
        assert len(zeros) >= 15


async def test_change_of_another_device_leaves_the_driver_alone(peer: Peer, tmp_path: Path) -> None:
    async with following(tmp_path) as (hub, file):
        await peer.until_heard_by(1)
        await drive(hub)
        file.write_text(SITE + WEATHER)
        await hub.next(DescriptionUpdate)
        await hub.send(LeaseRequest(device="base", session="tab", who="Ada", op=LeaseOp.RENEW))
        state = await hub.next(LeaseState, lambda each: each.asked == "tab")
        assert state.session == "tab"
        assert not state.refused


async def asked(hub: FakeHub, base: str, text: str, key: str = KEY) -> ChangeState:
    name = f"change{next(IDS)}"
    digest = digest_of(base)
    seal = seal_of(
        hashlib.sha256(key.encode()).hexdigest(), change_id=name, who="Ada", base=digest, text=text
    )
    await hub.send(
        ChangeRequest(id=name, source=compress_text(text), base=digest, who="Ada", seal=seal)
    )
    final = {ChangePhase.APPLIED, ChangePhase.REFUSED}
    return await hub.next(ChangeState, lambda each: each.id == name and each.phase in final)


async def test_gateway_takes_no_change_from_the_hub_unless_it_was_told_to(
    ros_domain: int, tmp_path: Path
) -> None:
    async with following(tmp_path) as (hub, file):
        assert hub.hellos[0].accepts == "no"
        told = await asked(hub, SITE, with_signal(SITE, "wind", SPEED))
        assert told.phase is ChangePhase.REFUSED
        assert "--accept-changes" in told.problems[0].remedy
        assert file.read_text() == SITE


async def test_sealed_change_of_readings_is_written_to_the_file_and_counts_at_once(
    ros_domain: int, tmp_path: Path
) -> None:
    async with following(tmp_path, AcceptedChanges.READINGS) as (hub, file):
        wanted = "# by hand\n" + with_signal(SITE, "wind", SPEED)
        assert (await asked(hub, SITE, wanted, key="another")).phase is ChangePhase.REFUSED
        assert (await asked(hub, SITE, wanted)).phase is ChangePhase.APPLIED
        assert file.read_text() == wanted
        late = await asked(hub, SITE, SITE.replace("name: Base", "name: B"))
        assert "meanwhile" in late.message
        faster = await asked(hub, wanted, wanted.replace("max_speed: 0.2", "max_speed: 2"))
        assert faster.problems[0].where == "$.devices.base.drive"
        wrong = await asked(hub, wanted, wanted.replace("unit: m/s", "decimals: many"))
        assert wrong.problems[0].where == "$.devices.base.signals.speed.decimals"
        assert file.read_text() == wanted


async def test_file_that_cannot_be_written_refuses_the_change(
    ros_domain: int, tmp_path: Path
) -> None:
    async with following(tmp_path, AcceptedChanges.ALL) as (hub, file):
        # A folder in the way of the new file.
        (tmp_path / "site.yaml.new").mkdir()
        told = await asked(hub, SITE, SITE.replace("max_speed: 0.2", "max_speed: 0.1"))
        assert told.phase is ChangePhase.REFUSED
        assert "site.yaml" in told.message
        assert file.read_text() == SITE
