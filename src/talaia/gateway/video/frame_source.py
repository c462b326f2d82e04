"""The newest picture of each camera that somebody at the gateway needs as pixels. Any thread."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from talaia.gateway.ports import CameraFrame

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

__all__ = ["FrameSource"]


class _Newest:
    """One camera: how many hold it, and its newest picture, which is decoded once at the most."""

    def __init__(self) -> None:
        self.holders = 0  # Those who look; at 0 it is forgotten.
        self.stamp = (0, 0, 0)  # Number, wall and monotonic time (µs) of the newest.
        # Gives its pixels; None until the first came.
        self.decode: Callable[[], NDArray[np.uint8] | None] | None = None
        # Gives what of it may leave the gateway; None where all of it may.
        self.blurred: Callable[[], NDArray[np.uint8] | None] | None = None
        self.look: CameraFrame | None = None  # The newest that was decoded, shared by all who look.


class FrameSource:
    """A `talaia.gateway.ports.CameraFrames`."""

    def __init__(self, on_held: Callable[[], None] = lambda: None) -> None:
        """Hold nothing; ``on_held`` is told, from any thread, that other streams are held."""
        self._of: dict[str, _Newest] = {}  # By stream; touched under `_lock` only.
        self._lock = threading.Lock()
        # On the same lock: it is free while somebody waits for a picture.
        self._arrived = threading.Condition(self._lock)
        self._on_held = on_held

    def held_streams(self) -> frozenset[str]:
        """Name the streams that somebody holds."""
        with self._lock:
            return frozenset(name for name, reader in self._of.items() if reader.holders)

    def hold(self, stream: str) -> Callable[[], None]:
        """See `Pictures.hold`."""
        with self._lock:
            newest = self._of.setdefault(stream, _Newest())
            newest.holders += 1
            first = newest.holders == 1
        # Outside the lock, for the receiver may ask `held_streams`.
        if first:
            self._on_held()
        # A second call of the same release must not count somebody else out.
        freed = False

        def release() -> None:
            nonlocal freed
            with self._lock:
                if freed:
                    return
                freed = True
                newest.holders -= 1
                last = not newest.holders
                if last:
                    self._of.pop(stream, None)
            if last:
                self._on_held()

        return release

    def offer_frame(
        self,
        stream: str,
        stamp: tuple[int, int, int],
        decode: Callable[[], NDArray[np.uint8] | None],
        blurred: Callable[[], NDArray[np.uint8] | None] | None = None,
    ) -> None:
        """Take a picture: number, wall time and monotonic time (µs), and what makes it RGB."""
        with self._lock:
            # Nobody holds it: the picture is not even kept.
            newest = self._of.get(stream)
            if newest is not None:
                newest.stamp, newest.decode, newest.blurred = stamp, decode, blurred
                self._arrived.notify_all()

    def arrived(self, stream: str, since_us: int = 0, wait_s: float = 0.0) -> int:
        """See `Pictures.arrived`."""
        with self._lock:

            def there() -> bool:
                held = self._of.get(stream)
                return held is not None and held.decode is not None and held.stamp[2] > since_us

            if there() or (wait_s and self._arrived.wait_for(there, wait_s)):
                return self._of[stream].stamp[2]
            return 0

    def newest(self, stream: str, after: int = 0, wait_s: float = 0.0) -> CameraFrame | None:
        """See `Pictures.newest`."""
        with self._lock:

            def there() -> bool:
                held = self._of.get(stream)
                return held is not None and held.decode is not None and held.stamp[0] > after

            if not there() and not (wait_s and self._arrived.wait_for(there, wait_s)):
                return None
            newest = self._of[stream]
            stamp, decode, blurred = newest.stamp, newest.decode, newest.blurred
            # Its moment, too: a camera that is connected anew begins to number anew.
            look = newest.look
            if look is not None and (look.seq, look.mono_us) == (stamp[0], stamp[2]):
                return look
        # Outside the lock: adapters that offer pictures must not wait for a decoder.
        rgb = None if decode is None else decode()
        if rgb is None:
            return None
        look = CameraFrame(stream, *stamp, rgb, blurred)
        newest.look = look
        return look
