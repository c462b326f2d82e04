"""Run one word of ``talaia`` on a disk that fails when a file says so.

    TALAIA_DISK_FAULT=FILE TALAIA_DISK=FOLDER python failing_disk.py gateway …

While FILE holds a number, every write below FOLDER ends with that errno (30 read-only, 5 failing).
The product knows nothing of this.
"""

from __future__ import annotations

import builtins
import io
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any


def arm(flag: Path, folder: str) -> None:
    """Replace what writes."""

    def trouble(where: str) -> None:
        if not where.startswith(folder):
            return
        try:
            number = int(flag.read_bytes() or b"0")
        except (FileNotFoundError, ValueError):
            return
        if number:
            raise OSError(number, os.strerror(number), where)

    def place_of(file: Any) -> str:
        if isinstance(file, int):
            try:
                return os.readlink(f"/proc/self/fd/{file}")
            except OSError:
                return ""
        return os.path.abspath(os.fspath(file))

    def by_file(original: Callable[..., Any]) -> Callable[..., Any]:
        def wrapped(file: Any, *rest: Any, **more: Any) -> Any:
            trouble(place_of(file))
            return original(file, *rest, **more)

        return wrapped

    for name in ("write", "pwrite", "pwritev", "writev", "fsync", "fdatasync", "ftruncate"):
        setattr(os, name, by_file(getattr(os, name)))
    for name in ("mkdir", "unlink", "rename", "replace"):
        setattr(os, name, by_file(getattr(os, name)))
    os_open, io_open = os.open, io.open

    def opened(path: Any, flags: int, *rest: Any, **more: Any) -> int:
        if flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
            trouble(place_of(path))
        return os_open(path, flags, *rest, **more)

    def opened_file(file: Any, mode: str = "r", *rest: Any, **more: Any) -> Any:
        if set(mode) & set("wax+") and not isinstance(file, int):
            trouble(place_of(file))
        return io_open(file, mode, *rest, **more)

    os.open = opened
    io.open = builtins.open = opened_file


def main() -> int:
    """Arm and run."""
    arm(Path(os.environ["TALAIA_DISK_FAULT"]), os.environ["TALAIA_DISK"])
    from talaia.cli.main import main as talaia

    sys.argv[0] = "talaia"
    return int(talaia() or 0)


if __name__ == "__main__":
    raise SystemExit(main())
