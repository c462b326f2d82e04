"""Who is told that the gateway supervises, and who is not when it does not; times by hand."""

from __future__ import annotations

from hypothesis import given, strategies as st

from talaia.clock import MS, SECOND, HandClock
from talaia.gateway.safety.supervision import Supervision
from talaia.gateway.watchdog.silence_timer import SilenceTimer, WatchdogTask


class _NoHeartbeats:
    def send_due(self, now_ns: int) -> None:
        pass


def supervision(clock: HandClock, judged: list[int | None]) -> tuple[Supervision, list[int]]:
    fed: list[int] = []
    parts = (lambda: fed.append(clock.monotonic_ns()),)
    return Supervision(clock, lambda: judged[0], parts, _NoHeartbeats()), fed  # type: ignore[arg-type]


def test_nobody_is_fed_while_interlocks_are_not_judged() -> None:
    clock, judged = HandClock(), [0]
    ours, fed = supervision(clock, judged)
    for _ in range(40):
        clock.advance(250 * MS)
        ours.check_supervision()
    # The loop runs, and what it should do stands still.
    assert fed
    assert fed[-1] <= 2 * SECOND
    judged[0] = clock.monotonic_ns()
    assert ours.check_supervision()
    assert fed[-1] == clock.monotonic_ns()


def test_a_loop_that_was_late_feeds_nobody_before_it_has_judged_again() -> None:
    clock, judged = HandClock(), [0]
    ours, fed = supervision(clock, judged)
    assert ours.check_supervision()
    clock.advance(30 * SECOND)
    judged[0] = clock.monotonic_ns()
    assert not ours.check_supervision()
    clock.advance(250 * MS)
    assert ours.check_supervision()
    assert fed == [0, 30 * SECOND + 250 * MS]


def test_where_there_is_nothing_to_judge_the_loop_alone_counts() -> None:
    clock = HandClock()
    ours, fed = supervision(clock, [None])
    clock.advance(SECOND)
    assert ours.check_supervision()
    assert fed


def test_silence_closes_and_a_beat_ends_that() -> None:
    silence = SilenceTimer(0.0)
    silence.after_s = 10.0
    now = 0.0
    while (task := silence.judge_silence(now)) is WatchdogTask.WAIT:
        now += 0.25
    assert task is WatchdogTask.CLOSE
    assert now == 10.0
    silence.hear_beat()
    assert silence.judge_silence(now + 0.25) is WatchdogTask.WAIT


def test_a_dead_gateway_is_waited_for_until_all_is_closed() -> None:
    silence = SilenceTimer(0.0)
    silence.after_s = 2.0
    silence.hear_end()
    assert [silence.judge_silence(each / 4) for each in range(8)] == [WatchdogTask.WAIT] * 8
    assert silence.judge_silence(2.0) is WatchdogTask.CLOSE
    silence.report_closed()
    assert silence.judge_silence(2.25) is WatchdogTask.LEAVE


def test_a_machine_that_stood_still_is_not_taken_for_a_dead_gateway() -> None:
    silence = SilenceTimer(0.0)
    silence.after_s = 10.0
    assert silence.judge_silence(3600.0) is WatchdogTask.WAIT
    silence.hear_beat()
    assert silence.judge_silence(3600.25) is WatchdogTask.WAIT


@given(st.lists(st.sampled_from(["beat", "look", "end", "closed"]), max_size=60))
def test_after_a_goodbye_nothing_is_closed_whatever_comes(words: list[str]) -> None:
    silence, now = SilenceTimer(0.0), 0.0
    silence.after_s = 2.0
    silence.hear_goodbye()
    for word in words:
        now += 1.0
        match word:
            case "beat":
                silence.hear_beat()
            case "end":
                silence.hear_end()
            case "closed":
                silence.report_closed()
        assert silence.judge_silence(now) is WatchdogTask.LEAVE
