"""Whoever floods by a stolen key is held off, and the gateway that was here before is not."""

from __future__ import annotations

import pytest

from talaia.clock import SECOND, HandClock
from talaia.hub.live.gateways.flood_guard import FloodGuard
from talaia.hub.live.gateways.frame_limits import HELD_S
from talaia.hub.live.sites import Sites
from talaia.hub.store.sites.site_registry import GatewayKey
from talaia.wire.errors import PeerError
from talaia.wire.gateway_proof import ResumeToken

pytestmark = pytest.mark.pure

# Lineages are numbered by time: the robot was here before anybody had stolen its key.
ROBOT = GatewayKey(1, "agv", challenged=True, resumed=ResumeToken(10, 12))
THIEF = GatewayKey(1, "agv", challenged=True, resumed=ResumeToken(40, 40))
# Who has the key and nothing else.
STRANGER = GatewayKey(1, "agv", challenged=True)


class Slowed(Exception):
    """Somebody would have had to wait."""


class Siege:
    """A guard on a clock that is moved by hand."""

    def __init__(self) -> None:
        """Begin with a hub that was just started."""
        self.clock = HandClock()
        # Of a site that was never described, so nobody is told: the log has it.
        self.guard = FloodGuard(Sites(), None, self.clock)  # type: ignore[arg-type]

    def dial_without_end(self, key: GatewayKey) -> None:
        """Twenty a second, far longer than it takes to be cut off."""
        for _ in range(60):
            for _ in range(20):
                self.guard.admit_dial(key)
            self.clock.advance(SECOND)

    def flood(self, key: GatewayKey) -> None:
        """Say twelve times as much as one may, until one is cut off."""
        for _ in range(400):
            try:
                self.speak(key, 600)
            except Slowed:
                pass
            except PeerError:
                return
            self.clock.advance(SECOND // 4)
        raise AssertionError("it was never cut off")

    def speak(self, key: GatewayKey, times: int) -> None:
        """Say something so often, and be slowed never."""
        for _ in range(times):
            if self.guard.charge_kind(key, "events"):
                raise Slowed


@pytest.mark.parametrize("thief", [STRANGER, THIEF])
def test_a_thief_that_dials_without_end_is_held_off_and_keeps_the_robot_out_never(
    thief: GatewayKey,
) -> None:
    siege = Siege()
    # Also over a restart, after which the thief is the first to dial.
    siege.dial_without_end(thief)
    assert siege.guard.admit_dial(ROBOT) == 0.0
    assert siege.guard.held_s(ROBOT) == 0.0
    siege.dial_without_end(thief)
    assert 0 < siege.guard.held_s(thief) <= HELD_S
    assert siege.guard.held_s(ROBOT) == 0.0
    assert [siege.guard.admit_dial(ROBOT) for _ in range(3)] == [0.0] * 3


@pytest.mark.parametrize("thief", [STRANGER, THIEF])
def test_a_thief_that_floods_while_the_robot_is_away_leaves_it_no_debt(thief: GatewayKey) -> None:
    siege = Siege()
    siege.guard.begin_link(thief, issued=40)
    siege.flood(thief._replace(resumed=ResumeToken(40, 41)))
    assert siege.guard.held_s(thief) > 0
    assert siege.guard.held_s(ROBOT) == 0.0
    siege.guard.begin_link(ROBOT, issued=10)
    # A robot that comes back says how everything stands at once.
    siege.speak(ROBOT, 5_000)


def test_a_robot_that_floods_is_held_off_itself_and_to_come_back_brings_no_allowance() -> None:
    siege = Siege()
    siege.guard.begin_link(ROBOT, issued=10)
    siege.flood(ROBOT)
    for key in (ROBOT, STRANGER, THIEF):
        assert 0 < siege.guard.held_s(key) <= HELD_S
    siege.guard.begin_link(ROBOT, issued=10)
    with pytest.raises(Slowed):
        siege.speak(ROBOT, 1)
