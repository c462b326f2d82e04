"""Cross-checks of interlocks and link-loss policies; part of `check`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.model.arguments import fields_of
from talaia.model.checks.identifiers import (
    Finding,
    at_least,
    check_above,
    finding_of,
    id_fits,
    name_fits,
    number_text,
)
from talaia.model.errors import UnknownWord
from talaia.model.maps.zone_checks import zone_condition_findings
from talaia.model.site import SignalType

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from talaia.model.interlocks.interlock import Condition, Interlock, Step
    from talaia.model.site import Signal, Site

__all__ = ["interlock_findings", "step_findings"]

_DAY = 86_400.0
# What a condition can compare.
_READABLE = (SignalType.NUMBER, SignalType.STATE)


def interlock_findings(site: Site) -> Iterator[Finding]:
    """List what does not fit in a site's interlocks and link-loss policies."""
    for interlock_id, interlock in site.interlocks.items():
        where = f"$.interlocks.{interlock_id}"
        yield from id_fits(where, interlock_id)
        yield from _check_interlock(site, where, interlock)
    for device_id, device in site.devices.items():
        if device.link_loss is not None:
            where = f"$.devices.{device_id}.link_loss"
            yield from at_least(f"{where}.after", device.link_loss.after, 0)
            if not device.link_loss.run:
                yield Finding(f"{where}.run", "nothing is to be done", "name a command")
            for index, step in enumerate(device.link_loss.run):
                yield from step_findings(site, f"{where}.run[{index}]", step)


def _check_interlock(site: Site, where: str, interlock: Interlock) -> Iterator[Finding]:
    yield from name_fits(f"{where}.name", interlock.name)
    if not interlock.when:
        yield Finding(
            f"{where}.when",
            "there is no condition",
            "write at least one: - {signal: device/name, above: 1}",
        )
    if not interlock.refuse and not interlock.run and not interlock.slow:
        yield Finding(where, "it neither refuses nor does anything", "add refuse, slow or run")
    for key in ("dwell", "longest_override"):
        found = getattr(interlock, key)
        # Written so that NaN is found as well.
        if not 0 <= found <= _DAY:
            yield Finding(f"{where}.{key}", f"expected 0 to {_DAY:g} s, found {number_text(found)}")
    for index, condition in enumerate(interlock.when):
        yield from _check_condition(site, f"{where}.when[{index}]", condition)
    known = [*_refusable_commands(site)]
    for index, target in enumerate(interlock.refuse):
        if target not in known:
            yield finding_of(UnknownWord(f"{where}.refuse[{index}]", "command", target, known))
    # Only driving has a speed that can be cut.
    driven = [address for address in known if address.endswith("/drive")]
    for target, share in interlock.slow.items():
        if target not in driven:
            yield finding_of(UnknownWord(f"{where}.slow.{target}", "driven device", target, driven))
        elif not 0 < share < 1:
            problem = f"expected a share above 0 and below 1, found {number_text(share)}"
            yield Finding(
                f"{where}.slow.{target}",
                problem,
                "write 0.5 for half its limits, or refuse it to let nobody drive",
            )
    for index, step in enumerate(interlock.run):
        yield from step_findings(site, f"{where}.run[{index}]", step)


def _check_condition(site: Site, where: str, condition: Condition) -> Iterator[Finding]:
    if condition.all_of:
        yield from _check_group(site, where, condition)
        return
    if condition.link_lost is not None:
        yield from at_least(f"{where}.link_lost", condition.link_lost, 0)
        if condition.signal or condition.sun:
            what = "signal" if condition.signal else "sun"
            yield Finding(where, f"both {what} and link_lost are given", "make two conditions")
        return
    if condition.sun is not None:
        yield from _check_sun(site, where, condition)
        return
    if condition.zone or condition.margin:
        yield from zone_condition_findings(site, where, condition)
        yield from at_least(f"{where}.lasting", condition.lasting, 0)
        yield from _check_dwell(where, condition)
        return
    signals = {
        f"{device_id}/{signal_id}": signal
        for device_id, device in site.devices.items()
        for signal_id, signal in device.signals.items()
        if signal.type in _READABLE
    }
    signal = signals.get(condition.signal)
    if signal is None:
        known = list(signals)
        yield finding_of(UnknownWord(f"{where}.signal", "number or state", condition.signal, known))
        return
    if condition.max_age is not None:
        yield from check_above(f"{where}.max_age", condition.max_age, 0)
    elif signal.max_age == 0:
        problem = f"{condition.signal} never goes stale, so nothing would tell that it fell silent"
        yield Finding(f"{where}.max_age", problem, "say here how old it may be (s)")
    yield from at_least(f"{where}.lasting", condition.lasting, 0)
    yield from _check_dwell(where, condition)
    if signal.type is SignalType.STATE:
        yield from _check_states(where, condition, signal)
    else:
        yield from _check_limits(where, condition)
    yield from _check_second_signal(where, condition, signals)


def _check_dwell(where: str, condition: Condition) -> Iterator[Finding]:
    if condition.dwell is not None and not 0 <= condition.dwell <= _DAY:
        yield Finding(
            f"{where}.dwell", f"expected 0 to {_DAY:g} s, found {number_text(condition.dwell)}"
        )


