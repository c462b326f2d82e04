"""Interlocks and link-loss policies as values: when something is unsafe, and what follows.

Conditions are data, not a language: nothing in a description is ever evaluated as code.
"""

from __future__ import annotations

import msgspec

from talaia.model.shape import Shape

__all__ = ["Condition", "Interlock", "LinkLossPolicy", "Step"]


class Condition(Shape, frozen=True, kw_only=True):
    """One thing that is unsafe while it holds. A value that is unknown or too old is unsafe too.

    Give ``signal`` with at least one of ``above``, ``below``, ``is`` and ``is_not`` (any of them
    is enough); with none of them only its absence is unsafe. Or give ``link_lost``.

    Attributes:
        signal: address of a number or a state, ``<device>/<signal>``.
        above: unsafe when greater, in the signal's unit.
        below: unsafe when less, in the signal's unit.
        is_one_of: unsafe in these states; written ``is`` in the description.
        is_not: unsafe in every state but these.
        max_age: a value older than this is unknown (s); none takes the signal's own.
        link_lost: unsafe when the hub has been out of reach for so long (s).

    """

    signal: str = ""
    above: float | None = None
    below: float | None = None
    is_one_of: tuple[str, ...] = msgspec.field(default=(), name="is")
    is_not: tuple[str, ...] = ()
    max_age: float | None = None
    link_lost: float | None = None


class Step(Shape, frozen=True, kw_only=True):
    """One command of a sequence.

    Attributes:
        command: ``<device>/<command>``.
        args: its arguments, by name.
        within: its end is waited for so long (s), and never beyond the command's own time-out.
        required: without success the steps behind it are not done. ``false`` goes on in any
            case once ``within`` is over: a dome that must close even if the telescope does
            not park.

    """

    command: str
    args: dict[str, float | int | bool | str] = {}
    within: float | None = None
    required: bool = True


class Interlock(Shape, frozen=True, kw_only=True):
    """What the gateway refuses and does, by itself, while something is unsafe.

    Attributes:
        when: any of these makes it unsafe, at once.
        refuse: ``<device>/<command>``, ``<device>/drive``, or ``<device>/*`` for all of a device.
        run: a sequence, begun once each time it becomes unsafe. Its commands are not refused by
            any interlock.
        dwell: safe again only after all has been safe for so long (s); begins anew with the
            gateway.
        longest_override: an admin may override it for so long at the most (s); 0 for never.

    """

    name: str
    when: tuple[Condition, ...]
    refuse: tuple[str, ...] = ()
    run: tuple[Step, ...] = ()
    dwell: float = 300.0
    longest_override: float = 3600.0


class LinkLossPolicy(Shape, frozen=True, kw_only=True):
    """What the gateway does with a device when the hub has been out of reach for a time.

    Attributes:
        after: so long (s); counted from the loss, or from the gateway's start.
        run: a sequence, begun once for each loss. A link that comes back before that calls it off.

    """

    after: float
    run: tuple[Step, ...]
