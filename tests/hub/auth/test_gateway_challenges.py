"""A number of the hub is good for a minute, and answered once."""

from __future__ import annotations

from talaia.clock import SECOND
from talaia.hub.auth.gateway_challenges import NONCE_S, GatewayChallenges


class _Clock:
    def __init__(self) -> None:
        self.now_ns = 0

    def monotonic_ns(self) -> int:
        return self.now_ns

    def wall_ns(self) -> int:
        return self.now_ns


def test_a_number_is_good_for_a_while_and_only_at_the_hub_that_made_it() -> None:
    clock = _Clock()
    hub, other = GatewayChallenges(clock), GatewayChallenges(clock)
    nonce = hub.make_nonce()
    assert hub.is_open(nonce)
    assert not other.is_open(nonce)
    clock.now_ns = NONCE_S * SECOND + 1
    assert not hub.is_open(nonce)


def test_a_number_that_was_answered_is_answered_no_more_and_is_not_kept_for_ever() -> None:
    clock = _Clock()
    hub = GatewayChallenges(clock)
    for _ in range(5):
        nonce = hub.make_nonce()
        hub.use_nonce(nonce)
        assert not hub.is_open(nonce)
        clock.now_ns += NONCE_S * SECOND + 1
    assert len(hub._used) == 1


def test_a_number_that_was_changed_is_none_of_ours() -> None:
    hub = GatewayChallenges(_Clock())
    nonce = hub.make_nonce()
    said, _, seal = nonce.rpartition(".")
    for forged in ("", "x", f"{said}.{seal[:-1]}", f"{said}0.{seal}", f"1{nonce}", "ä.1.2"):
        assert not hub.is_open(forged)
