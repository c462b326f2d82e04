"""Take-over: ask, answer, force; and the vehicle at rest between two drivers."""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, strategies as st

from talaia.clock import MS, SECOND
from talaia.gateway.driving.lease import ANSWER_NS, FORCE_NS, DeviceLease
from talaia.wire.frames import DriveState, LeaseForceRequest, LeaseOp, LeaseState, StopRequest

from .test_drive_service import Bench

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.pure


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    return Bench(tmp_path)


def force(bench: Bench, session: str) -> LeaseState:
    bench.control.handle_lease(LeaseForceRequest(device="base", session=session, who=session))
    return bench.robot.last(LeaseState)


def answers(bench: Bench, session: str) -> list[LeaseState]:
    return [x for x in bench.robot.sent if isinstance(x, LeaseState) and x.asked == session]


def renewed(bench: Bench, ns: int) -> None:
    """Let time pass while the holder's page renews, as it does each second."""
    for _ in range(ns // SECOND):
        bench.pass_time(SECOND)
        bench.lease(op=LeaseOp.RENEW)
    bench.pass_time(ns % SECOND)


def test_an_ask_tells_who_asks_and_how_long_there_is_to_answer(bench: Bench) -> None:
    bench.lease()
    state = bench.lease("ben", LeaseOp.ASK)
    assert (state.session, state.rival, state.rival_who) == ("tab", "ben", "ben")
    assert state.rival_ms == 5000
    assert state.refused == ""


def test_an_ask_for_a_free_lease_takes_it(bench: Bench) -> None:
    assert bench.lease("ben", LeaseOp.ASK).session == "ben"


def test_accepted_ask_stops_the_vehicle_and_raises_the_epoch(bench: Bench) -> None:
    old = bench.lease().epoch
    bench.drive()
    bench.lease("ben", LeaseOp.ASK)
    state = bench.lease(op=LeaseOp.ACCEPT)
    assert (state.session, state.rival) == ("ben", "")
    assert state.epoch > old
    assert bench.robot.driven[-1][1:] == (0.0, 0.0)
    bench.drive(session="tab", epoch=old)
    assert bench.robot.driven[-1][1:] == (0.0, 0.0)


def test_a_new_driver_moves_nothing_before_the_vehicle_had_time_to_stand(bench: Bench) -> None:
    bench.lease()
    bench.drive()
    bench.lease("ben", LeaseOp.ASK)
    before = len(bench.robot.driven)
    bench.lease(op=LeaseOp.ACCEPT)
    began = bench.clock.monotonic_ns()
    while not bench.robot.driven[-1][1]:
        bench.drive(session="ben")
        bench.pass_time(50 * MS)
    assert 500 * MS <= bench.robot.driven[-1][0] - began <= 650 * MS
    zeros = bench.robot.driven[before:-1]
    assert len(zeros) >= 8
    assert {linear for _, linear, _ in zeros} == {0.0}
    assert any(
        "between two drivers" in x.why for x in bench.robot.sent if isinstance(x, DriveState)
    )


def test_zero_is_said_even_when_the_former_driver_had_let_go(bench: Bench) -> None:
    bench.lease()
    bench.lease("ben", LeaseOp.ASK)
    bench.lease(op=LeaseOp.ACCEPT)
    assert bench.robot.driven[-1][1:] == (0.0, 0.0)


def test_a_no_reaches_the_asker_and_allows_force(bench: Bench) -> None:
    bench.lease()
    bench.lease("ben", LeaseOp.ASK)
    bench.lease(op=LeaseOp.DENY)
    answer = answers(bench, "ben")[-1]
    assert (answer.refused, answer.forceable) == ("tab keeps control", True)
    forced = force(bench, "ben")
    assert forced.session == "ben"
    assert "lease_forced" in bench.robot.notes
    assert bench.robot.driven[-1][1:] == (0.0, 0.0)


def test_no_answer_within_five_seconds_is_told_and_allows_force(bench: Bench) -> None:
    bench.lease()
    bench.lease("ben", LeaseOp.ASK)
    renewed(bench, 4 * SECOND + 900 * MS)
    assert not answers(bench, "ben")[-1].refused
    assert force(bench, "ben").refused
    bench.pass_time(200 * MS)
    answer = answers(bench, "ben")[-1]
    assert (answer.refused, answer.forceable) == ("tab has not answered", True)
    assert "lease_unanswered" in bench.robot.notes
    assert force(bench, "ben").session == "ben"


def test_force_without_an_ask_is_refused(bench: Bench) -> None:
    bench.lease()
    refused = force(bench, "ben")
    assert refused.session == "tab"
    assert "ask tab first" in refused.refused


def test_force_too_long_after_the_ask_is_refused(bench: Bench) -> None:
    bench.lease()
    bench.lease("ben", LeaseOp.ASK)
    bench.lease(op=LeaseOp.DENY)
    renewed(bench, 30 * SECOND)
    assert force(bench, "ben").session == "tab"


def test_second_asker_is_told_that_another_asks_already(bench: Bench) -> None:
    bench.lease()
    bench.lease("ben", LeaseOp.ASK)
    assert bench.lease("eve", LeaseOp.ASK).refused == "ben has asked for it already"


def test_asker_who_leaves_is_forgotten_and_that_is_told(bench: Bench) -> None:
    bench.lease()
    bench.lease("ben", LeaseOp.ASK)
    assert bench.lease("ben", LeaseOp.FREE).rival == ""
    assert bench.lease(op=LeaseOp.ACCEPT).refused
    assert bench.robot.last(LeaseState).session == "tab"


def test_who_asks_gets_it_when_the_holder_gives_it_back_or_is_gone(bench: Bench) -> None:
    bench.lease()
    bench.lease("ben", LeaseOp.ASK)
    bench.lease(op=LeaseOp.FREE)
    assert bench.robot.last(LeaseState).session == "ben"
    bench.lease("eve", LeaseOp.ASK)
    bench.pass_time(3100 * MS)
    assert bench.robot.last(LeaseState).session == "eve"


def test_nobody_but_the_holder_can_answer(bench: Bench) -> None:
    bench.lease()
    bench.lease("ben", LeaseOp.ASK)
    assert bench.lease("ben", LeaseOp.ACCEPT).refused
    bench.lease("eve", LeaseOp.DENY)
    assert bench.robot.last(LeaseState).rival == "ben"
    assert bench.robot.last(LeaseState).session == "tab"


def test_link_loss_forgets_holder_and_asker(bench: Bench) -> None:
    bench.lease()
    bench.lease("ben", LeaseOp.ASK)
    bench.control.link_lost()
    bench.pass_time(6 * SECOND)
    bench.control.link_up()
    assert bench.robot.last(LeaseState).session == ""


def test_take_over_while_stopped_changes_the_holder_and_nothing_moves(bench: Bench) -> None:
    bench.lease()
    bench.control.stop_device(StopRequest(device="base", id="i", who="Ben"))
    bench.lease("ben", LeaseOp.ASK)
    bench.lease(op=LeaseOp.ACCEPT)
    for _ in range(30):
        bench.drive(session="ben")
        bench.pass_time(50 * MS)
    assert {x[1] for x in bench.robot.driven} == {0.0}


def test_accept_on_a_full_disk_changes_nothing(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench.lease()
    bench.lease("ben", LeaseOp.ASK)

    def full() -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(bench.control.controllers["base"].lease, "_next_epoch", full)
    state = bench.lease(op=LeaseOp.ACCEPT)
    assert (state.session, state.rival) == ("tab", "ben")
    assert "No space left" in state.refused


ACTS = ["take", "ask", "accept", "deny", "force", "renew", "free", "pass_on", "drop"]
steps = st.tuples(
    st.sampled_from(ACTS),
    st.sampled_from(["a", "b", "c"]),
    st.integers(0, 7).map(lambda s: s * SECOND),
)


@given(st.lists(steps, max_size=120))
def test_control_changes_hands_only_by_consent_by_force_after_an_ask_or_when_free(
    history: list[tuple[str, str, int]],
) -> None:
    numbers = count(1)
    one, now, last_epoch = DeviceLease(10 * SECOND, lambda: next(numbers)), 0, 0
    asked: dict[str, int] = {}  # who asked the present holder, and when
    vain: dict[str, int] = {}  # whose ask the present holder has denied, and when
    for what, session, wait in history:
        now += wait
        before, rival = one.holder_at(now), one.rival_at(now)
        match what:
            case "take":
                one.take_lease(session, session, now)
            case "ask":
                if not one.request_lease(session, session, now) and rival is None:
                    asked[session] = now
                    vain.pop(session, None)
            case "accept":
                one.accept_rival(session, now)
            case "deny":
                if one.deny_rival(session, now):
                    assert rival is not None
                    vain[rival.session] = now
            case "force":
                one.force_lease(session, session, now)
            case "renew":
                one.renew_lease(session, now)
            case "free":
                one.free_lease(session, now)
            case "pass_on":
                one.pass_on(now)
            case "drop":
                one.drop_lease()
        after = one.holder_at(now)
        if after is not None and (before is None or after.epoch != before.epoch):
            # Whoever comes anew has an epoch higher than all before.
            assert after.epoch > last_epoch
            last_epoch = after.epoch
            if before is None:
                # Free: it goes to who asked first, or else to who takes it.
                assert after.session == (rival.session if rival else session)
            elif before.session == after.session:
                assert session == before.session
            elif what == "accept":
                assert session == before.session
                assert rival is not None
                assert after.session == rival.session
            else:
                # Against the holder's will: only after a no, or five seconds of silence.
                assert what == "force"
                assert after.session == session
                since = vain.get(session, asked.get(session, now) + ANSWER_NS)
                assert since <= now < since + FORCE_NS
        elif before is not None and after is None:
            assert what == "drop" or (what == "free" and session == before.session)
        if (before and before.session) != (after and after.session):
            vain = {}
            waits = one.rival_at(now)
            asked = {} if waits is None else {waits.session: now}
        waits = one.rival_at(now)
        assert waits is None or after is None or waits.session != after.session
