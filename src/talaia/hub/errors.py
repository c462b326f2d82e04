"""What can be wrong with the hub itself.

HubError
├── CannotStart       a setting, a file or the port keeps the hub from starting
├── StoreError        the database cannot be opened or refuses
├── NameTaken         there is a person of that name already
├── UnknownPerson     there is nobody of that name
├── UnknownRole       there is no role of that name
├── HistoryError      history.errors: samples cannot be kept or read
└── WeakPassword      the password is too short or too long
"""

from __future__ import annotations

from talaia.errors import TalaiaError

__all__ = [
    "CannotStart",
    "HubError",
    "NameTaken",
    "StoreError",
    "UnknownPerson",
    "UnknownRole",
    "WeakPassword",
]


class HubError(TalaiaError):
    """Base of the hub's errors; a sentence for people, with what to do."""

    def __init__(self, problem: str, remedy: str = "") -> None:
        """Keep problem and remedy apart, so a form can show each where it belongs."""
        super().__init__(problem, remedy)
        self.problem = problem
        self.remedy = remedy

    def __str__(self) -> str:
        return f"{self.problem}; {self.remedy}" if self.remedy else self.problem


class CannotStart(HubError):
    """A setting, a file or the port keeps the hub from starting."""


class StoreError(HubError):
    """The database cannot be opened, or refuses."""


class NameTaken(HubError):
    """There is a person of that name already."""


class UnknownPerson(HubError):
    """There is nobody of that name."""


class UnknownRole(HubError):
    """There is no role of that name."""


class WeakPassword(HubError):
    """The password does not meet the rules, or the name does not."""
