"""What does not fit in a mission: by itself, and at the site whose robot is to do it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from talaia.model.alarms.constant_parts import ZERO_REMEDY, zero_division_problem
from talaia.model.alarms.expression import ExpressionError, parse_condition
from talaia.model.arguments import fields_of, unit_problem
from talaia.model.checks.identifiers import Finding, name_fits
from talaia.model.derivation.plan import channel_kinds
from talaia.model.missions.mission import DAYS, LONGEST_S, MOST_STEPS, StepKind
from talaia.model.missions.mission_schedule import read_date, read_time

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.missions.mission import Mission, MissionSchedule, MissionStep
    from talaia.model.site import Site

__all__ = ["mission_findings", "site_findings", "with_units"]

_LONGEST_NOTE = 1000
# Keys that only one kind of step has.
_OWN = {
    "device": StepKind.COMMAND,
    "command": StepKind.COMMAND,
    "args": StepKind.COMMAND,
    "units": StepKind.COMMAND,
    "condition": StepKind.UNTIL,
}


def mission_findings(mission: Mission) -> Iterator[Finding]:
    """List what does not fit in a mission, whatever the site."""
    yield from name_fits("$.name", mission.name)
    if len(mission.note) > _LONGEST_NOTE:
        yield Finding("$.note", f"longer than {_LONGEST_NOTE} letters")
    if not mission.steps:
        yield Finding("$.steps", "a mission has at least one step")
    if len(mission.steps) > MOST_STEPS:
        yield Finding("$.steps", f"more than {MOST_STEPS} steps")
    for at, step in enumerate(mission.steps):
        yield from _step_findings(f"$.steps[{at}]", step)
    if mission.schedule is not None:
        yield from _schedule_findings(mission.schedule)


def _step_findings(where: str, step: MissionStep) -> Iterator[Finding]:
    if step.name:
        yield from name_fits(f"{where}.name", step.name)
    # Written so that NaN is found as well.
    if not 0 <= step.seconds <= LONGEST_S:
        yield Finding(f"{where}.seconds", f"expected 0 to {LONGEST_S:g} s")
    for key, kind in _OWN.items():
        if step.kind is not kind and getattr(step, key):
            yield Finding(f"{where}.{key}", f"belongs to a step of kind {kind}")
    if step.kind is StepKind.COMMAND and not (step.device and step.command):
        yield Finding(where, "a command names its device and itself")
    if step.kind is StepKind.UNTIL and not step.condition.strip():
        yield Finding(f"{where}.condition", "says what is waited for")
    if step.kind is StepKind.PAUSE and step.seconds == 0:
        yield Finding(f"{where}.seconds", "a pause lasts longer than 0 s")


def _schedule_findings(schedule: MissionSchedule) -> Iterator[Finding]:
    where = "$.schedule"
    if read_time(schedule.at) is None:
        yield Finding(f"{where}.at", "expected a time of day, HH:MM")
    if schedule.date and read_date(schedule.date) is None:
        yield Finding(f"{where}.date", "expected a day, YYYY-MM-DD")
    if schedule.date and schedule.days:
        yield Finding(f"{where}.days", "either days of the week or a date")
    for day in schedule.days:
        if day not in DAYS:
            yield Finding(f"{where}.days", f"expected {', '.join(DAYS)}; found {day!r}")


def site_findings(mission: Mission, site: Site) -> Iterator[Finding]:
    """List what of a mission the site's description does not have, or would refuse."""
    for at, step in enumerate(mission.steps):
        where = f"$.steps[{at}]"
        if step.kind is StepKind.COMMAND:
            yield from _command_findings(where, step, site)
        elif step.kind is StepKind.UNTIL:
            try:
                waited_for = parse_condition(step.condition, channel_kinds(site))
            except ExpressionError as error:
                yield Finding(f"{where}.condition", str(error), error.remedy)
                continue
            if problem := zero_division_problem(waited_for):
                yield Finding(f"{where}.condition", problem, ZERO_REMEDY)


def _command_findings(where: str, step: MissionStep, site: Site) -> Iterator[Finding]:
    device = site.devices.get(step.device)
    if device is None:
        yield Finding(f"{where}.device", f"there is no device {step.device!r}")
        return
    command = device.commands.get(step.command)
    if command is None:
        yield Finding(f"{where}.command", f"{device.name} has no command {step.command!r}")
        return
    fields = fields_of(command, step.args)
    if isinstance(fields, str):
        yield Finding(f"{where}.args", fields)
    elif problem := unit_problem(command, step.units):
        yield Finding(f"{where}.units", problem.partition(";")[0])


def with_units(mission: Mission, site: Site) -> Mission:
    """Note in each command the units that its arguments have at ``site`` now."""
    return replace(mission, steps=tuple(_noted(step, site) for step in mission.steps))


def _noted(step: MissionStep, site: Site) -> MissionStep:
    device = site.devices.get(step.device)
    command = None if device is None else device.commands.get(step.command)
    if command is None:
        return step
    units = {name: command.arguments[name].unit for name in step.args if name in command.arguments}
    # What was noted before stands: it says what the person meant then.
    return replace(step, units={**units, **step.units})
