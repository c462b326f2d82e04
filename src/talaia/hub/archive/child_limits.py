"""Limits that a process sets itself before it reads files of others; they cannot be raised again.

What a hostile file makes of its reader then costs that reader, and neither the hub nor the machine.
"""

from __future__ import annotations

import contextlib
import os
import resource
from pathlib import Path

__all__ = ["limit_this_process"]

# Of address space (bytes): pictures of a gigabyte are read, and half of a small machine is left.
_MOST_MEMORY = 4 * 1024**3
_LEAST_MEMORY = 1024**3
_MOST_FILES = 64


def limit_this_process(*, most_written: int) -> None:
    """Bound memory, open files and the size of files that are written (bytes)."""
    physical = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    memory = max(_LEAST_MEMORY, min(_MOST_MEMORY, physical // 2))
    wanted = {
        resource.RLIMIT_AS: memory,
        resource.RLIMIT_NOFILE: _MOST_FILES,
        resource.RLIMIT_FSIZE: most_written,
        resource.RLIMIT_CORE: 0,
    }
    for limit, most in wanted.items():
        hard = resource.getrlimit(limit)[1]
        most = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(limit, (most, most))
    # Where memory runs short on the machine all the same, this process ends and not the hub.
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("1000", "ascii")
