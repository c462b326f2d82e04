"""All that records at a gateway, begun and ended together: messages as MCAP, cameras as films."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia.model.derived_signals import clip_lengths
from talaia.model.topics import blurred_cameras
from talaia.wire.frames import RecorderState

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.recording.film_recorder import FilmRecorder
    from talaia.gateway.recording.recorder import Recorder
    from talaia.model.recording import Recording, Trigger
    from talaia.model.site import Site

__all__ = ["TriggeredRecorder"]


class TriggeredRecorder:
    """What is told to begin and to end, and tells how it stands. Any thread may call it.

    Attributes:
        plan: see `Recording`.
        recorder: of messages; none where no topic is recorded.
        films: of cameras; none where this machine cannot encode them.

    """

    def __init__(self, plan: Recording, send_state: Callable[[RecorderState], None]) -> None:
        """Record nothing until `attach_recorders`; any thread calls ``send_state``."""
        self.plan = plan
        self._send_state = send_state  # Takes the state of both together.
        # None until `attach_recorders`, and where there is nothing of its kind to record.
        self.recorder: Recorder | None = None
        self.films: FilmRecorder | None = None

    def attach_recorders(self, *, recorder: Recorder | None, films: FilmRecorder | None) -> None:
        """Take what records, before `start`."""
        self.recorder, self.films = recorder, films

    def start(self) -> None:
        """Begin to hold what is held."""
        if self.recorder is not None:
            self.recorder.start()
        if self.films is not None:
            self.films.start()

    def close(self) -> None:
        """Finish what is being recorded, and end."""
        if self.recorder is not None:
            self.recorder.close()
        if self.films is not None:
            self.films.close()

    def redescribe(self, site: Site) -> None:
        """Record what another description names; its `Recording` is the same."""
        if self.recorder is not None:
            self.recorder.topics = frozenset(site.recorded_topics())
            self.recorder.hides_pictures = bool(blurred_cameras(site))
        if self.films is not None:
            self.films.redescribe(site.filmed_cameras(), clip_lengths(site))

    def begin_recording(self, who: str, why: str = "", stream: str = "") -> None:
        """Record until `end_recording` or the longest time; with ``stream`` only its film."""
        if self.recorder is not None and self.recorder.topics and not stream:
            self.recorder.begin_recording(who, why)
        if self.films is not None:
            self.films.begin_film(who, why or "asked for", self.plan.longest, stream)

    def end_recording(self, who: str, stream: str = "") -> None:
        """End what is being recorded; with ``stream`` only that camera's film."""
        if self.recorder is not None and not stream:
            self.recorder.end_recording(who)
        if self.films is not None:
            self.films.end_film(who, stream)

    def trigger_recording(self, trigger: Trigger, why: str, who: str = "") -> None:
        """Record around what has just happened, if the description wants that."""
        if self.recorder is not None and self.recorder.topics:
            self.recorder.trigger_recording(trigger, why, who)
        if self.films is not None and trigger in self.plan.triggers:
            self.films.begin_film(who, why, self.plan.after)

    def recorder_state(self) -> RecorderState:
        """Tell how it stands."""
        state = RecorderState(on=False) if self.recorder is None else self.recorder.recorder_state()
        if self.films is None:
            return state
        return msgspec.structs.replace(
            state,
            films=self.films.rolling_cameras(),
            can_film=True,
            problem=state.problem or self.films.problem[:2000],
        )

    def report_state(self) -> None:
        """Tell how it stands, after a change."""
        self._send_state(self.recorder_state())
