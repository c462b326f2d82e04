"""Which time the samples of a stamped message have: its own, as long as that can be true. Pure.

``header.stamp`` is when a sensor measured, before a network and a filter took their time. A robot
without a clock of the right time, a simulation (whose time begins with 0) and a recording that is
played stamp other times; then, and for messages without a stamp, the time of arrival counts. How
old a value is goes by its arrival in any case.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.errors import FieldError
from talaia.gateway.samples.source_stamps import stamp_ns_of

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["LATE_US", "HeaderTimes"]

# Filters and slow networks take less; a clock that is wrong is mostly further off.
LATE_US = 5_000_000
# A stamp that was not believed makes the next ones doubtful for so long: else the times of a clock
# that is just at the limit would jump to and fro.
_DOUBT_US = 10_000_000


class HeaderTimes:
    """Judges the stamps of one topic.

    Attributes:
        lag_us: by how much the last message's time lies before its arrival.
        headless: a class of messages of which none has a header: they need not be asked about.

    """

    __slots__ = ("_doubted_us", "_shift_us", "headless", "lag_us")

    def __init__(self, shift_us: Callable[[], int | None] | None = None) -> None:
        """Believe the first stamp, if it can be true.

        Args:
            shift_us: of a robot that goes by a clock of its own (``/clock``): what is added to its
                time to have ours (µs), none while that is not known. None: stamps are of our time.

        """
        self._shift_us = shift_us
        self.lag_us = 0
        self.headless: type | None = None
        # When a stamp came that could not be true (wall, µs); none for a topic without any.
        self._doubted_us: int | None = None

    def time_of(self, message: object, arrived_us: int) -> int:
        """Give the time of a message's samples (µs, UTC).

        Args:
            message: decoded.
            arrived_us: when it came, by the gateway's wall clock.

        """
        # By far most messages without one have none of this name.
        header = getattr(message, "header", None)
        if header is None:
            # Only of a class that is made for its type: others hold whatever a message has.
            if "header" not in getattr(type(message), "__dataclass_fields__", "header"):
                self.headless = type(message)
                self.lag_us = 0
            return arrived_us
        try:
            stamp_us = stamp_ns_of(getattr(header, "stamp", None), "header.stamp") // 1000
        except FieldError:
            self.lag_us = 0
            return arrived_us
        if self._shift_us is not None:
            shift_us = self._shift_us()
            if shift_us is None:
                self.lag_us = 0
                return arrived_us
            stamp_us += shift_us
        late_us = arrived_us - stamp_us
        self.lag_us = 0
        # The robot's clock goes a little before ours; nothing is measured after it came.
        if -LATE_US <= late_us <= 0:
            return arrived_us
        if not 0 < late_us <= LATE_US:
            self._doubted_us = arrived_us
            return arrived_us
        doubted_us = self._doubted_us
        if doubted_us is not None and 0 <= arrived_us - doubted_us < _DOUBT_US:
            return arrived_us
        self.lag_us = late_us
        return stamp_us