def _check_sun(site: Site, where: str, condition: Condition) -> Iterator[Finding]:
    if site.place is None:
        yield Finding(where, "it is not known where the site is", "write place: at the top")
    if condition.signal or condition.minus or condition.humidity:
        yield Finding(where, "both signal and sun are given", "make two conditions")
    if condition.above is None and condition.below is None:
        yield Finding(where, "the Sun has no limit", "write: above: -6, until_below: -8")
    yield from _check_limits(where, condition)


def _check_second_signal(
    where: str, condition: Condition, signals: Mapping[str, Signal]
) -> Iterator[Finding]:
    """List what is wrong with the second signal of a difference."""
    key = "minus" if condition.minus else "humidity"
    address = condition.minus or condition.humidity
    if not address:
        return
    if condition.minus and condition.humidity:
        yield Finding(where, "both minus and humidity are given", "the dew point, or what gives it")
        return
    numbers = {name: signal for name, signal in signals.items() if signal.type is SignalType.NUMBER}
    first, second = numbers.get(condition.signal), numbers.get(address)
    if second is None:
        yield finding_of(UnknownWord(f"{where}.{key}", "number signal", address, list(numbers)))
    elif first is None:
        yield Finding(f"{where}.{key}", "a state has no difference", "take two numbers")
    elif condition.minus and first.unit != second.unit:
        problem = f"{address} is in {second.unit or 'no unit'}, {condition.signal} in "
        problem += first.unit or "no unit"
        yield Finding(f"{where}.minus", problem, "a difference needs one unit")
    elif condition.humidity and (first.unit, second.unit) != ("°C", "%"):
        problem = f"expected a temperature in °C and a humidity in %, found {first.unit!r} and "
        yield Finding(f"{where}.humidity", problem + repr(second.unit), "give their units")
    if condition.above is None and condition.below is None:
        yield Finding(where, "a difference has no limit", "write: below: 3, until_above: 4")


def _check_group(site: Site, where: str, condition: Condition) -> Iterator[Finding]:
    # Beside ``all`` every other key would be without effect.
    if condition != type(condition)(all_of=condition.all_of):
        yield Finding(where, "something stands beside all", "make two conditions")
    if len(condition.all_of) == 1:
        yield Finding(f"{where}.all", "there is one condition", "write it without all")
    for index, part in enumerate(condition.all_of):
        at = f"{where}.all[{index}]"
        if part.all_of:
            yield Finding(at, "an all within an all", "write its conditions into the outer one")
        else:
            yield from _check_condition(site, at, part)


def _check_states(where: str, condition: Condition, signal: Signal) -> Iterator[Finding]:
    if condition.above is not None or condition.below is not None:
        yield Finding(where, "a state is neither above nor below", "write is or is_not")
    for key, words in (("is", condition.is_one_of), ("is_not", condition.is_not)):
        for index, word in enumerate(words):
            if word not in signal.states:
                at = f"{where}.{key}[{index}]"
                yield finding_of(UnknownWord(at, "state", word, signal.states))


def _check_limits(where: str, condition: Condition) -> Iterator[Finding]:
    if condition.is_one_of or condition.is_not:
        yield Finding(where, "a number has no states", "write above or below")
    for key in ("above", "below", "until_below", "until_above"):
        value = getattr(condition, key)
        if value is not None and not math.isfinite(value):
            yield Finding(f"{where}.{key}", f"expected a finite number, found {number_text(value)}")
    # One rule for both: the limit above lets go below itself, the limit below above itself.
    for key, limit, until, sign in (
        ("until_below", condition.above, condition.until_below, 1),
        ("until_above", condition.below, condition.until_above, -1),
    ):
        if until is None:
            continue
        if limit is None:
            missing = "above" if sign > 0 else "below"
            yield Finding(
                f"{where}.{key}",
                f"there is no {missing} that it could let go of",
                f"write {missing}, too, or leave it out",
            )
        elif (limit - until) * sign < 0:
            yield Finding(
                f"{where}.{key}",
                f"{until:g} is beyond the limit {limit:g}",
                "it lets go on the safe side of the limit",
            )


def step_findings(site: Site, where: str, step: Step) -> Iterator[Finding]:
    """List what does not fit in a step."""
    device_id, _, command_id = step.command.partition("/")
    device = site.devices.get(device_id)
    command = device.commands.get(command_id) if device is not None else None
    if command is None:
        # A step is one command: neither driving nor all of a device can be run.
        known = [
            address
            for address in _refusable_commands(site)
            if not address.endswith(("/*", "/drive"))
        ]
        yield finding_of(UnknownWord(f"{where}.command", "command", step.command, known))
        return
    fields = fields_of(command, step.args)
    if isinstance(fields, str):
        # All of them, for the next one may be missing, too.
        needs = ", ".join(f"{name}: …" for name in command.arguments) or "none"
        yield Finding(f"{where}.args", fields, f"its arguments are: {needs}")
    if step.within is not None:
        yield from check_above(f"{where}.within", step.within, 0)


def _refusable_commands(site: Site) -> Iterator[str]:
    for device_id, device in site.devices.items():
        yield f"{device_id}/*"
        if device.drive is not None:
            yield f"{device_id}/drive"
        for command_id in device.commands:
            yield f"{device_id}/{command_id}"
