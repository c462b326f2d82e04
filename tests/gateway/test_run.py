"""The gateway as a process: signals, and what it says when it cannot start."""

from __future__ import annotations

import asyncio
import signal
import struct
from typing import TYPE_CHECKING

import pytest
from async_program import AsyncProgram, start_program
from fake_hub import KEY, fake_hub
from gateway_bench import SITE, Peer, addresses_of
from patience import PATIENCE_S, Stopwatch, lasts_for

from talaia.wire.frames import (
    CommandRequest,
    CommandState,
    DriveFrame,
    LeaseOp,
    LeaseRequest,
    LeaseState,
)

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path


_STARTED: list[asyncio.subprocess.Process] = []


@pytest.fixture(autouse=True)
async def none_left_behind() -> AsyncIterator[None]:
    """End what a failed test left running."""
    yield
    while _STARTED:
        process = _STARTED.pop()
        if process.returncode is None:
            process.kill()
            await process.communicate()


async def started(tmp_path: Path, url: str, text: str) -> AsyncProgram | asyncio.subprocess.Process:
    (tmp_path / "site.yaml").write_text(text)
    (tmp_path / "key").write_text(KEY)
    words = [str(tmp_path / "site.yaml"), "--hub", url, "--key-file", str(tmp_path / "key")]
    words += ["--allow-plain", "--data", str(tmp_path / "data")]
    process = await start_program("-m", "talaia", "gateway", *words, with_errors=True)
    _STARTED.append(process)
    return process


async def finished(process: asyncio.subprocess.Process) -> tuple[int, str]:
    _, said = await asyncio.wait_for(process.communicate(), PATIENCE_S)
    assert process.returncode is not None
    return process.returncode, said.decode()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
async def test_signal_ends_it_cleanly(tmp_path: Path, number: signal.Signals) -> None:
    text = "talaia: 1\nsite: q\nname: Q\ndevices: {d: {name: D}}"
    async with fake_hub(addresses_of) as hub:
        process = await started(tmp_path, hub.url, text)
        await hub.until(lambda: hub.hellos, "a hello")
        with Stopwatch() as watch:
            process.send_signal(number)
            code, said = await finished(process)
    assert (code, "Traceback" in said) == (0, False)
    # Far below what a service manager waits before it kills; how long exactly is for `bench`.
    assert watch.seconds < 10


async def test_second_gateway_on_one_data_folder_is_refused(tmp_path: Path) -> None:
    text = "talaia: 1\nsite: q\nname: Q\ndevices: {d: {name: D}}"
    async with fake_hub(addresses_of) as hub:
        first = await started(tmp_path, hub.url, text)
        await hub.until(lambda: hub.hellos, "a hello")
        code, said = await finished(await started(tmp_path, hub.url, text))
        assert (code, "used by another gateway" in said) == (2, True)
        first.terminate()
        assert (await finished(first))[0] == 0


@pytest.mark.robot
async def test_end_while_driving_leaves_a_zero_behind(peer: Peer, tmp_path: Path) -> None:
    async with fake_hub(addresses_of) as hub:
        process = await started(tmp_path, hub.url, SITE)
        await hub.until(lambda: hub.hellos, "a hello")
        await peer.until_heard_by(1)
        await hub.send(LeaseRequest(device="base", session="tab", who="Ada", op=LeaseOp.TAKE))
        epoch = (await hub.next(LeaseState, lambda each: each.asked == "tab")).epoch
        await hub.until(lambda: hub.tick >= 0, "a tick")
        frame = {"device": "base", "session": "tab", "epoch": epoch, "linear": 0.2, "angular": 0.0}
        await hub.send(DriveFrame(**frame, seq=1, tick=hub.tick))
        await peer.until(lambda: any(row[0] > 0 for row in peer.heard("cmd")))
        with Stopwatch() as watch:
            process.terminate()
            code, said = await finished(process)
    assert (code, "Traceback" in said) == (0, False)
    # Far below what a service manager waits before it kills; how long exactly is for `bench`.
    assert watch.seconds < 10
    await peer.until(lambda: peer.heard("cmd")[-1] == [0.0, 0.0])


@pytest.mark.robot
async def test_killed_gateway_comes_back_stopped_and_keeps_its_samples(
    peer: Peer, tmp_path: Path
) -> None:
    async with fake_hub(addresses_of) as hub:
        hub.acking = False
        first = await started(tmp_path, hub.url, SITE)
        await hub.until(lambda: hub.hellos, "a hello")
        await peer.until_heard_by(1)
        await peer.do("count", **{"from": 0, "to": 200, "hz": 1000})
        await hub.until(lambda: len(hub.values("base/number")) == 200, "samples")
        # What is sent is written beside it, not before: the last batch may still be on its way.
        last = struct.pack("<d", 199.0)
        await hub.until(
            lambda: any(
                last in each.read_bytes() for each in tmp_path.rglob("*") if each.is_file()
            ),
            "the last sample on disk",
        )
        first.kill()
        await finished(first)
        # The hub lost what it had not stored; the spool has it all.
        hub.samples.clear()
        hub.acking = True
        second = await started(tmp_path, hub.url, SITE)
        await hub.until(lambda: len(hub.values("base/number")) == 200, "the same again")
        assert hub.values("base/number") == [float(each) for each in range(200)]
        assert peer.heard("cmd") == []
        second.terminate()
        assert (await finished(second))[0] == 0


async def test_frozen_process_does_not_act_on_what_came_meanwhile(tmp_path: Path) -> None:
    text = "talaia: 1\nsite: q\nname: Q\ndevices: {d: {name: D}}"
    async with fake_hub(addresses_of) as hub:
        process = await started(tmp_path, hub.url, text)
        await hub.until(lambda: hub.hellos, "a hello")
        process.send_signal(signal.SIGSTOP)
        # An answer is given to every ask that is acted on, be it a refusal.
        await hub.send(CommandRequest(id="old", device="d", command="c", ttl_ms=9000, who="Ada"))
        await lasts_for(3.5)
        process.send_signal(signal.SIGCONT)
        await hub.until(lambda: len(hub.hellos) == 2, "a clean link")
        await hub.send(CommandRequest(id="new", device="d", command="c", ttl_ms=9000, who="Ada"))
        first = await hub.next(CommandState)
        assert first.id == "new"
        process.terminate()
        code, said = await finished(process)
    assert code == 0
    assert "stood still" in said
