"""What a night's hardware did, judged by the simulator's own ledger. Pure.

The limits are those of the example's description: the telescope parks first for at most half a
minute, the shutter takes twelve seconds, interlocks look at values of two seconds.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

from talaia.gateway.night.observation_book import MOST_WAITING
from talaia.wire.frames import NightPhase, ObservationUpdate

from .night_world import NightWorld
from .sky_robot import Truth

# Unsafe and still not closed after so long is a fault (s).
CLOSED_WITHIN_S = 75.0
# What is unknown (the station is silent) is so after the signals' own age.
KNOWN_S = 6.0
# What opens when it becomes unsafe may go on so long.
TURN_S = 8.0


def unsafe_reason(one: Truth) -> str:
    """Say why a roof must not be open at that moment, by the weather itself; empty: it may."""
    limits = (
        (one.rain > 0.0, "rain"),
        (one.wind > 45.0, "wind"),
        (one.gust > 65.0, "gusts"),
        (one.humidity > 85.0, "humidity"),
        (one.dew_gap < 2.0, "dew"),
        (one.clouds > 90.0, "clouds"),
        (one.weather_silent, "nothing is known of the weather"),
        (one.sun > -6.0, "the Sun"),
    )
    return next((name for holds, name in limits if holds), "")


class RoofJudge:
    """Follows the ledger from entry to entry.

    A value that is over its limit for a moment only, as gusts are, begins nothing: interlocks ask
    for some seconds of it, and here it has to last until the roof would have been closed.
    """

    def __init__(self) -> None:
        """Begin with what is safe."""
        self.wrong: list[str] = []
        self._unsafe_since: float | None = None
        # Since when roof and weather stand so that it has to be closed and could be.
        self._due_since: float | None = None
        self._before: Truth | None = None

    def add(self, one: Truth, *, by_hand: bool) -> None:
        """Take the next entry; ``by_hand``: somebody at the dome moves it."""
        why = unsafe_reason(one)
        self._unsafe_since = (self._unsafe_since or one.at) if why else None
        could = bool(why) and one.roof != "closed" and not one.roof_dead and not by_hand
        self._due_since = (self._due_since or one.at) if could else None
        margin = KNOWN_S if one.weather_silent else 0.0
        if self._due_since is not None and one.at - self._due_since > CLOSED_WITHIN_S + margin:
            self.wrong.append(
                f"{one.at:.0f}: {one.roof} for more than {CLOSED_WITHIN_S:g} s: {why}"
            )
            self._due_since = math.inf
        unsafe_s = one.at - self._unsafe_since if self._unsafe_since is not None else 0.0
        began = self._before is not None and self._before.roof == "closed"
        if one.roof == "opening" and began and unsafe_s > TURN_S + margin and not by_hand:
            self.wrong.append(f"{one.at:.0f}: it begins to open: {why}")
        self._before = one


def judge_roof(truths: Iterable[Truth], by_hand: Sequence[tuple[float, float]]) -> list[str]:
    """Say where the roof was open or opened while unsafe or unknown."""
    judge = RoofJudge()
    for one in truths:
        hand = any(since <= one.at <= until for since, until in by_hand)
        judge.add(one, by_hand=hand)
    return judge.wrong


def judge_morning(world: NightWorld) -> Iterator[str]:
    """Say what is not at rest in the morning."""
    last = world.truths[-1]
    if (last.roof, last.telescope) != ("closed", "parked"):
        yield f"in the morning the roof is {last.roof} and the telescope {last.telescope}"
    if last.camera == "exposing" or last.cooling:
        yield f"in the morning the camera is {last.camera}, its cooler {last.cooling}"
    if world.phase in {NightPhase.OPENING, NightPhase.OBSERVING}:
        yield f"in the morning the night is {world.phase}"


def judge_requests(world: NightWorld, asked: Iterable[str]) -> Iterator[str]:
    """Say of which request nobody knows why it was not observed, or what it counts wrongly."""
    last: dict[str, ObservationUpdate] = {}
    for _, update in sorted(world.hub.updates.items()):
        before = last.get(update.request)
        same = before is not None and before.id == update.id
        if same and before is not None and sum(update.frames_done) < sum(before.frames_done):
            yield f"{update.request} has fewer frames than before"
        last[update.request] = update
    why_not = {one.request: one.sentence for plan in world.hub.plans for one in plan.why_not}
    for name in asked:
        told = last.get(name)
        if told is None:
            waits = world.hub.states[-1].why if world.hub.states else ""
            if not (why_not.get(name) or waits):
                yield f"{name}: never begun, and nobody says why"
        elif told.state.name == "IN_PROGRESS":
            yield f"{name} is still in progress in the morning"
        elif told.state.name != "COMPLETED" and not told.why:
            yield f"{name} ended as {told.state} without a reason"
    yield from judge_numbers(world.hub.updates)


def judge_numbers(updates: Mapping[int, ObservationUpdate]) -> Iterator[str]:
    """Say what of the gateway's updates never came to the hub.

    With more waiting than the gateway keeps, steps within a try are left out by it. So no try may
    be missing then, and nothing of what was told last; how each try ended is judged besides.
    """
    numbers = sorted(updates)
    whole = list(range(1, len(numbers) + 1))
    if numbers == whole:
        return
    if numbers[-1] <= MOST_WAITING:
        yield f"the hub lacks updates: it has {numbers}"
    tries = sorted({int(update.id.rpartition("-")[2]) for update in updates.values()})
    if tries != list(range(1, len(tries) + 1)):
        yield f"the hub lacks tries: it has {tries}"


def judge_pictures(world: NightWorld) -> Iterator[str]:
    """Say which exposure is in the archive twice or not at all, and where counts differ."""
    made = [name for name, _ in world.robot.pictures]
    kept = world.archived()
    counted: dict[str, int] = {}
    for update in world.hub.updates.values():
        frames = sum(update.frames_done)
        counted[update.request] = max(counted.get(update.request, 0), frames)
    if len(kept) + len(world.refused) != len(made):
        yield f"{len(made)} pictures were read out, {len(kept)} are in the archive"
    if len(set(kept)) != len(kept):
        yield "a picture is in the archive twice"
    of_sky = [one for one in kept if b"= 'Light" in one[:5760]]
    for request, frames in counted.items():
        mine = sum(f"= '{request} ".encode() in one[:5760] for one in of_sky)
        if mine < frames:
            yield f"{request}: {frames} frames are counted, {mine} are in the archive"


def judge_night(
    world: NightWorld, asked: Iterable[str], by_hand: Sequence[tuple[float, float]]
) -> list[str]:
    """Give all that was not as it has to be."""
    return [
        *judge_roof(world.truths, by_hand),
        *judge_morning(world),
        *judge_requests(world, asked),
        *judge_pictures(world),
    ]
