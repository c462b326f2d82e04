"""A small night played to its end, and every block judged minute by minute by other means."""

from __future__ import annotations

import json
import math
from collections import defaultdict

import erfa
import numpy as np
import pytest

from talaia.planner.drive import DrivenNight
from talaia.planner.errors import NotANight

pytestmark = pytest.mark.pure

INSTRUMENT = {
    "slew_deg_s": 3.0, "settle_s": 6, "acquire_s": 20, "filter_s": 8,
    "readout_s": 4, "unpark_s": 20, "horizon_deg": 15.0,
}  # fmt: skip
LATITUDE, LONGITUDE = 42.05, 0.73
END = 6 * 3600
START = "2027-01-18T20:00:00Z"
# The roof is closed from when to when.
CLOSED = (7200, 9000)
HOURS = {"P1": 2.5, "P2": 9.0}


def request(name: str, **more: object) -> dict[str, object]:
    return {
        "id": name, "kind": "normal", "proposal": "P1", "ra": 80.0, "dec": 20.0, "priority": 10.0,
        "n": 5, "exp": 60.0, "filter": "V", "windows": [[0, END]], "min_alt": 30.0,
        "max_airmass": 1.8, "moon_dist": 0.0, "moon_illum": 1.0, "sun_alt": -12.0, **more,
    }  # fmt: skip


def make_requests() -> list[dict[str, object]]:
    random = np.random.default_rng(7)
    requests = [
        request(
            f"r{number:02d}",
            ra=round(float(random.uniform(0, 200)), 4),
            dec=round(float(random.uniform(-20, 80)), 4),
            priority=round(float(random.uniform(5, 40)), 2),
            n=int(random.integers(1, 15)),
            exp=float(random.choice([30, 60, 120])),
            filter=str(random.choice(["B", "V"])),
            proposal=str(random.choice(["P1", "P2"])),
        )
        for number in range(40)
    ]
    requests[3]["windows"] = [[600, 1800], [4000, 6000]]
    return requests


RAPID = request(
    "alert", kind="rapid", arrives=3000, priority=200.0, n=3, exp=120.0, windows=[[3000, 10_200]]
)


def lowest_altitude(visit: dict, begin: int, end: int) -> float:
    """Give the lowest altitude of a block by ERFA's whole chain, without refraction (°)."""
    seconds = np.append(np.arange(begin, end, 60), end)
    day, part = erfa.dtf2d("UTC", 2027, 1, 18, 20, 0, 0.0)
    _, zenith_distance, *_ = erfa.atco13(
        math.radians(visit["ra"]), math.radians(visit["dec"]), 0, 0, 0, 0,
        day, part + seconds / 86_400.0, 0.0,
        math.radians(LONGITUDE), math.radians(LATITUDE), 1570.0, 0, 0, 0, 0, 0, 0.5,
    )  # fmt: skip
    return 90.0 - math.degrees(float(np.max(zenith_distance)))


def overhead(before: dict | None, visit: dict) -> int:
    """Give what leads to a visit, by the format's own rule (s)."""
    if before is None:
        return 46
    across = abs(before["ra"] - visit["ra"])
    angle = max(min(across, 360 - across), abs(before["dec"] - visit["dec"]))
    change = 8 if before["filter"] != visit["filter"] else 0
    if angle < 0.01:
        return change
    return math.ceil(max(angle / 3.0 + 6, change) + 20)


