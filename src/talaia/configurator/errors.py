"""What cannot be done in the configurator.

ConfiguratorError
├── NoSuchPlace       the description has nothing at a path
├── BadValue          what was typed is not a value of that field
├── BadHost           not the name of a computer that ssh may be given
├── WordTaken         there is something of that name already
├── FileChanged       somebody else has written the file since it was opened
├── NotWritten        the file cannot be written
└── ImpossibleStep    a piece of work was told something that its state does not allow
"""

from __future__ import annotations

from talaia.errors import TalaiaError

__all__ = [
    "BadHost",
    "BadValue",
    "ConfiguratorError",
    "FileChanged",
    "ImpossibleStep",
    "NoSuchPlace",
    "NotWritten",
    "WordTaken",
]


class ConfiguratorError(TalaiaError):
    """What was asked for in the window cannot be done."""


class NoSuchPlace(ConfiguratorError):
    """The description has nothing at this path."""


class BadValue(ConfiguratorError):
    """What was typed is not a value of that field."""


class BadHost(ConfiguratorError):
    """Not the name of a computer that ssh may be given."""


class WordTaken(ConfiguratorError):
    """There is something of that name already."""


class FileChanged(ConfiguratorError):
    """Somebody else has written the file since it was opened."""


class NotWritten(ConfiguratorError):
    """The file cannot be written."""


class ImpossibleStep(ConfiguratorError):
    """The work's state does not allow this."""

    def __init__(self, state: str, step: str) -> None:
        """Say which state and which step."""
        super().__init__(state, step)
        self.state, self.step = state, step

    def __str__(self) -> str:
        return f"work that is {self.state} cannot become {self.step}"
