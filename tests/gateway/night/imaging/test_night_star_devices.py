"""Focus and centring ask a site's devices by its own commands."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace
from night_observatory import example_site

from talaia.gateway.fits.frame_arrivals import FrameArrivals
from talaia.gateway.fits.outbox import ArchiveOutbox
from talaia.gateway.night.imaging.night_star_devices import NightStarDevices
from talaia.gateway.night.imaging.star_parts import DeviceFailed
from talaia.gateway.night.night_values import StepAnswer
from talaia.model.night_section import NightFocuser
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from talaia.wire.frames import Scalar


class Site:
    """The example's devices, with a camera whose files go the real way into the outbox."""

    def __init__(self, folder: Path, answer: StepAnswer) -> None:  # noqa: D107
        night = example_site().night
        assert night is not None
        focuser = NightFocuser(command="focuser/goto", position="focuser/position")
        arrivals = FrameArrivals()
        self.outbox = ArchiveOutbox(folder / "out", 10_000, lambda: None, arrivals.notice_file)
        self.answer, self.folder = answer, folder
        self.asked: list[tuple[str, Mapping[str, Scalar]]] = []
        self.devices = NightStarDevices(
            night=replace(night, focuser=focuser),
            ask=self.ask,
            frames=arrivals,
            read={"focuser/position": 25_000.0}.get,
        )

    async def ask(self, command: str, args: Mapping[str, Scalar], _within: float) -> StepAnswer:
        self.asked.append((command, args))
        if command == "camera/expose":
            made = self.folder / "made"
            made.write_bytes(b"a picture")
            self.outbox.add_file(made, "fits", "camera", 1)
        return self.answer


GOOD = StepAnswer("", CommandPhase.SUCCEEDED)


async def test_a_frame_is_the_file_that_goes_into_the_archive(tmp_path: Path) -> None:
    site = Site(tmp_path, GOOD)
    assert await site.devices.take_frame(4.0) == b"a picture"
    assert site.asked == [("camera/expose", {"seconds": 4.0, "target": "focus or centring"})]
    assert [offer.device for offer in site.outbox.offers()] == ["camera"]


async def test_the_focuser_is_moved_by_its_command_and_read_by_its_signal(tmp_path: Path) -> None:
    site = Site(tmp_path, GOOD)
    await site.devices.move_focuser(24_999.6)
    assert site.asked == [("focuser/goto", {"position": 25_000})]
    assert site.devices.focuser_position() == 25_000.0
    assert site.devices.tube_temperature() is None


async def test_a_device_that_refuses_is_told_in_its_words(tmp_path: Path) -> None:
    site = Site(tmp_path, StepAnswer("", CommandPhase.REFUSED, "Rain"))
    with pytest.raises(DeviceFailed, match="telescope/goto: Rain"):
        await site.devices.slew_to(1.0, 2.0)
