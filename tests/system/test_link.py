"""The link between gateway and hub under kill -9, with the robot's ledger as the judge.

``TALAIA_FAULT_TRIES=10`` runs so many seeds.
"""

from __future__ import annotations

import asyncio
import os
import random
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import httpx
import pytest
from patience import ASK_S, PATIENCE_S
from segments import segments_of, write_crash_row
from shared_trust import usual_trust

from talaia.clock import SystemClock
from talaia.gateway.samples.absence_gaps import NOT_HEARD
from talaia.hub.history.queries.series import Series
from talaia.hub.history.store import HistoryStore
from talaia.hub.settings import Settings
from talaia.wire import browser

from .conftest import running_stack
from .people import page, sign_in
from .stack import SITE, Stack, until

pytestmark = pytest.mark.robot


TRIES = int(os.environ.get("TALAIA_FAULT_TRIES", "1"))
# `make proofs` kills the gateway a hundred times.
CRASHES = 100 if "TALAIA_PROOF_TABLE" in os.environ else 2
COUNT = "base/count"
RATE = 200
# What a gateway has taken but not yet written when it is killed: one flush, on a busy machine.
UNWRITTEN_NS = 250_000_000
# Between DDS telling of a subscription and sending to it.
MATCHING_NS = 50_000_000
BACK_S = 30.0


@pytest.fixture
def stack(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stack]:
    """Start one for each test: a subscription that died in another would be counted for a while."""
    with running_stack(tmp_path_factory) as started:
        yield started


class Counted(NamedTuple):
    """A line of the ledger: value, moment (monotonic, ns), subscriptions ever known just before."""

    value: int
    at: int
    known: int


def ledger(stack: Stack) -> list[Counted]:
    return [Counted(*line) for line in stack.ledger()]


async def counted(stack: Stack, more: int) -> None:
    """Wait until the robot has published so many more values."""
    goal = len(stack.ledger()) + more
    await until(lambda: len(stack.ledger()) >= goal, 30, f"{more} more values")


async def quiet(stack: Stack) -> None:
    said = stack.robot.said().count("quiet")
    stack.robot.tell("quiet")
    await stack.robot.says("quiet", times=said + 1)


def excused(lines: list[Counted], killed: int) -> range:
    """Values published while no gateway was subscribed, and what died unwritten just before.

    From a moment after the robot knew of a new subscription, none is excused.
    """
    before = [each for each in lines if each.at < killed - UNWRITTEN_NS]
    after = [each for each in lines if each.at >= killed]
    came = next(each.at for each in after if each.known > before[-1].known)
    heard = next(each.value for each in after if each.at >= came + MATCHING_NS)
    return range(before[-1].value + 1, heard)


async def stored(stack: Stack, cookie: str, from_us: int) -> set[int]:
    """Ask the hub for all values since a moment."""
    query = {"channel": COUNT, "from_us": from_us, "to_us": _now_us(), "width": 10_000}
    async with httpx.AsyncClient(
        base_url=stack.address, headers={"Cookie": cookie}, verify=usual_trust()
    ) as client:
        answer = await client.get(f"/api/sites/{SITE}/history", params=query)
    answer.raise_for_status()
    (series,) = answer.json()["series"]
    assert series["kind"] == "exact"
    return {int(value) for value in series["v"]}


async def on_disk(stack: Stack, from_us: int) -> Series:
    """Read the database itself, once nobody has it open."""
    settings = Settings(data=stack.folder, host="127.0.0.1", port=stack.port, plain=True)
    store = HistoryStore(settings.url, SystemClock())
    await store.open()
    try:
        (series,) = await store.read_series(SITE, [COUNT], from_us, _now_us(), width=10_000)
    finally:
        await store.close()
    return series


def _told(missing: set[int], lines: list[Counted], killed: int) -> str:
    """Tell which runs of values are missing, and when they were published (s after the kill)."""
    lost = [line for line in lines if line.value in missing]
    starts = [
        a for b, a in zip([None, *lost], lost, strict=False) if not b or a.value - b.value > 1
    ]
    return (
        ", ".join(
            f"{each.value} ({(each.at - killed) / 1e9:+.2f} s, {each.known} known)"
            for each in starts
        )
        + f"; {len(lost)} in all"
    )


def _has_all(pid: int) -> bool:
    """Tell whether a process has segments, and each of them is there."""
    owned = segments_of(pid)
    return bool(owned) and all(each.exists() for each in owned)


def _now_us() -> int:
    return time.time_ns() // 1000


