"""Ports that tests give to programs."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = "import ports; print(*(ports.free_port() for _ in range(200)), flush=True); input()"


@pytest.mark.skipif(sys.platform != "linux", reason="ports are reserved on Linux alone")
def test_no_port_is_given_twice_while_those_who_asked_live() -> None:
    programs = [
        subprocess.Popen(
            [sys.executable, "-c", PROGRAM],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=Path(__file__).parent,
        )
        for _ in range(2)
    ]  # fmt: skip
    given = []
    for program in programs:
        assert program.stdout is not None
        given += program.stdout.readline().split()
    for program in programs:
        program.communicate(b"\n")
    assert len(given) == 400
    assert len(set(given)) == 400
