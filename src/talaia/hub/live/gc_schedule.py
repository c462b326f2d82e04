"""Python's full garbage collection, at moments when nobody drives.

It looks at everything that lives, without a pause: 150 ms and more in a hub with many gateways,
which is longer than a driver should wait. So what the start has made is set aside, and a full
collection is made while nobody has control of a device. What has outlived one, sites and links
above all, is set aside too, or with thousands of gateways it would be looked at every second.
Everything is looked at again once an hour, and when much more is set aside than there was. Most
memory comes back without any of it, by counted references, and young objects are still collected
as always.
"""

from __future__ import annotations

import asyncio
import gc
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["collect_at_rest", "wants_collection", "wants_whole"]

# How often it is asked whether one is due (s).
_LOOK_S = 1.0
# More than the count gets to: Python makes no full collection by itself.
_NEVER = 1_000_000
# After so long everything is looked at, also what has outlived a full collection (s); or when so
# much more than then is set aside: links that come and go may leave some that nobody counts.
_WHOLE_S = 3600.0
_MORE, _MANY_MORE = 1.25, 100_000
# To count what is set aside is to go through it: after so many full collections.
_COUNTED = 10
# In collections of the young: how many make a full one due, and how many make it due at once. The
# latter bounds what can have gathered to about 700 000 objects.
_DUE, _OVERDUE = 10, 100


def wants_collection(young: int, *, driven: bool) -> bool:
    """Tell whether a full collection is to be made now. Pure."""
    return young >= (_OVERDUE if driven else _DUE)


def wants_whole(passed_s: float, aside: int, before: int) -> bool:
    """Tell whether everything is to be looked at: after ``passed_s``, with ``aside`` set aside.

    ``before`` is how many objects were when it was looked at last. Pure.
    """
    return passed_s >= _WHOLE_S or aside > _MORE * before + _MANY_MORE


async def collect_at_rest(driven: Callable[[], bool]) -> None:
    """Collect until cancelled; ``driven`` tells whether somebody has control of a device."""
    loop = asyncio.get_running_loop()
    before = gc.get_threshold()
    looked_at, known = loop.time(), _collect_whole()
    # The young and the middle generation are collected as before.
    gc.set_threshold(before[0], before[1], _NEVER)
    collections = 0
    try:
        while True:
            await asyncio.sleep(_LOOK_S)
            is_driven = driven()
            # The third count: collections of the middle generation since the last full one.
            if not wants_collection(gc.get_count()[2], driven=is_driven):
                continue
            gc.collect()
            gc.freeze()
            collections += 1
            if is_driven or collections % _COUNTED:
                continue
            if wants_whole(loop.time() - looked_at, gc.get_freeze_count(), known):
                looked_at, known = loop.time(), _collect_whole()
    # As it was, for whoever goes on in this process, such as tests.
    finally:
        gc.set_threshold(*before)
        gc.unfreeze()


def _collect_whole() -> int:
    """Look at everything, and set aside what lives; give how many objects that are."""
    gc.unfreeze()
    gc.collect()
    gc.freeze()
    return gc.get_freeze_count()
