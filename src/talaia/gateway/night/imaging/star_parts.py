"""What a night asks of the parts that look at stars: focus, place, guiding. Promises only.

Each is called off the event loop by the night's shell, in a time that it bounds itself; what it
needs of the devices it asks by commands, as the night does. A site without such a part has its
absent one, which is left out of blocks.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

__all__ = [
    "AbsentPart",
    "AutoFocuser",
    "AutoGuider",
    "DeviceFailed",
    "FieldCentre",
    "FocusOutlook",
    "PartOutcome",
    "PlateSolver",
]


class DeviceFailed(Exception):
    """A device did not do what it was asked; the words are its own."""


class PartOutcome(NamedTuple):
    """How a part ended.

    Attributes:
        good: it reached what it was for.
        message: in words: *focus at 12 450, FWHM 2.1″*, or why it failed.
        place: where the mount was sent (h, °, of date) for the field to be centred; none: it stood.
        seeing: FWHM of the stars that it saw (″); none: it measured none.

    """

    good: bool
    message: str = ""
    place: tuple[float, float] | None = None
    seeing: float | None = None


class FieldCentre(NamedTuple):
    """Where a field is to be centred (ICRS, °), how well (″), and through which filter."""

    ra: float
    dec: float
    within: float = 5.0
    filter: str = ""


class FocusOutlook(NamedTuple):
    """How a site is focused.

    Attributes:
        filter_name: of the last run.
        ago: it was so long ago (s).
        every: the next is due so long after it (s), by the clock or as the tube cools just now.
        again: why then, in words.

    """

    filter_name: str
    ago: float
    every: float
    again: str


class AutoFocuser(Protocol):
    """Brings the camera into focus on the field that the telescope tracks."""

    @property
    def present(self) -> bool:
        """Whether there is one."""
        ...

    def is_due(self, filter_name: str, temperature: float | None, time: float) -> bool:
        """Tell whether another filter, another temperature or the time asks for a run."""
        ...

    def outlook(self, temperature: float | None, time: float) -> FocusOutlook | None:
        """Tell of the last run, and when the next is due; none: there was none yet."""
        ...

    async def run_focus(self, filter_name: str) -> PartOutcome:
        """Find the best focus; ends by itself."""
        ...


class PlateSolver(Protocol):
    """Finds where the camera looks, and brings the telescope onto the field."""

    @property
    def present(self) -> bool:
        """Whether there is one."""
        ...

    async def centre_field(self, centre: FieldCentre) -> PartOutcome:
        """Take a picture, solve it, and move until the field is centred; ends by itself."""
        ...


class AutoGuider(Protocol):
    """Holds a star while the camera exposes."""

    @property
    def present(self) -> bool:
        """Whether there is one."""
        ...

    async def begin_guiding(self) -> PartOutcome:
        """Find a star and guide on it; ends when it is settled, or cannot be."""
        ...

    async def dither_star(self, arcseconds: float) -> PartOutcome:
        """Move the field so far at the most, in a random direction, and settle again."""
        ...

    async def end_guiding(self) -> PartOutcome:
        """Guide no longer."""
        ...

    def lost_reason(self) -> str:
        """Say why the star is not held now; empty while it is, or nobody guides."""
        ...


class AbsentPart:
    """A `AutoFocuser`, `PlateSolver` and `AutoGuider` for a site that has none."""

    present = False

    def is_due(self, filter_name: str, temperature: float | None, time: float) -> bool:
        """Never."""
        return False

    def outlook(self, temperature: float | None, time: float) -> FocusOutlook | None:
        """Nothing."""
        return None

    async def run_focus(self, filter_name: str) -> PartOutcome:
        """Do nothing."""
        return PartOutcome(good=False, message="there is no focuser")

    async def centre_field(self, centre: FieldCentre) -> PartOutcome:
        """Do nothing."""
        return PartOutcome(good=False, message="there is no plate solver")

    async def begin_guiding(self) -> PartOutcome:
        """Do nothing."""
        return PartOutcome(good=False, message="there is no guider")

    async def dither_star(self, arcseconds: float) -> PartOutcome:
        """Do nothing."""
        return PartOutcome(good=False, message="there is no guider")

    async def end_guiding(self) -> PartOutcome:
        """Do nothing."""
        return PartOutcome(good=True)

    def lost_reason(self) -> str:
        """Nobody guides."""
        return ""
