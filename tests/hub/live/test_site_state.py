"""The parts of a live site: what a lost link, a new link and another description leave of each."""

from __future__ import annotations

import pytest

from talaia.hub.live.site_state import CurrentState, LinkedGateway, Pending, RetainedState
from talaia.hub.live.sites import LiveSite, Sites
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import (
    CommandPhase,
    CommandState,
    DriveState,
    FromHub,
    InterlockState,
    LeaseState,
    RecorderState,
    StopState,
)

DESCRIBED = """
talaia: 1
site: hill
name: Hill
ros2: {}
devices:
  base: {name: Base}
  mast: {name: Mast}
"""


class _Link:
    def send(self, message: FromHub) -> None:
        raise AssertionError(message)

    def dismiss_gateway(self, reason: str) -> None:
        raise AssertionError(reason)


@pytest.fixture
def live() -> LiveSite:
    live = Sites().describe_site(load_site(DESCRIBED), "c1")
    live.attach_link(_Link(), LinkedGateway(id=1, boot="b1"), 10)
    for device in ("base", "mast"):
        live.current.leases[device] = LeaseState(device=device), 1
        live.current.drives[device] = DriveState(device=device, linear=0.0, angular=0.0, cap=1.0)
        live.current.unreached[device] = "no answer", 1
        live.retained.stops[device] = StopState(device=device, latched=True)
    live.current.interlocks["wind"] = InterlockState(interlock="wind", locked=True), 1
    live.current.pending["1"] = Pending("1", "base", "park", "anna")
    live.current.acting["1"] = (
        CommandState(id="1", device="base", command="park", phase=CommandPhase.RUNNING),
        1,
    )
    live.retained.enclosures["dome"] = "it rains"
    live.retained.recorder = RecorderState(on=False)
    return live


def test_a_lost_link_leaves_none_of_what_holds_only_while_it_stands(live) -> None:
    live.detach_link(20)
    live.forget_current()
    assert live.current == CurrentState()


def test_a_latched_stop_and_an_open_roof_are_still_shown_while_the_gateway_is_away(live) -> None:
    live.detach_link(20)
    live.forget_current()
    assert set(live.retained.stops) == {"base", "mast"}
    assert live.retained.enclosures == {"dome": "it rains"}
    assert live.retained.recorder is not None


def test_a_new_link_begins_without_what_was_said_over_an_earlier_one(live) -> None:
    live.gateway.problem = object()
    live.detach_link(20)
    live.attach_link(_Link(), LinkedGateway(id=1, boot="b2"), 30)
    assert live.retained == RetainedState()
    assert live.gateway == LinkedGateway(id=1, boot="b2")


def test_presence_says_since_when_a_site_is_there_or_away_and_why(live) -> None:
    here = live.presence
    assert (live.online, here.since_us, here.last_seen_us, here.why) == (True, 10, 0, "")
    live.detach_link(20)
    assert (live.online, here.since_us, here.last_seen_us) == (False, 20, 20)
    assert here.why == "the connection to its gateway was lost"
    live.attach_link(_Link(), LinkedGateway(id=1, boot="b1"), 30)
    assert (live.online, here.since_us, here.last_seen_us, here.why) == (True, 30, 20, "")


def test_a_description_without_a_device_leaves_nothing_of_it_but_its_commands(live) -> None:
    live.description = load_site(DESCRIBED.replace("  base: {name: Base}\n", ""))
    live.drop_undescribed()
    for by_device in (
        live.current.leases,
        live.current.drives,
        live.current.unreached,
        live.retained.stops,
    ):
        assert set(by_device) == {"mast"}
    assert not live.current.interlocks
    assert not live.retained.enclosures
    assert set(live.current.pending) == {"1"}


def test_people_are_told_once_of_a_rival_and_again_after_it_was_linked(live) -> None:
    assert live.rivals.add_boot("b0")
    assert not live.rivals.add_boot("b0")
    live.rivals.seen_us = 15
    live.detach_link(20)
    assert live.rivals.seen_us == 0
    live.attach_link(_Link(), LinkedGateway(id=1, boot="b0"), 30)
    assert live.rivals.add_boot("b0")


def test_a_gateway_that_starts_in_a_loop_does_not_fill_the_memory(live) -> None:
    for number in range(1000):
        live.rivals.add_boot(str(number))
    assert len(live.rivals.boots) <= 100
