"""A camera that has one picture, for what looks at pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.ports import CameraFrame


class OnePicture:
    """A `CameraFrames` of one camera; ``held`` counts who keeps it awake."""

    def __init__(self, look: CameraFrame) -> None:  # noqa: D107
        self.look = look
        self.held = 0

    def hold(self, stream: str) -> Callable[[], None]:
        assert stream == self.look.stream
        self.held += 1

        def release() -> None:
            self.held -= 1

        return release

    def arrived(self, stream: str, since_us: int = 0, wait_s: float = 0.0) -> int:
        return self.look.mono_us if self.look.mono_us > since_us else 0

    def newest(self, stream: str, after: int = 0, wait_s: float = 0.0) -> CameraFrame | None:
        return self.look