@pytest.mark.timeout(180 + CRASHES * 20)
async def test_a_crash_loop_of_the_gateway_leaves_no_shared_memory(stack: Stack) -> None:
    await stack.ready()
    robots = segments_of(stack.robot.popen.pid)
    assert robots
    left: dict[Path, int] = {}
    for _ in range(CRASHES):
        mine = segments_of(stack.gateway.popen.pid)
        assert mine
        left |= {each: each.stat().st_blocks * 512 for each in mine}
        stack.gateway.kill()
        stack.start_gateway()
        await stack.gateway.says("linked to")
    await until(lambda: not any(each.exists() for each in left), PATIENCE_S, f"gone: {[*left]}")
    assert not [each.name for each in robots if not each.exists()], "a living robot's memory"
    # This gateway may be joining the robot's domain just now, and take a first segment back.
    await until(lambda: _has_all(stack.gateway.popen.pid), PATIENCE_S, "the gateway's own memory")
    write_crash_row("gateway", CRASHES, left)


@pytest.mark.parametrize("seed", range(TRIES))
async def test_whatever_is_killed_every_value_that_a_gateway_took_is_stored_exactly_once(
    stack: Stack, seed: int
) -> None:
    chance = random.Random(seed)  # noqa: S311 - moments of a test
    await stack.fresh()
    began_us, begin = _now_us(), len(stack.ledger())
    stack.robot.tell(f"count {RATE}")
    await until(
        lambda: len(stack.ledger()) > begin and stack.ledger()[-1][2] > 0, what="a listener"
    )
    heard = stack.ledger()[-1][0] + round(RATE * MATCHING_NS / 1e9)

    await counted(stack, chance.randint(1, 300))
    stack.hub.kill()
    await counted(stack, chance.randint(1, 300))
    stack.start_hub()
    await stack.gateway.says("linked to", times=stack.gateway.said().count("linked to") + 1)

    # The gateway may still be catching up when the hub dies again.
    await counted(stack, chance.randint(1, 200))
    stack.hub.kill()
    await counted(stack, chance.randint(1, 200))
    knew = stack.ledger()[-1][2]
    killed = stack.gateway.kill()
    await counted(stack, chance.randint(1, 100))
    stack.start_hub()
    stack.start_gateway()
    await stack.ready()
    # A machine that is busy may take its time to introduce the two to each other.
    await until(lambda: stack.ledger()[-1][2] > knew, what="the robot knows the new gateway")
    await counted(stack, 200)
    await quiet(stack)

    lines = ledger(stack)[begin:]
    lines = [line for line in lines if line.value >= heard]
    spared = excused(lines, killed)
    taken = {line.value for line in lines} - {*spared}
    cookie = await sign_in(stack, "second")
    deadline = time.monotonic() + BACK_S
    while missing := taken - await stored(stack, cookie, began_us):
        assert time.monotonic() < deadline, f"lost: {_told(missing, lines, killed)}"
        await asyncio.sleep(ASK_S)
    stack.gateway.end()
    stack.hub.end()

    series = await on_disk(stack, began_us)
    values = [int(value) for value in series.value]
    assert series.exact
    assert len(values) == len(set(values)), "stored twice"
    assert taken <= set(values)
    # The hole is told, and nothing else is; a gateway may hear its robot a while after its start.
    assert {each.reason for each in series.gaps} <= {"the gateway was not running", NOT_HEARD}
    # In the hole, nothing came after a value that was lost: each run's values have no hole.
    lost = sorted({line.value for line in lines} - set(values))
    assert lost == [*range(lost[0], lost[0] + len(lost))]
    sys.stdout.write(
        f"\nseed {seed}: {len(lines)} published, {len(values)} stored, {len(lost)} while no gateway"
        f" listened ({len(spared)} excused)\n"
    )


async def test_after_a_restart_of_the_hub_the_gateway_is_back_by_itself_and_says_so_once(
    stack: Stack,
) -> None:
    await stack.fresh()
    cookie = await sign_in(stack, "second")
    async with page(stack, "second", cookie=cookie) as before:
        await before.subscribe("base/open")
        await before.sees(browser.Values)
        said = len(stack.gateway.said())
        at = stack.hub.kill()
    # Long enough for several attempts, each of which fails in its own way.
    await until(lambda: time.monotonic_ns() - at > 2_000_000_000, 5)
    stack.start_hub()
    await stack.hub.says("ready")
    up = time.monotonic()
    await until(lambda: "linked to" in stack.gateway.said()[said:], BACK_S, "the link")
    sys.stdout.write(f"\nlinked again {time.monotonic() - up:.1f} s after the hub was ready")
    async with page(stack, "second", cookie=cookie) as after:
        assert (await after.subscribe("base/open")).refused == []
        # The values of this topic are the moments of their publication.
        await until(lambda: any(value > up for value in after.values()), BACK_S, "live values")
    lines = stack.gateway.said()[said:].splitlines()
    assert [line for line in lines if "linked to" in line] == lines[-1:]
    losses = [line for line in lines if "WARNING" in line]
    assert len(losses) == 1, losses
    assert "trying again" in losses[0]
