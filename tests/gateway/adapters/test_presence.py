"""Who is there, of what is heard, offered and answered; time is moved by hand."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from talaia.clock import MS
from talaia.gateway.adapters.presence import LOOK_S, Deafness, DeviceEndpoints, DevicePresence

pytestmark = pytest.mark.pure

LOOK_NS = round(LOOK_S * 1000) * MS
NODE = frozenset({"/dome_server"})
THERE, NOTHING = DeviceEndpoints(there=True, nodes=NODE, askable=NODE), DeviceEndpoints(there=False)


class Robot:
    """One device, whose node answers or not."""

    def __init__(self, offer: DeviceEndpoints) -> None:  # noqa: D107
        self.told: list[str] = []
        self.asked = 0
        self.now = 10_000 * MS
        self.heard = 0
        self.offer = offer
        self.answers = True
        self.presence = DevicePresence(["dome"], lambda _, why, _sure: self.told.append(why))

    def looks(self, times: int, *, speaks: bool = False) -> None:
        for _ in range(times):
            self.now += LOOK_NS
            if speaks:
                self.heard = self.now
            for node in self.presence.judge_devices(
                self.now, {"dome": self.offer}, {"dome": self.heard}
            ):
                self.asked += 1
                if self.answers:
                    self.presence.mark_alive(node, self.now)


@pytest.fixture
def robot() -> Robot:
    return Robot(THERE)


def test_who_speaks_is_not_asked(robot: Robot) -> None:
    robot.looks(40, speaks=True)
    assert (robot.asked, robot.told) == (0, [])


def test_who_is_silent_and_answers_is_there(robot: Robot) -> None:
    robot.looks(40)
    assert robot.asked >= 10
    assert robot.told == []


def test_who_is_silent_and_does_not_answer_is_away_within_two_seconds_and_back_at_a_word(
    robot: Robot,
) -> None:
    robot.looks(4, speaks=True)
    robot.answers = False
    silent = robot.now
    while not robot.told:
        robot.looks(1)
    assert robot.now - silent < 2_000 * MS
    assert robot.told == ["/dome_server does not answer"]
    robot.looks(1, speaks=True)
    assert robot.told == ["/dome_server does not answer", ""]


def test_an_answer_brings_it_back_too(robot: Robot) -> None:
    robot.answers = False
    robot.looks(10)
    robot.answers = True
    robot.looks(2)
    assert robot.told == ["/dome_server does not answer", ""]


def test_a_gateway_that_stood_still_blames_nobody(robot: Robot) -> None:
    robot.looks(4, speaks=True)
    robot.answers = False
    robot.looks(2)
    robot.now += 60_000 * MS
    robot.answers = True
    robot.looks(1)
    assert robot.told == []


def test_who_cannot_be_asked_is_away_only_when_the_graph_says_so() -> None:
    robot = Robot(DeviceEndpoints(there=True, nodes=NODE))
    robot.looks(40)
    assert (robot.asked, robot.told) == (0, [])
    robot.offer = NOTHING
    robot.looks(1)
    assert robot.told == ["nothing of it is on the robot now"]


def test_one_of_two_nodes_that_lives_is_enough() -> None:
    both = frozenset({"/a", "/b"})
    robot = Robot(DeviceEndpoints(there=True, nodes=both, askable=both))
    robot.presence.mark_dead("/a")
    robot.looks(10)
    assert robot.told == []


def test_a_node_of_whom_nothing_is_left_is_away_at_once(robot: Robot) -> None:
    robot.answers = False
    robot.looks(1)
    robot.presence.mark_dead("/dome_server")
    robot.looks(1)
    assert robot.told == ["/dome_server does not answer"]


def test_what_was_never_there_is_not_missed() -> None:
    robot = Robot(NOTHING)
    robot.looks(40)
    assert robot.told == []


@given(
    st.lists(st.tuples(st.booleans(), st.booleans(), st.booleans()), max_size=60),
    st.sampled_from(["alive", "gone"]),
)
def test_whatever_happened_before_it_is_there_as_soon_as_it_speaks(
    past: list[tuple[bool, bool, bool]], last: str
) -> None:
    robot = Robot(THERE)
    for speaks, answers, there in past:
        robot.answers = answers
        robot.offer = THERE if there else NOTHING
        robot.looks(1, speaks=speaks)
    if last == "gone":
        robot.presence.mark_dead("/dome_server")
    robot.offer = THERE
    robot.looks(1, speaks=True)
    assert not robot.told or not robot.told[-1]
    # Told of changes only.
    assert all(one != other for one, other in zip(robot.told, robot.told[1:], strict=False))


def test_nobody_is_deaf_before_anybody_was_asked_nor_while_anybody_speaks(robot: Robot) -> None:
    assert robot.presence.deaf is None
    robot.looks(8, speaks=True)
    assert robot.presence.deaf is False
    robot.looks(40)
    assert robot.presence.deaf is False
    robot.answers = False
    robot.looks(8)
    assert robot.presence.deaf is True
    robot.looks(1, speaks=True)
    assert robot.presence.deaf is False
    # What has left the graph is gone, and no fault of one's own ears.
    robot.offer = NOTHING
    robot.looks(40)
    assert robot.presence.deaf is None


def test_who_is_there_without_a_name_and_silent_has_never_reached_us(robot: Robot) -> None:
    robot.offer = DeviceEndpoints(there=True, nodes=NODE, nameless=True)
    robot.looks(8, speaks=True)
    assert robot.presence.deaf is False
    robot.looks(8)
    assert robot.presence.deaf is True
    # A name without an answer yet proves nothing.
    robot.offer = DeviceEndpoints(there=True, nodes=NODE)
    robot.looks(8)
    assert robot.presence.deaf is not True


def test_whoever_hears_nobody_joins_anew_ever_more_seldom_until_somebody_is_heard() -> None:
    deafness = Deafness()

    def joins(looks: int) -> list[int]:
        """After how many looks it joins anew; the first ones behind that tell nothing yet."""
        found = []
        for number in range(1, looks + 1):
            if deafness.should_rejoin(deaf=True):
                found.append(number)
                assert not deafness.should_rejoin(deaf=None)
        return found

    first = Deafness.FIRST
    # A robot that was killed is on the graph for 20 s.
    assert first * LOOK_S > 20
    assert joins(7 * first) == [first, 3 * first, 7 * first]
    assert len(joins(40 * Deafness.LONGEST)) in range(39, 43)
    assert not deafness.should_rejoin(deaf=False)
    assert joins(first) == [first]
