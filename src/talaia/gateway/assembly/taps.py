"""Raw topics, and files that the robot's description among them names, on their way to the hub."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.assets.asset_outbox import AssetOutbox
from talaia.gateway.assets.asset_reader import AssetReader
from talaia.gateway.assets.asset_service import AssetService
from talaia.gateway.assets.package_index import PackageIndex
from talaia.gateway.taps.outbox import TapOutbox
from talaia.gateway.taps.service import TapService
from talaia.gateway.uplink.files import FileLane

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from talaia.gateway.assembly.foundation import FoundationPart

__all__ = ["TapsPart"]

# A page asks for some meshes of a robot at once, and for the next when it has one.
_LINGER_S = 2.0


class TapsPart(GatewayPart):
    """Nothing is heard or read before the hub wants it.

    Attributes:
        outbox: what waits for the connection for pictures.
        service: knows what the hub wants, and which topics there are.
        assets: answers the hub that asks for files.
        lane: files that wait for the connection for files.

    """

    def __init__(self, *, base: FoundationPart) -> None:
        """Want nothing yet."""
        self.outbox = TapOutbox(base.clock)
        self.service = TapService(clock=base.clock, outbox=self.outbox)
        settings, index = base.settings, PackageIndex.from_environment()
        # A reader for each: the one answers while the other reads what is on its way.
        reader, sender = (AssetReader(index, settings.meshes_from) for _ in range(2))
        waiting = AssetOutbox(sender)
        self.assets = AssetService(
            reader=reader if settings.meshes else None,
            outbox=waiting,
            send=base.lanes.send,
            announce=base.file_waiting.set,
        )
        self.lane = FileLane("meshes", waiting, settings.upload_bytes, linger_s=_LINGER_S)
        if settings.meshes:
            self.service.on_message = self.assets.hear_message

    def tasks(self) -> Mapping[str, Callable[[], Awaitable[None]]]:
        """Answer a hub that asks for files."""
        return {"files": self.assets.answer_requests}
