"""Devices that an adapter found by itself: kept, and taken into the description.

They stay in it when they are away later, as those that a person described do: their history goes
on under the same addresses, and a page says that they are not reached. To forget them, remove the
connection's file in the data folder.
"""

from __future__ import annotations

import logging
import re
from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.persistence import write_whole
from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.source_tags import devices_of_plain, plain_of

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from talaia.model.site import Device, Site

__all__ = ["add_discovered", "keep_found", "kept_of", "with_kept"]

log = logging.getLogger(__name__)
# The device's name in the place of a finding.
_AT = re.compile(r"\$\.devices\.([^.\[]+)")
# In the data folder.
_FOLDER = "found"


def add_discovered(
    site: Site,
    connection: str,
    devices: Mapping[str, Device],
    kept: Mapping[str, Device] | None = None,
) -> Site:
    """Add devices to a site; those a person described, and those that do not fit, are left.

    Of those that were found earlier (``kept``) the newer finding counts: a driver may have more
    to show once it has reached its hardware. A robot's side may name its things as it likes; what
    cannot be described is told in the log.
    """
    before = kept or {}
    new = {
        name: msgspec.structs.replace(device, connection=connection)
        for name, device in devices.items()
        # One that was found earlier and not changed by a person since may be replaced.
        if name not in site.devices or site.devices[name] == before.get(name)
    }
    # Checked together: a device may not fit only beside the others.
    both = msgspec.structs.replace(site, devices={**site.devices, **new})
    wrong = set()
    for finding in check_site(both):
        at = _AT.match(finding.where)
        if at is not None and at[1] in new:
            wrong.add(at[1])
            log.warning("%s: a device that was found cannot be described: %s", connection, finding)
    fitting = {name: device for name, device in new.items() if name not in wrong}
    return msgspec.structs.replace(site, devices={**site.devices, **fitting})


def keep_found(data: Path, connection: str, devices: Mapping[str, Device]) -> None:
    """Write down what a connection found, beside what it found earlier, for the next start.

    Raises:
        OSError: it cannot be written; what was kept before stands.

    """
    folder = data / _FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    # Newer findings count, and what is away now is kept.
    all_of_it = {**kept_of(data, connection), **devices}
    written = msgspec.json.encode(plain_of(all_of_it))
    write_whole(folder / f"{connection}.json", msgspec.json.format(written))


def kept_of(data: Path, connection: str) -> dict[str, Device]:
    """Give what a connection found in earlier runs, as the description has it."""
    path = data / _FOLDER / f"{connection}.json"
    try:
        devices = devices_of_plain(msgspec.json.decode(path.read_bytes()))
    except FileNotFoundError:
        return {}
    except (OSError, msgspec.DecodeError) as error:
        # It only saves the time until they are found again.
        log.warning("%s is not read: %s", path, error)
        return {}
    return {
        name: msgspec.structs.replace(device, connection=connection)
        for name, device in devices.items()
    }


def with_kept(data: Path, site: Site) -> Site:
    """Take in what the connections of a site found in earlier runs."""
    for connection in site.links():
        site = add_discovered(site, connection, kept_of(data, connection))
    return site
