"""A gateway proves its key and says it to no hub that can ask for a proof."""

from __future__ import annotations

import asyncio
import json
from typing import TYPE_CHECKING

import pytest
from fake_hub import fake_hub
from gateway_bench import addresses_of, running
from patience import PATIENCE_S

from talaia.clock import SystemClock
from talaia.gateway.errors import LinkLost
from talaia.gateway.settings import GatewaySettings, HubAddress
from talaia.gateway.uplink.connection import HubLink
from talaia.gateway.uplink.key_prover import RESUME_FILE, KeyProver
from talaia.gateway.uplink.send_lanes import SendLanes
from talaia.gateway.uplink.tls import HubTrust
from talaia.wire.frames import (
    Beat,
    BeatReply,
    ControlTick,
    Hello,
    ResumeSaved,
    StopRequest,
    StopState,
    Welcome,
)
from talaia.wire.gateway_proof import ResumeToken, read_proof, resume_answer

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

QUIET = """
talaia: 1
site: quiet
name: Quiet
devices:
  hut: {name: Hut}
"""
HANDED = ResumeToken(7, 9)
SECRET = b"handed down by the hub"


def handed(token: ResumeToken = HANDED) -> str:
    return f"{token.lineage}.{token.serial}.{SECRET.hex()}"


async def test_the_key_is_proved_on_each_connection_and_never_said(tmp_path: Path) -> None:
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path, QUIET):
        await hub.until(lambda: hub.links and hub.media, "link and pictures")
        assert {path for path, _ in hub.said} == {"/gateway/link", "/gateway/media"}
        assert not [said for _, said in hub.said if hub.key in said or "Bearer" in said]
        assert len({read_proof(said).nonce for _, said in hub.said}) == len(hub.said) - 1


async def test_a_key_is_not_taken_for_void_while_one_hub_takes_over_from_another(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with fake_hub(addresses_of) as hub:
        # The one that asked is gone when it is answered, and so is the next one.
        hub.forgets = 2
        async with running(hub.url, tmp_path, QUIET):
            await hub.until(lambda: hub.links, "a link")
    assert "refuses this gateway's key" not in caplog.text


async def test_a_hub_of_before_is_told_the_key_as_before(tmp_path: Path) -> None:
    async with fake_hub(addresses_of) as hub:
        hub.asks_proof = False
        async with running(hub.url, tmp_path, QUIET):
            await hub.until(lambda: hub.links and hub.media, "link and pictures")
    assert not (tmp_path / RESUME_FILE).exists()


async def test_what_the_hub_hands_down_is_on_the_disk_before_that_is_told_and_shown_after_a_crash(
    tmp_path: Path,
) -> None:
    async with fake_hub(addresses_of) as hub:
        hub.resume = handed()
        async with running(hub.url, tmp_path, QUIET):
            assert await hub.next(ResumeSaved) == ResumeSaved(serial=9)
            # All that a run that is killed now leaves.
            kept = (tmp_path / RESUME_FILE).read_bytes()
        (tmp_path / RESUME_FILE).write_bytes(kept)
        hub.said.clear()
        async with running(hub.url, tmp_path, QUIET):
            await hub.until(lambda: len(hub.links) == 2, "a second link")
        shown = next(proof for proof in map(read_proof, dict(hub.said).values()) if proof.resume)
        path = next(path for path, said in hub.said if shown == read_proof(said))
    right = resume_answer(SECRET, nonce=shown.nonce, site="quiet", path=path)
    assert (shown.place, shown.resume) == (HANDED, right)


async def test_a_hub_that_knew_better_is_not_told_the_key(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with fake_hub(addresses_of) as hub:
        hub.resume = handed()
        async with running(hub.url, tmp_path, QUIET):
            await hub.next(ResumeSaved)
        hub.asks_proof = False
        hub.said.clear()
        async with running(hub.url, tmp_path, QUIET):
            await hub.until(lambda: "asks for this gateway's key itself" in caplog.text, "a word")
        assert not [said for _, said in hub.said if hub.key in said]


async def test_a_damaged_file_or_one_of_another_key_shows_nothing_and_the_gateway_dials_on(
    tmp_path: Path,
) -> None:
    for content in (json.dumps({"key": "of another", "resume": handed()}), "{"):
        (tmp_path / RESUME_FILE).write_text(content)
        async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path, QUIET):
            await hub.until(lambda: hub.links, "a link")
            assert not [said for _, said in hub.said if "resume" in said]


class Heard:
    """Acts on what the hub says by writing it down."""

    def __init__(self) -> None:  # noqa: D107
        self.linked = asyncio.Event()
        self.messages: list[object] = []
        self.lanes: SendLanes | None = None

    def link_up(self, _welcome: Welcome) -> None:
        self.linked.set()

    def link_lost(self) -> None:
        self.linked.clear()

    def handle(self, message: object) -> None:
        self.messages.append(message)
        # As a device that is driven does, each time: the press is repeated.
        if isinstance(message, StopRequest) and self.lanes is not None:
            self.lanes.send(StopState(device=message.device, latched=True, id=message.id))


async def test_a_gateway_that_waits_acts_on_stop_alone_and_is_linked_when_its_turn_comes(
    tmp_path: Path,
) -> None:
    wake, heard = asyncio.Event(), Heard()
    heard.lanes = lanes = SendLanes(wake.set)
    async with fake_hub(addresses_of) as hub:
        hub.holds = True
        settings = GatewaySettings(
            hub=HubAddress.from_text(hub.url, allow_plain=True), key=hub.key, data=tmp_path
        )
        link = HubLink(
            trust=HubTrust(settings.hub),
            prover=prover_of(tmp_path, hub.key),
            clock=SystemClock(),
            lanes=lanes,
            wake=wake,
            handler=heard,
        )
        hello = Hello(site="quiet", boot="b", description=QUIET, catalogue="c")
        run = asyncio.create_task(
            link.once(hello, lambda _: asyncio.create_task(asyncio.Event().wait()))
        )
        await hub.until(lambda: hub.links, "a link that waits")
        # It answers beats, as every link does.
        await hub.send(Beat(n=1, mono_us=1))
        await hub.next(BeatReply)
        stop = StopRequest(device="hut", id="s1", who="anna")
        await hub.send(stop)
        await hub.send(stop)
        assert (await hub.next(StopState)).latched
        # That it stands still is told with the next beat, and nothing else is sent.
        lanes.send(StopState(device="hut", latched=True, confirmed=True, id="s1"))
        lanes.send(ControlTick(tick=1))
        await hub.send(Beat(n=2, mono_us=2))
        await hub.next(BeatReply)
        # The press came twice and is answered once.
        assert (await hub.next(StopState)).confirmed
        assert hub.tick == -1
        assert (heard.messages, heard.linked.is_set()) == ([stop, stop], False)
        await hub.send(Welcome())
        async with asyncio.timeout(PATIENCE_S):
            await heard.linked.wait()
        hub.cut()
        with pytest.raises(LinkLost):
            await run


def prover_of(folder: Path, key: str) -> KeyProver:
    async def write(work: Callable[[], None]) -> None:
        work()

    return KeyProver(key=key, site="quiet", path=folder / RESUME_FILE, on_disk=write)
