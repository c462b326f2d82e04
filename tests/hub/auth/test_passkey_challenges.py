"""Challenges of passkeys: each once, for its purpose, its session and its time."""

from __future__ import annotations

import pytest

from talaia.clock import SECOND
from talaia.hub.auth.passkey_challenges import ChallengeUse, PasskeyChallenges

pytestmark = pytest.mark.pure

CONFIRM = frozenset({ChallengeUse.CONFIRM})


def test_challenge_is_taken_once_and_in_its_time() -> None:
    waiting = PasskeyChallenges()
    value = waiting.begin(ChallengeUse.CONFIRM, 0, user=7, session="here")
    found = waiting.redeem(value, CONFIRM, 300 * SECOND, "here")
    assert (found.user, found.use) == (7, ChallengeUse.CONFIRM)
    assert waiting.redeem(value, CONFIRM, 0, "here") is None
    late = waiting.begin(ChallengeUse.CONFIRM, 0, session="here")
    assert waiting.redeem(late, CONFIRM, 301 * SECOND, "here") is None


def test_challenge_of_another_session_or_purpose_is_refused_and_used_up() -> None:
    waiting = PasskeyChallenges()
    for uses, session in ((CONFIRM, "there"), (frozenset({ChallengeUse.REGISTER}), "here")):
        value = waiting.begin(ChallengeUse.CONFIRM, 0, session="here")
        assert waiting.redeem(value, uses, 0, session) is None
        assert waiting.redeem(value, CONFIRM, 0, "here") is None


def test_flood_of_challenges_is_bounded() -> None:
    waiting = PasskeyChallenges()
    first = waiting.begin(ChallengeUse.CONFIRM, 0)
    for _ in range(10_000):
        last = waiting.begin(ChallengeUse.CONFIRM, 0)
    assert waiting.redeem(first, CONFIRM, 0) is None
    assert waiting.redeem(last, CONFIRM, 0) is not None
