"""What of a camera goes to one page, on connections of every kind."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.hub.live.pictures.picture_pacing import PicturePacing, Ready
from talaia.wire.frames import PictureForm

PERIOD_US = 33_333
# Bytes of a key picture and of another, and the period, by form; as measured at 640x480.
WEIGHTS = {
    PictureForm.H264: (30_000, 6_400, PERIOD_US),
    PictureForm.H264_SMALL: (7_000, 1_500, 2 * PERIOD_US),
    PictureForm.JPEG: (61_000, 61_000, PERIOD_US),
    PictureForm.JPEG_SMALL: (8_000, 8_000, 2 * PERIOD_US),
    PictureForm.STILL: (61_000, 61_000, 1_000_000),
}


class Age(NamedTuple):
    """A picture that was drawn: when, how old it was, and in which form."""

    at_us: int
    age_us: int
    form: PictureForm
    seq: int


class Line:
    """A camera, a hub's `PicturePacing`, a line of a speed and a way, and a page that draws."""

    def __init__(self, flow: PicturePacing, speed: float, way_us: int) -> None:
        """``speed`` in bytes/s, ``way_us`` one way."""
        self.flow, self.speed, self.way_us = flow, speed, way_us
        self.now_us = 0
        self.drawn: list[Age] = []
        self.keys: list[int] = []
        self.spoilt = 0
        self._due: dict[PictureForm, int] = {}
        self._key_at: dict[PictureForm, int] = {}
        self._key_next: set[PictureForm] = set(PictureForm)
        self._free_us = 0
        self._line: deque[tuple[int, int, int, PictureForm, bool]] = deque()
        self._back: deque[tuple[int, int]] = deque()
        self._seq = 0
        self._chain: tuple[PictureForm, int] | None = None
        self._of: dict[int, tuple[int, PictureForm, bool, int]] = {}
        self._count: dict[PictureForm, int] = {}

    def run(self, seconds: float) -> None:
        """Go on in steps of a millisecond."""
        for _ in range(round(seconds * 1000)):
            self.now_us += 1000
            self._camera()
            while self._back and self._back[0][0] <= self.now_us:
                self.flow.shown(self._back.popleft()[1], self.now_us)
                self._send()
            while self._line and self._line[0][0] <= self.now_us:
                self._draw(*self._line.popleft())

    def _camera(self) -> None:
        form = self.flow.form
        key_size, size, period = WEIGHTS[form]
        if self.now_us < self._due.get(form, 0):
            return
        self._due[form] = self.now_us + period
        if self.flow.wants_key(self.now_us):
            self._key_next.add(form)
            self.keys.append(self.now_us)
        film = form in (PictureForm.H264, PictureForm.H264_SMALL)
        key = not film or form in self._key_next
        self._key_next.discard(form)
        every = {PictureForm.H264: 10_000_000, PictureForm.H264_SMALL: 3_000_000}.get(form)
        if every and self.now_us - self._key_at.get(form, 0) >= every:
            key = True
        if key:
            self._key_at[form] = self.now_us
        self._seq += 1
        self._count[form] = 0 if key else self._count.get(form, 0) + 1
        weight = key_size if key else size
        self._of[self._seq] = (self.now_us, form, key, self._count[form])
        # The line's bytes stand for the frame: its number is all that is looked at.
        ready = Ready(self._seq, key, film, weight, str(self._seq))
        if self.flow.wants([form]):
            self.flow.offer(ready, self.now_us)
        self._send()

    def _send(self) -> None:
        while (frame := self.flow.next_picture(self.now_us)) is not None:
            taken_us, form, key, _ = self._of[int(frame)]
            weight = WEIGHTS[form][0 if key else 1]
            self._free_us = max(self._free_us, self.now_us) + round(weight / self.speed * 1e6)
            self._line.append((self._free_us + self.way_us, taken_us, int(frame), form, key))

    def _draw(self, at_us: int, taken_us: int, seq: int, form: PictureForm, key: bool) -> None:  # noqa: FBT001
        count = self._of[seq][3]
        if (
            form in (PictureForm.H264, PictureForm.H264_SMALL)
            and not key
            and self._chain != (form, count - 1)
        ):
            self.spoilt += 1
        self._chain = (form, count)
        self.drawn.append(Age(at_us, at_us - taken_us, form, seq))
        self._back.append((at_us + self.way_us, seq))


