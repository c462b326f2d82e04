"""Finding and starting as states: what is run, what its output means, and what a failure says."""

from __future__ import annotations

import msgspec
import pytest
from hypothesis import given, strategies as st

from talaia.configurator.errors import BadHost, ImpossibleStep
from talaia.configurator.program_run import (
    MAX_LINES,
    ProgramPhase,
    ProgramRun,
    deploy_command,
    up_command,
)
from talaia.configurator.robot_discovery import DiscoveryPhase, RobotDiscovery, probe_command
from talaia.model.discovery.probe_report import Found, TopicFound

HERE = ["python", "-m", "talaia"]
TOPIC = TopicFound("/a", "std_msgs/msg/Float64", 1)
SOME = msgspec.json.encode(Found(1, "ros2", "ROS 2", 5.0, domain=0, topics=(TOPIC,)))
NONE = msgspec.json.encode(Found(1, "ros2", "ROS 2, domain 3", 5.0, domain=3))


def test_here_the_probe_is_run_by_this_python_and_there_by_ssh_that_asks_nothing() -> None:
    assert probe_command(HERE) == [*HERE, "probe", "--json", "--seconds", "5"]
    words = probe_command(HERE, " ana@robot.local:2222 ", "/opt/talaia/bin/talaia")
    assert words[0] == "ssh"
    assert words[words.index("-p") + 1] == "2222"
    assert "BatchMode=yes" in words
    assert words[words.index("--") + 1 :] == [
        "ana@robot.local", "/opt/talaia/bin/talaia", "probe", "--json", "--seconds", "5",
    ]  # fmt: skip
    assert "2001:db8::7" in probe_command(HERE, "[2001:db8::7]")


@pytest.mark.parametrize(
    "host",
    [
        "-oProxyCommand=touch /tmp/x", "a b", "a;b", "$(id)", "a\nb", "a@b@c", "-x@host",
        "host:0", "host:70000", "host:ssh", "user@", "`id`", "ho|st", "é.local", "[::1",
    ],
)  # fmt: skip
def test_a_host_that_ssh_or_a_shell_could_take_for_something_else_is_refused(host: str) -> None:
    with pytest.raises(BadHost):
        probe_command(HERE, host)


@pytest.mark.parametrize("program", ["talaia; rm", "$(x)", "-x", "", "a b", "a\n", "`a`", "a&"])
def test_a_program_that_the_far_shell_could_take_for_more_is_refused(program: str) -> None:
    with pytest.raises(BadHost):
        probe_command(HERE, "robot", program)


@given(st.text(max_size=30), st.text(max_size=30))
def test_whatever_is_typed_every_word_given_to_ssh_is_plain(host: str, program: str) -> None:
    try:
        words = probe_command(HERE, host, program)
    except BadHost:
        return
    if host.strip():
        target, *far = words[words.index("--") + 1 :]
        assert target[0] != "-"
        assert all(set(each) <= set(PLAIN) for each in (target, *far))


PLAIN = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.-/@:~"


def test_a_look_that_finds_something_is_done_and_its_progress_never_says_so_before() -> None:
    look = RobotDiscovery()
    look.mark_started("robot")
    assert (
        0 < look.expected_progress(1) < look.expected_progress(5) < look.expected_progress(600) < 1
    )
    look.handle_exit(0, SOME, "listening …")
    assert look.phase is DiscoveryPhase.DONE
    assert look.found is not None
    look.mark_started("robot")
    assert look.found is None