class Judge:
    """Plays a night: moves time, closes the roof, keeps what was read out, and counts."""

    def __init__(self) -> None:
        """Hand over the night."""
        self.visits = {visit["id"]: visit for visit in [*make_requests(), RAPID]}
        self.left = {
            name: math.ceil(visit["n"] * (visit["exp"] + 4)) for name, visit in self.visits.items()
        }
        self.blocks: list[tuple[str, int, int]] = []
        self.done: list[str] = []
        self.charged: dict[str, int] = defaultdict(int)
        self.pointing: dict | None = None
        self.events: list[dict] = []
        self.time, self.arrived = 0, False
        self.interrupted = ""
        self.planner = DrivenNight()
        night = {
            "format": "talaia-night/1", "start": START, "end_s": END, "instrument": INSTRUMENT,
            "site": {"name": "Montsec", "lat": LATITUDE, "lon": LONGITUDE, "elevation": 1570.0},
            "rules": {"resume": True}, "requests": make_requests(),
            "proposals": [{"id": "P1", "share": 0.5, "hours_left": HOURS["P1"]},
                          {"id": "P2", "share": 0.5, "hours_left": HOURS["P2"]}],
        }  # fmt: skip
        assert self.ask(type="night", night=night) == {}

    def ask(self, **line: object) -> dict:
        return self.planner.answer_line(json.dumps(line).encode())

    def play(self) -> None:
        while self.time < END:
            if CLOSED[0] <= self.time < CLOSED[1]:
                self.time, self.pointing = CLOSED[1], None
                self.events.append({"type": "released", "t": self.time})
            answer = self.ask(
                type="decide", t=self.time, events=self.events, completed=self.done[-1:]
            )
            self.events = []
            if "wait" in answer:
                self.wait(answer["wait"])
            else:
                self.observe(answer["observe"], answer["not_before"])

    def wait(self, until: int) -> None:
        assert until > self.time
        stop = CLOSED[0] if self.time < CLOSED[0] else END
        if not self.arrived and self.time < 3000 <= until:
            stop = 3000
            self.arrive()
        self.time = min(until, stop)

    def arrive(self) -> None:
        self.arrived = True
        self.events.append({"type": "arrived", "t": 3000, "requests": [RAPID]})

    def observe(self, name: str, not_before: int) -> None:
        visit = self.visits[name]
        begin = max(self.time + overhead(self.pointing, visit), not_before)
        end = begin + self.left[name]
        stop = end
        if not self.arrived and end > 3000:
            self.arrive()
            answer = self.ask(
                type="interrupt", t=3000, events=self.events, request="alert", current=name
            )
            self.events = []
            if answer["interrupt"]:
                self.interrupted, stop = name, 3000
        if self.time < CLOSED[0] < stop:
            stop = CLOSED[0]
        self.judge(name, begin, end)
        self.pointing = visit
        self.time = stop
        if stop == end:
            self.done.append(name)
            self.charged[visit["proposal"]] += self.left[name]
            return
        frame = visit["exp"] + 4
        self.left[name] -= int(max(0, stop - begin) // frame * frame)
        self.events.append(
            {"type": "aborted", "t": stop, "request": name, "block_s": self.left[name]}
        )

    def judge(self, name: str, begin: int, end: int) -> None:
        """Hold a block, as it was begun, to every rule."""
        visit = self.visits[name]
        assert name not in self.done
        assert any(first <= begin and end <= last for first, last in visit["windows"])
        floor = max(visit["min_alt"], math.degrees(math.asin(1 / visit["max_airmass"])))
        assert lowest_altitude(visit, begin, end) >= floor - 0.002
        self.blocks.append((name, begin, end))


def test_a_night_with_a_closing_and_an_alert_breaks_no_rule():
    judge = Judge()
    judge.play()
    assert judge.interrupted
    # Interrupted, closed upon, and finished all the same.
    assert judge.interrupted in judge.done
    assert "alert" in judge.done
    alert = next(begin for name, begin, _ in judge.blocks if name == "alert")
    assert alert - 3000 <= 60 + 26
    after = min(begin for _, begin, _ in judge.blocks if begin >= CLOSED[1])
    assert after - CLOSED[1] == 46
    for proposal, hours in HOURS.items():
        assert judge.charged[proposal] <= hours * 3600
    observing = sum(end - begin for _, begin, end in judge.blocks)
    assert observing > 0.7 * (END - (CLOSED[1] - CLOSED[0]))


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (b"{", "truncated"),
        (b'{"type":"sing"}', "sing"),
        (b'{"type":"decide","t":0}', "no night was given"),
        (b'{"type":"night","night":{"site":{"lat":99}}}', "site.lat"),
    ],
)
def test_a_line_that_is_none_is_refused_with_its_place(line, words):
    with pytest.raises(NotANight, match=words):
        DrivenNight().answer_line(line)
