"""The judge of a roof's ledger finds what must not have been."""

from __future__ import annotations

from typing import Any

import pytest

from .judge import Unsafe, judge

pytestmark = pytest.mark.pure
S = 1_000_000_000


def truth(t: float, word: str) -> dict[str, Any]:
    return {"t": round(t * S), "device": "dome", "asked": "truth", "phase": "truth", "said": word}


def close(t: float, said: str = "") -> dict[str, Any]:
    return {"t": round(t * S), "device": "dome", "asked": "close", "phase": "asked", "said": said}


def judged(*lines: dict[str, Any], limit: float = 10, until: float = 20) -> tuple[Any, list[str]]:
    return judge(list(lines), Unsafe(2 * S, round(until * S), limit))


def test_a_roof_that_closes_in_time_is_right() -> None:
    assert judged(truth(0, "open"), truth(3, "closing"), truth(5, "closed")) == (3.0, [])


def test_a_roof_that_was_closed_all_the_time_is_right() -> None:
    assert judged(truth(0, "closed")) == (0.0, [])


def test_a_roof_that_stays_open_is_found() -> None:
    took, wrong = judged(truth(0, "open"))
    assert took is None
    assert "still open after 18.0 s of 10 s" in wrong[0]


def test_a_roof_that_closes_too_late_is_found() -> None:
    took, wrong = judged(truth(0, "open"), truth(13, "closed"))
    assert took == 11.0
    assert wrong == ["closed only after 11.0 s of 10 s"]


def test_a_roof_that_opens_again_and_stays_so_is_found() -> None:
    _, wrong = judged(truth(0, "closed"), truth(4, "opening"), truth(5, "open"))
    assert "still open after 16.0 s" in wrong[0]


def test_a_roof_that_goes_on_opening_is_found() -> None:
    _, wrong = judged(
        truth(0, "closed"), truth(1, "opening"), truth(6, "closing"), truth(7, "closed")
    )
    assert wrong == ["it opened for 4.0 s while unsafe"]


def test_a_roof_that_is_asked_too_often_is_found() -> None:
    lines = [truth(0, "open"), close(3), close(3.5), truth(5, "closed")]
    assert judged(*lines)[1] == ["asked to close twice within 0.50 s"]


def test_asked_again_after_a_foreign_open_or_by_the_domes_own_controller_is_right() -> None:
    lines = [
        truth(0, "open"), close(3), close(3.2, "by itself: no heartbeat"), truth(3.5, "closed"),
        truth(3.6, "opening"), close(3.7), truth(3.8, "closing"), truth(5, "closed"),
    ]  # fmt: skip
    assert judged(*lines)[1] == []
