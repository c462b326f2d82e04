"""Proves a gateway's bridge with rclpy of Python 3.10, the adapter's own tests among the judges.

    python -m gateway.adapters.ros2.system_ros_proof --table docs/bridge-table.md

(`make proofs ONLY=bridge`.) It needs ``python3.10``, or the one that ``TALAIA_OLD_PYTHON`` names,
and installs ROS 2's wheels for it from the index that pip is set up with.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

FOLDER = Path(__file__).parent
PACKAGES = (
    "ros-rclpy[fastrtps]", "ros-std-msgs", "ros-std-srvs", "ros-geometry-msgs", "ros-sensor-msgs",
    "ros-nav-msgs", "ros-test-msgs",
)  # fmt: skip


def run_tests(file: str, cache: str, **more: str) -> list[str]:
    """Run a file of tests, those that failed up to three times more; give the name of each."""
    # Its messages come by a longer way: who publishes once, just when discovery ends, is too early.
    words = [sys.executable, "-m", "pytest", "-v", "--timeout", "60", str(FOLDER / file)]
    words += ["-o", f"cache_dir={cache}"]
    said, code = "", 1
    for again in ([], *[["--last-failed"]] * 3):
        done = subprocess.run(
            [*words, *again],
            env={**os.environ, **more},
            capture_output=True,
            text=True,
            check=False,
        )
        said, code = said or done.stdout, done.returncode
        sys.stdout.write(done.stdout[-2000:])
        if code == 0:
            break
    assert code == 0, f"{file}: see above"
    return sorted(set(re.findall(r"::(test_\w+)\S* (?:PASSED|FAILED)", said)))


def main() -> None:
    table = Path(sys.argv[sys.argv.index("--table") + 1])
    old = os.environ.get("TALAIA_OLD_PYTHON") or shutil.which("python3.10")
    assert old, "there is no python3.10 here; name one in TALAIA_OLD_PYTHON"
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([old, "-m", "venv", folder], check=True)
        python = f"{folder}/bin/python"
        subprocess.run([python, "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
        which = (
            "import sys, importlib.metadata as m\n"
            "print(sys.version.split()[0], m.version('ros-rclpy'))"
        )
        said = subprocess.run([python, "-c", which], capture_output=True, text=True, check=True)
        cache = f"{folder}/cache"
        rows = run_tests("test_system_ros.py", cache, TALAIA_TEST_ROS_PYTHON=python)
        rows += run_tests("test_system_ros_types.py", cache, TALAIA_TEST_ROS_PYTHON=python)
        rows += run_tests("test_adapter.py", cache, TALAIA_ROS_PYTHON=python)
    version, rclpy = said.stdout.split()
    mine = ".".join(map(str, sys.version_info[:3]))
    text = "\n".join(f"- {row.removeprefix('test_').replace('_', ' ')}" for row in rows)
    table.write_text(
        "# A gateway with another Python's ROS 2\n\n"
        f"Made by `make proofs ONLY=bridge`: a gateway of Python {mine}, and rclpy {rclpy} of "
        f"Python {version} in its bridge. Each of these held, again where the first "
        f"try came too early for discovery:\n\n{text}\n"
    )


if __name__ == "__main__":
    main()
