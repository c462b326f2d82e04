"""What was said while nobody heard it, with silence after it, is what pages and alarms go by."""

from __future__ import annotations

import time

import numpy as np
from hypothesis import given, strategies as st

from talaia.hub.live.last_values import Latest
from talaia.wire.browser import AlarmUpdate, Subscribe, Subscribed, Values
from talaia.wire.columns import Columns, unpack_columns
from talaia.wire.frames import Ack
from talaia.wire.newest import NewestSamples, newest_frame, newest_of, runs_of

from ..conftest import DESCRIPTION
from ..features.test_alarms import LOW


def now_us() -> int:
    return time.time_ns() // 1000


def newest(gateway, *rows, boot: str = ""):
    """Give the message: rows of address, sequence, time (µs), value, age (ms)."""
    known = NewestSamples(
        Columns(
            np.array([gateway.channels[row[0]] for row in rows], np.uint16),
            np.array([row[2] for row in rows], np.int64),
            np.array([row[3] for row in rows], np.float64),
            {},
        ),
        np.array([row[1] for row in rows], np.int64),
        np.array([row[4] for row in rows], np.float64),
    )
    return newest_frame(known, boot or gateway.boot, "c1")


async def looking(hub, *channels: str, every_ms: int = 0):
    page = await hub.page("operator")
    await page.say(Subscribe(sub=1, site="agv", channels=list(channels), every_ms=every_ms))
    await page.hear(Subscribed)
    return page


def numbers(values: Values) -> list[float]:
    return unpack_columns(values).value.tolist()


async def test_value_said_in_an_outage_is_shown_with_its_age_and_kept_before_the_backlog(
    hub, gateway, history
) -> None:
    page = await looking(hub, "base/speed", every_ms=60_000)
    at = now_us()
    # The first goes out at once, the second gathers: it is older than what is told then.
    await gateway.samples(("base/speed", at, 1.0))
    await page.hear(Values)
    await gateway.samples(("base/speed", at + 1, 3.0))
    await gateway.hear(Ack, lambda ack: ack.below == 2)
    await gateway.say(newest(gateway, ("base/speed", 7, at + 100, 11.0, 300_000.0)))
    assert numbers(await page.hear(Values)) == [3.0]
    told = await page.hear(Values)
    assert numbers(told) == [11.0]
    assert 300_000 <= told.age_ms[0] < 330_000
    await gateway.hear(Ack)
    assert history.samples["agv", "boot-1"][7] == ("base/speed", at + 100, 11.0, "")
    assert (await history.last_readings("agv", ["base/speed"]))["base/speed"][1] == 11.0
    # The old ones come behind, the told one among them, and change nothing that is shown.
    rows = [("base/speed", at + 2 + each, 4.0 + each) for each in range(5)]
    await gateway.samples(*rows, ("base/speed", at + 100, 11.0), first=2, live=False)
    assert (await gateway.hear(Ack, lambda ack: ack.below == 8)).boot == "boot-1"
    again = await looking(hub, "base/speed")
    assert numbers(await again.hear(Values)) == [11.0]
    assert not [each for each in page.heard if isinstance(each, Values)]


async def test_alarm_goes_by_what_was_said_in_the_outage(hub) -> None:
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + LOW)
    page = await hub.page("operator")
    await page.hear(AlarmUpdate, lambda news: news.alarm == "low")
    await gateway.samples(("power/voltage", now_us(), 12.0))
    await gateway.say(newest(gateway, ("power/voltage", 4, now_us(), 10.0, 60_000.0)))
    raised = await page.hear(AlarmUpdate, lambda news: news.phase == "active")
    assert raised.why == "Voltage is 10 V, below 11 V"


async def test_alarm_does_not_take_what_is_too_old_for_what_is_so_now(hub) -> None:
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + LOW)
    page = await hub.page("operator")
    await page.hear(AlarmUpdate, lambda news: news.alarm == "low")
    await gateway.say(newest(gateway, ("power/voltage", 4, now_us(), 10.0, 7_200_000.0)))
    unknown = await page.hear(AlarmUpdate, lambda news: not news.known)
    assert unknown.phase == "normal"


async def test_what_is_told_twice_or_too_late_changes_nothing(hub, gateway, history) -> None:
    page = await looking(hub, "base/speed", "power/charge")
    told = newest(gateway, ("base/speed", 3, now_us(), 11.0, 50.0))
    await gateway.say(told)
    assert numbers(await page.hear(Values)) == [11.0]
    await gateway.samples(("base/speed", now_us(), 12.0), first=4)
    assert numbers(await page.hear(Values)) == [12.0]
    await gateway.say(told)
    await gateway.samples(("power/charge", now_us(), 0.5), first=5)
    assert numbers(await page.hear(Values)) == [0.5]
    await gateway.hear(Ack)
    assert list(history.samples["agv", "boot-1"]) == [3, 4, 5]


async def test_former_run_does_not_take_back_what_came_later(hub, gateway) -> None:
    page = await looking(hub, "base/speed")
    at = now_us()
    await gateway.samples(("base/speed", at, 12.0))
    assert numbers(await page.hear(Values)) == [12.0]
    await gateway.say(newest(gateway, ("base/speed", 9, at - 5, 11.0, 1.0), boot="boot-0"))
    await gateway.say(newest(gateway, ("base/speed", 10, at + 5, 13.0, 1.0), boot="boot-0"))
    assert numbers(await page.hear(Values)) == [13.0]


