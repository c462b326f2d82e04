"""Pictures of one INDI server's cameras, on their way into the archive.

A server sends no picture unasked: each camera is asked for once in every life of its driver (the
protocol's ``enableBLOB``). A picture passes in pieces and is never in memory whole.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from talaia.gateway.adapters.indi.fits_circumstances import header_cards
from talaia.gateway.adapters.indi.protocol import ask_blobs
from talaia.gateway.fits.header import rewrite_header, values_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.gateway.adapters.indi.protocol import BlobEnd, BlobHead, BlobPart
    from talaia.gateway.adapters.indi.state import IndiDeviceTree
    from talaia.gateway.ports import AdapterContext

__all__ = ["PictureReception"]


class PictureReception:
    """All cameras of one server. On the event loop; one picture at a time, as a server sends."""

    def __init__(
        self,
        names: Mapping[str, str],
        tree: IndiDeviceTree,
        context: AdapterContext,
        send: Callable[[bytes], None],
    ) -> None:
        """Take who is described, what is known, where pictures go, and words to the server.

        Args:
            names: by the INDI device: its name in the description.
            tree: what all devices say, which goes into the pictures' headers.
            context: of the adapter; without ``frames`` nobody keeps pictures and none is asked.
            send: says something to the server.

        """
        self._names, self._tree, self._send = names, tree, send
        self._frames, self._clock, self._site = context.frames, context.clock, context.site
        # Drivers that were asked for pictures since they came.
        self._asked: set[str] = set()
        # The INDI device whose picture is coming; empty for none, and for one that nobody keeps.
        self._camera = ""

    def restart(self) -> None:
        """Begin with a server anew: it has forgotten who was asked."""
        self._asked.clear()

    def redefine(self, device: str) -> None:
        """Take in that a driver has come again: it is asked anew."""
        self._asked.discard(device)

    def ask_camera(self, device: str) -> None:
        """Ask for a camera's pictures, once."""
        if self._frames is not None and device not in self._asked:
            self._asked.add(device)
            self._send(ask_blobs(device))

    async def begin_picture(self, head: BlobHead) -> None:
        """Begin a picture; one of no described device, or an empty one, is let pass."""
        described = self._names.get(head.device, "")
        self._camera = ""
        if self._frames is not None and described and head.size > 0:
            self._camera = head.device
            complete = partial(self._complete_header, described, head.device)
            await self._frames.begin(described, head.format, head.size, complete)

    async def write_part(self, part: BlobPart) -> None:
        """Write the next bytes of the picture."""
        if self._camera and self._frames is not None:
            await self._frames.write(part.data)

    async def end_picture(self, end: BlobEnd) -> tuple[str, str] | None:
        """End the picture.

        Returns:
            The INDI device and what is wrong with its picture (empty: it is kept); none if this
            was a picture that nobody keeps.

        """
        if not self._camera or self._frames is None:
            return None
        camera, problem = self._camera, await self._frames.end(end.problem)
        self._camera = ""
        return camera, problem

    async def drop_picture(self) -> None:
        """Forget a picture that will not end."""
        if self._frames is not None:
            await self._frames.drop()

    def _complete_header(self, described: str, camera: str, header: bytes) -> bytes:
        """Write into a picture's header what all devices say now."""
        # Drivers write some of it themselves; what they know better stays (`circumstances`).
        known = values_of(header)
        return rewrite_header(
            header,
            header_cards(
                book=self._tree,
                camera=camera,
                site=self._site,
                address=described,
                header=known,
                unix_s=self._clock.wall_ns() / 1e9,
            ),
        )
