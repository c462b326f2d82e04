"""Which Python .venv is made with: the one that was named, or the system's where it is quicker.

A Python that was compiled without optimisation (as pyenv does it unless told otherwise) takes half
as long again for all that it computes: every test, and the product. What `python3` is on somebody's
path is seldom chosen for that, so the system's own is tried beside it.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

SYSTEM = Path("/usr/bin/python3")
# Below this share of the other's time it is quicker for certain; less is noise.
QUICKER = 0.85
# Calls, attributes, numbers and dictionaries, 20 ms of them; the best of ten is printed. One
# that cannot make a virtual environment, or is too old, prints nothing.
TRIAL = """
import ensurepip, sys, time, venv
if sys.version_info < (3, 11):
    raise SystemExit(1)
class Point:
    def __init__(self, x):
        self.x = x
    def moved(self, by):
        return Point(self.x + by)
def compute():
    start, points = time.process_time(), {}
    for number in range(60_000):
        points[number % 100] = Point(number).moved(1).x * 0.5
    return time.process_time() - start
print(min(compute() for _ in range(10)))
"""


def choose_python(named: str = sys.executable, system: Path = SYSTEM) -> str:
    """Give the path of the Python to make .venv with."""
    if not system.exists() or Path(named).resolve() == system.resolve():
        return named
    of_named, of_system = measure_python(named), measure_python(str(system))
    if of_named is None or of_system is None:
        return named
    return str(system) if of_system < QUICKER * of_named else named


def measure_python(program: str) -> float | None:
    """Measure what a small task takes it (s of CPU); None if it cannot serve."""
    run = subprocess.run([program, "-c", TRIAL], check=False, capture_output=True, text=True)
    return float(run.stdout) if run.returncode == 0 else None
