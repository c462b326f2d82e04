"""What a tool that is no page may drive: refused or permitted, half as fast, 250 ms, then zeros."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, strategies as st

from talaia.clock import MS, SECOND
from talaia.hub.clients.client_driving import GOOD_NS, ClientDriving
from talaia.model.site import Drive
from talaia.wire.browser import (
    LeaseUpdate,
    PageDrive,
    PageLease,
    PageStop,
    RequestError,
    StopUpdate,
    TickUpdate,
)
from talaia.wire.frames import LeaseOp

pytestmark = pytest.mark.pure

RULE = Drive(topic="/cmd_vel", max_speed=1.0, max_reverse=0.4, max_turn=2.0)
START_NS = 1000 * SECOND


class Driver:
    """A client that drives, with a gateway that gives it the lease when told to."""

    def __init__(self, *, permitted=True, refusal=None) -> None:
        """Ask of nobody; ``refusal`` answers each request."""
        self.asked = []
        self.permitted = permitted
        self.refusal = refusal
        self.now_ns = START_NS
        self.driving = ClientDriving("agv", ask=self._ask, permits=lambda _device: self.permitted)

    def _ask(self, message):
        self.asked.append(message)
        return self.refusal

    def publish(self, linear=0.2, angular=0.0, *, rule=RULE) -> str:
        return self.driving.publish_velocity(
            "base", rule, linear=linear, angular=angular, now_ns=self.now_ns
        )

    def give_lease(self, epoch=7, tick=100, **said) -> str:
        self.driving.observe_news(TickUpdate(site="agv", tick=tick), self.now_ns)
        update = LeaseUpdate(site="agv", device="base", yours=True, epoch=epoch, **said)
        return self.driving.observe_news(update, self.now_ns)

    def pass_time(self, passed_ns, *, step_ns=5 * MS) -> None:
        """Let time pass; `step` is called whenever it wants to be."""
        end_ns = self.now_ns + passed_ns
        while (due := self.driving.due_ns()) is not None and due <= end_ns:
            self.now_ns = max(self.now_ns, due)
            self.driving.step(self.now_ns)
        self.now_ns = end_ns

    def frames(self):
        return [message for message in self.asked if isinstance(message, PageDrive)]

    def leases(self):
        return [message.op for message in self.asked if isinstance(message, PageLease)]


def test_what_is_published_without_an_admins_word_is_refused_with_the_reason() -> None:
    driver = Driver(permitted=False)
    assert "an admin may let your account" in driver.publish()
    assert driver.asked == []


def test_permitted_client_gets_the_lease_and_its_message_becomes_one_frame() -> None:
    driver = Driver()
    assert driver.publish(0.2, 0.5) == ""
    assert driver.leases() == [LeaseOp.TAKE]
    driver.give_lease(epoch=7, tick=100)
    assert [(f.epoch, f.tick, f.linear, f.angular) for f in driver.frames()] == [(7, 100, 0.2, 0.5)]


def test_message_that_is_too_old_when_the_lease_comes_moves_nothing() -> None:
    driver = Driver()
    driver.publish()
    driver.pass_time(GOOD_NS)
    driver.give_lease()
    assert driver.frames() == []


def test_it_drives_at_half_of_the_limits() -> None:
    driver = Driver()
    driver.publish()
    driver.give_lease()
    for linear, angular in ((5.0, 5.0), (-5.0, -5.0)):
        driver.publish(linear, angular)
    fast, back = driver.frames()[-2:]
    assert (fast.linear, fast.angular) == (0.5, 1.0)
    assert (back.linear, back.angular) == (-0.2, -1.0)


def test_zeros_follow_250_ms_after_the_last_message() -> None:
    driver = Driver()
    driver.publish()
    driver.give_lease()
    driver.pass_time(GOOD_NS - 1)
    assert len(driver.frames()) == 1
    driver.pass_time(SECOND)
    zeros = driver.frames()[1:]
    assert [(f.linear, f.angular) for f in zeros] == [(0.0, 0.0)] * 3
    sequence = [f.seq for f in driver.frames()]
    assert sequence == sorted(set(sequence))


def test_frame_says_how_long_ago_the_gateways_mark_was_heard() -> None:
    driver = Driver()
    driver.publish()
    driver.give_lease()
    driver.now_ns += 30 * MS
    driver.publish()
    assert driver.frames()[-1].held_ms == 30.0


def test_lease_is_renewed_while_it_drives_and_given_back_when_it_is_silent() -> None:
    driver = Driver()
    driver.publish()
    driver.give_lease()
    for _ in range(25):
        driver.pass_time(100 * MS)
        driver.publish()
    assert driver.leases().count(LeaseOp.RENEW) >= 2
    driver.asked.clear()
    driver.pass_time(5 * SECOND)
    assert driver.leases()[-1] is LeaseOp.FREE
    assert driver.driving.due_ns() is None


def test_person_who_asks_for_control_gets_it_at_once() -> None:
    driver = Driver()
    driver.publish()
    driver.give_lease()
    assert "Ana" in driver.give_lease(rival="Ana", answer_ms=5000)
    assert driver.leases()[-1] is LeaseOp.ACCEPT


def test_lost_lease_is_told_and_nothing_more_is_driven_by_it() -> None:
    driver = Driver()
    driver.publish()
    driver.give_lease()
    lost = LeaseUpdate(site="agv", device="base", holder="Ana")
    assert "Ana" in driver.driving.observe_news(lost, driver.now_ns)
    driver.asked.clear()
    driver.pass_time(SECOND)
    assert driver.asked == []


def test_refused_lease_is_the_answer_until_it_is_asked_for_again() -> None:
    driver = Driver()
    driver.publish()
    refused = LeaseUpdate(site="agv", device="base", holder="Ana", refused="Ana is driving")
    driver.driving.observe_news(refused, driver.now_ns)
    assert driver.publish() == "Ana is driving"
    driver.pass_time(SECOND)
    driver.publish()
    assert driver.leases() == [LeaseOp.TAKE, LeaseOp.TAKE]
    assert driver.frames() == []


def test_permission_that_is_taken_back_ends_the_hold_with_a_zero() -> None:
    driver = Driver()
    driver.publish()
    driver.give_lease()
    driver.permitted = False
    assert driver.publish(0.3)
    assert (driver.frames()[-1].linear, driver.leases()[-1]) == (0.0, LeaseOp.FREE)
    driver.asked.clear()
    driver.pass_time(SECOND)
    assert driver.asked == []


def test_stop_needs_no_permission_and_is_repeated_until_it_is_answered() -> None:
    driver = Driver(permitted=False)
    assert driver.driving.press_stop("base", "s1", driver.now_ns) == ""
    driver.pass_time(SECOND)
    assert len(driver.asked) == 5
    assert {(m.device, m.id) for m in driver.asked if isinstance(m, PageStop)} == {("base", "s1")}
    answer = StopUpdate(site="agv", device="base", latched=True, id="s1")
    driver.driving.observe_news(answer, driver.now_ns)
    driver.asked.clear()
    driver.pass_time(SECOND)
    assert driver.asked == []


def test_stop_that_nobody_answers_ends_some_time() -> None:
    driver = Driver()
    driver.driving.press_stop("base", "s1", driver.now_ns)
    driver.pass_time(3600 * SECOND)
    assert driver.driving.due_ns() is None


def test_missing_right_is_told() -> None:
    driver = Driver(refusal=RequestError(code="forbidden", message="you do not have the right"))
    assert driver.publish() == "you do not have the right"
    assert driver.driving.press_stop("base", "s1", driver.now_ns) == "you do not have the right"


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_refused(value) -> None:
    driver = Driver()
    assert "finite" in driver.publish(value)
    assert "finite" in driver.publish(0.0, value)
    assert driver.asked == []


def test_device_that_is_not_driven_is_refused() -> None:
    assert "nothing that is driven" in Driver().publish(rule=None)


_EVENTS = st.lists(
    st.one_of(
        st.tuples(st.just("publish"), st.floats(-10, 10), st.floats(-10, 10)),
        st.tuples(st.just("wait"), st.integers(0, 4000)),
        st.tuples(st.just("lease"), st.integers(1, 5)),
        st.tuples(st.just("lost")),
        st.tuples(st.just("permit"), st.booleans()),
    ),
    max_size=40,
)


@given(_EVENTS)
def test_whatever_happens_no_motion_is_asked_for_without_a_message_that_is_good(events) -> None:
    driver = Driver()
    published_ns = -SECOND
    for kind, *said in events:
        before = len(driver.asked)
        match kind:
            case "publish":
                if not driver.publish(*said):
                    published_ns = driver.now_ns
            case "wait":
                driver.pass_time(said[0] * MS)
            case "lease":
                driver.give_lease(epoch=said[0])
            case "lost":
                driver.driving.observe_news(LeaseUpdate(site="agv", device="base"), driver.now_ns)
            case "permit":
                driver.permitted = said[0]
        for frame in driver.asked[before:]:
            if isinstance(frame, PageDrive) and (frame.linear or frame.angular):
                assert kind in {"publish", "lease"}
                assert driver.now_ns - published_ns < GOOD_NS
                assert -0.2 <= frame.linear <= 0.5
                assert abs(frame.angular) <= 1.0
    driver.pass_time(10 * SECOND)
    # A lease that was lost ends the motion at the gateway.
    if driver.frames() and ("lost",) not in events:
        assert (driver.frames()[-1].linear, driver.frames()[-1].angular) == (0.0, 0.0)
    assert driver.driving.due_ns() is None
