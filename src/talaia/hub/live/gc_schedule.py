"""Python's full garbage collection, at moments when nobody drives.

It looks at everything that lives, without a pause: 150 ms and more in a hub with many gateways,
which is longer than a driver should wait. So what the start has made is set aside, and a full
collection is made while nobody has control of a device. What has outlived one, sites and links
above all, is set aside too, or with thousands of gateways it would be looked at every second; once
an hour everything is looked at again. Most memory comes back without any of it, by counted
references, and young objects are still collected as always.
"""

from __future__ import annotations

import asyncio
import gc
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["collect_at_rest", "wants_collection"]

# How often it is asked whether one is due (s).
_LOOK_S = 1.0
# More than the count gets to: Python makes no full collection by itself.
_NEVER = 1_000_000
# So often at the most everything is looked at, also what has outlived a full collection (s).
_WHOLE_S = 3600.0
# In collections of the young: how many make a full one due, and how many make it due at once. The
# latter bounds what can have gathered to about 700 000 objects.
_DUE, _OVERDUE = 10, 100


def wants_collection(young: int, *, driven: bool) -> bool:
    """Tell whether a full collection is to be made now. Pure."""
    return young >= (_OVERDUE if driven else _DUE)


async def collect_at_rest(driven: Callable[[], bool]) -> None:
    """Collect until cancelled; ``driven`` tells whether somebody has control of a device."""
    loop = asyncio.get_running_loop()
    whole_at = _collect_whole(loop)
    before = gc.get_threshold()
    # The young and the middle generation are collected as before.
    gc.set_threshold(before[0], before[1], _NEVER)
    try:
        while True:
            await asyncio.sleep(_LOOK_S)
            is_driven = driven()
            # The third count: collections of the middle generation since the last full one.
            if not wants_collection(gc.get_count()[2], driven=is_driven):
                continue
            if loop.time() - whole_at >= _WHOLE_S and not is_driven:
                whole_at = _collect_whole(loop)
            else:
                gc.collect()
                gc.freeze()
    # As it was, for whoever goes on in this process, such as tests.
    finally:
        gc.set_threshold(*before)
        gc.unfreeze()


def _collect_whole(loop: asyncio.AbstractEventLoop) -> float:
    """Look at everything, and set aside what lives; give when that was (s, the loop's clock)."""
    gc.unfreeze()
    gc.collect()
    gc.freeze()
    return loop.time()
