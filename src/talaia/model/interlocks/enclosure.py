"""What an observatory needs beyond interlocks, as values.

A roof that must be closed, a telescope that must not point everywhere, a dome that follows.
"""

from __future__ import annotations

from enum import StrEnum

import msgspec

from talaia.model.base import Shape
from talaia.model.interlocks.interlock import Step  # noqa: TC001 - msgspec reads it

__all__ = [
    "ClosingOrder",
    "Enclosure",
    "EnclosureCapabilities",
    "EnclosurePart",
    "Follow",
    "Heartbeat",
    "PastDeadline",
    "Place",
    "Pointing",
    "PointingArguments",
    "Sighting",
]


class Sighting(Shape, frozen=True, kw_only=True):
    """What a sensor says when something is so. A value that is unknown or too old says nothing.

    Attributes:
        signal: address of a state or a number.
        is_one_of: of a state: in these it is so; written ``is`` in the description.
        above: of a number: it is so while it is greater, in the signal's unit.
        below: of a number: it is so while it is less.

    """

    signal: str
    is_one_of: tuple[str, ...] = msgspec.field(default=(), name="is")
    above: float | None = None
    below: float | None = None


class ClosingOrder(StrEnum):
    """Whether the telescope stands in the way of the roof.

    ``close_first``: the roof clears the telescope in every position. ``parallel``: both at once.
    ``mount_first``: the roof waits for the parked telescope, but not for ever.
    """

    CLOSE_FIRST = "close_first"
    PARALLEL = "parallel"
    MOUNT_FIRST = "mount_first"


class PastDeadline(StrEnum):
    """What happens when the telescope is not parked in time: close all the same, or only alarm."""

    CLOSE = "close"
    ALARM = "alarm"


class Follow(Shape, frozen=True, kw_only=True):
    """A dome that turns its slit to where the telescope points, and never chases one that slews.

    Where the telescope's description says where its commands point (`Pointing`), the dome sets off
    to the end of a slew together with it.

    Attributes:
        target: address of the telescope's azimuth (°).
        azimuth: address of the dome's azimuth (°).
        when: the telescope stands on its target.
        command: turns the dome, ``<device>/<command>``.
        argument: of the command: the azimuth (°).
        within: so far apart they may be (°).
        every: asked at most so often (s).
        moving: the telescope is on its way; the commands of ``before`` wait for its end.
        open: the slit is open; the commands of ``before`` wait for it, and are refused while the
            roof is closed.
        before: commands that are begun only with telescope and dome in place: exposures.
        wait: they wait at most so long (s), and fail then.

    """

    target: str
    azimuth: str
    when: Sighting
    command: str
    argument: str = "azimuth"
    within: float = 5.0
    every: float = 5.0
    moving: Sighting | None = None
    open: Sighting | None = None
    before: tuple[str, ...] = ()
    wait: float = 120.0


class Heartbeat(Shape, frozen=True, kw_only=True):
    """A sign of life for the enclosure's own controller, which closes by itself without it.

    It is sent only while the gateway judges its interlocks and can read the enclosure's sensors.
    It is not written into the journal of commands, and no interlock refuses it.

    Attributes:
        command: ``<device>/<command>``; a service or a topic of the controller.
        args: its arguments, by name.
        every: so often (s); at most a third of what the controller waits for.

    """

    command: str
    args: dict[str, float | int | bool | str] = {}
    every: float = 2.0


class EnclosurePart(Shape, frozen=True, kw_only=True):
    """A part of a roof that is closed or open by itself: a segment of a clamshell, a flap.

    Attributes:
        closed: it is closed only when all of these say so.
        position: address of how far it is open (%), or empty.
        close: its own command, where that of the enclosure does not close it.

    """

    name: str
    closed: tuple[Sighting, ...]
    position: str = ""
    close: Step | None = None


class EnclosureCapabilities(Shape, frozen=True, kw_only=True):
    """What an enclosure can do. What is left out follows from the rest of its description.

    Attributes:
        has_shutter: it opens and closes.
        can_rotate: it turns; a dome with a slit does, a clamshell and a sliding roof do not. It
            follows from ``follow``, or from a command that takes an angle.
        segments: how many parts it opens in; it follows from ``segments``.
        can_partial: it may stand partly open; it follows from ``stop`` or a ``position``.
        has_flap: a part that opens by itself, below the shutter; it follows from ``flap``.

    """

    has_shutter: bool | None = None
    can_rotate: bool | None = None
    segments: int | None = None
    can_partial: bool | None = None
    has_flap: bool | None = None


