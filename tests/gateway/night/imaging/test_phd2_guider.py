"""Guiding by PHD2's published protocol. No PHD2 was there: a stand-in speaks as its pages say."""

from __future__ import annotations

import asyncio
import contextlib
import json
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings, strategies as st
from patience import PATIENCE_S

from talaia.gateway.night.imaging.phd2_guider import Phd2Guider
from talaia.gateway.night.imaging.phd2_protocol import Phd2Reader, Phd2Settle

if TYPE_CHECKING:
    from collections.abc import AsyncIterator


STEP = {"Event": "GuideStep", "Frame": 3, "dx": 0.3, "dy": -0.4}
QUICK = Phd2Settle(1.5, 0.1, 1.0)


class StandIn:
    """What PHD2 would say: greets, answers, and tells events."""

    def __init__(self, ending: list[dict[str, object]]) -> None:  # noqa: D107
        self.ending, self.asked = ending, []
        self.out: asyncio.StreamWriter | None = None
        self.ended = asyncio.Event()

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.out = writer
        self.tell({"Event": "Version", "PHDVersion": "2.6.13", "MsgVersion": 1})
        self.tell({"Event": "AppState", "State": "Looping"})
        while line := await reader.readline():
            asked = json.loads(line)
            self.asked.append((asked["method"], asked["params"]))
            result = 2.0 if asked["method"] == "get_pixel_scale" else 0
            answer = {"jsonrpc": "2.0", "result": result, "id": asked["id"]}
            if asked["method"] in ("guide", "dither"):
                if self.ending[0].get("refused"):
                    del answer["result"]
                    answer["error"] = {"code": 1, "message": "equipment is not connected"}
                    self.tell(answer)
                    continue
                self.tell(answer)
                for event in self.ending:
                    self.tell(event)
            else:
                self.tell(answer)
        writer.close()
        with contextlib.suppress(OSError):
            await writer.wait_closed()
        self.ended.set()

    def tell(self, said: dict[str, object]) -> None:
        assert self.out is not None
        self.out.write(json.dumps(said).encode() + b"\r\n")


@asynccontextmanager
async def guiding(*ending: dict[str, object]) -> AsyncIterator[tuple[Phd2Guider, StandIn]]:
    stand_in = StandIn(list(ending))
    server = await asyncio.start_server(stand_in.serve, "127.0.0.1", 0)
    guider = Phd2Guider(port=server.sockets[0].getsockname()[1], settle=QUICK)
    try:
        yield guider, stand_in
    finally:
        await guider.end_guiding()
        await asyncio.wait_for(stand_in.ended.wait(), PATIENCE_S)
        server.close()


# Guiding is the same for whatever is observed.


async def test_it_guides_dithers_and_ends() -> None:
    async with guiding(STEP, {"Event": "SettleDone", "Status": 0}) as (guider, phd2):
        begun = await guider.begin_guiding()
        assert (begun.good, begun.message) == (True, "guiding, 0.50 px off")
        assert guider.lost_reason() == ""
        assert (await guider.dither_star(5.0)).good
        assert (await guider.end_guiding()).good
        assert guider.lost_reason() == ""
    settle = {"pixels": 1.5, "time": 0.1, "timeout": 1.0}
    assert phd2.asked == [
        ("guide", [settle, False]),
        ("get_pixel_scale", []),
        # 5 seconds of arc at 2 a pixel.
        ("dither", [2.5, False, settle]),
        ("stop_capture", []),
    ]


async def test_a_lost_star_is_told_in_words_and_found_again() -> None:
    async with guiding(STEP, {"Event": "SettleDone", "Status": 0}) as (guider, phd2):
        await guider.begin_guiding()
        phd2.tell({"Event": "StarLost", "Status": "Star lost - low SNR"})
        await guider.dither_star(0.0)
        # The stand-in goes on guiding: what was lost is forgotten.
        assert guider.lost_reason() == ""
        phd2.ending = [
            {"Event": "StarLost", "Status": "low SNR"},
            {"Event": "SettleDone", "Status": 1, "Error": "timed-out waiting for guider to settle"},
        ]
        failed = await guider.dither_star(1.0)
        assert "did not settle: timed-out" in failed.message
        assert guider.lost_reason() == "the guide star is lost: low SNR"


async def test_what_phd2_refuses_and_a_line_that_breaks_are_failures_in_words() -> None:
    async with guiding({"refused": True}) as (guider, _):
        assert (await guider.begin_guiding()).message == (
            "PHD2 refuses: equipment is not connected"
        )
    async with guiding(STEP) as (guider, phd2):
        begun = asyncio.ensure_future(guider.begin_guiding())
        while not phd2.asked:  # noqa: ASYNC110 - a stand-in is asked
            await asyncio.sleep(0)
        assert phd2.out is not None
        phd2.out.close()
        assert (await begun).message == "the line to PHD2 is lost"
        assert guider.lost_reason() == "the line to PHD2 is lost"
    assert "start it" in (await guider.begin_guiding()).message


@given(st.binary(max_size=300), st.integers(1, 40))
@settings(max_examples=60)
def test_whatever_comes_in_pieces_is_read_and_never_believed(noise: bytes, size: int) -> None:
    reader = Phd2Reader()
    said = noise.replace(b"\n", b"") + b"\n" + json.dumps(STEP).encode() + b"\r\n"
    for at in range(0, len(said), size):
        reader.feed_bytes(said[at : at + size])
    assert (reader.state, reader.problem) == ("Guiding", "")
    assert reader.error == pytest.approx(0.5)


def test_a_line_without_an_end_is_not_phd2() -> None:
    with pytest.raises(ValueError, match="not PHD2"):
        Phd2Reader().feed_bytes(b"x" * 300_000)
