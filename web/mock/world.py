"""A made-up vehicle for page development: values over time, and a drive that answers."""

from __future__ import annotations

import io
import math
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from PIL import Image, ImageDraw
from seen_side import paint

from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from talaia.model.site import Site

LIMIT_S = 0.25


@dataclass
class World:
    """What the mock hub knows. Times are seconds of the wall clock unless they say otherwise."""

    site: Site
    online: bool = True
    since: float = field(default_factory=time.time)
    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0
    linear: float = 0.0
    angular: float = 0.0
    asked: tuple[float, float] = (0.0, 0.0)
    asked_at: float = 0.0
    accepted: int = 0
    refused: int = 0
    wandering: bool = False
    latched: bool = False
    stopper: str = ""
    epoch: int = 0
    holder: str = ""
    holder_key: int = 0
    until: float = 0.0

    def step(self, seconds: float) -> None:
        """Let time pass: the newest driving frame counts for 250 ms, then zeros."""
        linear, angular = self.asked if time.time() - self.asked_at < LIMIT_S else (0.0, 0.0)
        if self.wandering and not self.holder:
            linear, angular = 0.15, 0.6 * math.sin(time.time() / 3)
        if self.latched:
            linear = angular = 0.0
        self.linear += max(-1.0 * seconds, min(1.0 * seconds, linear - self.linear))
        self.angular += max(-8.0 * seconds, min(8.0 * seconds, angular - self.angular))
        self.yaw = math.remainder(self.yaw + self.angular * seconds, math.tau)
        self.x += self.linear * math.cos(self.yaw) * seconds
        self.y += self.linear * math.sin(self.yaw) * seconds

    def value(self, address: str, when: float, *, past: bool = False) -> float:
        """Say what a channel reads at a moment; the vehicle's own state when it is now."""
        if "~" in address:
            return 0.3 + 0.25 * math.sin(when / 11) + (0.4 if when % 120 < 6 else 0.0)
        if not past:
            own = {
                "base/speed": self.linear,
                "base/turn_rate": self.angular,
                "base/pose.x": self.x,
                "base/pose.y": self.y,
                "base/pose.yaw": self.yaw,
                "base/wandering": float(self.wandering),
                "sensors/fix.lat": 41.3874 + self.y / 111_320,
                "sensors/fix.lon": 2.1686 + self.x / 83_500,
                "sensors/fix.alt": 12.0,
                "sensors/speed1": self.linear,
            }
            if address in own:
                return own[address]
        if address == "base/wandering":
            return float(int(when / 300) % 2)
        low, high, noise = RANGES.get(address, (-1.0, 1.0, 0.02))
        seed = sum(address.encode())
        wave = 0.5 + 0.42 * math.sin(when / (7 + seed % 11) + seed) + 0.06 * math.sin(when / 0.9)
        jitter = noise * math.sin(when * 977 + seed) * math.sin(when * 331)
        return low + (high - low) * wave + jitter

    def picture(self, seq: int, now: float) -> bytes:
        """Draw a corridor that moves with the vehicle, as JPEG of 640 by 480."""
        image = Image.new("RGB", (640, 480), (196, 205, 208))
        draw = ImageDraw.Draw(image)
        middle = 320 - math.degrees(self.yaw) * 4 % 160 + 80
        draw.polygon([(0, 480), (640, 480), (middle + 70, 260), (middle - 70, 260)], (151, 126, 98))
        draw.polygon([(0, 0), (640, 0), (middle + 70, 200), (middle - 70, 200)], (224, 226, 222))
        draw.rectangle((middle - 70, 200, middle + 70, 260), (120, 140, 150))
        phase = (self.x + self.y) * 120 % 60
        for row in range(7):
            depth = ((row * 60 + phase) / 420) ** 2
            y = 262 + depth * 218
            draw.line((0, y, 640, y), (130, 106, 80), 2)
        paint(draw, now, 640, 480)
        clock = time.strftime("%H:%M:%S", time.gmtime(now))
        draw.text((12, 456), f"picture {seq}  {clock} UTC", (20, 24, 26), font_size=16)
        out = io.BytesIO()
        image.save(out, "JPEG", quality=70)
        return out.getvalue()


# Lowest, highest, noise.
RANGES = {
    "base/speed": (-0.02, 0.22, 0.01),
    "base/turn_rate": (-1.2, 1.2, 0.05),
    "base/pose.x": (-3.0, 3.0, 0.0),
    "base/pose.y": (-2.0, 2.0, 0.0),
    "base/pose.yaw": (-3.0, 3.0, 0.0),
    "power/charge": (71.0, 76.0, 0.0),
    "power/voltage": (11.6, 11.9, 0.02),
    "sensors/ultrasonic1": (0.4, 2.9, 0.03),
    "sensors/ultrasonic2": (0.3, 3.6, 0.03),
    "sensors/ultrasonic3": (0.5, 2.2, 0.03),
    "sensors/temperature": (21.4, 23.8, 0.05),
    "sensors/acceleration": (-0.6, 0.6, 0.3),
}


