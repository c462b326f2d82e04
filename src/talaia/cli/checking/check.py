"""``talaia check``: say everything that is wrong with a site description, and where.

Where cameras are to detect objects it says, too, whether this machine could: that is no mistake of
the description, which may be for another one.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from talaia.cli.checking.mistake_texts import json_text, mistakes_text
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

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from talaia.model.site import Site

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Check each file; 0 when all are right, 1 when one is not."""
    parser = argparse.ArgumentParser(
        "talaia check", description="Check site descriptions and report what is wrong, and where."
    )
    parser.add_argument("file", type=Path, nargs="+", help="a site description (YAML)")
    parser.add_argument(
        "--json", action="store_true", help="print the mistakes as JSON, for editors"
    )
    options = parser.parse_args(argv)
    checked = {path: check_file(path) for path in options.file}
    wrong = any(report.mistakes for report in checked.values())
    if options.json:
        print(json_text({str(path): report.mistakes for path, report in checked.items()}))
        return int(wrong)
    for path, report in checked.items():
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

    """

    text: str
    mistakes: list[Mistake]
    site: Site | None


def check_file(path: Path) -> CheckedFile:
    """Find all mistakes of a description, and of the files that it takes in."""
    # With the extensions' own rules, for the keys that they add.
    rules = installed_extensions().description_rules()
    text = ""
    try:
        text = text_of(path)
        if path.suffix != ".json":
            report = check_text(text, rules, lambda site: with_files(site, path.parent))
            return CheckedFile(text, *report)
        # A command file of the founding observatory has no lines that mean anything here.
        site = site_in(text, path)
        findings = check_site(site, rules)
    except DescriptionError as error:
        findings, site = [finding_of(error)], None
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
