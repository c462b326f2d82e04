"""Programs that are forked from a process with their modules imported are as any other program."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import fork_server
import pytest
from fork_server import ANCESTOR, ForkedProcess, fork_program, is_used, start_ancestor
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


@pytest.fixture(scope="module", params=["a server of its own", "one server for all groups"])
def server(request: pytest.FixtureRequest) -> Iterator[None]:
    """Fork from a server that these tests start, of each kind."""
    with pytest.MonkeyPatch.context() as patch, tempfile.TemporaryDirectory() as folder:
        patch.setattr(fork_server, "_servers", [])
        patch.delenv(ANCESTOR, raising=False)
        if request.param == "a server of its own":
            yield
            return
        patch.setenv(ANCESTOR, f"{folder}/forks")
        ancestor = start_ancestor(Path(folder) / "forks")
        try:
            yield
        finally:
            ancestor.terminate()
            ancestor.wait(PATIENCE_S)


@pytest.fixture
def program(server: None, tmp_path: Path) -> Path:
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


def test_a_program_ends_with_the_server_that_forked_it(program: Path) -> None:
    started, _ = start(program)
    running = os.pidfd_open(started.pid)
    fork_server._servers.pop().close()
    # See pidfd_open(2): it can be read from when the process has ended.
    assert select.select([running], [], [], PATIENCE_S)[0]
    os.close(running)
    # Who could tell its exit code has ended, too.
    assert started.wait(PATIENCE_S) == -signal.SIGTERM
    assert started.stdin is not None
    started.stdin.close()
