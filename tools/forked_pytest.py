"""Run pytest in forks of this process, which has imported what most tests import.

Each group of tests is a process of its own, and to import pytest, its plugins and the hub takes two
seconds of a core: so once for all of them, and not for each.
"""

from __future__ import annotations

import atexit
import contextlib
import gc
import importlib
import io
import os
import signal
import sys
import tempfile
import threading
import traceback
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from pathlib import Path

# What these import is what most tests import. Nothing of ROS 2, nothing of Qt: their libraries
# begin threads, and those end with a fork.
COLLECTED = (
    "tests/hub/test_lifecycle.py",
    "tests/gateway/test_run.py",
    "tests/system/test_interlocks.py",
    "tests/model/test_topics.py",
)
MODULES = ("playwright.async_api", "playwright.sync_api", "hypothesis.stateful")


class ForkedPytest:
    """A group's process: what the runner uses of `subprocess.Popen`.

    Attributes:
        pid: of the process.
        returncode: None until the runner has seen its end.

    """

    def __init__(self, pid: int) -> None:
        """Wrap a process that was forked."""
        self.pid = pid
        self.returncode: int | None = None

    def kill(self) -> None:
        """End it."""
        self._send(signal.SIGKILL)

    def terminate(self) -> None:
        """Ask it to end."""
        self._send(signal.SIGTERM)

    def _send(self, number: signal.Signals) -> None:
        if self.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.pid, number)


def import_everything(root: Path) -> None:
    """Import what the forks need: by a pytest of this process, which only collects.

    So plugins and the tests' own modules are imported as pytest imports them, which would warn of
    those that it finds imported otherwise.
    """
    files = [str(root / file) for file in COLLECTED if (root / file).exists()]
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        if files:
            pytest.main(["--collect-only", "-q", "-p", "no:cacheprovider", *files])
        for name in MODULES:
            with contextlib.suppress(ImportError):
                importlib.import_module(name)
    # What is here now stays: no fork has to go through it.
    gc.collect()
    gc.freeze()


def fork_pytest(words: list[str], environment: dict[str, str], output: Path) -> ForkedPytest:
    """Run ``pytest WORDS`` with this environment; what it prints goes to a file."""
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    if pid := os.fork():
        return ForkedPytest(pid)
    code = 1
    try:
        code = _run_pytest(words, environment, output)
    except BaseException:  # noqa: BLE001 - nothing may come out of a fork
        traceback.print_exc()
    finally:
        # As at the end of any Python; nothing of the runner's own must run here.
        threading._shutdown()  # type: ignore[attr-defined]  # noqa: SLF001
        atexit._run_exitfuncs()  # noqa: SLF001
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(code)


def _run_pytest(words: list[str], environment: dict[str, str], output: Path) -> int:
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    nothing, file = os.open(os.devnull, os.O_RDONLY), os.open(output, os.O_WRONLY | os.O_CREAT)
    for number, mine in enumerate((nothing, file, file)):
        os.dup2(mine, number)
    os.environ.clear()
    os.environ.update(environment)
    # Chosen by the environment of before.
    tempfile.tempdir = None
    sys.argv = ["pytest", *words]
    sys.orig_argv = [sys.executable, "-m", *sys.argv]
    sys.dont_write_bytecode = False
    return int(pytest.main(words))
