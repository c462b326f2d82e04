"""Which release of a gateway runs, which is tried, and what follows from each event. Pure.

    idle ── begin ──▸ installing ── installed ──▸ waiting ── at rest ──▸ allowed
     ▴                    │ failed, or cut off        ▴── it moves again ────┤ start
     ├────────────────────┘                                                  ▾
     ├──────────────── the link is back: the new one is kept ────────────  trying
     └── it ended, was not back in time, or was started too often: the old one ──┘

The state is on disk before anything is done by it, so whatever ends a machine ends it in one of
these states; `recover_state` says what follows at the next start. `current` is a whole release in
each of them.
"""

from __future__ import annotations

import re
from enum import StrEnum
from typing import Annotated

import msgspec
from msgspec import Meta

from talaia.updates.errors import UpdateError

__all__ = [
    "MOST_TRIES",
    "SlotPhase",
    "SlotState",
    "begin_trial",
    "begin_update",
    "confirm_trial",
    "end_trial",
    "mark_allowed",
    "mark_installed",
    "recover_state",
    "slot_to_run",
    "version_order",
    "withdraw_permission",
]

# A power cut in the middle of a trial is no fault of the release; a machine that restarts again
# and again may be.
MOST_TRIES = 3
_VERSION = re.compile(
    r"([0-9]{1,6})\.([0-9]{1,6})(?:\.([0-9]{1,6}))?(?:(a|b|rc)([0-9]{1,6}))?"
    # Of a checkout: commits since the release before, and which one it is.
    r"(?:\.dev([0-9]{1,6})(?:\+g[0-9a-f]{4,40})?)?\Z"
)
# Behind all commits on the way to it.
_MADE = 1_000_000
_Version = Annotated[str, Meta(max_length=40)]


class SlotPhase(StrEnum):
    """How far an update is."""

    IDLE = "idle"
    INSTALLING = "installing"
    WAITING = "waiting"
    ALLOWED = "allowed"
    TRYING = "trying"


class SlotState(msgspec.Struct, frozen=True, kw_only=True):
    """What is on disk of the releases.

    Attributes:
        current: the release that is known to work.
        candidate: the one that is installed or tried; empty when idle.
        tries: how often the candidate was started.
        previous: what was current before; it stays on disk, to go back by hand.
        failed: releases that were tried and left, and why.

    """

    current: _Version
    phase: SlotPhase = SlotPhase.IDLE
    candidate: _Version = ""
    tries: int = 0
    previous: _Version = ""
    failed: dict[str, str] = {}


def version_order(version: str) -> tuple[int, ...]:
    """Give what versions are sorted by; pre-releases come before their release.

    Raises:
        UpdateError: it is no version.

    """
    found = _VERSION.match(version)
    if found is None:
        raise UpdateError(f"{version[:40]!r} is no version like 1.2.3 or 1.3.0rc1")
    major, minor, patch, kind, number, commits = found.groups()
    # What is on its way to a version comes before it, and before the pre-releases of that.
    unmade = -1 if commits else 3
    before = ("a", "b", "rc").index(kind) if kind else unmade
    made = _MADE if commits is None else int(commits)
    return int(major), int(minor), int(patch or 0), before, int(number or 0), made


def slot_to_run(state: SlotState) -> str:
    """Give the release that a start runs."""
    return state.candidate if state.phase is SlotPhase.TRYING else state.current


def begin_update(state: SlotState, version: str, *, downgrade: bool) -> SlotState:
    """Begin to install a release.

    Raises:
        UpdateError: another one is under way, it is what runs, or it is older and may not be.

    """
    if state.phase not in (SlotPhase.IDLE, SlotPhase.WAITING):
        raise UpdateError(f"the update to {state.candidate} is under way ({state.phase})")
    if version == state.current:
        raise UpdateError(f"{version} is what runs")
    if version_order(version) < version_order(state.current) and not downgrade:
        raise UpdateError(
            f"{version} is older than {state.current}, and this gateway takes no older ones "
            "(--allow-downgrade)"
        )
    # Tried again: what was said of it before is not said of this time.
    failed = {name: why for name, why in state.failed.items() if name != version}
    return msgspec.structs.replace(
        state, phase=SlotPhase.INSTALLING, candidate=version, tries=0, failed=failed
    )


def mark_installed(state: SlotState) -> SlotState:
    """Note that the candidate is whole on disk."""
    _expect(state, SlotPhase.INSTALLING)
    return msgspec.structs.replace(state, phase=SlotPhase.WAITING)


def mark_allowed(state: SlotState) -> SlotState:
    """Note that the gateway is at rest and ends in favour of the candidate."""
    _expect(state, SlotPhase.WAITING)
    return msgspec.structs.replace(state, phase=SlotPhase.ALLOWED)


def withdraw_permission(state: SlotState) -> SlotState:
    """Let what was allowed wait again: something began to move before the gateway ended."""
    _expect(state, SlotPhase.ALLOWED)
    return msgspec.structs.replace(state, phase=SlotPhase.WAITING)


def begin_trial(state: SlotState) -> SlotState:
    """Count a start of the candidate."""
    _expect(state, SlotPhase.ALLOWED, SlotPhase.TRYING)
    return msgspec.structs.replace(state, phase=SlotPhase.TRYING, tries=state.tries + 1)


def confirm_trial(state: SlotState) -> SlotState:
    """Keep the candidate: its link to the hub is there."""
    _expect(state, SlotPhase.TRYING)
    failed = {name: why for name, why in state.failed.items() if name != state.candidate}
    return SlotState(current=state.candidate, previous=state.current, failed=failed)


def end_trial(state: SlotState, why: str) -> SlotState:
    """Go back to what ran before."""
    _expect(state, SlotPhase.INSTALLING, SlotPhase.WAITING, SlotPhase.ALLOWED, SlotPhase.TRYING)
    return SlotState(
        current=state.current,
        previous=state.previous,
        failed={**state.failed, state.candidate: why},
    )


def recover_state(state: SlotState) -> SlotState:
    """Say what follows at a start, whatever ended the machine before; the caller counts a trial."""
    if state.phase is SlotPhase.INSTALLING:
        # Half of a release is none.
        return end_trial(state, "its installation was cut off")
    if state.phase is SlotPhase.TRYING and state.tries >= MOST_TRIES:
        return end_trial(state, f"started {state.tries} times without a link to the hub")
    return state


def _expect(state: SlotState, *phases: SlotPhase) -> None:
    if state.phase not in phases:
        raise UpdateError(f"the update is {state.phase}, which does not fit")