def settled(line: Line, after_s: float) -> list[Age]:
    return [each for each in line.drawn if each.at_us > after_s * 1e6]


def test_a_good_connection_has_every_picture_of_the_camera_s_size_at_once() -> None:
    line = Line(PicturePacing(["h264", "jpeg"]), 10_000_000, 2_000)
    line.run(10)
    assert {each.form for each in line.drawn} == {PictureForm.H264}
    assert len(line.drawn) >= 285
    assert max(each.age_us for each in line.drawn) < 10_000


def test_a_far_page_on_a_wide_line_keeps_the_large_film() -> None:
    line = Line(PicturePacing(["h264"]), 10_000_000, 150_000)
    line.run(10)
    assert {each.form for each in line.drawn} == {PictureForm.H264}
    assert len(line.drawn) >= 250


def test_on_one_megabit_pictures_stay_fresher_than_300_ms() -> None:
    for able in (["h264", "jpeg"], ["jpeg"]):
        line = Line(PicturePacing(able), 125_000, 20_000)
        line.run(60)
        late = settled(line, 3)
        assert max(each.age_us for each in late) < 300_000
        assert {each.form for each in late} == {
            PictureForm.H264_SMALL if "h264" in able else PictureForm.JPEG_SMALL
        }
        assert len(late) / 57 > 8
        assert line.spoilt == 0


def test_one_hiccup_of_a_machine_costs_a_moment_and_not_the_large_film() -> None:
    line = Line(PicturePacing(["h264"]), 10_000_000, 2_000)
    line.run(5)
    line._free_us = line.now_us + 250_000
    line.run(5)
    assert {each.form for each in line.drawn} == {PictureForm.H264}
    assert line.spoilt == 0
    assert len(settled(line, 5.5)) > 130


def test_a_line_that_carries_next_to_nothing_still_brings_single_fresh_pictures() -> None:
    line = Line(PicturePacing(["h264"]), 12_000, 50_000)
    line.run(60)
    late = settled(line, 10)
    assert len(late) > 20
    assert sorted(each.age_us for each in late)[len(late) // 2] < 1_500_000
    assert line.spoilt == 0


def test_a_line_that_gets_better_brings_the_large_film_back() -> None:
    line = Line(PicturePacing(["h264"]), 60_000, 5_000)
    line.run(20)
    assert line.flow.form is PictureForm.H264_SMALL
    line.speed = 10_000_000
    line.run(30)
    assert line.flow.form is PictureForm.H264


def test_a_page_that_is_hidden_has_a_picture_a_second_and_then_all_again() -> None:
    line = Line(PicturePacing(["h264"]), 10_000_000, 2_000)
    line.run(2)
    line.flow.glance(still=True)
    line.run(5)
    stills = [each for each in line.drawn if each.form is PictureForm.STILL]
    assert 4 <= len(stills) <= 6
    line.flow.glance(still=False)
    line.run(1)
    assert sum(each.at_us > 7e6 and each.form is PictureForm.H264 for each in line.drawn) > 25
    assert line.spoilt == 0


def test_pictures_of_a_gateway_that_names_no_forms_are_for_everyone() -> None:
    flow = PicturePacing(["h264"])
    assert flow.wants([])
    assert not flow.wants(["jpeg"])
    flow.offer(Ready(seq=1, key=True, film=False, size=10, frame="1"), 0)
    assert flow.next_picture(0) == "1"


@given(
    speed=st.floats(2_000, 20_000_000),
    way=st.integers(0, 300_000),
    able=st.sampled_from([["h264"], ["jpeg"], []]),
    later=st.floats(2_000, 20_000_000),
)
@settings(max_examples=examples(25, many=250), deadline=None)
def test_whatever_the_line_no_film_is_spoilt_little_waits_and_it_never_stops(
    speed: float, way: int, able: list[str], later: float
) -> None:
    line = Line(PicturePacing(able), speed, way)
    line.run(6)
    line.speed = later
    line.run(6)
    assert line.spoilt == 0
    assert len(line.flow._waiting) <= 6
    assert len(line.flow._under) <= 32
    line.speed = 20_000_000
    before = line.now_us + 500_000
    line.run(2 + 100_000 / min(speed, later))
    assert any(each.at_us > before for each in line.drawn)
    assert line.keys == sorted(line.keys)
    gaps = [b - a for a, b in zip(line.keys, line.keys[1:], strict=False)]
    assert all(each >= 500_000 for each in gaps)
