"""Makes what records at this gateway, with what earlier runs left on the disk."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.errors import SettingsError
from talaia.gateway.recording.recorders import TriggeredRecorder
from talaia.gateway.recording.recording_store import FILM, RecordingStore
from talaia.gateway.uplink.files import FileLane
from talaia.gateway.video.camera import ABLE

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from talaia.clock import Clock
    from talaia.gateway.ports import EventSink
    from talaia.gateway.recording.film_recorder import FilmRecorder
    from talaia.gateway.recording.recorder import Recorder
    from talaia.gateway.recording.recording_store import RecoveredFile
    from talaia.gateway.settings import GatewaySettings
    from talaia.model.recording import Recording
    from talaia.model.site import Site
    from talaia.wire.frames import RecorderState

__all__ = ["RecorderCallbacks", "RecorderParts", "taping_of"]

log = logging.getLogger(__name__)


class RecorderCallbacks(NamedTuple):
    """Who is told of recordings; from any thread.

    Attributes:
        events: what is worth writing down.
        state: how it stands, after each change.
        finished: that a recording waits for the hub.
        filmed: that other cameras are filmed than before.

    """

    events: EventSink
    state: Callable[[RecorderState], None]
    finished: Callable[[], None]
    filmed: Callable[[], None]


class RecorderParts(NamedTuple):
    """What records here, and what of it waits for the hub.

    Attributes:
        tapes: to be begun and ended; none where the description wants nothing recorded.
        lanes: films and recordings that are finished; films go first.

    """

    tapes: TriggeredRecorder | None = None
    lanes: tuple[FileLane, ...] = ()

    @property
    def recorder(self) -> Recorder | None:
        """Who takes raw messages."""
        return None if self.tapes is None else self.tapes.recorder

    @property
    def films(self) -> FilmRecorder | None:
        """Who takes encoded pictures."""
        return None if self.tapes is None else self.tapes.films


def taping_of(
    site: Site, settings: GatewaySettings, clock: Clock, ear: RecorderCallbacks
) -> RecorderParts:
    """Make what records, where the description asks for it.

    Raises:
        SettingsError: topics are to be recorded, and cannot be here.

    """
    plan = site.recording
    if plan is None:
        return RecorderParts()
    tapes: TriggeredRecorder | None = None

    def say() -> None:
        if tapes is not None:
            tapes.say()

    def filmed() -> None:
        say()
        ear.filmed()

    most, rate = round(plan.disk_mb * 1e6), plan.upload * 1000
    recordings = RecordingStore(settings.data / "recordings", most, settings.spare_bytes)
    films = RecordingStore(settings.data / "films", most, settings.spare_bytes, FILM)
    recorder = _recorder(plan, site, recordings, clock, ear, say)
    filming = _films(plan, site, films, clock, ear, filmed)
    tapes = TriggeredRecorder(plan, recorder, filming, ear.state)
    lanes = []
    if filming is not None:
        lanes.append(FileLane("films", films, rate))
    if recorder is not None:
        lanes.append(FileLane("recordings", recordings, rate))
    return RecorderParts(tapes, tuple(lanes))


def _recorder(
    plan: Recording,
    site: Site,
    shelf: RecordingStore,
    clock: Clock,
    ear: RecorderCallbacks,
    say: Callable[[], None],
) -> Recorder | None:
    try:
        from talaia.gateway.adapters.ros2.requests import class_of
        from talaia.gateway.recording.definitions import definition_of
        from talaia.gateway.recording.mcap_file import recover
        from talaia.gateway.recording.recorder import Recorder
    except ImportError as error:
        if not site.recorded():
            return None
        raise SettingsError(
            f"the description names topics to record, and they cannot be ({error}); "
            "install talaia[recording]"
        ) from error
    _open(shelf, recover)

    def fields_of(name: str) -> dict[str, str]:
        fields: dict[str, str] = class_of(name, "recording").get_fields_and_field_types()
        return fields

    return Recorder(
        plan,
        site.recorded(),
        shelf,
        clock,
        lambda name: definition_of(name, fields_of),
        lambda _: say(),
        ear.events,
        ear.finished,
    )


def _films(
    plan: Recording,
    site: Site,
    shelf: RecordingStore,
    clock: Clock,
    ear: RecorderCallbacks,
    changed: Callable[[], None],
) -> FilmRecorder | None:
    if not ABLE:
        if site.filmed():
            log.warning("cameras cannot be filmed here: install talaia[camera]")
        return None
    from talaia.gateway.recording.film_file import recover_film
    from talaia.gateway.recording.film_recorder import FilmRecorder

    _open(shelf, recover_film)
    return FilmRecorder(plan, site.filmed(), shelf, clock, ear.events, ear.finished, changed)


def _open(shelf: RecordingStore, recover: Callable[[Path, Path], RecoveredFile]) -> None:
    """Open a shelf; a disk that takes nothing keeps nobody from guarding the robot."""
    try:
        shelf.open(recover)
    except OSError as error:
        log.warning("nothing can be recorded until the disk works: %s", error)