class Enclosure(Shape, frozen=True, kw_only=True):
    """A roof over instruments, and how it is brought to be closed for as long as it must be.

    Attributes:
        unsafe: interlocks that want it closed while they lock, once something was unsafe.
        closed: it is closed only when all of these say so: end switches, its position. Sensors
            that disagree count as sensors that say nothing, and so as not closed.
        segments: its parts, where it opens in several; it is closed only when each is.
        flap: what opens by itself beside the shutter; it is closed only when that is, too.
        position: address of how far it is open (%), or empty.
        capabilities: what it can do; see `EnclosureCapabilities`.
        disagree_after: sensors that disagree for so long (s) are an event.
        moving: it moves when any of these says so.
        opening: it opens when any of these says so; then it is stopped or turned at once when it
            must be closed. Without it every signal of ``closed`` and ``moving`` that has a state
            ``opening`` is asked for that.
        close: its command; asked again until the sensors say closed.
        stop: address of the command by which people stop it, or empty. A closing that a person
            has stopped is resumed by a person only, by the command of ``close``.
        abort: done at once and not waited for: end the exposure, stop slaving.
        park: parks the telescope.
        parked: the telescope is parked.
        order: see `ClosingOrder`.
        mount_within: with ``mount_first`` the roof waits so long for the telescope (s).
        past_deadline: what then.
        move_within: one closing takes at most so long (s).
        retries: closings that are asked for before it counts as *not closed*.
        alarm_every: the alarm is said again so often until it is over (s).
        follow: see `Follow`; off while it must be closed.
        heartbeat: see `Heartbeat`; none where its controller takes none.
        watchdog_after: a process beside the gateway closes it when the gateway is dead or stands
            still for so long (s), whatever the weather; 0 for never.

    """

    name: str
    unsafe: tuple[str, ...]
    closed: tuple[Sighting, ...]
    close: Step
    moving: tuple[Sighting, ...] = ()
    opening: tuple[Sighting, ...] = ()
    stop: str = ""
    abort: tuple[Step, ...] = ()
    park: Step | None = None
    parked: Sighting | None = None
    # Where nobody says it, the roof may not clear the telescope.
    order: ClosingOrder = ClosingOrder.MOUNT_FIRST
    mount_within: float = 60.0
    # A telescope that does not park must not keep the roof open.
    past_deadline: PastDeadline = PastDeadline.CLOSE
    move_within: float = 60.0
    retries: int = 3
    alarm_every: float = 60.0
    follow: Follow | None = None
    heartbeat: Heartbeat | None = None
    watchdog_after: float = 10.0
    segments: dict[str, EnclosurePart] = {}
    flap: EnclosurePart | None = None
    position: str = ""
    capabilities: EnclosureCapabilities | None = None
    # Switches of a roof change one after the other, some seconds apart.
    disagree_after: float = 10.0

    def parts(self) -> dict[str, EnclosurePart]:
        """Give segments and flap by name."""
        return {**self.segments, **({} if self.flap is None else {"flap": self.flap})}


class Place(Shape, frozen=True, kw_only=True):
    """Where the site is on Earth.

    Attributes:
        latitude: degrees north (WGS 84).
        longitude: degrees east.
        elevation: above the sea (m).

    """

    latitude: float
    longitude: float
    elevation: float = 0.0


class PointingArguments(Shape, frozen=True, kw_only=True):
    """Which arguments of a command say where it points: ``ra`` and ``dec``, or ``alt`` and ``az``.

    Attributes:
        ra: name of the argument with the right ascension (h, of date).
        dec: with the declination (°, of date).
        alt: with the altitude (°).
        az: with the azimuth (°, from north through east).

    """

    ra: str = ""
    dec: str = ""
    alt: str = ""
    az: str = ""


class Pointing(Shape, frozen=True, kw_only=True):
    """Where a telescope may not point. Needs the site's ``place``.

    Attributes:
        commands: what points it, by the device's own command names.
        horizon: lowest altitude (°).
        sun: least distance from the Sun (°) while that is higher than 6° below the horizon.

    """

    commands: dict[str, PointingArguments]
    horizon: float = 10.0
    sun: float = 30.0
