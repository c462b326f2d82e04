"""How long a sign-in must wait after wrong ones: by person, by address and by browser. Pure.

No account is ever locked for good: the wait for a person grows to a minute and is forgotten
after a quarter of an hour without a wrong try. A browser from which the person has signed in
before has a count of its own, so that whoever floods the sign-in with wrong tries does not hold
the person back.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["FORGET_NS", "AttemptKind", "CountedAttempts", "Throttle"]


class AttemptKind(StrEnum):
    """What wrong tries are counted by."""

    USER = "user"
    ADDRESS = "address"
    BROWSER = "browser"


class CountedAttempts(NamedTuple):
    """A count as it is kept; 0 wrong tries: forget it."""

    kind: AttemptKind
    key: str
    wrong: int
    last_ns: int


@dataclass(slots=True)
class _Tries:
    # Not forgotten yet; and when the last was (ns of the clock that `Throttle` is given).
    wrong: int = 0
    last_ns: int = 0


@dataclass(frozen=True, slots=True)
class _Rule:
    """So many wrong tries are free; each one more doubles the wait, up to ``longest_s``."""

    free: int
    longest_s: int


# An address may be shared by a whole institute, so more of its tries are free.
_RULES = {
    AttemptKind.USER: _Rule(free=5, longest_s=60),
    AttemptKind.ADDRESS: _Rule(free=20, longest_s=60),
    AttemptKind.BROWSER: _Rule(free=5, longest_s=60),
}
FORGET_NS = 900 * SECOND  # without a wrong try for so long, a count begins anew
_MOST_KEPT = 10_000  # of each kind; then the one whose last try is oldest goes


class Throttle:
    """Counts wrong tries. Times are nanoseconds of one clock, the wall's where they are kept.

    ``browser`` names one from which this very person has signed in before, else it is empty;
    where it is given it is the only thing that counts.
    """

    def __init__(self) -> None:
        """Start with a clean slate."""
        # By kind and by the hash of what is counted, in the order of the last try.
        self._tries: dict[AttemptKind, dict[str, _Tries]] = {kind: {} for kind in AttemptKind}
        # What is not written down yet; taken, and cleared, by `changed_attempts`.
        self._changed: set[tuple[AttemptKind, str]] = set()

    def wait_ns(self, user: str, address: str, now_ns: int, browser: str = "") -> int:
        """Tell how long this person at this address must wait; 0 when they may try now."""
        return max(
            _wait_time(self._tries[kind].get(key), _RULES[kind], now_ns)
            for kind, key in _attempt_keys(user, address, browser)
        )

    def count_attempt(self, user: str, address: str, now_ns: int, browser: str = "") -> None:
        """Count a try as wrong, before it is looked at: many at once must not slip through."""
        for kind, key in _attempt_keys(user, address, browser):
            table = self._tries[kind]
            tries = table.pop(key, None)
            # One from the future counts as old, too: a clock that was set back leaves it behind.
            if tries is None or abs(now_ns - tries.last_ns) > FORGET_NS:
                tries = _Tries()
            tries.wrong += 1
            tries.last_ns = now_ns
            # Put at the end again: the table is in the order of the last try.
            table[key] = tries
            self._changed.add((kind, key))
            if len(table) > _MOST_KEPT:
                # Its row in the database goes by age, not by this.
                del table[next(iter(table))]

    def clear_attempts(self, user: str, address: str, browser: str = "") -> None:
        """Forget the person's wrong tries, and take this one off the address's count."""
        for kind, key in _attempt_keys(user, address, browser):
            # One who knows one account's password must not wipe out tries at the others.
            if kind is AttemptKind.ADDRESS:
                self._decrement_count(kind, key)
            elif self._tries[kind].pop(key, None) is not None:
                self._changed.add((kind, key))

    def uncount_attempt(self, user: str, address: str, browser: str = "") -> None:
        """Take this one try off every count: it was not wrong, and not all that is needed."""
        for kind, key in _attempt_keys(user, address, browser):
            self._decrement_count(kind, key)

    def bring_back(self, counts: Iterable[CountedAttempts]) -> None:
        """Remember what was counted before, the oldest first."""
        for kind, key, wrong, last_ns in counts:
            # The oldest first keeps the table in the order of the last try.
            self._tries[kind][key] = _Tries(wrong, last_ns)

    def changed_attempts(self) -> list[CountedAttempts]:
        """Give what changed since this was last asked, to be kept."""
        changed, self._changed = self._changed, set()
        return [
            CountedAttempts(kind, key, tries.wrong if tries else 0, tries.last_ns if tries else 0)
            for kind, key in changed
            for tries in (self._tries[kind].get(key),)
        ]

    def _decrement_count(self, kind: AttemptKind, key: str) -> None:
        tries = self._tries[kind].get(key)
        if tries is not None:
            tries.wrong = max(0, tries.wrong - 1)
            self._changed.add((kind, key))


def _attempt_keys(user: str, address: str, browser: str) -> list[tuple[AttemptKind, str]]:
    # A known browser: what others do to this account or from this network is no matter.
    if browser:
        return [(AttemptKind.BROWSER, _hash_key(browser))]
    return [(AttemptKind.USER, _hash_key(user)), (AttemptKind.ADDRESS, _hash_key(address))]


def _hash_key(text: str) -> str:
    # People type passwords where the name belongs; these are not kept.
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def _wait_time(tries: _Tries | None, rule: _Rule, now_ns: int) -> int:
    if tries is None or tries.wrong < rule.free or abs(now_ns - tries.last_ns) > FORGET_NS:
        return 0
    # Bounded, so that a long flood makes no huge number.
    doublings = min(tries.wrong - rule.free, 16)
    wait = min(1 << doublings, rule.longest_s) * SECOND
    # A wall clock that was set back must not make anyone wait longer than the rule says.
    return max(0, min(wait, tries.last_ns + wait - now_ns))