@pytest.mark.parametrize(
    ("code", "said", "complained", "told"),
    [
        (1, NONE, "", "same ROS domain (3)"),
        (255, b"", "ana@robot: Permission denied (publickey).", "ssh-copy-id robot"),
        (255, b"", "Host key verification failed.", "compare its key"),
        (255, b"", "ssh: Could not resolve hostname robot: x", "no computer called robot"),
        (255, b"", "ssh: connect to host robot port 22: Connection timed out", "is it on"),
        (127, b"", "sh: 1: talaia: not found", "the whole path"),
        (2, b"", "talaia probe: talaia probe needs the Python package 'rclpy', which is not "
         "installed; run: pip install 'talaia[ros2]'", "no ROS 2"),
        (0, b"Welcome!", "", "is not what `talaia probe --json` prints"),
        (0, SOME.replace(b'"talaia_probe":1', b'"talaia_probe":2'), "", "same version"),
        (-11, b"", "", "code -11"),
    ],
)  # fmt: skip
def test_each_failure_says_what_to_do(code: int, said: bytes, complained: str, told: str) -> None:
    look = RobotDiscovery()
    look.mark_started("robot")
    look.handle_exit(code, said, complained)
    assert look.phase is DiscoveryPhase.FAILED
    assert told in look.problem


def test_a_cancelled_look_changes_nothing_whatever_came_last() -> None:
    look = RobotDiscovery()
    look.mark_started("")
    look.mark_cancelled()
    look.handle_exit(0, SOME, "")
    assert look.phase is DiscoveryPhase.CANCELLED
    assert look.found is None
    with pytest.raises(ImpossibleStep, match="cancelled cannot become cancelling"):
        look.mark_cancelled()


UP = """
  Rover is up (3.4 s):  http://127.0.0.1:8470

  Nobody has an account yet. Make the first admin's here:
    http://127.0.0.1:8470/setup#abc_D-1

  data and logs: x
  Ctrl-C stops everything; stored data is kept.""".splitlines()


def started() -> ProgramRun:
    run = ProgramRun()
    run.start(up_command(HERE, "site.yaml"))
    return run


def test_a_site_is_up_when_its_last_word_is_said_and_the_first_admin_is_made_first() -> None:
    run = started()
    for line in UP[:-1]:
        run.add_line(line)
        assert run.phase is ProgramPhase.STARTING
    run.add_line(UP[-1])
    assert run.phase is ProgramPhase.UP
    assert run.page == "http://127.0.0.1:8470/setup#abc_D-1"
    run.stop()
    run.handle_exit(0)
    assert run.phase is ProgramPhase.ENDED


def test_a_start_that_fails_tells_the_last_words() -> None:
    run = started()
    run.add_line("talaia up: port 8470 is taken; choose another with --port")
    run.add_line("")
    run.add_line("stopping …")
    run.handle_exit(2)
    assert run.phase is ProgramPhase.FAILED
    assert run.problem.startswith("talaia up: port 8470 is taken")
    run.start(["x"])
    run.handle_exit(3)
    assert run.problem == "it ended with code 3"


def test_a_site_that_stops_by_itself_has_failed_and_one_that_was_stopped_has_not() -> None:
    run = started()
    for line in UP:
        run.add_line(line)
    run.handle_exit(1)
    assert run.phase is ProgramPhase.FAILED
    with pytest.raises(ImpossibleStep):
        run.stop()


def test_what_could_not_be_started_and_was_stopped_meanwhile_has_ended() -> None:
    run = started()
    run.stop()
    run.not_started("talaia")
    assert (run.phase, run.problem) == (ProgramPhase.ENDED, "")
    look = RobotDiscovery()
    look.mark_started("")
    look.mark_cancelled()
    look.not_started("ssh")
    assert (look.phase, look.problem) == (DiscoveryPhase.CANCELLED, "")


def test_a_deployment_is_written_by_a_command_that_ends() -> None:
    run = ProgramRun()
    words = deploy_command(HERE, "site.yaml", "to", "postgresql", over=False)
    assert words == [*HERE, "generate", "site.yaml", "--to", "to", "--database", "postgresql"]
    run.start(words)
    run.add_line("to: 14 files")
    run.handle_exit(0)
    assert run.phase is ProgramPhase.ENDED


def test_the_log_that_is_kept_is_bounded() -> None:
    run = started()
    for number in range(MAX_LINES * 2):
        run.add_line(str(number))
    assert len(run.lines) == MAX_LINES
