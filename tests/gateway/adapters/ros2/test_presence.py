"""A ROS 2 gateway that hears nobody of all who are there joins anew."""

from __future__ import annotations

import asyncio
import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest
from fake_hub import fake_hub
from gateway.conftest import peer_in
from gateway_bench import SITE, Peer, addresses_of, running
from patience import PATIENCE_S

from talaia.gateway.adapters.presence import Deafness
from talaia.wire.frames import Event

pytestmark = pytest.mark.robot
# Above every number that another robot says.
OWN = 10_000


async def count_until(peer: Peer, heard: Callable[[], object], first: int = 100) -> None:
    """Have the robot say one number after the other until one of them was heard."""
    sent = first
    async with asyncio.timeout(PATIENCE_S):
        while not heard():
            sent += 1
            await peer.do("count", **{"from": sent, "to": sent + 1, "hz": 100})
            await asyncio.sleep(0.2)


@pytest.fixture
def soon_deaf(monkeypatch: pytest.MonkeyPatch) -> None:
    """Join anew after two seconds without hearing anybody, instead of 22."""
    monkeypatch.setattr(Deafness, "FIRST", 8)


@pytest.mark.usefixtures("soon_deaf")
async def test_a_gateway_that_hears_nobody_joins_anew_and_hears_again(
    peer: Peer, ros_domain: int, tmp_path: Path
) -> None:
    # Whether the robot hangs or our own transport does, looks the same.
    async with (
        fake_hub(addresses_of) as hub,
        running(hub.url, tmp_path / "data", SITE),
    ):
        await hub.until(lambda: hub.hellos, "a hello")
        await peer.until_heard_by(1)
        await peer.do("count", **{"from": 1, "to": 2, "hz": 100})
        await hub.until(lambda: 1.0 in hub.values("base/number"), "a value")

        def said(kind: str) -> list[str]:
            return [x.message for x in hub.messages if isinstance(x, Event) and x.kind == kind]

        os.kill(peer._process.pid, signal.SIGSTOP)
        try:
            await hub.until(lambda: said("connection lost"), "the loss")
            await hub.until(lambda: said("connection back"), "it has joined anew")
        finally:
            os.kill(peer._process.pid, signal.SIGCONT)
        assert "nobody of all who are there is heard or answers" in said("connection lost")[0]
        before = len(hub.values("base/number"))
        # Its listener may be the one that left meanwhile: one word alone could go to nobody.
        await count_until(peer, lambda: len(hub.values("base/number")) > before)


@pytest.mark.usefixtures("soon_deaf")
async def test_a_port_of_shared_memory_that_was_made_anew_beside_us_is_heard_after_joining_anew(
    ros_domain: int, tmp_path: Path
) -> None:
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path / "data", SITE):
        await hub.until(lambda: hub.hellos, "a hello")
        # As Fast DDS does it with a port whose reader seems dead: who writes to it makes another.
        first = 7400 + 250 * ros_domain + 11
        folder = Path("/dev/shm")  # noqa: S108 - where Fast DDS has them
        ports = [folder / f"fastdds_port{first + 2 * number}" for number in range(8)]
        # ROS is joined beside the line to the hub, and maybe after it: a robot shows that it is.
        async with peer_in(ros_domain) as first_peer:
            await count_until(first_peer, lambda: hub.values("base/number"))
        for each in ports:
            each.unlink(missing_ok=True)
        async with peer_in(ros_domain) as peer:
            # Numbers of its own: some of the first robot's may still be on their way to the hub.
            await count_until(peer, lambda: max(hub.values("base/number")) > OWN, OWN)
            lost = [x for x in hub.messages if isinstance(x, Event) and x.kind == "connection lost"]
            assert lost
