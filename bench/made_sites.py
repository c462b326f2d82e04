"""Signals of a made-up vehicle and observatory, of every kind, faster than real time.

Healthy ones, and faults planted in them: a fault is a change of some signals from a moment on, with
what it does to each by the truth of this model.

A row every second, or every ``TALAIA_BENCH_STEP_S`` seconds.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["DAY_S", "FAULTS", "STEP_S", "Fault", "MadeSite", "make_site"]

STEP_S = int(os.environ.get("TALAIA_BENCH_STEP_S", "1"))
DAY_S = 86_400
# Rows of a minute, and of a slew.
_MINUTE, _SLEW = 60 // STEP_S, 30 // STEP_S
# So many steps of a recursion are made at once.
_CHUNK = 256
_BEGAN_S = 1_790_000_000 // DAY_S * DAY_S


@dataclass(frozen=True)
class MadeSite:
    """What a site's signals were."""

    # Seconds since the epoch (n,), values (n, signals), the way of running (n,).
    time_s: NDArray[np.int64]
    values: Floats
    mode: NDArray[np.int64]
    # Device and signal of each column.
    names: tuple[str, ...]


@dataclass(frozen=True)
class Fault:
    """A fault: of what site, in which way of running it is planted, and what it does."""

    name: str
    site: str
    mode: int
    # From the healthy values (m, signals), the names and a generator: the faulty ones.
    plant: Callable[[Floats, tuple[str, ...], np.random.Generator], Floats]


def _ar(rng: np.random.Generator, count: int, tau_s: float, spread: float) -> Floats:
    """Make noise with a memory of so long (s) and such a spread."""
    keep = np.exp(-STEP_S / tau_s)
    steps = rng.normal(0.0, spread * np.sqrt(1 - keep * keep), count)
    return _relax(steps, keep, float(rng.normal(0.0, spread)))


def _relax(steps: Floats, keep: float, start: float) -> Floats:
    """Give ``y[i] = keep · y[i-1] + steps[i]``."""
    powers = keep ** np.arange(_CHUNK + 1.0)
    # What each step has become at the end of each row, and the level of before.
    ages = np.arange(_CHUNK)[:, None] - np.arange(_CHUNK)
    kept = np.where(ages >= 0, powers[np.maximum(ages, 0)], 0.0)
    padded = np.concatenate([steps, np.zeros(-len(steps) % _CHUNK)]).reshape(-1, _CHUNK)
    found = padded @ kept.T
    level = start
    for row in found:
        row += level * powers[1:]
        level = row[-1]
    return found.ravel()[: len(steps)]


def _follow(target: Floats, tau_s: float) -> Floats:
    """Let something follow a target with a time constant (s)."""
    keep = np.exp(-STEP_S / tau_s)
    return _relax((1 - keep) * target, keep, float(target[0]))


def make_site(kind: str, seed: int, days: int) -> MadeSite:
    """Make so many healthy days of a ``vehicle`` or an ``observatory``."""
    rng = np.random.default_rng([seed, len(kind)])
    count = days * DAY_S // STEP_S
    time_s = _BEGAN_S + np.arange(count) * STEP_S
    columns, mode = (_vehicle if kind == "vehicle" else _observatory)(rng, time_s)
    return MadeSite(time_s, np.column_stack(list(columns.values())), mode, tuple(columns))


def _shifts(rng: np.random.Generator, time_s: NDArray[np.int64]) -> NDArray[np.int64]:
    """Give the vehicle's way of running: 0 docked, 1 idle, 2 driving."""
    mode = np.zeros(len(time_s), np.int64)
    hour = time_s % DAY_S / 3600
    at = 0
    while at < len(time_s):
        if not 6.0 <= hour[at] < 22.0:
            length, what = 1200 // STEP_S, 0
        else:
            what = int(rng.choice([0, 1, 2], p=[0.12, 0.28, 0.6]))
            length = int(rng.uniform(*((600, 2400), (120, 900), (600, 3600))[what])) // STEP_S
        mode[at : at + length] = what
        at += length
    return mode


