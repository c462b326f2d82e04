"""The states of one alarm, and everything that takes it from one to another.

::

    normal ──raise──▶ active ──acknowledge──▶ acknowledged ──clear──▶ normal
                        │ ▲                                             ▲
                      clear raise                                       │
                        ▼ │                                             │
                      cleared ───────────── acknowledge ────────────────┘

All passes through `apply_event`. Each time it is raised begins an *episode* with its own number, by
which a message about it is told from any other, also over a restart.

Long, because every state and event of an alarm is in one place.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import NamedTuple, assert_never

from talaia.errors import TalaiaError

__all__ = [
    "Acknowledge",
    "Assign",
    "Clear",
    "Comment",
    "Event",
    "Grow",
    "Happened",
    "NotNow",
    "Phase",
    "Raise",
    "Remind",
    "Retire",
    "Shelve",
    "State",
    "Unshelve",
    "What",
    "apply_event",
]


class Phase(StrEnum):
    """Where an alarm stands."""

    NORMAL = "normal"
    ACTIVE = "active"
    ACKNOWLEDGED = "acknowledged"
    # Over, and nobody has said that they have seen it.
    CLEARED = "cleared"


class What(StrEnum):
    """What happened to an alarm."""

    RAISED = "raised"
    REMINDED = "reminded"
    CLEARED = "cleared"
    ACKNOWLEDGED = "acknowledged"
    ASSIGNED = "assigned"
    COMMENTED = "commented"
    SHELVED = "shelved"
    UNSHELVED = "unshelved"
    # No description asks for it any more.
    RETIRED = "retired"


@dataclass(frozen=True, slots=True)
class State:
    """One alarm, as the database has it. Times are µs since the epoch (UTC); 0: not yet.

    Attributes:
        episode: how often it has been raised.
        assigned: who sees to it.
        shelved_until_us: it is shown apart and nobody is told of it until then.

    """

    phase: Phase = Phase.NORMAL
    episode: int = 0
    # Why it was raised, as people read it; kept after the end for the log.
    why: str = ""
    # Of the present episode or the last one.
    raised_us: int = 0
    # 0 while it is on.
    cleared_us: int = 0
    # Who has seen this episode; the next raise empties both.
    acked_us: int = 0
    acked_by: str = ""
    assigned: str = ""
    shelved_until_us: int = 0
    # Both empty while it is not shelved.
    shelved_by: str = ""
    shelved_why: str = ""

    @property
    def on(self) -> bool:
        """Whether its condition counts as true."""
        return self.phase in {Phase.ACTIVE, Phase.ACKNOWLEDGED}

    @property
    def unseen(self) -> bool:
        """Whether it waits for somebody to acknowledge it."""
        return self.phase in {Phase.ACTIVE, Phase.CLEARED}


class Raise(NamedTuple):
    """Its condition has begun to count; ``anew``: another cause, whether or not it is on."""

    time_us: int
    why: str
    to: tuple[str, ...] = ()
    anew: bool = False


class Grow(NamedTuple):
    """What it is about has become more, or otherwise; nobody is told once more."""

    time_us: int
    why: str


class Clear(NamedTuple):
    """Its condition has ceased to count."""

    time_us: int
    why: str


class Remind(NamedTuple):
    """It still stands, and people are told again; ``to``: only these accounts, none: everybody."""

    time_us: int
    to: tuple[str, ...] = ()


class Acknowledge(NamedTuple):
    """Somebody has seen it."""

    time_us: int
    who: str
    comment: str = ""


class Assign(NamedTuple):
    """Somebody is to see to it; an empty ``to``: nobody."""

    time_us: int
    who: str
    to: str


class Comment(NamedTuple):
    """Somebody has something to say about it."""

    time_us: int
    who: str
    text: str


class Shelve(NamedTuple):
    """It is put aside until a moment."""

    time_us: int
    who: str
    until_us: int
    why: str


class Unshelve(NamedTuple):
    """It is put aside no longer: by somebody, or (no ``who``) since the time is over."""

    time_us: int
    who: str = ""


class Retire(NamedTuple):
    """There is no such alarm any more."""

    time_us: int
    who: str = ""


Event = Raise | Grow | Remind | Clear | Acknowledge | Assign | Comment | Shelve | Unshelve | Retire


class Happened(NamedTuple):
    """What came of an event.

    Attributes:
        tell: people are to be told of it, by whatever way they chose.
        to: only these accounts are told; none: everybody who wants to.

    """

    what: What
    episode: int
    time_us: int
    who: str
    message: str
    tell: bool = False
    to: tuple[str, ...] = ()


class NotNow(TalaiaError):
    """What somebody asked of an alarm makes no sense as it stands."""

    def __init__(self, problem: str) -> None:
        """Say why, in a sentence."""
        super().__init__(problem)
        self.problem = problem

    def __str__(self) -> str:
        return self.problem


def apply_event(state: State, event: Event) -> tuple[State, tuple[Happened, ...]]:
    """Give the state after ``event``, and what happened; nothing when it changes nothing.

    Raises:
        NotNow: a person asked for what cannot be done as it stands.

    """
    match event:
        case Raise():
            return _apply_raise(state, event)
        case Grow():
            return (replace(state, why=event.why) if state.on else state), ()
        case Remind():
            # It may have changed while the reminder waited to be written.
            if not state.on or _is_shelved(state, event.time_us):
                return state, ()
            seen = f" (acknowledged by {state.acked_by})" if state.acked_by else ""
            why = f"still so{seen}: {state.why}"
            again = _make_happened(
                What.REMINDED, state, event.time_us, who="", message=why, tell=True
            )
            return state, (again._replace(to=event.to),)
        case Clear():
            return _apply_clear(state, event)
        case Acknowledge():
            return _apply_acknowledge(state, event)
        case Assign():
            message = f"to {event.to}" if event.to else "to nobody"
            said = _make_happened(
                What.ASSIGNED, state, event.time_us, who=event.who, message=message
            )
            # To whom it is assigned already: nothing to write.
            return (
                (state, ())
                if state.assigned == event.to
                else (_apply_assign(state, event), (said,))
            )
        case Comment():
            return state, (
                _make_happened(
                    What.COMMENTED, state, event.time_us, who=event.who, message=event.text
                ),
            )
        case Shelve():
            return _apply_shelve(state, event)
        case Unshelve():
            return _apply_unshelve(state, event)
        case Retire():
            return _apply_retire(state, event)
        case _:
            assert_never(event)


def _apply_raise(state: State, event: Raise) -> tuple[State, tuple[Happened, ...]]:
    # A repeat, for instance after a restart: no new episode.
    if state.on and not event.anew:
        return state, ()
    after = replace(
        state,
        phase=Phase.ACTIVE,
        episode=state.episode + 1,
        why=event.why,
        raised_us=event.time_us,
        cleared_us=0,
        acked_us=0,
        acked_by="",
        # What comes back before anybody has seen it stays with whoever sees to it.
        assigned=state.assigned if state.phase is Phase.CLEARED else "",
    )
    tell = not _is_shelved(state, event.time_us)
    said = _make_happened(What.RAISED, after, event.time_us, who="", message=event.why, tell=tell)
    return after, (said._replace(to=event.to),)


def _apply_clear(state: State, event: Clear) -> tuple[State, tuple[Happened, ...]]:
    if not state.on:
        return state, ()
    # Acknowledged while it was on: nobody has to see it again.
    phase = Phase.CLEARED if state.phase is Phase.ACTIVE else Phase.NORMAL
    after = replace(state, phase=phase, cleared_us=event.time_us)
    tell = not _is_shelved(state, event.time_us)
    return after, (
        _make_happened(What.CLEARED, after, event.time_us, who="", message=event.why, tell=tell),
    )


def _apply_acknowledge(state: State, event: Acknowledge) -> tuple[State, tuple[Happened, ...]]:
    if not state.unseen:
        by = f": {state.acked_by} has acknowledged it" if state.acked_by else ""
        raise NotNow(f"there is nothing to acknowledge{by}")
    # It was over before: to have seen it ends it.
    phase = Phase.ACKNOWLEDGED if state.phase is Phase.ACTIVE else Phase.NORMAL
    after = replace(state, phase=phase, acked_us=event.time_us, acked_by=event.who)
    return after, (
        _make_happened(
            What.ACKNOWLEDGED, after, event.time_us, who=event.who, message=event.comment
        ),
    )


def _apply_assign(state: State, event: Assign) -> State:
    return replace(state, assigned=event.to)


def _apply_shelve(state: State, event: Shelve) -> tuple[State, tuple[Happened, ...]]:
    if event.until_us <= event.time_us:
        raise NotNow("the end of the shelving is not in the future")
    after = replace(
        state,
        shelved_until_us=event.until_us,
        shelved_by=event.who,
        shelved_why=event.why,
    )
    return after, (
        _make_happened(What.SHELVED, after, event.time_us, who=event.who, message=event.why),
    )


def _apply_unshelve(state: State, event: Unshelve) -> tuple[State, tuple[Happened, ...]]:
    # The automatic end is asked for at each look until it is written; only people are refused.
    if not state.shelved_until_us:
        if event.who:
            raise NotNow("it is not shelved")
        return state, ()
    after = replace(state, shelved_until_us=0, shelved_by="", shelved_why="")
    # Nobody was told while it was put aside.
    tell = state.phase is Phase.ACTIVE
    message = state.why if tell else ""
    return after, (
        _make_happened(
            What.UNSHELVED, after, event.time_us, who=event.who, message=message, tell=tell
        ),
    )


def _apply_retire(state: State, event: Retire) -> tuple[State, tuple[Happened, ...]]:
    # The number stays: an alarm of this name that comes back goes on from it.
    after = State(episode=state.episode)
    if state == after:
        return state, ()
    return after, (
        _make_happened(
            What.RETIRED, after, event.time_us, who=event.who, message="it is described no more"
        ),
    )


def _is_shelved(state: State, time_us: int) -> bool:
    return state.shelved_until_us > time_us


def _make_happened(
    what: What, state: State, time_us: int, *, who: str, message: str, tell: bool = False
) -> Happened:
    return Happened(what, state.episode, time_us, who, message, tell)
