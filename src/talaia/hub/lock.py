"""One program at a time writes a data folder's history: the hub, or an import while none runs."""

from __future__ import annotations

import fcntl
import os
from contextlib import contextmanager
from typing import TYPE_CHECKING

from talaia.hub.errors import CannotStart

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

__all__ = ["LOCK", "HubRuns", "hub_lock"]

# Never removed: were it, two programs could each have a lock on a file of that name.
LOCK = "hub.lock"


class HubRuns(CannotStart):
    """Another program has the data folder."""


@contextmanager
def hub_lock(data: Path) -> Iterator[None]:
    """Have the data folder for as long as the block lasts; a killed program lets go of it, too.

    Raises:
        HubRuns: another program has it.
        CannotStart: it cannot be written.

    """
    try:
        # O_CLOEXEC: a program that is started from here would hold the lock on after our end.
        number = os.open(data / LOCK, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    except OSError as error:
        raise CannotStart(
            f"the data folder {data} cannot be written: {error.strerror}",
            "choose another with --data",
        ) from error
    try:
        try:
            # The kernel drops it with the last descriptor: who is killed leaves no stale lock.
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise HubRuns(
                f"the data folder {data} is used by another hub, or an import",
                "wait for it, or choose another with --data",
            ) from error
        yield
    finally:
        # Lets go of the lock, too.
        os.close(number)
