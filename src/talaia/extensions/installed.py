"""Finds the extensions that are installed beside this package, by their entry points.

One that cannot be used is named with the reason, once in the log and for whoever lists them; it
takes no other with it.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from functools import cache
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import msgspec

from talaia.extensions.declarations import (
    API_VERSION,
    AdapterExtension,
    Declared,
    DetectorExtension,
    ExtensionKeys,
    ImporterExtension,
    NotifierExtension,
)
from talaia.model.alarms.anomaly import MOST_LETTERS, DetectorKind
from talaia.model.checks.extension_rules import AdapterRules, ExtensionRules
from talaia.model.checks.identifiers import id_fits

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from importlib.metadata import EntryPoint

__all__ = [
    "KINDS_OF_EXTENSION",
    "BrokenExtension",
    "InstalledExtension",
    "InstalledExtensions",
    "installed_extensions",
]

_LOG = logging.getLogger(__name__)

KINDS_OF_EXTENSION: tuple[type[Declared], ...] = (
    AdapterExtension,
    DetectorExtension,
    NotifierExtension,
    ImporterExtension,
)
# Of a key: what YAML can say and a form can ask for.
_PLAIN = (
    msgspec.inspect.BoolType,
    msgspec.inspect.IntType,
    msgspec.inspect.FloatType,
    msgspec.inspect.StrType,
    msgspec.inspect.LiteralType,
)
_Kind = TypeVar("_Kind", bound=Declared)


class InstalledExtension(NamedTuple):
    """One that can be used, and the package that brings it: ``talaia-snmp 1.0``."""

    group: str
    name: str
    package: str
    declared: Declared


@dataclass(frozen=True, slots=True, order=True)
class BrokenExtension:
    """One that cannot be used, or that failed while it was used, and why."""

    group: str
    name: str
    package: str
    problem: str

    def __str__(self) -> str:
        brought = f" of {self.package}" if self.package else ""
        return f"the extension {self.name!r} ({self.group}){brought} is broken: {self.problem}"


class InstalledExtensions:
    """The extensions of one process; each group is loaded when it is first asked for."""

    def __init__(
        self, find: Callable[[str], Iterable[EntryPoint]] = lambda group: entry_points(group=group)
    ) -> None:
        """Look with ``find``, which gives a group's entry points."""
        self._find = find
        # Entry points by group, read once: looking through all packages takes a while.
        self._entries: dict[str, list[EntryPoint]] = {}
        # Parts that were imported, by group and name.
        self._loaded: dict[str, dict[str, InstalledExtension]] = {}
        # What is broken, once for each reason, however often it is asked for.
        self._broken: dict[tuple[str, str, str], BrokenExtension] = {}

    def adapters_by_name(self) -> Mapping[str, AdapterExtension]:
        """Give the adapters by name."""
        return self._declared_parts(AdapterExtension)

    def detectors_by_name(self) -> Mapping[str, DetectorExtension]:
        """Give the detectors by name."""
        return self._declared_parts(DetectorExtension)

    def notifiers_by_name(self) -> Mapping[str, NotifierExtension]:
        """Give the notifiers by name."""
        return self._declared_parts(NotifierExtension)

    def importers_by_name(self) -> Mapping[str, ImporterExtension]:
        """Give the importers by name."""
        return self._declared_parts(ImporterExtension)

    def names_of(self, kind: type[Declared]) -> list[str]:
        """Name those of a kind, without loading any: some of them may be broken."""
        return sorted({point.name for point in self._points_of(kind)})

    def list_extensions(self) -> list[InstalledExtension]:
        """List all that can be used, in the order of `KINDS_OF_EXTENSION`, by name."""
        return [
            found
            for kind in KINDS_OF_EXTENSION
            for _, found in sorted(self._usable_parts(kind).items())
        ]

    def list_broken(self) -> list[BrokenExtension]:
        """List what could not be loaded so far, and what failed while it was used."""
        return sorted(self._broken.values())

    def description_rules(self) -> ExtensionRules:
        """Give what they ask for in a description."""
        return ExtensionRules(
            adapters={
                name: AdapterRules(adapter.connection, adapter.source, adapter.command)
                for name, adapter in self.adapters_by_name().items()
            },
            detectors={name: detector.keys for name, detector in self.detectors_by_name().items()},
        )

    def note_failure(self, kind: type[Declared], name: str, problem: str) -> None:
        """Write down, once, that an extension failed while it was used."""
        of_name = (point for point in self._points_of(kind) if point.name == name)
        package = next(map(_package_of, of_name), "")
        self._add_broken(BrokenExtension(kind.group, name, package, problem))

    def _add_broken(self, broken: BrokenExtension) -> None:
        key = broken.group, broken.name, broken.problem
        if key not in self._broken:
            self._broken[key] = broken
            _LOG.error("%s", broken)

    def _declared_parts(self, kind: type[_Kind]) -> dict[str, _Kind]:
        return {
            name: found.declared
            for name, found in self._usable_parts(kind).items()
            if isinstance(found.declared, kind)
        }

    def _usable_parts(self, kind: type[Declared]) -> dict[str, InstalledExtension]:
        # When it is first asked for: to load an extension is to run its code.
        loaded = self._loaded.get(kind.group)
        if loaded is None:
            # Entered before it is filled: an extension that asks for its own kind while it is
            # imported finds what is there so far, and no endless loop.
            loaded = self._loaded[kind.group] = {}
            for point in self._points_of(kind):
                self._load_point(kind, point, loaded)
        return loaded

    def _points_of(self, kind: type[Declared]) -> list[EntryPoint]:
        found = self._entries.get(kind.group)
        if found is None:
            found = sorted(self._find(kind.group), key=lambda point: point.name)
            self._entries[kind.group] = found
        return found

    def _load_point(
        self, kind: type[Declared], point: EntryPoint, loaded: dict[str, InstalledExtension]
    ) -> None:
        package = _package_of(point)
        try:
            declared = point.load()
            problem = _why_not(kind, point.name, declared)
        # A module that calls `sys.exit` must not end this process.
        except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever it does, it is named
            problem = f"it cannot be imported: {type(error).__name__}: {error}"
            _LOG.debug("%s", problem, exc_info=True)
        else:
            twice = loaded.get(point.name)
            if not problem and twice is not None:
                problem = f"{twice.package} brings one of the same name, which is used"
            if not problem:
                loaded[point.name] = InstalledExtension(kind.group, point.name, package, declared)
                return
        self._add_broken(BrokenExtension(kind.group, point.name, package, problem))


