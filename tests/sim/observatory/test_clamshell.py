"""A roof of two shells without azimuth, in time that a hand moves."""

from __future__ import annotations

import pytest
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.sim.observatory.models.clamshell import SHELLS, Clamshell
from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.servers.catalog import make_server
from talaia.sim.observatory.servers.dome import ClamshellServer
from talaia.sim.observatory.servers.sequencer import GlobalServer

pytestmark = pytest.mark.pure
OPEN_S = 13.0


def pass_time(model: Clamshell, seconds: float) -> None:
    for _ in range(round(seconds * 20)):
        model.step(0.05)


def opened() -> Clamshell:
    dome = Clamshell()
    dome.open()
    pass_time(dome, OPEN_S)
    assert (dome.state, dome.position) == ("opened", 1.0)
    return dome


def server() -> ClamshellServer:
    made = make_server("dome", seed=1, unix_s=0.0, call=_nobody, roof="clamshell")
    assert isinstance(made, ClamshellServer)
    return made


def _nobody(device: str, service: str) -> Ticket:
    return Ticket.refused(f"/{device}/{service} is not there")


def test_a_clamshell_has_two_end_switches_and_nothing_that_turns() -> None:
    said = server()
    assert {"west_closed", "west_position", "east_closed", "east_position"} <= {
        *said.topic_values()
    }
    assert not {"azimuth", "turning"} & {*said.topic_values()}
    assert "park" not in said.triggers
    assert said.asks == {}
    assert not said.model.turn_to(90.0).good
    assert "no fault 'encoder'" in said.inject_fault("encoder")


def test_parking_all_of_an_observatory_does_not_ask_a_clamshell_to_turn() -> None:
    asked = []

    def call(device: str, service: str) -> Ticket:
        asked.append((device, service))
        return Ticket.done("")

    made = make_server("observatory", seed=1, unix_s=0.0, call=call, roof="clamshell")
    assert isinstance(made, GlobalServer)
    ticket = made.triggers["park"]()
    for _ in range(5):
        made.step(0.05, 0.0)
    assert (ticket.good, asked) == (True, [("camera", "abort"), ("telescope", "park")])


def test_a_shell_that_is_stuck_stays_while_the_other_closes_and_the_request_fails() -> None:
    dome = opened()
    dome.shells["west"].stuck = True
    ticket = dome.close()
    pass_time(dome, OPEN_S + 3)
    assert (ticket.good, dome.state, dome.closed) == (False, "error", False)
    assert "west" in ticket.message
    assert [dome.shells[each].position for each in SHELLS] == [1.0, 0.0]
    # As far as the shell that is open furthest.
    assert dome.position == 1.0
    dome.shells["west"].stuck = False
    again = dome.close()
    pass_time(dome, OPEN_S)
    assert (again.good, dome.state) == (True, "closed")


def test_an_end_switch_that_lies_leaves_its_shell_open_and_the_controller_content() -> None:
    dome = opened()
    dome.shells["west"].lying = "closed"
    ticket = dome.close()
    pass_time(dome, OPEN_S)
    assert (ticket.good, dome.state, dome.closed) == (True, "closed", True)
    assert (dome.shells["west"].position, dome.shells["east"].position) == (1.0, 0.0)


def test_an_end_switch_that_never_says_closed_ends_the_closing_as_an_error() -> None:
    dome = opened()
    dome.shells["east"].lying = "opened"
    ticket = dome.close()
    pass_time(dome, OPEN_S + 3)
    assert (ticket.good, dome.state, dome.position) == (False, "error", 0.0)


def test_faults_of_one_shell_are_named_and_ok_ends_them() -> None:
    said = server()
    assert said.inject_fault("west stuck") == ""
    assert said.inject_fault("east lying closed") == ""
    assert "no fault 'bent'" in said.inject_fault("east bent")
    shells = said.model.shells
    assert (shells["west"].stuck, shells["east"].lying) == (True, "closed")
    assert said.inject_fault("ok") == ""
    assert (shells["west"].stuck, shells["east"].lying) == (False, "")


@given(st.lists(st.tuples(st.sampled_from(["open", "close", "stop"]), st.floats(0, 20))))
@settings(max_examples=examples(15, many=600))
def test_whatever_is_asked_it_says_closed_exactly_when_both_shells_are(
    asked: list[tuple[str, float]],
) -> None:
    dome = Clamshell()
    for what, seconds in asked:
        ticket = getattr(dome, what)()
        pass_time(dome, seconds)
        positions = [each.position for each in dome.shells.values()]
        assert all(0 <= each <= 1 for each in positions)
        assert dome.closed == (max(positions) == 0) == (dome.position == 0)
        assert dome.opened == (min(positions) == 1)
        assert ticket.ended or dome.wanted is not None
