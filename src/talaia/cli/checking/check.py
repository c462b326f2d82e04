"""``talaia check``: say everything that is wrong with a site description, and where.

Where cameras are to detect objects it says, too, whether this machine could: that is no mistake of
the description, which may be for another one.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, NamedTuple

from talaia.cli.checking.mistake_texts import json_text, mistakes_text, notes_text
from talaia.extensions.declarations import AdapterExtension, DetectorExtension
from talaia.extensions.installed import installed_extensions
from talaia.model.checks.identifiers import finding_of
from talaia.model.checks.site_checks import check_site
from talaia.model.checks.text_checks import Mistake, check_text, place_findings
from talaia.model.connection import ExtensionConnection
from talaia.model.errors import DescriptionError
from talaia.model.interlocks.unguarded import unguarded_notice
from talaia.model.yaml_text.load import site_in, text_of, with_files
from talaia.objects.availability import detection_availability
from talaia.ros_type_library import RosTypeLibrary

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from talaia.model.site import Site
    from talaia.ros_type_library import FieldKind

__all__ = ["check_file", "check_files"]


def check_files(paths: Sequence[Path], *, as_json: bool) -> int:
    """Check each file; 0 when all are right, 1 when one is not."""
    checked = {path: check_file(path) for path in paths}
    wrong = any(report.mistakes for report in checked.values())
    if as_json:
        found = {str(path): (report.mistakes, report.notes) for path, report in checked.items()}
        print(json_text(found))
        return int(wrong)
    for path, report in checked.items():
        if report.notes:
            print(notes_text(str(path), report.text, report.notes) + "\n", file=sys.stderr)
        if report.mistakes:
            print(mistakes_text(str(path), report.text, report.mistakes), file=sys.stderr)
        elif report.site is not None:
            _print_valid(path, report.site)
    # Told, but no mistake of a description: it does not change the exit code.
    for broken in installed_extensions().list_broken():
        print(broken, file=sys.stderr)
    return int(wrong)


class CheckedFile(NamedTuple):
    """A file that was checked.

    Attributes:
        text: what stands in it; nothing if it cannot be read.
        mistakes: all that is wrong.
        site: the description; None if something is wrong.
        notes: what is worth a word and is no mistake.

    """

    text: str
    mistakes: list[Mistake]
    site: Site | None
    notes: Sequence[Mistake] = ()


class _TypesBesideFile:
    """Types of ROS that this machine knows, and those in the folders that a description names."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._library: RosTypeLibrary | None = None
        self._named: list[Path] = []

    def complete(self, site: Site) -> Site:
        """Take in the files beside the description, and remember where its types lie."""
        named = [getattr(link, "definitions", "") for link in site.links().values()]
        self._named = [self._folder / one for one in named if one]
        return with_files(site, self._folder)

    def versions_of(self, type_name: str, part: str = "") -> Iterator[Mapping[str, FieldKind]]:
        """See `KnownTypes`."""
        return self._all().versions_of(type_name, part)

    def names_in(self, package: str, middle: str) -> list[str]:
        """See `KnownTypes`."""
        return self._all().names_in(package, middle)

    def packages(self) -> list[str]:
        """See `KnownTypes`."""
        return self._all().packages()

    def _all(self) -> RosTypeLibrary:
        # Read for the first type: most descriptions without ROS name none.
        self._library = self._library or RosTypeLibrary(self._named)
        return self._library


def check_file(path: Path) -> CheckedFile:
    """Find all mistakes of a description, and of the files that it takes in."""
    # With the extensions' own rules, for the keys that they add.
    rules = installed_extensions().description_rules()
    text = ""
    try:
        text = text_of(path)
        if path.suffix != ".json":
            library = _TypesBesideFile(path.parent)
            report = check_text(text, rules, library.complete, library)
            return CheckedFile(text, *report)
        # A command file of the founding observatory has no lines that mean anything here.
        site = site_in(text, path)
        findings = check_site(site, rules)
    except DescriptionError as error:
        findings, site = [finding_of(error)], None
        text = text or getattr(error, "text", "")
    return CheckedFile(text, place_findings(findings, text), None if findings else site)


def _print_valid(path: Path, site: Site) -> None:
    channels = len(site.channels())
    print(f"{path}: valid; {len(site.devices)} devices, {channels} channels")
    if notice := unguarded_notice(site):
        print(f"{path}: note: {notice}")
    for line in _not_judged(site):
        print(f"{path}: note: {line}")
    for sight in detection_availability(site, path.parent):
        print(f"{path}: {sight.said}")


def _not_judged(site: Site) -> Iterator[str]:
    """Name the extensions that a description needs and that are not here."""
    adapters, detectors = (
        installed_extensions().adapters_by_name(),
        installed_extensions().detectors_by_name(),
    )
    needed = {
        (AdapterExtension, connection.extension, "its gateway")
        for connection in site.connections.values()
        if isinstance(connection, ExtensionConnection) and connection.extension not in adapters
    } | {
        (DetectorExtension, watch.extension, "the hub")
        for device in site.devices.values()
        for signal in device.signals.values()
        for watch in signal.anomalies
        if watch.extension and watch.extension not in detectors
    }
    # Sets have no order; the same description must give the same lines.
    for kind, name, where in sorted(needed, key=lambda part: (part[0].group, part[1])):
        what = kind.group.removeprefix("talaia.").removesuffix("s")
        yield (
            f"the {what} {name!r} is not installed here, so its keys were not judged; "
            f"{where} needs the package that brings it"
        )
