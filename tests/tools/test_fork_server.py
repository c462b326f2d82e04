"""Programs that are forked from a process with their modules imported are as any other program."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path

import pytest
from fork_server import ForkedProcess, fork_program, is_used
from patience import PATIENCE_S

pytestmark = pytest.mark.skipif(not is_used(), reason="programs are started anew here")
PROGRAM = """\
import json, os, signal, sys
print(json.dumps([sys.argv[1:], os.environ.get("MARK"), __name__, sys.path[0], os.getsid(0)]))
print("and an error", file=sys.stderr)
for line in sys.stdin:
    if line == "fail\\n":
        raise ValueError("as it was told")
    if line == "end\\n":
        sys.exit(7)
"""


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / "program.py"
    path.write_text(PROGRAM)
    return path


def start(program: Path, *words: str, **environment: str) -> tuple[ForkedProcess, Path]:
    log = program.with_suffix(".log")
    with log.open("ab") as output:
        started = fork_program([str(program), *words], {**os.environ, **environment}, output)
    return started, log


def end(started: ForkedProcess, word: bytes) -> int:
    assert started.stdin is not None
    started.stdin.write(word)
    started.stdin.close()
    return started.wait(PATIENCE_S)


def test_a_forked_program_has_its_own_words_environment_session_and_output(program: Path) -> None:
    started, log = start(program, "one", "two", MARK="mine")
    assert end(started, b"end\n") == 7
    said = f'[["one", "two"], "mine", "__main__", "{program.parent}", {started.pid}]'
    assert log.read_text() == f"{said}\nand an error\n"
    assert started.poll() == started.returncode == 7


def test_a_forked_program_that_fails_prints_why(program: Path) -> None:
    started, log = start(program)
    assert end(started, b"fail\n") == 1
    assert log.read_text().endswith("ValueError: as it was told\n")


def test_a_forked_program_is_killed_and_waited_for(program: Path) -> None:
    started, _ = start(program)
    with pytest.raises(subprocess.TimeoutExpired):
        started.wait(0.05)
    started.send_signal(signal.SIGKILL)
    assert started.wait(PATIENCE_S) == -signal.SIGKILL
    # Of somebody else by now, maybe.
    started.kill()
    assert started.stdin is not None
    started.stdin.close()
