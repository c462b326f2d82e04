"""How full the line to the hub is, and what goes over it then."""

from __future__ import annotations

import asyncio

from talaia.clock import HandClock
from talaia.gateway.uplink.link_capacity import LinkCapacity
from talaia.gateway.uplink.pictures import PictureUplink
from talaia.gateway.video.frame_source import FrameSource
from talaia.wire.frames import (
    MEDIA_FROM_GATEWAY,
    Beat,
    BeatReply,
    ModelOverlay,
    OverlayLayer,
    PictureForm,
    PictureFrame,
    StreamError,
)


def over(
    room: LinkCapacity, speed: float, way_us: int, seconds: float, start_us: int = 0
) -> list[float]:
    """Send 6400 bytes at 30 Hz, times the share, over a line; give the shares."""
    shares, free_us, n, now_us = [], start_us, start_us, start_us
    back: list[tuple[int, int]] = []
    while now_us < start_us + seconds * 1e6:
        now_us += 33_333
        while back and back[0][0] <= now_us:
            at_us, sent = back.pop(0)
            room.arrived(sent, at_us)
        share = room.share(now_us)
        shares.append(share)
        if share:
            n += 1
            room.sent(n, now_us)
            free_us = max(free_us, now_us) + round(6400 * share / speed * 1e6)
            back.append((free_us + way_us, n))
    for at_us, sent in back:
        room.arrived(sent, at_us)
    return shares


def test_a_line_with_room_for_all_gets_all() -> None:
    assert set(over(LinkCapacity(), 2_000_000, 20_000, 20)) == {1.0}
    assert set(over(LinkCapacity(), 2_000_000, 300_000, 20)) == {1.0}


def test_a_narrow_line_gets_fewer_bits_until_they_fit_and_more_once_it_is_wide() -> None:
    room = LinkCapacity()
    narrow = over(room, 60_000, 20_000, 60)
    assert 0.1 <= sorted(narrow[-300:])[150] <= 0.5
    wide = over(room, 2_000_000, 20_000, 60, 100_000_000)
    assert wide[-1] == 1.0


def test_a_receipt_for_nothing_changes_nothing() -> None:
    room = LinkCapacity()
    room.arrived(77, 5)
    room.sent(1, 0)
    assert room.share(100_000) == 1.0
    assert room.share(600_000) == 0.0
    room.arrived(1, 600_000)
    assert room.share(600_001) == 1.0


def picture(seq: int, *, key: bool = False, form: str = "h264") -> PictureFrame:
    return PictureFrame(
        stream="cam/front", seq=seq, time_us=0, mono_us=0, width=2, height=2, format="h264",
        forms=[form], key=key, data=b"x",
    )  # fmt: skip


async def sent(pictures: PictureUplink) -> list[object]:
    """What goes out, until nothing waits."""
    out: list[object] = []
    while True:
        try:
            async with asyncio.timeout(0.05):
                out.append(MEDIA_FROM_GATEWAY.decode(await pictures.next()))
        except TimeoutError:
            return out


def linked() -> PictureUplink:
    pictures = PictureUplink(asyncio.get_running_loop(), HandClock(), frames=FrameSource())
    pictures.link_up()
    return pictures


async def test_a_film_waits_in_order_and_each_picture_has_its_receipt() -> None:
    pictures = linked()
    for seq in (1, 2, 3):
        pictures.offer(picture(seq, key=seq == 1))
    out = await sent(pictures)
    assert [each.seq for each in out if isinstance(each, PictureFrame)] == [1, 2, 3]
    beats = [each for each in out if isinstance(each, Beat)]
    assert len(beats) == 3
    assert pictures.room() == 1.0
    for beat in beats:
        pictures.answered(BeatReply(n=beat.n, mono_us=0, peer_us=0))


async def test_too_much_of_a_film_goes_all_at_once_and_a_fresh_beginning_is_asked_for() -> None:
    pictures = linked()
    pictures.watch(["cam/front"], {"cam/front": ["h264"]})
    for seq in range(1, 12):
        pictures.offer(picture(seq, key=seq == 1))
    pictures.offer(picture(12, key=True))
    out = [each.seq for each in await sent(pictures) if isinstance(each, PictureFrame)]
    assert out == [12]
    assert pictures.key_due("cam/front", "h264")
    assert not pictures.key_due("cam/front", "h264")


async def test_an_old_hub_gets_jpeg_and_no_messages_it_does_not_know() -> None:
    pictures = linked()
    pictures.watch(["cam/front"], {})
    assert pictures.asked("cam/front") == {PictureForm.JPEG}
    pictures.trouble("cam/front", "cut off")
    assert await sent(pictures) == []
    pictures.watch(["cam/front"], {"cam/front": ["h264", "hologram"]})
    assert pictures.asked("cam/front") == {"h264", "hologram"}
    pictures.trouble("cam/front", "cut off")
    assert await sent(pictures) == [StreamError(stream="cam/front", why="cut off")]
    pictures.link_lost()
    assert pictures.asked("cam/front") == frozenset()


async def test_a_camera_is_read_for_those_at_the_hub_and_those_at_the_gateway() -> None:
    looks = FrameSource()
    pictures = PictureUplink(asyncio.get_running_loop(), HandClock(), frames=looks)
    pictures.watch(["cam/front"], {})
    looks.hold("cam/back")
    assert pictures.watched() == {"cam/front", "cam/back"}


def overlay(seq: int, model: str) -> ModelOverlay:
    layer = OverlayLayer(rows=0, columns=0, runs=b"", near=None, far=None, poses=[], likely=[])
    return ModelOverlay(stream="cam/front", seq=seq, time_us=0, model=model, layer=layer)


async def test_overlays_are_the_newest_of_each_model_and_take_turns_with_pictures() -> None:
    pictures = linked()
    pictures.watch(["cam/front"], {"cam/front": ["h264", "jpeg"]})
    pictures.send_overlay(overlay(1, "ground"))
    assert not pictures.wants_overlay("cam/front")
    assert await sent(pictures) == []
    # Of the pictures as they are it is the same camera.
    pictures.watch(["cam/front"], {"cam/front": ["h264"]}, overlays=["cam/front!unblurred"])
    assert pictures.wants_overlay("cam/front")
    for seq in (2, 3, 4):
        pictures.send_overlay(overlay(seq, "ground"))
        pictures.send_overlay(overlay(seq, "far"))
    for form in ("h264", "jpeg"):
        pictures.offer(picture(4, key=True, form=form))
    # What was offered from a thread is taken on the loop.
    await asyncio.sleep(0)
    kinds = [one for one in await sent(pictures) if not isinstance(one, Beat)]
    assert [type(one).__name__ for one in kinds] == [
        "PictureFrame", "ModelOverlay", "PictureFrame", "ModelOverlay",
    ]  # fmt: skip
    assert {(one.model, one.seq) for one in kinds if isinstance(one, ModelOverlay)} == {
        ("ground", 4), ("far", 4),
    }  # fmt: skip
    # Of before a lost line nothing is sent.
    pictures.send_overlay(overlay(5, "ground"))
    pictures.link_lost()
    assert not pictures.wants_overlay("cam/front")
    pictures.link_up()
    assert [one for one in await sent(pictures) if not isinstance(one, Beat)] == []
