"""A dome that turns to where its telescope points, and exposures that wait for it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from talaia.clock import SECOND
from talaia.gateway.ports import ChannelReading
from talaia.gateway.safety.dome_following import Follower, hold_of
from talaia.gateway.safety.interlocks import Interlocks
from talaia.model.interlocks.enclosure import Follow, Sighting
from talaia.model.yaml_text.load import load_site

if TYPE_CHECKING:
    from talaia.model.interlocks.interlock import Step

pytestmark = pytest.mark.pure

TICK = SECOND // 10
FOLLOW = Follow(
    target="t/az",
    azimuth="d/az",
    when=Sighting(signal="t/state", is_one_of=("tracking",)),
    command="dome/goto",
)


@pytest.mark.parametrize(
    ("target", "azimuth", "settled", "expected"),
    [
        (100.0, 94.0, True, 100.0),
        (100.0, 96.0, True, None),
        (1.0, 358.0, True, None),
        (3.0, 357.0, True, 3.0),
        (100.0, 10.0, False, None),
        (None, 10.0, True, None),
        (100.0, None, True, None),
    ],
)
def test_a_dome_follows_to_the_final_target_only_and_only_when_it_is_worth_it(
    target: float | None,
    azimuth: float | None,
    settled: bool,  # noqa: FBT001 - given by the table
    expected: float | None,
) -> None:
    step = Follower(FOLLOW).next_step(target, azimuth, 0, settled=settled)
    assert (None if step is None else step.args["azimuth"]) == expected


def test_a_dome_that_does_not_come_is_not_asked_at_every_look() -> None:
    one = Follower(FOLLOW)
    asked = [one.next_step(100.0, 0.0, at * TICK, settled=True) for at in range(100)]
    assert sum(each is not None for each in asked) == 2


def test_a_dome_turns_to_the_end_of_a_slew_while_the_telescope_slews_and_never_chases_it() -> None:
    one = Follower(FOLLOW)
    one.begin_slew(200.0, 0)
    # The telescope still says that it tracks, then that it slews by other azimuths.
    steps = [one.next_step(10.0, 10.0, 0, settled=True, moving=False)]
    steps += [
        one.next_step(10.0 + at, 10.0 + at, at * SECOND, settled=False, moving=True)
        for at in range(1, 20)
    ]
    asked = [step.args["azimuth"] for step in steps if step is not None]
    assert asked == [200.0] * 4


def test_a_slew_that_ended_elsewhere_has_the_dome_come_to_where_the_telescope_stands() -> None:
    one = Follower(FOLLOW)
    one.begin_slew(200.0, 0)
    assert one.next_step(10.0, 10.0, 0, settled=True) is not None
    one.end_slew()
    # A mount that answers at once and slews then is still on its way.
    assert one.next_step(90.0, 200.0, 6 * SECOND, settled=False, moving=True) is None
    back = one.next_step(90.0, 200.0, 12 * SECOND, settled=True, moving=False)
    assert back is not None
    assert back.args["azimuth"] == 90.0


def test_a_slew_that_never_ends_is_not_waited_for_longer_than_an_exposure_is() -> None:
    one = Follower(FOLLOW)
    one.begin_slew(200.0, 0)
    late = round((FOLLOW.wait + 1.0) * SECOND)
    assert one.next_step(10.0, 10.0, late, settled=True, moving=False) is None


def test_a_dome_turns_nowhere_while_nobody_knows_where_telescope_or_slit_are() -> None:
    one = Follower(FOLLOW)
    one.begin_slew(200.0, 0)
    assert one.next_step(None, 10.0, 0, settled=False, moving=None) is None
    assert one.next_step(10.0, None, 0, settled=True, moving=True) is None


@pytest.mark.parametrize(
    ("seen", "said", "final"),
    [
        ({}, None, False),
        ({"apart": 5.0}, None, False),
        ({"apart": 40.0}, "40° from the telescope", False),
        ({"apart": None}, "where telescope and dome stand", False),
        ({"moving": True}, "on its way", False),
        ({"moving": None}, "on its way", False),
        ({"is_open": False}, "until it is open", False),
        ({"is_open": None}, "until it is open", False),
        ({"is_open": False, "closed": True}, "it is closed", True),
    ],
)
def test_an_exposure_waits_for_dome_and_telescope_and_not_for_a_closed_roof(
    seen: dict[str, Any],
    said: str | None,
    final: bool,  # noqa: FBT001 - given by the table
) -> None:
    good = {"is_open": True, "closed": False, "moving": False, "apart": 0.0}
    held = hold_of(FOLLOW, **{**good, **seen})
    if said is None:
        assert held is None
    else:
        assert held is not None
        assert (said in held.why, held.final) == (True, final)


SITE = load_site(
    """
