"""What opens an observatory and what brings it to rest, as steps. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.night.step_runner import NightStep, StepRunner

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.night.night_values import NightAction, NightView
    from talaia.model.interlocks.enclosure import Enclosure
    from talaia.model.interlocks.interlock import Step
    from talaia.model.night_section import NightSection

__all__ = ["abort_commands", "closing_steps", "opening_steps", "steps_of"]

# Where the description does not say how long a command may take (s).
STEP_S = 120.0


def opening_steps(night: NightSection) -> list[NightStep]:
    """Give what leads to an open roof and a telescope that may point."""

    def is_open(view: NightView) -> bool:
        return view.opened is True

    def is_ready(view: NightView) -> bool:
        return view.parked is False

    return [
        *steps_of(night.start, "getting ready"),
        NightStep(
            words="opening the roof",
            command=night.open.command,
            args=night.open.args,
            within=night.open.within or STEP_S,
            tries=night.step_tries,
            reached=is_open,
        ),
        NightStep(
            words="unparking the telescope",
            command=night.unpark.command,
            args=night.unpark.args,
            within=night.unpark.within or STEP_S,
            tries=night.step_tries,
            reached=is_ready,
        ),
    ]


def closing_steps(rule: Enclosure, *, opens: bool, unparks: bool) -> list[NightStep]:
    """Give what brings telescope and roof to rest; a failed park does not end it.

    While a command that ``opens`` the roof or ``unparks`` the telescope may still be under way,
    sensors that say closed or parked say only that it has not got there yet.
    """
    steps = steps_of(rule.abort, "ending what is under way")
    if rule.park is not None:

        def is_parked(view: NightView) -> bool:
            return view.parked is True

        steps.append(
            NightStep(
                words="parking the telescope",
                command=rule.park.command,
                args=rule.park.args,
                within=rule.mount_within,
                tries=2,
                # Past that the roof closes all the same; `Enclosure.past_deadline` is the guard's.
                required=False,
                insists=True,
                reached=is_parked,
                asks_first=unparks,
            )
        )

    def is_closed(view: NightView) -> bool:
        return view.closed is True

    steps.append(
        NightStep(
            words="closing the roof",
            command=rule.close.command,
            args=rule.close.args,
            within=rule.close.within or STEP_S,
            tries=1 + rule.retries,
            insists=True,
            reached=is_closed,
            asks_first=opens,
        )
    )
    return steps


def abort_commands(
    rule: Enclosure, view: NightView, next_id: Callable[[], str]
) -> list[NightAction]:
    """Give what ends an exposure at once; nobody waits for it."""
    actions: list[NightAction] = []
    for step in steps_of(rule.abort, "ending the exposure"):
        actions += StepRunner([step], next_id).update_steps(view)
    return actions


def steps_of(steps: tuple[Step, ...], words: str) -> list[NightStep]:
    """Give steps of the description as such of the night."""
    return [
        NightStep(
            words=words,
            command=step.command,
            args=step.args,
            within=step.within or STEP_S,
            required=False,
        )
        for step in steps
    ]
