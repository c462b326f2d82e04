"""Where samples and pictures go when there is no hub and no spool: nowhere."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.ports import Filming
from talaia.objects.errors import DetectorError

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from talaia.model.detection import Blur
    from talaia.objects.detection import Detection
    from talaia.wire.columns import Columns
    from talaia.wire.frames import PictureFrame

__all__ = ["SilentSinks"]


class SilentSinks:
    """A `SampleSink` and a `PictureSink` that take nothing."""

    def put_samples(self, columns: Columns) -> None:
        """Take none."""

    def asked(self, stream: str) -> Collection[str]:
        """Want no picture."""
        return ()

    def key_due(self, stream: str, form: str) -> bool:
        """Need none to begin with."""
        return False

    def room(self) -> float:
        """Have no room for any."""
        return 0.0

    def offer_frame(
        self,
        stream: str,
        stamp: tuple[int, int, int],
        decode: Callable[[], NDArray[np.uint8] | None],
        blurred: Callable[[], NDArray[np.uint8] | None] | None = None,
    ) -> None:
        """Take none."""

    def find_private(self, blur: Blur, rgb: NDArray[np.uint8]) -> Sequence[Detection]:
        """Look at none."""
        # Nobody is asked for a picture here.
        raise DetectorError("nothing is detected here")

    def offer(self, picture: PictureFrame) -> None:
        """Take none."""

    def filming(self, stream: str, time_us: int) -> Filming:
        """Film nothing."""
        return Filming.NO

    def film(self, picture: PictureFrame) -> None:
        """Film nothing."""

    def trouble(self, stream: str, why: str) -> None:
        """Tell nobody."""
