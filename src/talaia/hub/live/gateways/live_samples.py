"""Hands samples on to all that follow them live: last values, pages, alarms, anomaly detectors."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.live.alarms.alarm_engine import AlarmEngine
    from talaia.hub.live.detection.anomaly_service import AnomalyService
    from talaia.hub.live.pages.fanout import Fanout
    from talaia.hub.live.sites import LiveSite
    from talaia.wire.columns import Columns
    from talaia.wire.newest import NewestSamples

__all__ = ["LiveSamples"]


class LiveSamples:
    """The one way by which samples reach those who follow them; never waits."""

    def __init__(
        self, *, fanout: Fanout, alarms: AlarmEngine, anomalies: AnomalyService, clock: Clock
    ) -> None:
        """Show samples on pages by ``fanout``, judge them by ``alarms`` and ``anomalies``."""
        self._fanout = fanout
        self._alarms = alarms
        self._anomalies = anomalies
        self._clock = clock

    def publish_batch(
        self, live: LiveSite, columns: Columns, *, boot: str = "", end: int = 0
    ) -> None:
        """Hand on a live batch; ``boot`` is its run and ``end`` one past its last number there."""
        # First: whoever asks for the newest value from here on is to get this one.
        live.latest.update_values(columns, self._clock.monotonic_ns(), boot, end)
        self._fanout.publish(live, columns)
        self._alarms.evaluate_samples(live, columns)
        self._anomalies.enqueue_samples(live, columns)

    def publish_late_batch(self, live: LiveSite, columns: Columns) -> None:
        """Hand on a batch that waited for its link: detectors learn from it, nothing is shown."""
        self._anomalies.enqueue_samples(live, columns)

    def publish_newest(self, live: LiveSite, newest: NewestSamples, boot: str, now_ns: int) -> None:
        """Hand on the newest sample of each channel, with the age it had at ``now_ns``."""
        # Before `publish_known`, which has pages told what `latest` holds.
        live.latest.correct_values(newest, boot, now_ns)
        self._fanout.publish_known(live, newest.columns.channel)
        self._alarms.evaluate_samples(live, newest.columns, now_ns - newest.age_ms * 1e6)
        self._anomalies.enqueue_samples(live, newest.columns)
