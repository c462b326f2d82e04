"""The connections to the hub, and where its messages are acted on."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.samples.signal_watch import SignalWatch
from talaia.gateway.uplink.files import FileLane
from talaia.gateway.uplink.key_prover import RESUME_FILE, KeyProver
from talaia.gateway.uplink.links import HubConnection, keep_files, keep_link, keep_media
from talaia.gateway.uplink.message_dispatcher import MessageDispatcher
from talaia.gateway.uplink.releases import OfferedReleases
from talaia.gateway.uplink.tls import HubTrust

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from talaia.gateway.assembly.actuation import ActuationPart
    from talaia.gateway.assembly.adapters import AdaptersPart
    from talaia.gateway.assembly.detection import DetectionPart
    from talaia.gateway.assembly.foundation import FoundationPart
    from talaia.gateway.assembly.night import NightPart
    from talaia.gateway.assembly.reload import ReloadPart
    from talaia.gateway.assembly.samples import SamplesPart
    from talaia.gateway.assembly.video import VideoPart

__all__ = ["UplinkPart"]


class UplinkPart(GatewayPart):
    """See the module.

    Attributes:
        dispatcher: gives each message of the hub to whom it concerns.
        actuation: what moves, and may move.
        night: what observes by itself, of which the hub is told.
        releases: of this gateway's own software, which the hub has offered.
        hub: the way to it.

    """

    def __init__(
        self,
        *,
        base: FoundationPart,
        samples: SamplesPart,
        video: VideoPart,
        adapters: AdaptersPart,
        detection: DetectionPart,
        actuation: ActuationPart,
        reload: ReloadPart,
        night: NightPart,
    ) -> None:
        """Dial nobody yet."""
        self.night, self.actuation = night, actuation
        self._base, self._samples, self._reload = base, samples, reload
        self._recording, self._video, self._taps = adapters.recording, video, adapters.taps
        self.releases = OfferedReleases()
        self.dispatcher = MessageDispatcher(
            boot=base.boot,
            actuation=actuation.actuation,
            spool=samples.spool,
            adapter=adapters.adapter,
            output=adapters.output,
            events=base.events,
            lanes=base.lanes,
            reachability=adapters.reachability,
            recorders=adapters.recording.recorders,
            change_requests=reload.requests,
            pictures=video.pictures,
            taps=adapters.taps.service,
            assets=adapters.taps.assets,
            watch=SignalWatch(
                batches=samples.batcher,
                reader=adapters.adapter,
                listed=lambda: (reload.reload.now.catalogue, reload.reload.now.addresses),
            ),
            reporter=detection.reporter,
            releases=self.releases,
            robot_log=adapters.robot_log.reporter,
            night=night.service,
        )
        base.streams_changed.connect(self.dispatcher.update_watched_streams)
        self.hub = HubConnection(
            settings=base.settings,
            # One for all connections: the certificate is looked at once.
            trust=HubTrust(base.settings.hub),
            prover=KeyProver(
                key=base.settings.key,
                site=reload.reload.now.site.site,
                path=base.settings.data / RESUME_FILE,
                on_disk=base.run_on_disk,
            ),
            clock=base.clock,
            dispatcher=self.dispatcher,
        )

    def start(self) -> None:
        """Have the cameras read of which the last seconds are held."""
        if self._recording.recorders is not None:
            self.dispatcher.update_watched_streams()

    def tasks(self) -> Mapping[str, Callable[[], Awaitable[None]]]:
        """Keep one connection for messages and samples, one for pictures, one for files."""
        base = self._base
        upload_bytes = base.settings.upload_bytes
        files = [
            # First: somebody waits for these.
            self._taps.lane,
            FileLane("pictures", self._video.outbox, upload_bytes),
            *self._recording.lanes,
        ]
        # Tasks of their own: a file that hangs on a slow line holds up no command.
        return {
            "link": partial(
                keep_link,
                hub=self.hub,
                boot=base.boot,
                reload=self._reload.reload,
                lanes=base.lanes,
                wake=base.frame_waiting,
                batcher=self._samples.batcher,
                spool=self._samples.spool,
            ),
            "pictures": partial(keep_media, self.hub, self._video.pictures),
            "files": partial(
                keep_files,
                hub=self.hub,
                files=files,
                to_send=base.file_waiting,
                lanes=base.lanes,
                events=base.events,
            ),
        }
