"""PyPI's alpaca-simulators, a program of others, started once; and the folder for imports."""

from __future__ import annotations

import subprocess
import sys
import time
import urllib.request
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from patience import PATIENCE_S
from ports import free_port

sys.path.insert(0, str(Path(__file__).parent))  # test modules are imported by path

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture(scope="session")
def simulators(tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    """The port of a server with one device of each type, on this computer alone."""
    folder, port = tmp_path_factory.mktemp("simulators"), free_port()
    # Its own default is every address of the computer.
    code = "from alpaca_simulators.run_simulator import main; main()"
    command = [sys.executable, "-c", code, "--host", "127.0.0.1", "--port", str(port)]
    with (folder / "log").open("wb") as log:
        program = subprocess.Popen(command, stdout=log, stderr=log, cwd=folder)
    try:
        _await_answer(port, program)
        yield port
    finally:
        program.terminate()
        program.wait(PATIENCE_S)


def _await_answer(port: int, program: subprocess.Popen[bytes]) -> None:
    until = time.monotonic() + PATIENCE_S
    while True:
        try:
            urllib.request.urlopen(f"http://127.0.0.1:{port}/api/v1/dome/0/name", timeout=5).close()
        except OSError:
            assert program.poll() is None, "alpaca-simulators ended"
            assert time.monotonic() < until, "alpaca-simulators do not answer"
            time.sleep(0.1)
        else:
            return
