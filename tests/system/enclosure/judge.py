"""What a simulated roof really did, from its own ledger. Pure.

The ledger has a line for each change of the real position (``truth``), whatever the sensors said,
and one for each request. All times are the ledger's own (monotonic, ns).
"""

from __future__ import annotations

from typing import Any, NamedTuple

__all__ = ["Line", "Span", "Unsafe", "asked_too_often", "judge", "open_spans", "truth_at"]

Line = dict[str, Any]
SECOND = 1_000_000_000
CLOSED = "closed"
# Rule 7: a roof is asked to close at most once a second, unless it was opened in between.
LEAST_APART_S = 1.0
# A request and the next one may be held up differently on their way.
JITTER_S = 0.15


class Span(NamedTuple):
    """A time in which the roof was not closed; ``words`` are the truths in it, with their time."""

    began: int
    ended: int | None
    words: tuple[tuple[int, str], ...]


class Unsafe(NamedTuple):
    """From when to when it had to be closed, and how long that may take.

    Attributes:
        since: unsafe, unknown or unsupervised from here; or, where an obstacle stood in the way,
            from its end.
        until: the end of what is judged.
        limit_s: closed within.
        turn_s: what opens may do so for as long after that.
        rated: whether the rate of requests is judged.

    """

    since: int
    until: int
    limit_s: float
    turn_s: float = 3.0
    rated: bool = True


def truths(lines: list[Line]) -> list[tuple[int, str]]:
    """Give the changes of the real position."""
    return [(each["t"], each["said"]) for each in lines if each["phase"] == "truth"]


def truth_at(lines: list[Line], at: int) -> str:
    """Give how the roof stood at a moment; empty before the first line."""
    return next((word for t, word in reversed(truths(lines)) if t <= at), "")


def open_spans(lines: list[Line], since: int, until: int) -> list[Span]:
    """Give the times between two moments in which the roof was not closed."""
    changes = [(since, truth_at(lines, since))]
    changes += [(t, word) for t, word in truths(lines) if since < t <= until]
    spans: list[Span] = []
    words: list[tuple[int, str]] = []
    for t, word in changes:
        if word == CLOSED:
            if words:
                spans.append(Span(words[0][0], t, tuple(words)))
            words = []
        else:
            words.append((t, word))
    if words:
        spans.append(Span(words[0][0], None, tuple(words)))
    return spans


def judge(lines: list[Line], unsafe: Unsafe) -> tuple[float | None, list[str]]:
    """Say after how long it was closed (s; none: not at all), and what must not have been."""
    spans = open_spans(lines, unsafe.since, unsafe.until)
    wrong: list[str] = []
    for number, span in enumerate(spans):
        end = unsafe.until if span.ended is None else span.ended
        took = (end - span.began) / SECOND
        if span.ended is None and took <= unsafe.limit_s and number:
            continue
        if span.ended is None or took > unsafe.limit_s:
            still = "still open" if span.ended is None else "closed only"
            wrong.append(f"{still} after {took:.1f} s of {unsafe.limit_s:g} s")
        wrong += _opening(span, end, unsafe.turn_s)
    if unsafe.rated:
        wrong += asked_too_often(lines, unsafe.since, unsafe.until)
    first = spans[0] if spans else None
    if first is None:
        return 0.0, wrong
    return (None if first.ended is None else (first.ended - unsafe.since) / SECOND), wrong


def _opening(span: Span, end: int, turn_s: float) -> list[str]:
    wrong = []
    for (t, word), following in zip(span.words, [*span.words[1:], (end, "")], strict=True):
        lasted = (following[0] - t) / SECOND
        if word == "opening" and lasted > turn_s:
            wrong.append(f"it opened for {lasted:.1f} s while unsafe")
    return wrong


def asked_too_often(lines: list[Line], since: int, until: int) -> list[str]:
    """Say where it was asked to close twice within a second, and not opened in between."""
    wrong = []
    before: int | None = None
    for each in lines:
        if each["device"] != "dome" or not since <= each["t"] <= until:
            continue
        if each["asked"] == "open" or each["said"] == "opening":
            before = None
        elif (
            each["asked"] == "close"
            and each["phase"] in ("asked", "answered")
            and "by itself" not in each["said"]
        ):
            if before is not None and (each["t"] - before) / SECOND < LEAST_APART_S - JITTER_S:
                apart = (each["t"] - before) / SECOND
                wrong.append(f"asked to close twice within {apart:.2f} s")
            before = each["t"]
    return wrong
