"""How long a sign-in must wait after wrong ones: by person, and by address. Pure.

No account is ever locked for good: the wait for a person grows to a minute and is forgotten
after a quarter of an hour without a wrong try.
"""

from __future__ import annotations

from dataclasses import dataclass

from talaia.clock import SECOND

__all__ = ["Throttle"]


@dataclass(slots=True)
class _Tries:
    wrong: int = 0
    last_ns: int = 0


@dataclass(frozen=True, slots=True)
class _Rule:
    """So many wrong tries are free; each one more doubles the wait, up to ``longest_s``."""

    free: int
    longest_s: int


_BY_USER = _Rule(free=5, longest_s=60)
_BY_ADDRESS = _Rule(free=20, longest_s=60)
_FORGET_NS = 900 * SECOND
_MOST_KEPT = 10_000


class Throttle:
    """Counts wrong tries. Times are the hub's monotonic nanoseconds."""

    def __init__(self) -> None:
        """Start with a clean slate."""
        self._users: dict[str, _Tries] = {}
        self._addresses: dict[str, _Tries] = {}

    def wait_ns(self, user: str, address: str, now_ns: int) -> int:
        """Tell how long this person at this address must wait; 0 when they may try now."""
        return max(
            _wait(self._users.get(user), _BY_USER, now_ns),
            _wait(self._addresses.get(address), _BY_ADDRESS, now_ns),
        )

    def tried(self, user: str, address: str, now_ns: int) -> None:
        """Count a try as wrong, before it is looked at: many at once must not slip through."""
        for table, key in ((self._users, user), (self._addresses, address)):
            tries = table.pop(key, None)
            if tries is None or now_ns - tries.last_ns > _FORGET_NS:
                tries = _Tries()
            tries.wrong += 1
            tries.last_ns = now_ns
            # Put at the end again: the table is in the order of the last try.
            table[key] = tries
            if len(table) > _MOST_KEPT:
                del table[next(iter(table))]

    def succeeded(self, user: str, address: str) -> None:
        """Forget the person's wrong tries, and take this one off the address's count."""
        self._users.pop(user, None)
        tries = self._addresses.get(address)
        if tries is not None:
            tries.wrong = max(0, tries.wrong - 1)


def _wait(tries: _Tries | None, rule: _Rule, now_ns: int) -> int:
    if tries is None or tries.wrong < rule.free or now_ns - tries.last_ns > _FORGET_NS:
        return 0
    doublings = min(tries.wrong - rule.free, 16)
    wait = min(1 << doublings, rule.longest_s) * SECOND
    return max(0, tries.last_ns + wait - now_ns)
