"""What keeps a simulated robot from running on this machine.

SimError
├── NoRenderer        no software renderer works here
├── CameraEnded       the drawing process ended before it could draw
├── NoFreeDomain      every ROS domain of this machine is taken
├── BadDomain         a ROS domain number that is not safe to use
├── NoTwin            the description has no twin that could be run
└── RosMissing        the ROS 2 Python packages cannot be imported
"""

from __future__ import annotations

from talaia.errors import TalaiaError

__all__ = [
    "BadDomain",
    "CameraEnded",
    "NoFreeDomain",
    "NoRenderer",
    "NoTwin",
    "RosMissing",
    "SimError",
]


class SimError(TalaiaError):
    """Base of the tree above."""


class NoRenderer(SimError):
    """Neither EGL nor OSMesa could draw a picture.

    Attributes:
        reasons: for each way that was tried, what it answered.

    """

    def __init__(self, reasons: dict[str, str]) -> None:
        """Remember what each way answered."""
        super().__init__(reasons)
        self.reasons = reasons

    def __str__(self) -> str:
        """Say what to install."""
        tried = "; ".join(f"{way}: {reason}" for way, reason in self.reasons.items())
        return (
            f"the camera of the simulated vehicle cannot be drawn here ({tried}). "
            "Install one of Debian's software renderers, `apt install libosmesa6` or "
            "`apt install libegl1 libegl-mesa0 libgl1-mesa-dri`, or run with --no-camera"
        )


class CameraEnded(SimError):
    """The process that draws ended without a word; what went wrong stands above in its output."""

    def __init__(self, code: int) -> None:
        """Remember its exit code; negative is a signal."""
        super().__init__(code)
        self.code = code

    def __str__(self) -> str:
        """Say what to do."""
        return (
            f"the camera's process ended at its start (exit code {self.code}); "
            "see its output above, or run with --no-camera"
        )


class NoFreeDomain(SimError):
    """All ROS domains that are safe on this machine are in use."""

    def __init__(self, first: int, last: int) -> None:
        """Remember which domains were tried."""
        super().__init__(first, last)
        self.first = first
        self.last = last

    def __str__(self) -> str:
        """Say what to do."""
        return (
            f"every ROS domain from {self.first} to {self.last} is in use on this machine; "
            "end another demo or test, or name one with --domain"
        )


class BadDomain(SimError):
    """A domain number outside the range whose ports are free on Linux."""

    def __init__(self, domain: int, first: int, last: int) -> None:
        """Remember the number and the range."""
        super().__init__(domain, first, last)
        self.domain = domain
        self.first = first
        self.last = last

    def __str__(self) -> str:
        """Say which numbers may be used."""
        return f"ROS domain {self.domain}: expected a number from {self.first} to {self.last}"


class NoTwin(SimError):
    """A description without the twin that was asked for; its text says what to do."""


class RosMissing(SimError):
    """The ROS 2 packages are not importable."""

    def __init__(self, reason: str) -> None:
        """Remember what the import said."""
        super().__init__(reason)
        self.reason = reason

    def __str__(self) -> str:
        """Say what to install."""
        return (
            f"the ROS 2 packages cannot be imported ({self.reason}); "
            "run `pip install 'talaia[sim]'`, or source the ROS installation of this machine"
        )
