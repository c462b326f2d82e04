"""Pictures of cameras: for programs at the gateway, for the hub's pages, and for the archive."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.cores.shared_budget import SharedBudget
from talaia.gateway.fits.frame_writer import FitsFrameWriter
from talaia.gateway.fits.outbox import ArchiveOutbox
from talaia.gateway.fits.whole_files import WholeFiles
from talaia.gateway.uplink.pictures import PictureUplink
from talaia.gateway.video.blur_detectors import BlurDetectors
from talaia.gateway.video.frame_source import FrameSource
from talaia.objects.worker import Worker

if TYPE_CHECKING:
    from talaia.gateway.assembly.description import DescriptionPart
    from talaia.gateway.assembly.foundation import FoundationPart
    from talaia.gateway.assembly.recording import RecordingPart
    from talaia.gateway.assembly.taps import TapsPart

__all__ = ["VideoPart"]


class VideoPart(GatewayPart):
    """Where adapters give pictures.

    Attributes:
        frames: gives pixels to whoever looks at cameras here, such as a detector.
        pictures: encoded, to the hub and to films.
        budget: what all pictures together may take of the cores.
        films: takes encoded pictures of cameras; none where nothing is filmed.
        blur_detectors: find what is blurred before a picture leaves.
        outbox: whole FITS files that wait for the hub's archive.
        frame_taker: takes pictures for the archive in pieces.
        whole_files: takes pictures for the archive that come as whole files.

    """

    def __init__(
        self,
        *,
        base: FoundationPart,
        description: DescriptionPart,
        recording: RecordingPart,
        taps: TapsPart,
    ) -> None:
        """Take up the files that an earlier run left."""
        settings, site = base.settings, description.site
        # Who looks at pixels here keeps a camera awake as a page does.
        self.frames = FrameSource(on_held=base.streams_changed.emit)
        self.blur_detectors = BlurDetectors(
            lambda on_status: Worker(
                site.object_models,
                settings.folder,
                on_status,
                provider=settings.detector_provider,
            )
        )
        self.films = recording.films
        self.budget = SharedBudget()
        self.pictures = PictureUplink(
            base.loop,
            base.clock,
            frames=self.frames,
            films=self.films,
            taps=taps.outbox,
            detectors=self.blur_detectors,
            budget=self.budget,
        )
        # What an earlier run could not send is taken up again.
        self.outbox = ArchiveOutbox(
            settings.data / "outbox",
            settings.outbox_bytes,
            base.announce_file,
            base.arrivals.notice_file,
            kept=base.arrivals.note_kept,
        )
        # In a folder of its own, so that half a picture is never taken for a whole one.
        self.frame_taker = FitsFrameWriter(
            folder=settings.data / "taking",
            outbox=self.outbox,
            events=base.events,
            clock=base.clock,
            disk=base.file_thread,
        )
        self.whole_files = WholeFiles(
            folder=settings.data / "taking",
            outbox=self.outbox,
            events=base.events,
            clock=base.clock,
            disk=base.file_thread,
            site=site.name,
            place=site.place,
        )

    def start(self) -> None:
        """Let pictures be looked at from here on, by detectors on this event loop."""
        self.blur_detectors.start()

    async def close(self) -> None:
        """End the detectors."""
        await self.blur_detectors.close()
