"""What can be wrong with the hub itself.

HubError
├── CannotStart       a setting, a file or the port keeps the hub from starting
├── StoreError        the database cannot be opened or refuses
│   └── StoreDown     it did not answer just now
│       └── FilesDown the store of files did not
├── HeadsRefused      signed heads of another hub that do not hold
├── LibraryMissing    what is asked for needs an extra that is not installed
├── HubBusy           so many ask at once that this one must come again
├── NameTaken         there is a person or a role of that name already
├── NoPassword        the account would be left without a way to sign in
├── UnknownPerson     there is nobody of that name or number
├── UnknownRole       there is no role of that name or number
├── LastAdmin         the last person who can manage the hub would be gone
├── RoleInUse         people have the role
├── SeededRole        the role came with the hub and cannot be changed like that
├── AssetRefused      a file of a robot that is not sent
│   └── AssetMissing  there is none
├── TapRefused        a raw topic that is not there, or not for this person
├── HistoryError      history.errors: samples cannot be kept or read
└── WeakPassword      the password is too short or too long
"""

from __future__ import annotations

from talaia.errors import TalaiaError

__all__ = [
    "AssetMissing",
    "AssetRefused",
    "CannotStart",
    "FilesDown",
    "HeadsRefused",
    "HubBusy",
    "HubError",
    "LastAdmin",
    "LibraryMissing",
    "NameTaken",
    "NoPassword",
    "PasskeyRefused",
    "ProviderRefused",
    "RoleInUse",
    "SeededRole",
    "StoreDown",
    "StoreError",
    "TapRefused",
    "UnknownPerson",
    "UnknownRole",
    "WeakPassword",
]


class HubError(TalaiaError):
    """Base of the hub's errors; a sentence for people, with what to do."""

    def __init__(self, problem: str, remedy: str = "") -> None:
        """Keep problem and remedy apart, so a form can show each where it belongs."""
        super().__init__(problem, remedy)
        # What is wrong, and what to do about it; the latter may be empty.
        self.problem = problem
        self.remedy = remedy

    def __str__(self) -> str:
        return f"{self.problem}; {self.remedy}" if self.remedy else self.problem


class CannotStart(HubError):
    """A setting, a file or the port keeps the hub from starting."""


class StoreError(HubError):
    """The database cannot be opened, or refuses."""


class StoreDown(StoreError):
    """The database did not answer just now, or has no room; what was asked is not done."""


class FilesDown(StoreDown):
    """The store of files did not answer just now, has no room, or answered with something else."""


class HubBusy(HubError):
    """So many ask at once that this one must come again later."""


class LibraryMissing(HubError):
    """What is asked for needs a library that is an extra and is not installed."""


class NameTaken(HubError):
    """There is a person or a role of that name already."""


class UnknownPerson(HubError):
    """There is nobody of that name or number."""


class UnknownRole(HubError):
    """There is no role of that name or number."""


class LastAdmin(HubError):
    """The last person who can manage the hub would be gone."""


class RoleInUse(HubError):
    """People have the role."""


class SeededRole(HubError):
    """The role came with the hub and cannot be changed like that."""


class WeakPassword(HubError):
    """The password does not meet the rules, or the name does not."""


class NoPassword(HubError):
    """An account without a password that would be left without a way to sign in."""


class PasskeyRefused(HubError):
    """What a browser says of a passkey does not hold, or may not be."""


class HeadsRefused(HubError):
    """Signed heads of another hub's audit log that do not hold, or that it does not keep."""


class ProviderRefused(HubError):
    """The provider of sign-ins does not answer, or what it says does not hold."""


class TapRefused(HubError):
    """A raw topic that is not there, or that this person may not have."""


class AssetRefused(HubError):
    """A file of a robot, such as a mesh, that is not sent."""


class AssetMissing(AssetRefused):
    """There is no such file, or nothing is told of it."""

    def __init__(self) -> None:
        """Say no more than that: which folders there are is nobody's matter."""
        super().__init__("there is no such file")