def now_columns(world: World, channels: list[str], known: set[str], times: list[float]) -> Columns:
    """Sample every known channel at each time."""
    rows = [
        (index, when, world.value(address, when))
        for when in times
        for index, address in enumerate(channels)
        if address in known
    ]
    return Columns(
        np.array([row[0] for row in rows], np.uint16),
        np.array([int(row[1] * 1e6) for row in rows], np.int64),
        np.array([row[2] for row in rows], np.float64),
        {},
    )


def anomalies() -> dict[str, Any]:
    """Say what a detector of the speed thinks."""
    why = "0.2 m/s is 0.15 m/s above the 0.05 m/s of the last 5 min, a change greater than any"
    one = {"address": "base/speed", "detector": "together", "name": "all together", "bar": 0.65}
    began = int(time.time() * 1e6) - 8_000_000
    now = {"score": 0.71, "scores": "base/speed~together", "began_us": began, "why": why, "late": 0}
    now |= {"from_us": began, "to_us": 0, "forgiven": False, "learns": True, "learning": 0}
    return {"detectors": [{**one, **now}], "may_forgive": True, "skipped": 0}


def outliers(address: str) -> dict[str, Any]:
    """Say which values of a channel are far out, of a great many samples."""
    low, high, _ = RANGES.get(address, (-1.0, 1.0, 0.0))
    found = {"samples": 8_640_000, "stored": 8_640_000, "count": 1_203, "exact": True}
    return {"address": address, "first": low, "third": high, "low": low, "high": high, **found}


def history(world: World, address: str, from_us: int, to_us: int, width: int) -> dict[str, Any]:
    """Make up a past, with one gap of a tenth of the window and an outlier."""
    span = to_us - from_us
    count = max(2, min(width, span // 100_000))
    gap_from, gap_to = from_us + span * 55 // 100, from_us + span * 62 // 100
    exact = span < width * 200_000
    times: list[int] = []
    values: list[float] = []
    for index in range(count):
        at = from_us + span * index // count
        if gap_from <= at < gap_to or at > time.time() * 1e6:
            continue
        value = world.value(address, at / 1e6, past=True)
        low, high, _ = RANGES.get(address, (0.0, 0.01, 0.0) if "~" in address else (-1.0, 1.0, 0.0))
        spread = 0.0 if exact else (high - low) * 0.04
        if index == count // 3:
            spread = (high - low) * 0.4
        times += [at] if exact else [at, at + span // count // 2]
        values += [value] if exact else [value - spread, value + spread]
    said: dict[str, Any] = {
        "address": address,
        "t_us": times,
        "v": values,
        "kind": "exact" if exact else "minmax",
        "gaps": [{"from_us": gap_from, "to_us": gap_to, "reason": "the spool was full"}],
    }
    device, _, signal = address.partition("~")[0].partition("/")
    if world.site.devices[device].signals[signal.partition(".")[0]].type == "text":
        said["text"] = [WORDS[int(at / 90e6) % 3] for at in times]
        said["v"] = [None] * len(times)
    return said


WORDS = ("Docked at the charger in the kitchen", "On the way to the hall", "Waiting")


HAPPENED = (
    ("lease taken", "base", "operator", "epoch 4", True),
    ("command asked", "base", "operator", "wander(active=True) 7f3a", True),
    ("command succeeded", "base", "operator", "wander 7f3a", True),
    ("stop pressed", "base", "operator", "", True),
    ("stop confirmed by the robot", "base", "operator", "", True),
    ("alarm raised", "power", "", "Battery voltage below 11.7 V for 30 s", False),
    ("gateway lost", "", "", "", False),
    ("gateway connected", "", "", "version 0.1", True),
)


def events(from_us: int, to_us: int, limit: int) -> dict[str, object]:
    """Make up what happened: something every 97 s, and some of it close together."""
    step = 97_000_000
    found = [
        {"time_us": at, "kind": kind, "device": device, "who": who, "message": said, "good": good}
        for n in range(from_us // step, to_us // step + 1)
        for kind, device, who, said, good in (HAPPENED[n % 8], HAPPENED[(n + 1) % 8])
        if from_us <= (at := n * step + (2_000_000 if kind == HAPPENED[n % 8][0] else 0)) <= to_us
        if at <= time.time() * 1e6
    ]
    found.sort(key=lambda event: -int(str(event["time_us"])))
    return {"events": found[:limit], "more": len(found) > limit}


def statistics(world: World, address: str, from_us: int, to_us: int) -> dict[str, object]:
    """Sum up the made-up past."""
    drawn = history(world, address, from_us, to_us, 1000)
    pairs = [(t, v) for t, v in zip(drawn["t_us"], drawn["v"], strict=True) if v is not None]
    numbers = [v for _, v in pairs]
    mean = float(np.mean(numbers)) if numbers else None
    low, high = (min(pairs, key=_value), max(pairs, key=_value)) if pairs else (None, None)
    return {
        "address": address,
        "count": len(drawn["t_us"]),
        "numbers": len(numbers),
        "low": low and {"t_us": low[0], "v": low[1], "text": None},
        "high": high and {"t_us": high[0], "v": high[1], "text": None},
        "mean": mean,
        "deviation": float(np.std(numbers)) if numbers else None,
        "first": None,
        "last": None,
        "gap_us": (to_us - from_us) * 7 // 100,
    }


def _value(pair: tuple[int, float]) -> float:
    return pair[1]
