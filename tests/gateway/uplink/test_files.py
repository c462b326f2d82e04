"""Pictures and recordings go to the hub on one connection of their own, and on from a cut."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import pytest
from fake_hub import fake_hub
from gateway_bench import addresses_of

from talaia.gateway.errors import LinkLost
from talaia.gateway.fits.outbox import ArchiveOutbox
from talaia.gateway.recording.recording_store import RecordingStore, StoredRecording
from talaia.gateway.settings import GatewaySettings, HubAddress
from talaia.gateway.uplink.files import FileLane, TransferCallbacks, send_files
from talaia.gateway.uplink.key_prover import KeyProver
from talaia.gateway.uplink.tls import HubTrust
from talaia.wire.frames import PIECE, ArchiveOffer

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path


async def hand_over(
    settings: GatewaySettings, lanes: Sequence[FileLane], sending: TransferCallbacks
) -> None:
    async def run(work: Callable[[], None]) -> None:
        work()

    prover = KeyProver(
        key=settings.key, site="test", path=settings.data / "place.json", on_disk=run
    )
    await send_files(HubTrust(settings.hub), prover, lanes=lanes, sending=sending)


async def test_pictures_and_recordings_share_a_connection_and_a_picture_goes_before(
    tmp_path: Path,
) -> None:
    data = tmp_path / "gateway"
    shelf = RecordingStore(data / "recordings", 10**9, 0)
    shelf.open(lambda _part, _whole: None)
    long = os.urandom(20 * PIECE)
    kept = StoredRecording(id="20260101T000000Z-abcdef", why="test")
    shelf.begin_recording(kept, len(long))
    shelf.whole_path(kept.id).write_bytes(long)
    shelf.finish_recording(kept)
    outbox = ArchiveOutbox(data / "outbox", 10**9, lambda: None)
    (tmp_path / "made").write_bytes(b"picture")
    async with fake_hub(addresses_of) as hub:
        # Cut in the middle of the recording; meanwhile a picture is taken.
        hub.cut_after = 5
        source = Source(shelf, lambda: outbox.add_file(tmp_path / "made", "fits", "camera", 7))
        lanes = [FileLane("pictures", outbox, 1e9), FileLane("recordings", source, 1e9)]
        settings = GatewaySettings(
            hub=HubAddress.from_text(hub.url, allow_plain=True), key="test-key", data=data
        )
        refused: list[str] = []
        sending = TransferCallbacks(
            lambda: False, lambda: None, lambda offer, _why: refused.append(offer.id)
        )
        with pytest.raises(LinkLost):
            await hand_over(settings, lanes, sending)
        await hand_over(settings, lanes, sending)
        picture = next(each for each in hub.offers if isinstance(each, ArchiveOffer))
        assert (picture.kind, picture.device, hub.files[picture.id]) == (
            "fits",
            "camera",
            b"picture",
        )
        assert hub.files[kept.id] == long
        # The recording began, gave way to the picture, and went on: nothing was sent twice.
        order = [type(each).__name__ for each in hub.offers]
        assert order.index("ArchiveOffer") < len(order) - 1
        assert hub.pieces == 21
    assert (outbox.offers(), shelf.offers(), refused) == ([], [], [])


class Source:
    """A shelf during whose third piece something happens."""

    def __init__(self, shelf: RecordingStore, happens: Callable[[], None]) -> None:  # noqa: D107
        self._shelf, self._happens, self._reads = shelf, happens, 0
        self.offers, self.remove, self.refuse = shelf.offers, shelf.remove, shelf.refuse

    def read_part(self, name: str, at: int, size: int, /) -> bytes:
        self._reads += 1
        if self._reads == 3:
            self._happens()
        return self._shelf.read_part(name, at, size)


async def test_a_hub_that_does_not_know_pictures_still_gets_recordings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("talaia.gateway.uplink.files.DONE_S", 0.2)
    outbox = ArchiveOutbox(tmp_path / "outbox", 10**9, lambda: None)
    (tmp_path / "made").write_bytes(b"picture")
    outbox.add_file(tmp_path / "made", "fits", "camera", 7)
    shelf = RecordingStore(tmp_path / "recordings", 10**9, 0)
    shelf.open(lambda _part, _whole: None)
    kept = StoredRecording(id="20260101T000000Z-abcdef", why="test")
    shelf.begin_recording(kept, 3)
    shelf.whole_path(kept.id).write_bytes(b"abc")
    shelf.finish_recording(kept)
    async with fake_hub(addresses_of) as hub:
        hub.knows_pictures = False
        settings = GatewaySettings(
            hub=HubAddress.from_text(hub.url, allow_plain=True), key="test-key", data=tmp_path
        )
        lanes = [FileLane("pictures", outbox, 1e9), FileLane("recordings", shelf, 1e9)]
        await hand_over(settings, lanes, TransferCallbacks(bool, lambda: None, lambda *_: None))
        assert hub.files == {kept.id: b"abc"}
    # It waits until the hub is updated.
    assert [each.device for each in outbox.offers()] == ["camera"]


def test_the_outbox_keeps_to_its_size_and_offers_what_is_whole_and_not_refused(
    tmp_path: Path,
) -> None:
    outbox = ArchiveOutbox(tmp_path / "outbox", 25, lambda: None)
    for number in range(4):
        (tmp_path / "made").write_bytes(b"0123456789")
        outbox.add_file(tmp_path / "made", "fits", "camera", number)
    third, fourth = outbox.offers()
    assert (third.time_us, fourth.time_us) == (2, 3)
    outbox.refuse(third.id)
    (tmp_path / "outbox" / "broken.json").write_text("{")
    assert [each.id for each in outbox.offers()] == [fourth.id]
    assert outbox.read_part(fourth.id, 8, 10) == b"89"
    outbox.remove(fourth.id)
    assert outbox.offers() == []


async def test_a_file_that_is_damaged_here_is_not_sent_for_ever(tmp_path: Path) -> None:
    outbox = ArchiveOutbox(tmp_path / "outbox", 10**9, lambda: None)
    (tmp_path / "made").write_bytes(b"picture")
    outbox.add_file(tmp_path / "made", "fits", "camera", 7)
    async with fake_hub(addresses_of) as hub:
        hub.finds_damage = True
        settings = GatewaySettings(
            hub=HubAddress.from_text(hub.url, allow_plain=True), key="test-key", data=tmp_path
        )
        told: list[str] = []
        sending = TransferCallbacks(bool, lambda: None, lambda _offer, why: told.append(why))
        await hand_over(settings, [FileLane("pictures", outbox, 1e9)], sending)
        assert hub.pieces == 3
    assert told == ["it is not what its digest says"]
    assert outbox.offers() == []
