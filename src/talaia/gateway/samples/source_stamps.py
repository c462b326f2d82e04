"""When a time stamp that a robot gives its values advanced last, by the gateway's clock. Pure."""

from __future__ import annotations

import math
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.gateway.errors import FieldError

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.model.connection import RosSource

__all__ = ["StampAge", "StampReader", "iso_stamp_ns", "stamp_ns_of"]


class StampAge:
    """The memory of one row of stamps.

    Whether the robot's clock is right does not matter: what counts is that it goes on. A stamp that
    steps back (its clock was set) is no progress, and the next is measured by it.
    """

    __slots__ = ("_advanced_ns", "_newest_ns", "_proven")

    def __init__(self, *, proven: bool = False) -> None:
        """Start without any.

        Args:
            proven: the first stamp counts as progress, because its lag behind the gateway's clock
                is looked at as well. Otherwise it proves nothing: it may be as old as it likes.

        """
        self._proven = proven  # The first stamp alone proves that the robot's clock goes on.
        # The newest stamp (robot's ns), even one that stepped back.
        self._newest_ns: int | None = None
        self._advanced_ns: int | None = None  # When a stamp last advanced (our monotonic ns).

    def add_stamp(self, stamp_ns: int, mono_ns: int) -> int | None:
        """Take the stamp of a message; give when a stamp advanced last, none if none ever did.

        Args:
            stamp_ns: the robot's own time.
            mono_ns: when the message came, by the gateway's monotonic clock.

        """
        newest, self._newest_ns = self._newest_ns, stamp_ns
        if stamp_ns > newest if newest is not None else self._proven:
            self._advanced_ns = mono_ns
        return self._advanced_ns


class StampReader:
    """Reads the stamp of one signal in each message, and keeps how it went on."""

    def __init__(self, get: Callable[[object], object], source: RosSource) -> None:
        """Find it by ``get``, the compiled path ``source.stamp``."""
        # Compiled once: it runs for each message.
        self._get, self._path = get, source.stamp
        self._age = StampAge(proven=source.synchronized)

    def read_stamp(self, message: object, mono_ns: int) -> tuple[int, int | None]:
        """Give the stamp (ns) of a message, and when one advanced last; see `StampAge.add_stamp`.

        Raises:
            FieldError: there is none.

        """
        stamp_ns = stamp_ns_of(self._get(message), self._path)
        return stamp_ns, self._age.add_stamp(stamp_ns, mono_ns)


def stamp_ns_of(value: object, path: str) -> int:
    """Read a stamp: a time of ROS 2 or ROS 1, or a number of seconds.

    Raises:
        FieldError: it is none of them.

    """
    # ROS 2, ROS 1 in Python (genpy), and ROS 1 as rosbridge sends it.
    for whole, part in (("sec", "nanosec"), ("secs", "nsecs"), ("sec", "nsec")):
        seconds, rest = getattr(value, whole, None), getattr(value, part, None)
        if isinstance(seconds, int) and isinstance(rest, int):
            return seconds * SECOND + rest
    # bool is an int to Python, but no time.
    if isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value):
        return round(value * SECOND)
    raise FieldError(path, "is no time; name a stamp, such as header.stamp")


def iso_stamp_ns(text: str) -> int:
    """Read INDI's ``timestamp`` (ISO 8601, UTC) as ns since the epoch; 0 when it is none."""
    try:
        at = datetime.fromisoformat(text.strip())
    except ValueError:
        # INDI's timestamps carry no zone; the protocol says that they are UTC.
        return 0
    return round((at.replace(tzinfo=at.tzinfo or UTC)).timestamp() * SECOND)