@cache
def installed_extensions() -> InstalledExtensions:
    """Give the extensions of this process."""
    return InstalledExtensions()


def _package_of(point: EntryPoint) -> str:
    # One that was made by hand belongs to no package.
    return f"{point.dist.name} {point.dist.version}" if point.dist is not None else ""


def _why_not(kind: type[Declared], name: str, declared: object) -> str:
    """Say why something is no extension of its group; empty where it is one."""
    for finding in id_fits("its name", name):
        return f"{finding.problem}; {finding.remedy}"
    if not isinstance(declared, kind):
        return f"its entry point names a {type(declared).__name__}, not a {kind.__name__}"
    # Neither older nor newer: the number changes only when a name means something else.
    if declared.api != API_VERSION:
        return (
            f"it is written for version {declared.api!r} of talaia.extend, "
            f"and this Talaia has version {API_VERSION}"
        )
    for shape in _shapes_of(declared):
        if problem := _wrong_shape(shape):
            return problem
    if isinstance(declared, DetectorExtension):
        if name in set(DetectorKind):
            return "a detector of Talaia itself has this name"
        if len(name) > MOST_LETTERS:
            return f"a detector's name has at most {MOST_LETTERS} letters"
    return ""


def _shapes_of(declared: Declared) -> list[object]:
    match declared:
        case AdapterExtension():
            command = [] if declared.command is None else [declared.command]
            return [declared.connection, declared.source, *command]
        case DetectorExtension() | NotifierExtension():
            return [declared.keys]
        case _:
            return []


def _wrong_shape(shape: object) -> str:
    if not (isinstance(shape, type) and issubclass(shape, ExtensionKeys)):
        return f"{shape!r} is no subclass of ExtensionKeys"
    info = msgspec.inspect.type_info(shape)
    for field in info.fields if isinstance(info, msgspec.inspect.StructType) else ():
        if not isinstance(field.type, _PLAIN):
            return f"{shape.__name__}.{field.name} is not a plain string, number or boolean"
    return ""