def _vehicle(
    rng: np.random.Generator, time_s: NDArray[np.int64]
) -> tuple[dict[str, Floats], NDArray[np.int64]]:
    count = len(time_s)
    mode = _shifts(rng, time_s)
    driving = mode == 2
    # Speeds that are asked for, a new one every minute or so.
    asked = np.repeat(rng.choice([0.3, 0.6, 0.9, 1.2], count // _MINUTE + 1), _MINUTE)[:count]
    speed = _follow(np.where(driving, asked, 0.0), 8.0)
    turn = np.where(driving, _ar(rng, count, 20.0, 0.08), 0.0)
    wobble = np.where(driving, 1.0, 0.0)
    left = speed - turn + wobble * rng.normal(0, 0.02, count)
    right = speed + turn + wobble * rng.normal(0, 0.02, count)
    load = _ar(rng, count, 60.0, 0.4) * driving
    drawn = 1.2 + 0.1 * rng.normal(0, 1, count) + driving * (2.0 + 5.0 * speed + load)
    charge = np.empty(count)
    level = 0.9
    for at, (what, amps) in enumerate(zip(mode.tolist(), drawn.tolist(), strict=True)):
        level += STEP_S * ((1 - level) * 6e-4 if what == 0 else -amps * 2.4e-6)
        level = min(0.999, max(0.15, level))
        charge[at] = level
    current = np.where(mode == 0, -8.0 * (1 - charge) * 3 + 0.05 * rng.normal(0, 1, count), drawn)
    volts = 22.0 + 3.2 * charge - 0.045 * current + rng.normal(0, 0.015, count)
    hall = 19 + 2.5 * np.sin(2 * np.pi * (time_s / DAY_S - 0.3)) + _ar(rng, count, 6 * 3600, 0.7)
    warm_left = hall + _follow(14 * np.abs(left) ** 1.5 + 1.5 * (np.abs(load)), 900.0)
    warm_right = hall + _follow(14 * np.abs(right) ** 1.5 + 1.5 * (np.abs(load)), 900.0)
    cell = hall + 2 + _follow(0.12 * np.abs(current) ** 1.3, 2400.0)
    busy = np.clip(0.15 + 0.35 * driving + _ar(rng, count, 120.0, 0.06), 0.02, 1.0)
    radio = -52 - 9 * driving + _ar(rng, count, 90.0, 3.0) + 1.2 * rng.standard_t(5, count)
    return {
        "battery/voltage": np.round(volts, 2),
        "battery/current": current + rng.normal(0, 0.05, count),
        "battery/temperature": np.round(cell + rng.normal(0, 0.08, count), 1),
        "base/left_speed": left,
        "base/right_speed": right,
        "base/odometry_speed": 0.5 * (left + right) + wobble * rng.normal(0, 0.01, count),
        "base/left_motor": warm_left + rng.normal(0, 0.15, count),
        "base/right_motor": warm_right + rng.normal(0, 0.15, count),
        "computer/load": busy,
        "computer/temperature": 34 + 30 * _follow(busy, 60.0) + rng.normal(0, 0.4, count),
        "computer/radio": np.round(radio),
    }, mode


def _observatory(
    rng: np.random.Generator, time_s: NDArray[np.int64]
) -> tuple[dict[str, Floats], NDArray[np.int64]]:
    count = len(time_s)
    hour = time_s % DAY_S / 3600
    night = (hour < 5.0) | (hour > 20.0)
    sun = np.clip(np.sin(2 * np.pi * (hour - 6.0) / 24), 0, None)
    outside = 9 + 6 * _follow(sun, 3 * 3600.0) + _ar(rng, count, 40_000.0, 2.0)
    cloudy = _ar(rng, count, 9_000.0, 1.0) > 0.9
    cloud = _follow(np.where(cloudy, 1.0, 0.0), 900.0)
    humid = 62 - 1.9 * (outside - 12) + _ar(rng, count, 10_000.0, 4.0) + 10 * cloud
    wind = np.exp(1.3 + _ar(rng, count, 15_000.0, 0.4) + _ar(rng, count, 60.0, 0.2))
    pressure = 812 + _ar(rng, count, 150_000.0, 4.0)
    dome = 1.5 + _follow(outside, 3000.0)
    mirror = 1.0 + _follow(outside, 7000.0)
    # Frames and slews at night: the telescope moves every few minutes, and the dome after it.
    slewing = night & (np.repeat(rng.random(count // _SLEW + 1) < 0.08, _SLEW)[:count])
    mode = np.where(night, 1, 0)
    cooler = 42 + 1.6 * (outside - 9) + 14 * (night - 0.5)
    seeing = np.exp(_ar(rng, count, 2000.0, 0.15) + rng.normal(0, 0.12, count))
    current = np.where(slewing, 4.2 + 0.15 * rng.normal(0, 1, count), 0.2)
    mains = 229 + 2.5 * np.sin(2 * np.pi * (hour - 4) / 24) + _ar(rng, count, 1200.0, 0.9)
    return {
        "weather/temperature": np.round(outside + rng.normal(0, 0.06, count), 1),
        "weather/humidity": np.round(np.clip(humid + rng.normal(0, 0.4, count), 3, 100), 1),
        "weather/wind": np.round(wind, 1),
        "weather/pressure": np.round(pressure + rng.normal(0, 0.05, count), 1),
        "weather/sky": outside - 24 + 19 * cloud + rng.normal(0, 0.35, count),
        "camera/temperature": -15 + np.where(night, 0.0, 0.0) + rng.normal(0, 0.04, count),
        "camera/cooler": np.round(_follow(cooler, 300.0) + rng.normal(0, 0.6, count), 1),
        "dome/temperature": dome + rng.normal(0, 0.06, count),
        "dome/motor": current + 0.02 * rng.normal(0, 1, count),
        "telescope/mirror": mirror + rng.normal(0, 0.05, count),
        "telescope/guiding": np.where(night, 0.45 * seeing, 0.02 + 0.002 * rng.normal(0, 1, count)),
        "power/mains": np.round(mains + rng.normal(0, 0.3, count), 1),
    }, mode


# ── faults ──────────────────────────────────────────────────────────────────────────────────────


def _at(names: tuple[str, ...], *wanted: str) -> list[int]:
    return [names.index(name) for name in wanted]


def _stuck(name: str) -> Callable[[Floats, tuple[str, ...], np.random.Generator], Floats]:
    def plant(values: Floats, names: tuple[str, ...], rng: np.random.Generator) -> Floats:
        column = _at(names, name)[0]
        values[:, column] = values[0, column]
        return values

    return plant


def _ramp(**changes: float) -> Callable[[Floats, tuple[str, ...], np.random.Generator], Floats]:
    """Change signals by so much a minute (``device__signal``)."""

    def plant(values: Floats, names: tuple[str, ...], rng: np.random.Generator) -> Floats:
        minutes = np.arange(len(values)) * STEP_S / 60
        for name, slope in changes.items():
            values[:, _at(names, name.replace("__", "/"))[0]] += slope * minutes
        return values

    return plant


def _step(**changes: float) -> Callable[[Floats, tuple[str, ...], np.random.Generator], Floats]:
    """Change signals by so much at once."""

    def plant(values: Floats, names: tuple[str, ...], rng: np.random.Generator) -> Floats:
        for name, change in changes.items():
            values[:, _at(names, name.replace("__", "/"))[0]] += change
        return values

    return plant


def _slip(values: Floats, names: tuple[str, ...], rng: np.random.Generator) -> Floats:
    left, odometry = _at(names, "base/left_speed", "base/odometry_speed")
    gone = 0.5 * np.abs(values[:, left]) * (0.7 + 0.3 * rng.random(len(values)))
    values[:, left] += gone
    values[:, odometry] += 0.5 * gone
    return values


def _blocked(values: Floats, names: tuple[str, ...], rng: np.random.Generator) -> Floats:
    left, odometry, amps, volts = _at(
        names, "base/left_speed", "base/odometry_speed", "battery/current", "battery/voltage"
    )
    values[:, odometry] -= 0.5 * values[:, left]
    values[:, left] = rng.normal(0, 0.01, len(values))
    values[:, amps] += 6.0
    values[:, volts] -= 0.27
    return values


def _weak(values: Floats, names: tuple[str, ...], rng: np.random.Generator) -> Floats:
    amps, volts = _at(names, "battery/current", "battery/voltage")
    minutes = np.arange(len(values)) * STEP_S / 60
    values[:, volts] -= np.minimum(0.5, 0.05 * minutes) * np.maximum(values[:, amps], 0.0)
    return values


def _noisy(
    name: str, spread: float
) -> Callable[[Floats, tuple[str, ...], np.random.Generator], Floats]:
    def plant(values: Floats, names: tuple[str, ...], rng: np.random.Generator) -> Floats:
        values[:, _at(names, name)[0]] += rng.normal(0, spread, len(values))
        return values

    return plant


def _slow_dome(values: Floats, names: tuple[str, ...], rng: np.random.Generator) -> Floats:
    motor = _at(names, "dome/motor")[0]
    # It turns for twice as long, and harder.
    turning = values[:, motor] > 1.0
    longer = np.convolve(turning, np.ones(35 // STEP_S + 1))[: len(values)] > 0
    values[:, motor] = np.where(longer, 6.5, values[:, motor]) + rng.normal(0, 0.1, len(values))
    return values


FAULTS = (
    Fault("stuck wheel sensor", "vehicle", 2, _stuck("base/left_speed")),
    Fault("slipping wheel", "vehicle", 2, _slip),
    Fault("blocked wheel", "vehicle", 2, _blocked),
    Fault("weak battery", "vehicle", 2, _weak),
    Fault("motor gets hot", "vehicle", 2, _ramp(base__left_motor=1.2)),
    Fault("battery temperature drifts", "vehicle", 0, _ramp(battery__temperature=0.5)),
    Fault("voltage sensor off", "vehicle", 1, _step(battery__voltage=-0.8)),
    Fault("current sensor noisy", "vehicle", 1, _noisy("battery/current", 3.0)),
    Fault("computer overheats", "vehicle", 2, _ramp(computer__temperature=6.0)),
    Fault("radio lost an antenna", "vehicle", 1, _step(computer__radio=-28.0)),
    Fault("slow dome", "observatory", 1, _slow_dome),
    Fault("stuck wind sensor", "observatory", 1, _stuck("weather/wind")),
    Fault("outside temperature drifts", "observatory", 1, _ramp(weather__temperature=0.4)),
    Fault(
        "camera cooling lost", "observatory", 1, _ramp(camera__temperature=0.4, camera__cooler=6.0)
    ),
    Fault("cooler fan weak", "observatory", 1, _ramp(camera__cooler=4.0)),
    Fault("sky sensor fogged", "observatory", 1, _step(weather__sky=12.0)),
    Fault("humidity sensor off", "observatory", 0, _step(weather__humidity=9.0)),
    Fault("pressure sensor off", "observatory", 0, _step(weather__pressure=1.5)),
    Fault("guiding gets bad", "observatory", 1, _ramp(telescope__guiding=0.6)),
    Fault("mains sag", "observatory", 0, _step(power__mains=-11.0)),
)
