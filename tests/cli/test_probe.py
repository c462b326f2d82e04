"""The command line of ``talaia probe`` and ``talaia init``: what is meant, and what is not."""

from __future__ import annotations

import socket

import pytest

from talaia.cli.main import main


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--ros1", "robot:11311"], "expected http://HOST:11311"),
        (["--indi", "a:b"], "expected HOST or HOST:PORT"),
        (["--indi", ":7624"], "expected HOST or HOST:PORT"),
        (["--connect"], "--connect is for --indi"),
        (["--domain", "300"], "0 to 232"),
    ],
)
def test_a_place_that_is_none_is_told_before_anything_is_looked_at(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["probe", *words]) == 2
    assert said in capsys.readouterr().err


def test_only_one_kind_of_robot_is_looked_at(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["probe", "--ros1", "--indi", "here"])
    assert "not allowed with" in capsys.readouterr().err


def test_the_master_of_the_environment_is_named_when_it_does_not_answer(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        uri = f"http://127.0.0.1:{taken.getsockname()[1]}"
        monkeypatch.setenv("ROS_MASTER_URI", uri)
        assert main(["probe", "--ros1", "--seconds", "0.5"]) == 2
    assert uri in capsys.readouterr().err
