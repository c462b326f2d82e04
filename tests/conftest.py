"""Settings of all tests."""

import os
import sys
import tempfile
from pathlib import Path

import pytest
import report_progress
from hypothesis import HealthCheck, settings
from many_examples import examples

# How long an example takes says how busy the machine is; timings are `bench/`'s matter.
settings.register_profile(
    "talaia",
    deadline=None,
    max_examples=examples(25, many=1000),
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("talaia")

# The HTTP client asks for it at each lock that it takes. Where it is not installed all folders
# would be searched each time, a tenth of what tests of the hub compute; now it is absent at once.
sys.modules.setdefault("sniffio", None)  # type: ignore[arg-type]

# What a test that is marked as pure does not do: it would not belong to the quick ring.
_IMPURE = {"socket.bind", "socket.connect", "subprocess.Popen", "os.fork", "os.posix_spawn"}
_pure_test = ""


def _forbid(event: str, _: tuple[object, ...]) -> None:
    if _pure_test and event in _IMPURE:
        raise RuntimeError(f"{_pure_test} is marked as pure, and calls {event}")


sys.addaudithook(_forbid)


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Hold a pure test to what it says."""
    global _pure_test
    _pure_test = item.nodeid if item.get_closest_marker("pure") else ""


def pytest_runtest_teardown() -> None:
    """Let fixtures end as they like."""
    global _pure_test
    _pure_test = ""


def pytest_configure(config: pytest.Config) -> None:
    """Report to the runner, and agree with other runs on this machine about ROS domains."""
    report_progress.register(config)
    if not os.environ.get("XDG_RUNTIME_DIR"):
        # Where domains are reserved; tests give programs temporary folders of their own.
        folder = Path(tempfile.gettempdir()) / f"talaia-runtime-{os.getuid()}"
        folder.mkdir(mode=0o700, exist_ok=True)
        os.environ["XDG_RUNTIME_DIR"] = str(folder)
