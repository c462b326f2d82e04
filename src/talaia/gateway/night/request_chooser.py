"""What is to be observed next: asks the planner, looks at its answer, and does without it. Pure."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

from talaia.gateway.night.frames.calibration_choice import best_calibration
from talaia.gateway.night.night_values import NightAction, NightEvent, PlanQuestion
from talaia.gateway.night.simple_dispatch import (
    NightLimits,
    best_request,
    pending_requests,
    veto_reason,
)
from talaia.model.observing.requests import Urgency

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.gateway.night.night_values import NightChoice, NightView
    from talaia.gateway.night.simple_dispatch import AskedRequest
    from talaia.model.interlocks.enclosure import Place
    from talaia.model.night_section import NightSection
    from talaia.model.observing.requests import RequestGroup

__all__ = ["LOOK_S", "RequestChooser"]

# A planner that has not answered by then is not waited for (s).
PLANNER_S = 30.0
# Between two looks whether something may be observed (s).
LOOK_S = 20.0
# The same for one that is urgent, while another is observed: what the planner reckons with goes by
# the minute.
RAPID_LOOK_S = 60.0
# A request that has interrupted another interrupts none again for so long (s), whatever became of
# it.
RAPID_AGAIN_S = 1800.0
# Of another's reckoning; see `veto_reason`.
SLACK = 1.0


class RequestChooser:
    """Knows what is asked, what there is of it, and what is left alone for a while.

    Attributes:
        wait_until: the planner has nothing before (s since the epoch, UTC); 0: nobody knows.

    """

    def __init__(self, night: NightSection, place: Place) -> None:
        """Begin with nothing asked."""
        filters = frozenset(night.filter.filters if night.filter is not None else ())
        times, self._night = night.times, night
        self._limits = NightLimits(place, times, night.sun.observing, filters)
        self._asked: dict[str, AskedRequest] = {}
        # Frames read out, in all tries; what has ended; what is not tried before (UTC, s).
        self._done: dict[str, tuple[int, ...]] = {}
        self._ended: set[str] = set()
        self._held: dict[str, float] = {}
        # Urgent ones that have interrupted another, and interrupt none before (monotonic, s).
        self._interrupted: dict[str, float] = {}
        self._numbers = itertools.count(1)
        # The question that is open, and until when it is waited for (monotonic, s).
        self._question: tuple[int, float] | None = None
        self._choice: NightChoice | None = None
        # Said once, until it does well again.
        self._planner_failed = False
        self._next_look = 0.0
        self.wait_until = 0.0

    @property
    def thinks(self) -> bool:
        """Whether the planner has been asked and has not answered yet."""
        return self._question is not None

    def replace_requests(
        self,
        groups: Sequence[RequestGroup],
        done: Mapping[str, tuple[int, ...]],
        ended: frozenset[str],
    ) -> None:
        """Take what is asked from now on, with what there is of it already."""
        self._asked = {one.request.id: one for one in pending_requests(groups)}
        self._done, self._ended = dict(done), set(ended)
        self.look_again()

    def frames_done(self, request: str) -> tuple[int, ...]:
        """Give what there is of a request, of each configuration."""
        return self._done.get(request, ())

    def take_hours(self, left: Mapping[str, float]) -> None:
        """Take what each proposal has left (s); one that is not named cannot pay."""
        self._limits = self._limits._replace(left=dict(left))

    def keep_frames(self, request: str, frames: tuple[int, ...]) -> bool:
        """Keep what was read out; tell whether that is more than before."""
        before = self._done.get(request, ())
        self._done[request] = frames
        return sum(frames) > sum(before)

    def end_request(self, request: str) -> None:
        """Plan it no more."""
        self._ended.add(request)

    def hold_request(self, request: str, until: float) -> None:
        """Leave it alone until then (s since the epoch, UTC)."""
        self._held[request] = until

    def held_requests(self) -> dict[str, float]:
        """Give what is left alone for a while, until when (s since the epoch, UTC)."""
        return dict(self._held)

    def look_again(self) -> None:
        """Ask anew at the next turn: another choice may be better now."""
        self._choice, self._question = None, None
        self._next_look, self.wait_until = 0.0, 0.0

    def take_choice(self, choice: NightChoice) -> None:
        """Take what the planner answers; an answer to an earlier question is passed over."""
        if self._question is not None and choice.number == self._question[0]:
            self._choice, self._question = choice, None

    def rapid_request(
        self, view: NightView, current: str
    ) -> tuple[AskedRequest | None, list[NightAction]]:
        """Give a request that is urgent and is to be observed instead of ``current``, if any.

        Only one that the planner would begin now: it knows the Moon, the horizon's outline and the
        hours of proposals, and what it refuses would interrupt block after block for nothing.

        Returns:
            The request, and what to ask to know of one.

        """
        urgent = [
            asked
            for asked in self._asked.values()
            if asked.urgency is Urgency.RAPID_RESPONSE
            and view.now >= self._interrupted.get(asked.request.id, 0.0)
            and not self._veto(asked, view)
        ]
        if not urgent:
            self._choice = self._question = None
            return None, []
        chosen, actions = self._ask_of_rapid(view, current)
        found = next((asked for asked in urgent if asked.request.id == chosen), None)
        if found is not None:
            self._interrupted[chosen] = view.now + RAPID_AGAIN_S
        return found, actions

    def _ask_of_rapid(self, view: NightView, current: str) -> tuple[str, list[NightAction]]:
        """Give what would be begun now, as soon as it is known; empty: nothing, or not yet."""
        if self._choice is not None:
            choice, self._choice = self._choice, None
            self._next_look, self._planner_failed = view.now + RAPID_LOOK_S, False
            return choice.request, []
        if self._question is not None:
            if view.now < self._question[1]:
                return "", []
            self._question = None
            simple, actions = self._choose_simply(view, "the planner does not answer")
            self._next_look = view.now + RAPID_LOOK_S
            return simple.request.id if simple is not None else "", actions
        return "", self._ask_planner(view, current)

    def calibration(self, view: NightView, *, flats: bool) -> AskedRequest | None:
        """Give what is to be taken now of flats, or of what needs no sky; no planner is asked."""
        return best_calibration(
            self._asked.values(),
            view,
            self._night,
            flats=flats,
            done=self._done,
            ended=frozenset(self._ended),
            held=self._held,
            left=self._limits.left,
        )

    def flats_now(self, view: NightView) -> AskedRequest | None:
        """Give a request of flats, while the sky is too bright for targets and not for flats."""
        sun = self._night.sun
        if not sun.observing < view.sun <= sun.closing:
            return None
        return self.calibration(view, flats=True)

    def choose_request(self, view: NightView) -> tuple[AskedRequest | None, list[NightAction]]:
        """Give what is to be observed now, if anything is known yet, and what to ask."""
        if flats := self.flats_now(view):
            return flats, []
        if self._choice is not None:
            return self._judge_choice(view, self._choice)
        if self._question is not None:
            if view.now < self._question[1]:
                return None, []
            self._question = None
            return self._choose_simply(view, "the planner does not answer")
        return None, self._ask_planner(view)

    def _ask_planner(self, view: NightView, current: str = "") -> list[NightAction]:
        """Ask, unless it was asked a moment ago."""
        if view.now < self._next_look:
            return []
        number = next(self._numbers)
        self._question = number, view.now + PLANNER_S
        return [PlanQuestion(number, view.time, current)]

    def _judge_choice(
        self, view: NightView, choice: NightChoice
    ) -> tuple[AskedRequest | None, list[NightAction]]:
        self._choice = None
        self._next_look = view.now + LOOK_S
        self.wait_until = 0.0
        if not choice.request:
            self._planner_failed = False
            self.wait_until = choice.wait_until
            return None, []
        asked = self._asked.get(choice.request)
        why = "there is no such request" if asked is None else self._veto(asked, view, SLACK)
        if asked is None or why:
            return self._choose_simply(view, f"the planner chose {choice.request}, but {why}")
        self._planner_failed = False
        return asked, []

    def _choose_simply(
        self, view: NightView, why: str
    ) -> tuple[AskedRequest | None, list[NightAction]]:
        self._next_look = view.now + LOOK_S
        found = best_request(
            self._asked.values(),
            view,
            self._limits,
            done=self._done,
            ended=frozenset(self._ended),
            held=self._held,
        )
        if self._planner_failed:
            return found, []
        self._planner_failed = True
        more = f"{why}; the simplest planner stands in"
        return found, [NightEvent("night_planner_failed", more, good=False)]

    def _veto(self, asked: AskedRequest, view: NightView, slack: float = 0.0) -> str:
        name = asked.request.id
        return veto_reason(
            asked,
            view,
            self._limits,
            done=self._done.get(name, ()),
            ended=frozenset(self._ended),
            held_until=self._held.get(name, 0.0),
            slack=slack,
        )
