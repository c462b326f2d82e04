"""Let Atheris look for inputs that a target fails on: one process for each, which it may take down.

    python -m system.fuzz.child GROUP TARGET SEEDS CORPUS SECONDS

It prints ``tried N, reached N, grew N`` at its end (inputs, places in our code, KiB). What fails is
left in the working folder as ``crash-…``, ``timeout-…`` or ``oom-…``, and the exit code is not 0.
"""

from __future__ import annotations

import atexit
import logging
import os
import re
import resource
import sys
import warnings
from pathlib import Path

import atheris

from .target import load_seeds, try_input
from .targets import targets_in

# A single input that takes more has taken what no reader may (MiB, beyond what is there already).
_MOST_MEMORY = 1024
# Of the wall clock: for what stands still, which takes no processor time (s).
_STANDSTILL_S = 30


def _resident_kib() -> int:
    status = Path("/proc/self/status").read_text("ascii")
    found = re.search(r"VmRSS:\s+(\d+)", status)
    assert found is not None
    return int(found[1])


def main(group: str, name: str, corpus: str, seconds: str) -> None:
    """Fuzz one target; does not come back."""
    # What is imported here for the first time, which is all of ours, says what an input reaches.
    with atheris.instrument_imports(include=["talaia", "mcap", "rosbags"]):
        target = next(target for target in targets_in(group) if target.name == name)
    logging.disable()
    warnings.simplefilter("ignore")
    folder = Path(corpus)
    folder.mkdir(parents=True, exist_ok=True)
    for number, seed in enumerate(load_seeds(name)):
        (folder / f"seed-{number:03}").write_bytes(seed)
        try_input(target, seed)
    before = _resident_kib()
    most = (before >> 10) + _MOST_MEMORY << 20
    resource.setrlimit(resource.RLIMIT_DATA, (most, most))
    atexit.register(lambda: print(f"grew {_resident_kib() - before}", file=sys.stderr, flush=True))  # noqa: T201
    words = [
        sys.argv[0],
        str(folder),
        f"-max_total_time={seconds}",
        f"-max_len={min(target.longest, 16 * 1024)}",
        f"-timeout={_STANDSTILL_S}",
        f"-rss_limit_mb={(before >> 10) + _MOST_MEMORY}",
        # The same each time: what was found once is found again.
        "-seed=1",
        "-print_final_stats=1",
        "-verbosity=1",
    ]
    atheris.Setup(words, lambda data: try_input(target, data))
    os.nice(10)
    atheris.Fuzz()


if __name__ == "__main__":
    main(*sys.argv[1:])
