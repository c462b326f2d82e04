"""A frame counts when its file is on disk."""

from __future__ import annotations

import asyncio
from pathlib import Path

from msgspec.structs import replace
from night_observatory import example_site

from talaia.clock import HandClock
from talaia.gateway.fits.frame_arrivals import FrameArrivals
from talaia.gateway.fits.outbox import ArchiveOutbox
from talaia.gateway.night.frames.frame_files import FrameFiles
from talaia.gateway.night.night_values import NightCommand, StepAnswer
from talaia.model.site import Site
from talaia.simulated_time import SimulatedLoop
from talaia.wire.frames import CommandPhase

DONE = StepAnswer("night-1", CommandPhase.SUCCEEDED)


def followed(site: Site, outbox: Path | None) -> tuple[StepAnswer, list[str], HandClock]:
    """Follow one frame, whose file comes into an outbox or does not."""
    clock = HandClock()

    async def follow() -> tuple[StepAnswer, list[str]]:
        arrivals = FrameArrivals()
        files = FrameFiles(arrivals, site)
        # A dark of the description's own is no request's.
        assert files.expect_file(NightCommand("n-1", "camera/dark", {}, 60.0)) is None
        waiting = files.expect_file(NightCommand("n-2", "camera/expose", {}, 60.0, is_frame=True))
        assert waiting is not None
        if outbox is not None:
            made = outbox / "made"
            made.write_bytes(b"a picture")
            box = ArchiveOutbox(outbox / "box", 10**6, lambda: None, kept=arrivals.note_kept)
            await asyncio.to_thread(box.add_file, made, "fits", "camera", 1)
        answer = await files.follow_frame(DONE, waiting)
        return answer, files.take_names()

    with asyncio.Runner(loop_factory=lambda: SimulatedLoop(clock)) as runner:
        answer, names = runner.run(follow())
    return answer, names, clock


def test_a_frame_whose_file_is_kept_is_done_and_named_by_its_digest(tmp_path: Path) -> None:
    answer, names, _ = followed(example_site(), tmp_path)
    assert answer == DONE
    assert [len(name) for name in names] == [64]


def test_a_frame_of_which_no_file_comes_has_failed() -> None:
    answer, names, clock = followed(example_site(), None)
    assert answer.phase is CommandPhase.FAILED
    assert "no file" in answer.message
    assert names == []
    assert 30 <= clock.monotonic_ns() / 1e9 < 31


def test_a_camera_that_is_not_described_to_give_files_is_not_waited_for_long() -> None:
    site = example_site()
    camera = replace(site.devices["camera"], frames=None)
    site = replace(site, devices={**site.devices, "camera": camera})
    answer, _, clock = followed(site, None)
    assert answer == DONE
    assert clock.monotonic_ns() / 1e9 < 4


def test_a_flat_is_measured_from_its_file_and_a_light_is_not(tmp_path: Path) -> None:
    measured: list[bytes] = []

    async def measure(data: bytes) -> float:
        measured.append(data)
        return 21_000.0

    async def follow(*, flat: bool) -> StepAnswer:
        arrivals = FrameArrivals()
        files = FrameFiles(arrivals, example_site())
        files.measure = measure
        asked = NightCommand("n-1", "camera/flat", {}, 60.0, is_frame=True, wants_level=flat)
        waiting = files.expect_file(asked)
        assert waiting is not None
        made = tmp_path / "made"
        made.write_bytes(b"an even sky")
        box = ArchiveOutbox(
            tmp_path / "box", 10**6, lambda: None, arrivals.notice_file, kept=arrivals.note_kept
        )
        await asyncio.to_thread(box.add_file, made, "fits", "camera", 1)
        return await files.follow_frame(DONE, waiting)

    with asyncio.Runner(loop_factory=lambda: SimulatedLoop(HandClock())) as runner:
        assert runner.run(follow(flat=False)).level is None
        assert runner.run(follow(flat=True)).level == 21_000.0
    assert measured == [b"an even sky"]
