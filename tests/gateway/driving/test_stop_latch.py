"""STOP: latched, confirmed by the robot, opened in two steps."""

import math

import pytest

from talaia.clock import SECOND
from talaia.gateway.driving.stop_latch import LatchedStop, StandstillProof, StopLatch

pytestmark = pytest.mark.pure

ASK = LatchedStop("one", "Ada", 1)
FRESH = SECOND


def latched() -> StopLatch:
    latch = StopLatch(0.02)
    latch.request_stop(ASK, 5 * SECOND)
    return latch


def proof(value: float, at: int = 6 * SECOND) -> StandstillProof:
    return StandstillProof(value, at, FRESH)


def test_asking_again_changes_nothing_and_the_first_stays_on_record() -> None:
    latch = latched()
    assert not latch.request_stop(LatchedStop("two", "Ben", 2), 6 * SECOND)
    assert latch.latched == ASK


def test_confirmed_once_all_readings_are_near_zero() -> None:
    latch = latched()
    assert not latch.judge_standstill([proof(0.01), proof(0.3)], 6 * SECOND)
    assert latch.judge_standstill([proof(0.01), proof(-0.02)], 6 * SECOND)
    assert latch.confirmed


def test_reading_from_before_stop_proves_nothing() -> None:
    latch = latched()
    latch.judge_standstill([proof(0.0, 5 * SECOND - 1)], 5 * SECOND)
    assert not latch.confirmed


def test_stale_missing_and_nan_readings_prove_nothing() -> None:
    latch = latched()
    for seen in ([proof(0.0)], [None], [proof(math.nan, 8 * SECOND)], []):
        latch.judge_standstill(seen, 8 * SECOND)
        assert not latch.confirmed


def test_robot_that_moves_again_is_no_longer_confirmed() -> None:
    latch = latched()
    latch.judge_standstill([proof(0.0)], 6 * SECOND)
    assert latch.judge_standstill([proof(0.1)], 6 * SECOND)
    assert not latch.confirmed


def test_token_opens_once_for_its_session_within_ten_seconds() -> None:
    latch = latched()
    assert latch.offer_token("tab", "T", 10 * SECOND) == ""
    assert latch.check_token("other", "T", 11 * SECOND) != ""
    assert latch.check_token("tab", "T", 11 * SECOND) != "", "a wrong try uses it up"
    latch.offer_token("tab", "T", 10 * SECOND)
    assert latch.check_token("tab", "T", 20 * SECOND) != ""
    latch.offer_token("tab", "T", 10 * SECOND)
    assert latch.check_token("tab", "T", 20 * SECOND - 1) == ""


def test_new_stop_takes_back_a_token_that_was_given() -> None:
    latch = latched()
    latch.offer_token("tab", "T", 10 * SECOND)
    latch.request_stop(LatchedStop("two", "Ben", 2), 11 * SECOND)
    assert latch.check_token("tab", "T", 12 * SECOND) != ""
