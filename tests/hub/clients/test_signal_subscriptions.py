"""Thousands of single wishes of a tool are a few subscriptions at the hub."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.hub.clients.signal_subscriptions import SignalSubscriptions
from talaia.wire.browser import Subscribe, Unsubscribe, Values
from talaia.wire.columns import Columns, pack_columns

pytestmark = pytest.mark.pure


def values(sub, *rows, known=False) -> Values:
    """Make a message of rows of channel, time (µs) and value."""
    columns = Columns(
        np.array([row[0] for row in rows], np.uint16),
        np.array([row[1] for row in rows], np.int64),
        np.array([row[2] for row in rows], np.float64),
        {},
    )
    return Values(
        sub=sub, age_ms=[1.0] * len(rows) if known else [], **pack_columns(columns)._asdict()
    )


def test_addresses_of_one_message_are_one_subscription() -> None:
    subscriptions = SignalSubscriptions("agv")
    (asked,) = subscriptions.add_addresses(["base/a", "base/b", "base/a"])
    assert asked == Subscribe(sub=asked.sub, site="agv", channels=["base/a", "base/b"], every_ms=0)
    assert subscriptions.add_addresses(["base/b"]) == []


def test_subscription_ends_with_its_last_address() -> None:
    subscriptions = SignalSubscriptions("agv")
    (asked,) = subscriptions.add_addresses(["base/a", "base/b"])
    assert subscriptions.remove_addresses(["base/a"]) == []
    assert list(subscriptions.read_samples(values(asked.sub, (0, 1, 1.0)))) == []
    assert subscriptions.remove_addresses(["base/b"]) == [Unsubscribe(sub=asked.sub)]


def test_newest_value_that_the_client_had_is_not_told_again_when_subscriptions_become_one() -> None:
    subscriptions = SignalSubscriptions("agv")
    for number in range(16):
        (asked,) = subscriptions.add_addresses([f"base/{number}"])
        list(subscriptions.read_samples(values(asked.sub, (0, 10, 1.0), known=True)))
    *ended, joined = subscriptions.add_addresses(["base/new"])
    assert len(ended) == 16
    assert len(joined.channels) == 17
    told = values(joined.sub, *((at, 10, 1.0) for at in range(17)), known=True)
    assert [sample.address for sample in subscriptions.read_samples(told)] == ["base/new"]
    newer = values(joined.sub, (3, 11, 2.0), known=True)
    assert [sample.address for sample in subscriptions.read_samples(newer)] == ["base/3"]


def test_address_that_is_wanted_again_begins_with_its_newest_value() -> None:
    subscriptions = SignalSubscriptions("agv")
    (first,) = subscriptions.add_addresses(["base/a"])
    list(subscriptions.read_samples(values(first.sub, (0, 10, 1.0))))
    subscriptions.remove_addresses(["base/a"])
    (again,) = subscriptions.add_addresses(["base/a"])
    assert [
        s.value for s in subscriptions.read_samples(values(again.sub, (0, 10, 1.0), known=True))
    ]


@given(
    st.lists(
        st.tuples(st.booleans(), st.lists(st.integers(0, 40).map(str), min_size=1, max_size=5)),
        max_size=60,
    )
)
def test_hub_is_asked_for_what_is_wanted_by_few_subscriptions(steps) -> None:
    subscriptions = SignalSubscriptions("agv")
    at_hub, wanted = {}, set()
    for adds, addresses in steps:
        if adds:
            wanted.update(addresses)
        else:
            wanted.difference_update(addresses)
        asked = (subscriptions.add_addresses if adds else subscriptions.remove_addresses)(addresses)
        for message in asked:
            if isinstance(message, Subscribe):
                assert message.sub not in at_hub
                at_hub[message.sub] = message.channels
            else:
                del at_hub[message.sub]
        assert set(subscriptions.wanted) == wanted
        assert wanted <= {address for channels in at_hub.values() for address in channels}
        assert len(at_hub) <= 16
        got = [
            sample.address
            for sub, channels in at_hub.items()
            for sample in subscriptions.read_samples(
                values(sub, *((at, 2**40, 0.0) for at in range(len(channels))))
            )
        ]
        assert sorted(got) == sorted(wanted)
