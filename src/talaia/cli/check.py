"""``talaia check``: check a site description, and where it is not.

Where cameras are to detect objects it says, too, whether this machine could: that is no mistake of
the description, which may be for another one.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.extensions.declarations import AdapterExtension, DetectorExtension
from talaia.extensions.installed import installed_extensions
from talaia.model.checks.site_checks import check_site
from talaia.model.connection import ExtensionConnection
from talaia.model.errors import DescriptionError
from talaia.model.interlocks.unguarded import unguarded_notice
from talaia.model.yaml_text.load import read_site
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
    options = parser.parse_args(argv)
    wrong = 0
    for path in options.file:
        try:
            site = read_site(path)
        except DescriptionError as error:
            print(f"{path}: {error}", file=sys.stderr)
            wrong += 1
            continue
        # With the extensions' own rules, for the keys that they add.
        findings = check_site(site, installed_extensions().description_rules())
        for finding in findings:
            print(f"{path}: {finding}", file=sys.stderr)
        if findings:
            wrong += 1
        else:
            channels = len(site.channels())
            print(f"{path}: valid; {len(site.devices)} devices, {channels} channels")
            if notice := unguarded_notice(site):
                print(f"{path}: note: {notice}")
            for line in _not_judged(site):
                print(f"{path}: note: {line}")
            for sight in detection_availability(site, path.parent):
                print(f"{path}: {sight.said}")
    # Told, but no mistake of a description: it does not change the exit code.
    for broken in installed_extensions().list_broken():
        print(broken, file=sys.stderr)
    return 1 if wrong else 0


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
