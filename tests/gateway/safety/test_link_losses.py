"""A roof that is closed because the hub is away is closed as in the rain: asked until it is."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import given, settings, strategies as st
from many_examples import examples
from msgspec import structs

from talaia.clock import SECOND, HandClock
from talaia.gateway.freeze_watchdog import FreezeCredit
from talaia.gateway.safety.interlocks import Interlocks
from talaia.model.connection import RosSource
from talaia.model.interlocks.enclosure import Enclosure, Sighting
from talaia.model.interlocks.interlock import LinkLossPolicy, Step
from talaia.model.site import Signal, SignalType

from .test_interlocks import SITE, World

if TYPE_CHECKING:
    from talaia.model.site import Site

CLOSED = Signal(
    name="Closed",
    type=SignalType.STATE,
    states=("no", "yes"),
    source=RosSource(topic="/c"),
    max_age=2,
)


def under_a_roof() -> Site:
    dome = SITE.devices["dome"]
    policy = LinkLossPolicy(after=60, run=(Step(command="dome/close"), Step(command="base/lamp")))
    dome = structs.replace(dome, signals={"closed": CLOSED}, link_loss=policy)
    roof = Enclosure(
        name="Dome",
        unsafe=("weather",),
        closed=(Sighting(signal="dome/closed", is_one_of=("yes",)),),
        close=Step(command="dome/close"),
        retries=1,
    )
    return structs.replace(SITE, devices={**SITE.devices, "dome": dome}, enclosures={"dome": roof})


class Bench:
    """Interlocks over a roof, ten looks a second."""

    def __init__(self) -> None:  # noqa: D107
        self.clock = HandClock()
        self.world = World(self.clock)
        self.world.values = {"weather/wind": 3.0, "weather/rain": 0.0, "dome/closed": 0.0}
        self.interlocks = Interlocks(
            site=under_a_roof(),
            readings=self.world,
            output=self.world,
            run=self.world.run,
            now_ns=self.clock.monotonic_ns(),
        )

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * 10)):
            self.clock.advance(SECOND // 10)
            self.interlocks.evaluate_all(self.clock.monotonic_ns())

    def asked(self, what: str) -> int:
        return sum(what in each for each in self.world.ran)


@pytest.fixture
def bench() -> Bench:
    one = Bench()
    one.interlocks.link_up(0)
    one.run(40)
    return one


def test_a_roof_that_a_lost_link_closes_is_asked_until_it_is_closed(bench: Bench) -> None:
    bench.interlocks.link_lost(bench.clock.monotonic_ns())
    bench.run(59)
    assert bench.asked("dome/close") == 0
    bench.run(30)
    # The rest of the policy is done once; the roof is asked again, and nobody is left in doubt.
    assert bench.asked("link loss dome: base/lamp") == 1
    assert bench.asked("dome/close") >= 3
    assert "enclosure_not_closed" in bench.world.notes
    bench.world.values["dome/closed"] = 1.0
    bench.run(1)
    asked = bench.asked("dome/close")
    bench.run(60)
    assert bench.asked("dome/close") == asked
    assert "enclosure_closed" in bench.world.notes


def test_a_link_that_is_back_wants_no_roof_closed(bench: Bench) -> None:
    bench.interlocks.link_lost(bench.clock.monotonic_ns())
    bench.run(61)
    asked = bench.asked("dome/close")
    assert asked
    bench.interlocks.link_up(bench.clock.monotonic_ns())
    bench.run(60)
    assert bench.asked("dome/close") == asked


def test_a_policy_waits_while_a_night_looks_after_the_device_and_is_due_at_once_behind_it(
    bench: Bench,
) -> None:
    attending = {"dome"}
    bench.interlocks.attend_devices(lambda device: device in attending)
    bench.interlocks.link_lost(bench.clock.monotonic_ns())
    bench.run(600)
    assert bench.asked("dome/close") == 0
    attending.clear()
    bench.run(1)
    assert bench.asked("dome/close") == 1


def stop_values(bench: Bench) -> None:
    """Let every sensor fall silent, with its last words."""
    now = bench.clock.monotonic_ns()
    said: dict[str, Any] = {name: bench.world.latest(name) for name in bench.world.values}
    assert all(each.mono_ns == now for each in said.values())
    bench.world.said, bench.world.values = said, {}


def test_a_gateway_that_stood_still_itself_does_not_lock_for_it(bench: Bench) -> None:
    values = dict(bench.world.values)
    stop_values(bench)
    bench.clock.advance(30 * SECOND)
    bench.run(1)
    assert bench.asked("dome/close") == 0
    assert "interlock_locked" not in bench.world.notes
    # But nobody opens it by what was said before.
    refused = bench.interlocks.refusal_reason("dome", "open", bench.clock.monotonic_ns())
    assert "nothing was heard since the gateway stood still" in refused
    # What arrives within the time to settle decides.
    bench.world.values = values
    bench.run(5)
    assert bench.interlocks.refusal_reason("dome", "open", bench.clock.monotonic_ns()) == ""
    assert bench.asked("dome/close") == 0
    assert "interlock_locked" not in bench.world.notes


def test_a_station_that_is_silent_after_the_standstill_locks(bench: Bench) -> None:
    stop_values(bench)
    bench.clock.advance(30 * SECOND)
    bench.run(FreezeCredit.SETTLE_NS / SECOND + 0.3)
    assert "Wind: no value" in bench.interlocks.refusal_reason(
        "dome", "open", bench.clock.monotonic_ns()
    )
    assert bench.asked("dome/close")


READINGS = st.tuples(
    st.sampled_from([3.0, 13.0, float("nan"), None]),
    st.sampled_from([0.0, 1.0, 7.0, None]),
    st.integers(1, 60),
    st.sampled_from([0, 0, 7, 300]),
)


@settings(max_examples=examples(20, many=200), deadline=None)
@given(st.lists(READINGS, min_size=1, max_size=5))
def test_whatever_is_heard_nothing_opens_while_it_is_unsafe_or_unknown(
    history: list[tuple[float | None, float | None, int, int]],
) -> None:
    bench = Bench()
    bench.interlocks.link_up(0)
    bench.run(31)
    closes: list[int] = []
    for wind, rain, ticks, still in history:
        heard = {"weather/wind": wind, "weather/rain": rain, "dome/closed": 0.0}
        stop_values(bench)
        bench.clock.advance(still * SECOND // 10)
        bench.world.values = {name: value for name, value in heard.items() if value is not None}
        measured = wind == 13.0 or rain in (1.0, 7.0)
        unknown = wind is None or rain is None or wind != wind
        for tick in range(ticks):
            before = len(bench.world.ran)
            bench.run(0.1)
            now = bench.clock.monotonic_ns()
            if any("enclosure dome close" in each for each in bench.world.ran[before:]):
                closes.append(now)
            # What falls silent is known until it is two seconds old (rain: five), and settled.
            if measured or (unknown and tick > 52):
                assert bench.interlocks.refusal_reason("dome", "open", now)
        if measured:
            # Asked again at the latest after the longest pause.
            assert closes
            assert bench.clock.monotonic_ns() - closes[-1] <= (31 + still) * SECOND
    assert all(later - at >= 2 * SECOND for at, later in pairwise(closes))
