"""Cross-checks of what makes a value unknown although it arrives; part of `check`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import Finding, at_least, range_fits
from talaia.model.closed_lists import SignalType

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Signal

__all__ = ["stamp_fits", "validity_fits"]


def validity_fits(where: str, signal: Signal) -> Iterator[Finding]:
    """List what is wrong with a signal's range, and with when it counts as frozen."""
    yield from range_fits(where, signal.minimum, signal.maximum)
    yield from at_least(f"{where}.frozen_after", signal.frozen_after, 0)
    if signal.frozen_after and signal.type not in (SignalType.NUMBER, SignalType.POSITION):
        problem = f"a {signal.type} may stay the same for as long as it likes"
        yield Finding(f"{where}.frozen_after", problem, "leave it out")
    # A sensor may send as rarely as that, and the same value twice: it would be called frozen.
    elif 0 < signal.frozen_after <= signal.max_age:
        problem = f"within {signal.max_age:g} s (max_age) one value may come but once"
        yield Finding(f"{where}.frozen_after", problem, "take a longer time")


# Texts are what people read; of the others interlocks and fences go by.
_JUDGED = (SignalType.NUMBER, SignalType.STATE, SignalType.POSITION)


def stamp_fits(where: str, signal: Signal, stamp: str, *, synchronized: bool) -> Iterator[Finding]:
    """List what is wrong with a value's own time, in every protocol that has one.

    Args:
        where: the signal's source.
        signal: what the value is of.
        stamp: as its source has it.
        synchronized: likewise.

    """
    if synchronized and not stamp:
        problem = "there is no stamp whose clock could agree"
        yield Finding(f"{where}.synchronized", problem, "write: stamp: header.stamp")
    if stamp and signal.type not in _JUDGED:
        problem = f"a {signal.type} is judged by no interlock"
        yield Finding(f"{where}.stamp", problem, "leave the stamp out")