steps = st.lists(
    st.tuples(st.integers(0, 2), st.booleans(), st.integers(0, 30)), min_size=1, max_size=40
)


@given(steps)
def test_newest_of_a_run_is_what_its_numbers_say_in_whatever_way_it_came(
    came: list[tuple[int, bool, int]],
) -> None:
    """Live batches come in order; what is told may be any of the past, or of the time to come."""
    latest, best, sequence = Latest(3), dict[int, int](), 0
    for channel, live, ahead in came:
        if live:
            sequence = max([sequence, *best.values()]) + 1
            number = sequence
            one = Columns(
                np.array([channel], np.uint16), np.array([0]), np.array([float(number)]), {}
            )
            latest.update_values(one, 0, "b", number + 1)
        else:
            number = ahead
            one = Columns(
                np.array([channel], np.uint16), np.array([0]), np.array([float(number)]), {}
            )
            told = NewestSamples(one, np.array([number]), np.array([0.0]))
            if latest.newer_samples(told, "b", 0, current=True).all():
                latest.correct_values(told, "b", 0)
        best[channel] = max(best.get(channel, -1), number)
        assert latest.value[channel] == best[channel]


@given(st.sets(st.integers(0, 60), max_size=40), st.integers(0, 60))
def test_pieces_to_store_are_all_that_is_not_stored_under_its_own_number(
    sequences: set[int], below: int
) -> None:
    rows = np.array(sorted(sequences), np.int64)
    columns = Columns(np.arange(rows.size, dtype=np.uint16), rows * 10, rows * 1.0, {})
    known = NewestSamples(columns, rows, np.zeros(rows.size))
    back = newest_of(newest_frame(known, "b", "c"))
    pieces = runs_of(back, below)
    stored = {
        first + at: float(value) for first, piece in pieces for at, value in enumerate(piece.value)
    }
    assert stored == {each: float(each) for each in sequences if each >= below}
    assert len(pieces) == sum(each - 1 not in stored for each in stored)


def test_latest_keeps_the_last_of_a_batch_and_tells_its_age() -> None:
    latest = Latest(3)
    batch = Columns(
        np.array([1, 1, 2], np.uint16), np.array([5, 6, 7]), np.array([0.1, 0.2, np.nan]), {2: "hi"}
    )
    latest.update_values(batch, 1_000_000_000)
    columns, ages = latest.values_of(np.array([2, 0, 1]), 1_500_000_000)
    assert columns.channel.tolist() == [0, 2]
    assert columns.time_us.tolist() == [7, 6]
    assert columns.value[1] == 0.2
    assert columns.texts == {0: "hi"}
    assert ages == [500.0, 500.0]


def test_remembered_sample_does_not_hide_a_live_one() -> None:
    latest = Latest(1)
    latest.remember_value(0, time_us=5, value=1.0, text="", arrived_ns=-1_000_000)
    columns, ages = latest.values_of(np.array([0]), 0)
    assert (columns.value.tolist(), ages) == ([1.0], [1.0])
    latest.update_values(Columns(np.zeros(1, np.uint16), np.array([9]), np.array([2.0]), {}), 10)
    latest.remember_value(0, time_us=5, value=1.0, text="", arrived_ns=0)
    assert latest.values_of(np.array([0]), 10)[0].value.tolist() == [2.0]


_BATCHES = st.lists(
    st.lists(st.tuples(st.integers(0, 3), st.sampled_from(["", "opening"])), max_size=5),
    max_size=20,
)


@given(_BATCHES, st.sets(st.integers(0, 19)))
def test_values_are_the_same_whether_they_are_asked_for_after_each_batch_or_after_many(
    batches, looked_at
) -> None:
    seldom, always = Latest(4), Latest(4)
    for number, samples in enumerate(batches):
        size = len(samples)
        columns = Columns(
            np.array([channel for channel, _ in samples], np.uint16),
            np.arange(size) + 100 * number,
            np.arange(size) + 100.0 * number,
            {at: text for at, (_, text) in enumerate(samples) if text},
        )
        for latest in (seldom, always):
            latest.update_values(columns, 10 + number, f"run {number % 3}", 1000 * number)
        asked = (always, seldom) if number in looked_at else (always,)
        for latest in asked:
            _ = latest.value
    told = NewestSamples(
        Columns(np.arange(4, dtype=np.uint16), np.zeros(4, np.int64), np.zeros(4), {}),
        np.full(4, 7_000),
        np.zeros(4),
    )
    # Before anything else is asked for: it goes by runs and their numbers.
    newer = [
        one.newer_samples(told, "run 1", 50, current=True).tolist() for one in (seldom, always)
    ]
    assert newer[0] == newer[1]
    np.testing.assert_array_equal(seldom.value, always.value)
    assert seldom.time_us.tolist() == always.time_us.tolist()
    assert seldom.arrived_ns.tolist() == always.arrived_ns.tolist()
    assert seldom.texts == always.texts
