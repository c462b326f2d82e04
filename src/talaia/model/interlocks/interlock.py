"""Interlocks and link-loss policies as values: when something is unsafe, and what follows.

Conditions are data, not a language: nothing in a description is ever evaluated as code.
"""

from __future__ import annotations

from enum import StrEnum

import msgspec

from talaia.model.base import Shape

__all__ = ["Condition", "Interlock", "LinkLossPolicy", "Overriding", "Step", "SunAngle"]


class Overriding(StrEnum):
    """Whether a condition may be overridden.

    ``auto``: unless it is rain, a lost link or somebody on site, as far as that can be told.
    ``never``: in no case.
    """

    AUTO = "auto"
    NEVER = "never"


class SunAngle(StrEnum):
    """What is asked of the Sun. ``altitude``: above the horizon (°); below it negative."""

    ALTITUDE = "altitude"


class Condition(Shape, frozen=True, kw_only=True):
    """One thing that is unsafe while it holds. A value that is unknown or too old is unsafe too.

    Give ``signal`` with at least one of ``above``, ``below``, ``is`` and ``is_not`` (any of them
    is enough); with none of them only its absence is unsafe. Or give ``sun`` with one of the
    limits, or ``link_lost``. Or give a ``signal`` that is a position, with ``inside`` or
    ``outside``. Or give ``all``: conditions that are harmless one by one and unsafe
    together.

    Attributes:
        signal: address of a number or a state, ``<device>/<signal>``.
        minus: address of a number in the same unit: what the limits are for is ``signal`` less
            this one, such as temperature less dew point.
        humidity: address of the relative humidity (%) beside a ``signal`` that is the air's
            temperature (°C): what the limits are for is the temperature less the dew point, which
            is computed (Magnus).
        sun: ``altitude``: the limits are for the Sun's altitude (°) at the site's ``place``, by
            the gateway's clock.
        inside: a polygon of the map's zones: unsafe while the position ``signal`` is in it.
        outside: a polygon of the map's zones: unsafe while the position ``signal`` is not in it.
        margin: of ``inside`` and ``outside``: unsafe already so near to the zone's edge (m). Give
            what the position may be wrong by, and the way that the robot needs to stand.
        above: unsafe when greater, in the signal's unit.
        until_below: once it was above, unsafe until it is less than this.
        below: unsafe when less, in the signal's unit.
        until_above: once it was below, unsafe until it is greater than this.
        is_one_of: unsafe in these states; written ``is`` in the description.
        is_not: unsafe in every state but these.
        max_age: a value older than this is unknown (s); none takes the signal's own.
        all_of: unsafe while every one of these is, one that is unknown included; written ``all``.
            At least two, and none that is itself an ``all``.
        link_lost: unsafe when the hub has been out of reach for so long (s).
        lasting: unsafe only after it has held for so long (s), or for so long in all within twice
            that time, so that weather that comes and goes counts; a value that is unknown is
            unsafe at once.
        dwell: once it was unsafe, all must be safe for at least so long (s); none takes the
            interlock's own. With several limits of one signal it makes a ladder.
        override: ``never`` to let nobody override it. Rain, a lost link and somebody on site are
            never overridden anyhow, and nothing is while it is unknown.

    """

    signal: str = ""
    minus: str = ""
    humidity: str = ""
    sun: SunAngle | None = None
    inside: str = ""
    outside: str = ""
    margin: float = 0.0
    above: float | None = None
    until_below: float | None = None
    below: float | None = None
    until_above: float | None = None
    is_one_of: tuple[str, ...] = msgspec.field(default=(), name="is")
    is_not: tuple[str, ...] = ()
    max_age: float | None = None
    link_lost: float | None = None
    all_of: tuple[Condition, ...] = msgspec.field(default=(), name="all")
    lasting: float = 0.0
    dwell: float | None = None
    override: Overriding = Overriding.AUTO

    @property
    def zone(self) -> str:
        """Name the zone that it looks at; empty for none."""
        return self.inside or self.outside

    def zones(self) -> tuple[str, ...]:
        """Name all zones that it looks at, those of its ``all`` among them."""
        own = (self.zone,) if self.zone else ()
        return (*own, *(name for part in self.all_of for name in part.zones()))

    def signals(self) -> tuple[str, ...]:
        # Each condition of an ``all`` names its own.
        """Name all signals that it looks at, those of its ``all`` among them."""
        own = tuple(address for address in (self.signal, self.minus, self.humidity) if address)
        return (*own, *(name for part in self.all_of for name in part.signals()))


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
    """What the gateway refuses, slows down and does, by itself, while something is unsafe.

    Attributes:
        when: any of these makes it unsafe, at once.
        refuse: ``<device>/<command>``, ``<device>/drive``, or ``<device>/*`` for all of a device.
        slow: ``<device>/drive``, and at which share of its limits it may be driven, above 0 and
            below 1.
        run: a sequence, begun once each time it becomes unsafe. Its commands are not refused by
            any interlock.
        dwell: safe again only after all has been safe for so long (s); begins anew with the
            gateway.
        longest_override: an admin may override one of its conditions for so long at the most (s);
            0 for never. More than 1800 counts as 1800.

    """

    name: str
    when: tuple[Condition, ...]
    refuse: tuple[str, ...] = ()
    slow: dict[str, float] = {}
    run: tuple[Step, ...] = ()
    dwell: float = 300.0
    longest_override: float = 1800.0


class LinkLossPolicy(Shape, frozen=True, kw_only=True):
    """What the gateway does with a device when the hub has been out of reach for a time.

    Attributes:
        after: so long (s); counted from the loss, or from the gateway's start.
        run: a sequence, begun once for each loss. A link that comes back before that calls it off.

    """

    after: float
    run: tuple[Step, ...]
