"""Changes of the description while the gateway runs: who is told, and in which order."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.reload.apply import DescriptionReload
from talaia.gateway.reload.connection_exchange import ConnectionExchange
from talaia.gateway.reload.requests import ChangeRequests

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from talaia.gateway.assembly.actuation import ActuationPart
    from talaia.gateway.assembly.adapters import AdaptersPart
    from talaia.gateway.assembly.description import DescriptionPart
    from talaia.gateway.assembly.detection import DetectionPart
    from talaia.gateway.assembly.foundation import FoundationPart
    from talaia.gateway.assembly.legacy import LegacyPart
    from talaia.gateway.assembly.recording import RecordingPart
    from talaia.gateway.assembly.samples import SamplesPart
    from talaia.gateway.assembly.supervision import SupervisionPart
    from talaia.model.description_follower import DescriptionFollower
    from talaia.model.site import Site

__all__ = ["ReloadPart"]


class ReloadPart(GatewayPart):
    """Knows every part that follows a change of the description.

    Attributes:
        reload: puts another description in the place of the one that counts.
        requests: changes of the file, and those that the hub asks for.

    """

    def __init__(
        self,
        *,
        base: FoundationPart,
        description: DescriptionPart,
        samples: SamplesPart,
        recording: RecordingPart,
        adapters: AdaptersPart,
        detection: DetectionPart,
        actuation: ActuationPart,
        legacy: LegacyPart,
        supervision: SupervisionPart,
    ) -> None:
        """Follow nothing yet."""
        settings = base.settings
        # In this order: what records before what is read, what acts after what it acts through.
        followers: list[DescriptionFollower[Site]] = []
        if recording.recorders is not None:
            followers.append(recording.recorders)
        connections = ConnectionExchange(
            site=description.site,
            numbering=description.numbering,
            reachability=adapters.reachability,
            adapter=adapters.adapter,
            adapters=adapters.by_connection,
            make=adapters.make_adapter,
        )
        followers += [
            connections,
            actuation.actuation,
            detection,
            supervision,
        ]
        if legacy.server is not None:
            followers.append(legacy.server)
        self.reload = DescriptionReload(
            current=description.current,
            numbering=description.numbering,
            connections=connections,
            actuation=actuation.actuation,
            samples=samples,
            followers=followers,
            say=base.lanes.send,
            begin_again=description.restart.request_restart,
        )
        self.requests = ChangeRequests(
            file=description.file,
            accepts=settings.accepts,
            key_hash=hashlib.sha256(settings.key.encode()).hexdigest(),
            data=settings.data,
            reload=self.reload,
            send=base.lanes.send,
            events=base.events,
            on_disk=base.run_on_disk,
        )

    def tasks(self) -> Mapping[str, Callable[[], Awaitable[None]]]:
        """Follow the description's file."""
        return {"file": self.requests.watch_file}
