"""What the hub says that somebody looks at is read sooner from a real robot, as long as it says so.

How soon is not measured here but in `bench/`: batches of what is read sooner hold fewer samples.
"""

from __future__ import annotations

import asyncio
import itertools
from typing import TYPE_CHECKING

import numpy as np
import pytest
from fake_hub import fake_hub
from gateway_bench import SITE, Peer, addresses_of, running

from talaia.wire.frames import SignalSubscription

if TYPE_CHECKING:
    from pathlib import Path

    from fake_hub import FakeHub

pytestmark = pytest.mark.robot
NUMBER = "base/number"
RATE = 250
# A batch as ever has five samples of a signal of this rate, one of the signals that are read soon
# has one or two. So many batches together are no chance.
LARGE, SMALL, TOGETHER = 3.5, 2.5, 20


async def count_on(peer: Peer) -> None:
    """Have the robot count for ever, a second's numbers at a time: so it ends soon when asked."""
    for turn in itertools.count():
        await peer.do("count", **{"from": turn * RATE, "to": (turn + 1) * RATE, "hz": RATE})
        await peer.until(lambda turn=turn: len(peer.heard("counted")) > turn)


async def batches_become(hub: FakeHub, *, small: bool) -> None:
    """Wait until batches have so few samples, or so many."""
    begin = len(hub.batch_sizes)

    def found() -> bool:
        sizes = hub.batch_sizes[begin:][-TOGETHER:]
        if len(sizes) < TOGETHER:
            return False
        return bool(np.mean(sizes) <= SMALL if small else np.mean(sizes) >= LARGE)

    await hub.until(found, f"small: {small}; {hub.batch_sizes[begin:][-TOGETHER:]}")


async def look(hub: FakeHub, *addresses: str) -> None:
    hello = hub.hellos[-1]
    listed = addresses_of(hello)
    places = np.array([listed.index(address) for address in addresses], "<u2").tobytes()
    await hub.send(SignalSubscription(catalogue=hello.catalogue, channels=places))


async def test_batches_are_made_soon_while_somebody_looks_and_as_ever_before_and_after(
    peer: Peer, tmp_path: Path
) -> None:
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path, SITE):
        await peer.until_heard_by(1)
        counting = asyncio.create_task(count_on(peer))
        # A hub of before says nothing of who looks.
        await batches_become(hub, small=False)
        await look(hub, NUMBER)
        await batches_become(hub, small=True)
        await look(hub)
        await batches_become(hub, small=False)
        # Somebody looks at something else.
        await look(hub, "base/speed")
        await batches_become(hub, small=False)
        await look(hub, NUMBER)
        await batches_become(hub, small=True)
        # The next link begins with nobody.
        hub.cut()
        await hub.until(lambda: len(hub.hellos) == 2, "a new link")
        await batches_become(hub, small=False)
        await look(hub, NUMBER)
        await batches_become(hub, small=True)
        counting.cancel()
        values = hub.values(NUMBER)
        assert values == [float(number) for number in range(len(values))]
