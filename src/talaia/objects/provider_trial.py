"""Try what a detector may run on here: ``python -m talaia.objects.provider_trial [NAME]``.

Without a name it lists what this machine's ONNX Runtime has; with one it looks at a picture and
says how long that takes. A process of its own, because a vendor's library may crash.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import time
from typing import NamedTuple

import numpy as np

from talaia.objects.detector import NANODET
from talaia.objects.errors import DetectorError
from talaia.objects.network import open_network
from talaia.objects.providers import found_providers, parse_provider
from talaia.objects.worker import OWN_FILE, OWN_REMEDY

__all__ = ["ProviderTrial", "main", "try_providers"]

# A vendor's library may build its program for this device first (s).
_LONGEST_S = 120.0
_PICTURES = 5
# Of another's score and place: other devices add up in another order, and with fewer bits.
_DIFFERENCE = 0.05


class ProviderTrial(NamedTuple):
    """How a detector ran.

    Attributes:
        name: as people write it.
        picture_s: for one picture, median; 0 when it could not be used.
        problem: why not; empty when it could.

    """

    name: str
    picture_s: float
    problem: str = ""


def try_providers() -> list[ProviderTrial]:
    """Try all that are here, the processor last; blocks for some seconds."""
    listed = _run_trial()
    if isinstance(listed, str):
        return [ProviderTrial("cpu", 0.0, listed)]
    trials = []
    for name in listed:
        found = _run_trial(name)
        took = float(found[0]) if not isinstance(found, str) else 0.0
        trials.append(ProviderTrial(name, took, found if isinstance(found, str) else ""))
    return trials


def _run_trial(*words: str) -> list[str] | str:
    """Give a trial's answer, or why there is none."""
    try:
        done = subprocess.run(  # noqa: S603 - this very module
            [sys.executable, "-m", "talaia.objects.provider_trial", *words],
            capture_output=True,
            text=True,
            timeout=_LONGEST_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return str(error)
    if done.returncode < 0:
        return f"its process ended by signal {-done.returncode}"
    last = (done.stdout.strip().splitlines() or [""])[-1]
    if done.returncode or not last:
        errors = done.stderr.strip().splitlines() or [f"it ended with code {done.returncode}"]
        return last or errors[-1]
    answer: list[str] = json.loads(last)
    return answer


def _measure_provider(name: str) -> float:
    """Give how long a picture takes (s).

    Raises:
        DetectorError: it cannot be used, or sees something else than the processor.

    """
    if not OWN_FILE.is_file():
        raise DetectorError(f"{OWN_FILE} is missing; {OWN_REMEDY}")
    random = np.random.default_rng(1)
    shown = random.normal(0, 1, (1, 3, NANODET.side, NANODET.side)).astype(np.float32)
    run = open_network(str(OWN_FILE), parse_provider(name))
    found = run(shown)
    expected = found if name == "cpu" else open_network(str(OWN_FILE), parse_provider("cpu"))(shown)
    if any(
        ours.shape != theirs.shape or float(np.abs(ours - theirs).max()) > _DIFFERENCE
        for ours, theirs in zip(found, expected, strict=True)
    ):
        raise DetectorError("it sees something else than the processor does")
    times = []
    for _ in range(_PICTURES):
        before = time.perf_counter()
        run(shown)
        times.append(time.perf_counter() - before)
    return statistics.median(times)


def main() -> int:
    """Print the answer as JSON in one line, or why there is none."""
    # Libraries may print: the answer comes last, and alone.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    try:
        if len(sys.argv) > 1:
            found = [str(_measure_provider(sys.argv[1]))]
        else:
            import onnxruntime

            found = found_providers(onnxruntime.get_available_providers())
    except (DetectorError, ImportError) as error:
        print(" ".join(str(error).split())[:500], file=answers, flush=True)
        return 1
    print(json.dumps(found), file=answers, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
