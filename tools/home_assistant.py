"""Judge the MQTT discovery messages by Home Assistant's own schemas, in an environment of its own.

    .venv/bin/python tools/home_assistant.py [TABLE]

It is made below ``build/`` from requirements/home-assistant.txt, for Python 3.11 or 3.12, and used
again. With TABLE, what was seen is written there.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LOCK = ROOT / "requirements" / "home-assistant.txt"
PLACE = ROOT / "build" / "home-assistant"
TESTS = "tests/wire/mqtt/test_home_assistant.py"


def environment() -> Path | None:
    """Give the Python that has Home Assistant, made where it is not there; None: it cannot be."""
    python = PLACE / "bin" / "python"
    done = PLACE / "lock.txt"
    if done.exists() and done.read_bytes() == LOCK.read_bytes():
        return python
    if subprocess.run([sys.executable, "-m", "venv", str(PLACE)], check=False).returncode:
        return None
    # Without what they say they need: Bluetooth, and more that no MQTT asks for.
    pip = [str(python), "-m", "pip", "install", "-q", "--disable-pip-version-check", "--no-deps"]
    wanted = [*pip, "--require-hashes", "-r", str(LOCK)]
    if subprocess.run(wanted, check=False).returncode:
        return None
    done.write_bytes(LOCK.read_bytes())
    return python


def main(arguments: list[str]) -> int:
    """Give 0 when Home Assistant takes every message of every example."""
    python = environment()
    if python is None:
        print("Home Assistant could not be installed; its message stands above", file=sys.stderr)
        return 1
    known = {**os.environ, "TALAIA_HOME_ASSISTANT": str(python)}
    words = [sys.executable, "-m", "pytest", "-q", "-s", "-p", "no:cacheprovider", TESTS]
    judged = subprocess.run(words, cwd=ROOT, env=known, check=False, capture_output=True, text=True)
    print(judged.stdout + judged.stderr)
    if judged.returncode == 0 and arguments:
        said = next(line for line in judged.stdout.splitlines() if "messages" in line)
        Path(arguments[0]).write_text(f"# Discovery messages at Home Assistant\n\n{said}\n")
    return judged.returncode


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
