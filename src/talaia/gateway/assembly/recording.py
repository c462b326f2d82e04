"""What records at this gateway: messages of topics and films of cameras."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.errors import SettingsError
from talaia.gateway.recording.recorders import TriggeredRecorder
from talaia.gateway.recording.recording_store import FILM, RecordingStore
from talaia.gateway.uplink.files import FileLane
from talaia.gateway.video.camera import can_film
from talaia.model.derived_signals import clip_lengths
from talaia.model.topics import blurred_cameras

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from talaia.gateway.assembly.description import DescriptionPart
    from talaia.gateway.assembly.foundation import FoundationPart
    from talaia.gateway.recording.film_recorder import FilmRecorder
    from talaia.gateway.recording.recorder import Recorder
    from talaia.gateway.recording.recording_store import RecoveredFile
    from talaia.model.recording import Recording
    from talaia.model.site import Site

__all__ = ["RecordingPart"]

log = logging.getLogger(__name__)


class RecordingPart(GatewayPart):
    """What records here, and what of it waits for the hub.

    Attributes:
        recorders: to be begun and ended; none where the description wants nothing recorded.
        lanes: films and recordings that are finished; films go first.

    """

    def __init__(self, *, base: FoundationPart, description: DescriptionPart) -> None:
        """Make what records, where the description asks for it.

        Raises:
            SettingsError: topics are to be recorded, and cannot be here.

        """
        self._base = base
        # None where the description records nothing.
        self.recorders: TriggeredRecorder | None = None
        self.lanes: tuple[FileLane, ...] = ()  # Films before messages: they are sent in this order.
        site, settings = description.site, base.settings
        plan = site.recording
        if plan is None:
            return
        # Decimal units: the description's are MB and kB.
        most_bytes, rate = round(plan.disk_mb * 1e6), plan.upload * 1000
        messages = RecordingStore(settings.data / "recordings", most_bytes, settings.spare_bytes)
        films = RecordingStore(settings.data / "films", most_bytes, settings.spare_bytes, FILM)
        # Made before its recorders, which report their state through it.
        self.recorders = recorders = TriggeredRecorder(plan, base.send_threadsafe)
        recorders.attach_recorders(
            recorder=self._make_recorder(plan, site, messages, recorders),
            films=self._make_film_recorder(plan, site, films, recorders),
        )
        if recorders.films is not None:
            self.lanes += (FileLane("films", films, rate),)
        if recorders.recorder is not None:
            self.lanes += (FileLane("recordings", messages, rate),)

    @property
    def recorder(self) -> Recorder | None:
        """Who takes raw messages."""
        return None if self.recorders is None else self.recorders.recorder

    @property
    def films(self) -> FilmRecorder | None:
        """Who takes encoded pictures."""
        return None if self.recorders is None else self.recorders.films

    def start(self) -> None:
        """Hold the last seconds from here on."""
        if self.recorders is not None:
            self.recorders.start()

    async def close(self) -> None:
        """Finish what is being recorded."""
        if self.recorders is not None:
            # On a thread: it waits for the disk.
            await asyncio.to_thread(self.recorders.close)

    def _make_recorder(
        self, plan: Recording, site: Site, store: RecordingStore, recorders: TriggeredRecorder
    ) -> Recorder | None:
        # Imported here: what it needs is an extra.
        try:
            from talaia.gateway.adapters.ros2.requests import class_of
            from talaia.gateway.recording.definitions import definition_of
            from talaia.gateway.recording.mcap_file import recover_file
            from talaia.gateway.recording.recorder import Recorder
        except ImportError as error:
            # Nothing is named, so nothing is missing.
            if not site.recorded_topics():
                return None
            raise SettingsError(
                f"the description names topics to record, and they cannot be ({error}); "
                "install talaia[recording]"
            ) from error
        _open_store(store, recover_file)

        def fields_of(name: str) -> dict[str, str]:
            fields: dict[str, str] = class_of(name, "recording").get_fields_and_field_types()
            return fields

        return Recorder(
            plan=plan,
            topics=site.recorded_topics(),
            hides_pictures=bool(blurred_cameras(site)),
            shelf=store,
            clock=self._base.clock,
            definition=lambda name: definition_of(name, fields_of),
            tell_state=lambda _state: recorders.report_state(),
            events=self._base.events,
            finished=self._base.announce_file,
        )

    def _make_film_recorder(
        self, plan: Recording, site: Site, store: RecordingStore, recorders: TriggeredRecorder
    ) -> FilmRecorder | None:
        if not can_film():
            # Only cameras are missing then: messages are recorded all the same.
            if site.filmed_cameras() or clip_lengths(site):
                log.warning("cameras cannot be filmed here: install talaia[camera]")
            return None
        from talaia.gateway.recording.film_file import recover_film
        from talaia.gateway.recording.film_recorder import FilmRecorder

        _open_store(store, recover_film)
        base = self._base

        def on_change() -> None:
            recorders.report_state()
            # The last seconds of other cameras may be wanted now, so they are read.
            base.streams_changed.emit()

        return FilmRecorder(
            plan=plan,
            cameras=site.filmed_cameras(),
            clips=clip_lengths(site),
            shelf=store,
            clock=base.clock,
            events=base.events,
            finished=base.announce_file,
            changed=on_change,
        )


def _open_store(store: RecordingStore, recover: Callable[[Path, Path], RecoveredFile]) -> None:
    """Open a store; a disk that takes nothing keeps nobody from guarding the robot."""
    try:
        store.open(recover)
    except OSError as error:
        log.warning("nothing can be recorded until the disk works: %s", error)
