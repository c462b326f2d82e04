"""Cross-checks of what is watched for anomalies."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia.model.ai_services import FEWEST_A_WEEK, MOST_A_WEEK
from talaia.model.alarms.anomaly import (
    MOST_LETTERS,
    OPTIONS,
    DetectorKind,
    SignalGroup,
    Watch,
)
from talaia.model.alarms.signal_groups import (
    FEWEST_IN_GROUP,
    GROUP_DETECTOR,
    MOST_IN_GROUP,
    group_named,
)
from talaia.model.checks.identifiers import Finding, finding_of, id_fits, name_fits
from talaia.model.errors import UnknownWord

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Site

__all__ = ["anomaly_findings", "budget_findings", "group_findings"]

# Every detector knows these.
_ANY = {"detector", "bar", "rest"}
# Steps that are learned from, modes, and numbers that all groups of a site keep while they learn
# (32 MB).
_FEWEST_STEPS, _MOST_STEPS, _MOST_MODES, _MOST_NUMBERS = 60, 30_000, 16, 4_000_000


def anomaly_findings(where: str, watches: tuple[Watch, ...], *, number: bool) -> Iterator[Finding]:
    """List what does not fit in the detectors of one signal.

    Args:
        where: the signal's path.
        watches: as they stand in the description.
        number: whether the signal is a number.

    """
    if watches and not number:
        yield Finding(f"{where}.anomalies", "only numbers are watched", "leave it out")
    # Scores are channels named ``<signal>~<detector>``, so a detector stands there once.
    seen: set[str] = set()
    for index, watch in enumerate(watches):
        at = f"{where}.anomalies[{index}]"
        if watch.detector_name() in seen:
            yield Finding(
                f"{at}.detector",
                f"the detector '{watch.detector_name()}' stands here twice",
                "keep one of them",
            )
        seen.add(watch.detector_name())
        yield from _check_watch(at, watch)


def _check_watch(where: str, watch: Watch) -> Iterator[Finding]:
    if not 0.0 <= watch.bar <= 1.0:
        yield Finding(f"{where}.bar", f"expected 0 to 1, found {watch.bar:g}")
    if not 1 <= watch.rest <= 1_000_000:
        yield Finding(f"{where}.rest", f"expected 1 to 1000000 samples, found {watch.rest}")
    means = _ANY | set(OPTIONS.get(watch.detector, ()))
    for field in msgspec.structs.fields(Watch):
        # What stands at its default may have been written, but says nothing.
        if field.name in means or getattr(watch, field.name) == _default_of(field):
            continue
        owner = ", ".join(kind for kind, keys in OPTIONS.items() if field.name in keys)
        yield Finding(
            f"{where}.{field.name}",
            f"the detector '{watch.detector}' does not know '{field.name}'",
            f"it belongs to: {owner}",
        )
    for name in ("after", "within", "most"):
        if getattr(watch, name) < 0.0:
            yield Finding(f"{where}.{name}", f"expected 0 or more, found {getattr(watch, name):g}")
    if watch.k <= 0.0:
        yield Finding(f"{where}.k", f"expected more than 0, found {watch.k:g}")
    if watch.detector is DetectorKind.EXTENSION:
        yield from id_fits(f"{where}.extension", watch.extension)
        if len(watch.extension) > MOST_LETTERS:
            problem = f"a detector's name has at most {MOST_LETTERS} letters"
            yield Finding(f"{where}.extension", problem)
        if watch.extension in {*DetectorKind, GROUP_DETECTOR}:
            problem = f"'{watch.extension}' is a detector of Talaia itself"
            yield Finding(f"{where}.extension", problem, f"write: detector: {watch.extension}")
    if watch.detector is DetectorKind.LIMITS:
        low, high = watch.minimum, watch.maximum
        if low is None and high is None:
            yield Finding(where, "limits without a limit", "give minimum, maximum or both")
        elif low is not None and high is not None and low >= high:
            yield Finding(f"{where}.minimum", f"{low:g} is not below the maximum, {high:g}")


def _default_of(field: msgspec.structs.FieldInfo) -> object:
    return field.default if field.default_factory is msgspec.NODEFAULT else field.default_factory()


def budget_findings(site: Site) -> Iterator[Finding]:
    """List what does not fit in how often the detectors of a site may cry."""
    asked = 0.0 if site.services is None else site.services.false_alarms_a_week
    if asked and not FEWEST_A_WEEK <= asked <= MOST_A_WEEK:
        problem = f"expected 0, or {FEWEST_A_WEEK:g} to {MOST_A_WEEK:g} a week, found {asked:g}"
        yield Finding("$.services.false_alarms_a_week", problem, "write 1 for one a week")


def group_findings(site: Site) -> Iterator[Finding]:
    """List what does not fit in the groups of signals that are judged together."""
    numbers = 0
    for key, group in site.anomaly_groups.items():
        where = f"$.anomaly_groups.{key}"
        yield from id_fits(where, key)
        if group.name:
            yield from name_fits(f"{where}.name", group.name)
        yield from _check_members(site, where, group)
        yield from _check_modes(site, where, group)
        if not 0.0 < group.bar <= 1.0:
            yield Finding(f"{where}.bar", f"expected more than 0, at most 1, found {group.bar:g}")
        if not 1.0 <= group.step <= 3600.0:
            yield Finding(f"{where}.step", f"expected 1 to 3600 s, found {group.step:g}")
        if not _FEWEST_STEPS <= group.learn <= _MOST_STEPS:
            problem = f"expected {_FEWEST_STEPS} to {_MOST_STEPS} steps, found {group.learn}"
            yield Finding(f"{where}.learn", problem)
            continue
        found = group_named(site, key)
        numbers += group.learn * _modes_of(site, group) * (len(found.signals) if found else 0)
    if numbers > _MOST_NUMBERS:
        problem = (
            f"all groups together keep {numbers} numbers while they learn (signals by steps by"
            f" modes), at most {_MOST_NUMBERS} are kept"
        )
        yield Finding("$.anomaly_groups", problem, "shorten learn, or make the groups smaller")


def _check_members(site: Site, where: str, group: SignalGroup) -> Iterator[Finding]:
    if bool(group.signals) == bool(group.device):
        problem = "expected either signals or a device"
        yield Finding(where, problem, "list signals as device/signal, or name one device")
        return
    if group.device and group.device not in site.devices:
        yield finding_of(UnknownWord(f"{where}.device", "device", group.device, list(site.devices)))
        return
    known = [
        f"{device_id}/{signal_id}"
        for device_id, device in site.devices.items()
        for signal_id, signal in device.signals.items()
        if signal.type == "number"
    ]
    for at, address in enumerate(group.signals):
        place = f"{where}.signals[{at}]"
        if address not in known:
            yield finding_of(UnknownWord(place, "number", address, known))
        elif address in group.signals[:at]:
            yield Finding(place, f"{address!r} stands here twice", "keep one of them")
    count = len(group.signals)
    if group.device:
        of_device = site.devices[group.device].signals.values()
        count = sum(signal.primary and signal.type == "number" for signal in of_device)
    if not FEWEST_IN_GROUP <= count <= MOST_IN_GROUP:
        problem = f"expected {FEWEST_IN_GROUP} to {MOST_IN_GROUP} numbers, found {count}"
        remedy = f"name {FEWEST_IN_GROUP} or more: [device/name, device/other]"
        if group.device:
            remedy = "of a device those of the first page count (primary)"
        yield Finding(where, problem, remedy)


def _check_modes(site: Site, where: str, group: SignalGroup) -> Iterator[Finding]:
    if not 1 <= group.modes <= _MOST_MODES:
        yield Finding(f"{where}.modes", f"expected 1 to {_MOST_MODES}, found {group.modes}")
    if not group.state:
        return
    states = [
        f"{device_id}/{signal_id}"
        for device_id, device in site.devices.items()
        for signal_id, signal in device.signals.items()
        if signal.type == "state"
    ]
    if group.state not in states:
        yield finding_of(UnknownWord(f"{where}.state", "state", group.state, states))
    elif _modes_of(site, group) > _MOST_MODES:
        problem = f"expected at most {_MOST_MODES} states, found {_modes_of(site, group)}"
        yield Finding(f"{where}.state", problem, "leave it out, and write modes: 4")
    if group.modes != 1:
        problem = "ways of running are told by a state or found, not both"
        yield Finding(f"{where}.modes", problem, "leave it out")


def _modes_of(site: Site, group: SignalGroup) -> int:
    """Give how many notions of usual it may learn."""
    if not group.state:
        return group.modes
    signal = site.signal(group.state)
    return 1 if signal is None else max(1, len(signal.states))