talaia: 1
site: s
name: S
place: {latitude: 42, longitude: 1, elevation: 0}
ros2: {}
devices:
  dome:
    name: Dome
    kind: dome
    signals:
      closed: {name: C, type: state, states: ["no", "yes"], max_age: 2,
               source: {topic: /c, type: std_msgs/msg/Bool, field: data}}
      rain: {name: R, type: state, states: [dry, wet], max_age: 2,
             source: {topic: /r, type: std_msgs/msg/Bool, field: data}}
      azimuth: {name: A, unit: °, max_age: 2,
                source: {topic: /a, type: std_msgs/msg/Float64, field: data}}
    commands:
      close: {name: Close, target: /close, type: std_srvs/srv/Trigger}
      goto:
        name: Go
        target: /goto
        type: rcl_interfaces/srv/SetParametersAtomically
        arguments:
          azimuth: {type: number, field: "parameters[0].value.double_value", name: A}
  telescope:
    name: Telescope
    kind: telescope
    signals:
      azimuth: {name: A, unit: °, max_age: 2,
                source: {topic: /t, type: std_msgs/msg/Float64, field: data}}
      state: {name: S, type: state, states: [slewing, tracking], max_age: 2,
              source: {topic: /s, type: std_msgs/msg/UInt8, field: data}}
    commands:
      point:
        name: Point
        target: /point
        type: rcl_interfaces/srv/SetParametersAtomically
        arguments:
          alt: {type: number, field: "parameters[0].value.double_value", name: Alt}
          az: {type: number, field: "parameters[1].value.double_value", name: Az}
    pointing: {commands: {point: {alt: alt, az: az}}, horizon: 15}
interlocks:
  rain: {name: Rain, when: [{signal: dome/rain, is: [wet]}], refuse: [dome/goto], dwell: 0}
enclosures:
  dome:
    name: Dome
    unsafe: [rain]
    closed: [{signal: dome/closed, is: ["yes"]}]
    close: {command: dome/close}
    follow:
      target: telescope/azimuth
      azimuth: dome/azimuth
      when: {signal: telescope/state, is: [tracking]}
      moving: {signal: telescope/state, is: [slewing]}
      command: dome/goto
"""
)


class Observatory:
    """What sensors say, and what was asked by the gateway itself."""

    def __init__(self) -> None:
        """A telescope that tracks, in fair weather."""
        self.now = 1000 * SECOND
        self.values = {
            "dome/closed": 0.0, "dome/rain": 0.0, "dome/azimuth": 10.0,
            "telescope/azimuth": 10.0, "telescope/state": 1.0,
        }  # fmt: skip
        self.asked: list[tuple[str, Any]] = []
        self.interlocks = Interlocks(
            site=SITE, readings=self, output=self, run=self.run, now_ns=self.now
        )
        self.look()

    def latest(self, address: str) -> ChannelReading | None:
        return ChannelReading(self.values[address], self.now)

    def send(self, message: object) -> None: ...

    def record_event(self, *about: object, good: bool) -> None: ...

    def run(self, _label: str, steps: tuple[Step, ...]) -> None:
        self.asked += [(step.command, step.args) for step in steps]

    def look(self) -> None:
        for _ in range(10):
            self.now += TICK
            self.interlocks.evaluate_all(self.now)

    def point(self, azimuth: float) -> None:
        self.interlocks.begin_command(
            "telescope", "point", "ada", args={"alt": 50.0, "az": azimuth}, now_ns=self.now
        )
        self.look()


def test_a_dome_sets_off_with_its_telescope_whoever_sends_that() -> None:
    one = Observatory()
    assert one.asked == []
    one.point(120.0)
    assert one.asked == [("dome/goto", {"azimuth": 120.0})]


def test_a_dome_that_has_to_close_sets_off_with_no_telescope() -> None:
    one = Observatory()
    one.values["dome/rain"] = 1.0
    one.look()
    one.asked.clear()
    one.point(120.0)
    assert {command for command, _ in one.asked} <= {"dome/close"}


def test_a_dome_under_way_is_not_sent_anew_as_the_sky_turns() -> None:
    one = Follower(FOLLOW)
    steps = [one.next_step(100.0 + at / 10, 0.0, at * 6 * SECOND, settled=True) for at in range(60)]
    assert [step.args["azimuth"] for step in steps if step][::29] == [100.0, 100.0, 105.1]
