"""Pictures from a gateway to everyone who looks: the newest wins, nobody waits for anybody.

A gateway encodes a camera once in each form that any page wants just now (`flow` says which each
page wants), and rests it when nobody looks.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.hub.live.pictures.picture_pacing import Ready
from talaia.wire.browser import (
    MEDIA_TO_BROWSER,
    CameraPicture,
    CameraPictureBoxes,
    CameraPictureOverlay,
)
from talaia.wire.frames import (
    KeyframeRequest,
    PictureForm,
    StreamSubscription,
    camera_address,
    unblurred_address,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.hub.live.gateways.clock_offset import ClockOffset
    from talaia.hub.live.pictures.camera_viewer import Viewer
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.wire.frames import DetectedBoxes, ModelOverlay, PictureFrame, StreamError

__all__ = ["PictureFanout"]

# Forms of the small size, by the words in which a gateway names them.
_SMALL = {PictureForm.H264_SMALL.value, PictureForm.JPEG_SMALL.value}


class PictureFanout:
    """All viewers, and what the gateways are asked to send for them."""

    def __init__(self, sites: Sites, clock: Clock, linger_s: float) -> None:
        """A stream rests ``linger_s`` after its last viewer has gone."""
        self._sites = sites
        # Monotonic: by it pages are told when a picture was taken.
        self._clock = clock
        # A camera goes on for so long after the last page has gone (s): pages are loaded anew.
        self._linger_s = linger_s
        # By site and stream: the sockets that watch.
        self._viewers: dict[tuple[str, str], set[Viewer]] = {}
        # By site and stream: ends the stream when nobody has come back by then.
        self._timers: dict[tuple[str, str], asyncio.TimerHandle] = {}
        # What the gateway was asked for last; asked again only when it changes.
        self._forms: dict[tuple[str, str], frozenset[PictureForm]] = {}
        # Streams of which boxes are asked for, too, and of which overlays.
        self._boxed: set[tuple[str, str]] = set()
        self._overlaid: set[tuple[str, str]] = set()
        # Who looks for the hub itself: in which form, and who is handed each picture.
        self._eyes: dict[tuple[str, str], tuple[PictureForm, Callable[[PictureFrame], None]]] = {}
        # Why a stream cannot be shown, as its pages were last told; a picture ends it.
        self._troubles: dict[tuple[str, str], str] = {}

    def join(self, viewer: Viewer) -> None:
        """Take a viewer in; the first one wakes the stream."""
        key = (viewer.site, viewer.stream)
        timer = self._timers.pop(key, None)
        if timer is not None:
            timer.cancel()
        self._viewers.setdefault(key, set()).add(viewer)
        viewer.on_flow = self._flow
        self._flow(viewer)
        # Whoever comes later is told as well.
        why = self._troubles.get(key)
        if why is not None:
            viewer.trouble(why)

    def leave(self, viewer: Viewer) -> None:
        """Let a viewer go; a little after the last one the stream rests."""
        key = (viewer.site, viewer.stream)
        viewers = self._viewers.get(key, set())
        viewers.discard(viewer)
        if viewers:
            self._request_stream(key)
        elif key in self._viewers and key not in self._timers:
            loop = asyncio.get_running_loop()
            self._timers[key] = loop.call_later(self._linger_s, self._rest, key)

    def watch(self, site: str) -> None:
        """Tell a site's gateway which streams are looked at now, and as what."""
        live = self._sites.find_site(site)
        if live is not None and live.link is not None:
            forms = {
                stream: [form.value for form in sorted(wanted)]
                for (where, stream), wanted in sorted(self._forms.items())
                if where == site
            }
            boxed = sorted(stream for where, stream in self._boxed if where == site)
            overlaid = sorted(stream for where, stream in self._overlaid if where == site)
            live.link.send(
                StreamSubscription(streams=list(forms), forms=forms, boxes=boxed, overlays=overlaid)
            )

    def watch_stream(
        self, site: str, stream: str, form: PictureForm, take: Callable[[PictureFrame], None]
    ) -> None:
        """Let the hub itself look at a stream: ``take`` gets each picture, at once."""
        self._eyes[site, stream] = (form, take)
        self._request_stream((site, stream))

    def unwatch_stream(self, site: str, stream: str) -> None:
        """Look no more."""
        if self._eyes.pop((site, stream), None) is not None:
            self._request_stream((site, stream))

    def looked_at(self, site: str, stream: str) -> bool:
        """Tell whether a page wants to know what is seen on a stream."""
        return (site, stream) in self._boxed

    def boxes(self, site: str, boxes: DetectedBoxes) -> None:
        """Hand what is seen on a picture to those who asked; written once for all of them."""
        key = (site, boxes.stream)
        # On its way when nobody wanted it any more.
        if key not in self._boxed:
            return
        said = CameraPictureBoxes(seq=boxes.seq, time_us=boxes.time_us, things=boxes.things)
        frame_for = _written_once(said)
        for viewer in self._viewers_of_camera(key):
            if viewer.wants_boxes:
                viewer.boxes(frame_for(viewer))

    def publish_overlay(self, site: str, overlay: ModelOverlay) -> None:
        """Hand what a model tells of a picture to those who asked; as `boxes`."""
        key = (site, overlay.stream)
        if key not in self._overlaid:
            return
        frame_for = _written_once(
            CameraPictureOverlay(
                seq=overlay.seq, time_us=overlay.time_us, model=overlay.model, layer=overlay.layer
            )
        )
        for viewer in self._viewers_of_camera(key):
            if viewer.wants_overlays:
                viewer.queue_overlay(overlay.model, frame_for(viewer))

    def close(self) -> None:
        """Stop the timers."""
        for timer in self._timers.values():
            timer.cancel()
        self._timers.clear()

    def shot(self, live: LiveSite, picture: PictureFrame, offset: ClockOffset) -> None:
        """Hand a picture to its viewers; written once for all who read the same form."""
        key = (live.name, picture.stream)
        # A picture has come, so what was wrong is not any more.
        self._troubles.pop(key, None)
        eye = self._eyes.get(key)
        # A picture that names no forms is for all.
        if eye is not None and (not picture.forms or eye[0] in picture.forms):
            eye[1](picture)
        wanting = [
            viewer for viewer in self._viewers.get(key, ()) if viewer.flow.wants(picture.forms)
        ]
        if not wanting:
            return
        shot = self._shot(picture, offset)
        # Written once in each form, for all pages that get it.
        written: dict[bool, Ready] = {}
        for viewer in wanting:
            ready = written.get(viewer.text)
            if ready is None:
                frame = (
                    MEDIA_TO_BROWSER.encode_text(shot)
                    if viewer.text
                    else MEDIA_TO_BROWSER.encode(shot)
                )
                film = picture.format == PictureForm.H264
                ready = Ready(picture.seq, picture.key, film, len(frame), frame)
                written[viewer.text] = ready
            viewer.offer(ready)

    def trouble(self, site: str, said: StreamError) -> None:
        """Hand on why a camera cannot be shown, to those who look and those who come."""
        key = (site, said.stream)
        if key not in self._viewers or self._troubles.get(key) == said.why:
            return
        self._troubles[key] = said.why
        for viewer in self._viewers[key]:
            viewer.trouble(said.why)

    def _shot(self, picture: PictureFrame, offset: ClockOffset) -> CameraPicture:
        captured = offset.to_ours(picture.mono_us)
        now_us = self._clock.monotonic_ns() // 1000
        return CameraPicture(
            seq=picture.seq,
            time_us=picture.time_us,
            # Without an estimate yet: as if it had been taken now. Never from the future.
            hub_us=now_us if captured is None else min(captured, now_us),
            width=picture.width,
            height=picture.height,
            format=picture.format,
            key=picture.key,
            codec=picture.codec,
            small=bool(picture.forms) and _SMALL.issuperset(picture.forms),
            data=picture.data,
        )

    def _flow(self, viewer: Viewer) -> None:
        """Ask the gateway for what a viewer wants now, where that is new."""
        self._request_stream((viewer.site, viewer.stream))
        if viewer.flow.wants_key(self._clock.monotonic_ns() // 1000):
            live = self._sites.find_site(viewer.site)
            if live is not None and live.link is not None:
                live.link.send(KeyframeRequest(stream=viewer.stream, form=viewer.flow.form))

    def _request_stream(self, key: tuple[str, str]) -> None:
        viewers = self._viewers.get(key, ())
        wanted = frozenset(viewer.flow.form for viewer in viewers)
        if not wanted and key in self._viewers:
            # The last one has just gone, and may be back in a moment.
            return
        if key in self._eyes:
            wanted |= {self._eyes[key][0]}
        # Of a camera, whichever of its streams is looked at.
        camera = (key[0], camera_address(key[1]))
        looking = self._viewers_of_camera(camera)
        boxed = any(viewer.wants_boxes for viewer in looking)
        overlaid = any(viewer.wants_overlays for viewer in looking)
        before = (
            self._forms.get(key, frozenset()),
            camera in self._boxed,
            camera in self._overlaid,
        )
        if before == (wanted, boxed, overlaid):
            return
        self._forms[key] = wanted
        if not wanted:
            del self._forms[key]
            self._troubles.pop(key, None)
        # Before it is asked for: `watch` tells all of a site from these.
        (self._boxed.add if boxed else self._boxed.discard)(camera)
        (self._overlaid.add if overlaid else self._overlaid.discard)(camera)
        self.watch(key[0])

    def _viewers_of_camera(self, camera: tuple[str, str]) -> list[Viewer]:
        site, stream = camera
        both = (camera, (site, unblurred_address(stream)))
        return [viewer for key in both for viewer in self._viewers.get(key, ())]

    def _rest(self, key: tuple[str, str]) -> None:
        del self._timers[key]
        if not self._viewers.get(key):
            self._viewers.pop(key, None)
            self._request_stream(key)


def _written_once(
    said: CameraPictureBoxes | CameraPictureOverlay,
) -> Callable[[Viewer], bytes | str]:
    """Give a function that gives the message as a viewer reads it, written once for all of them."""
    written: dict[bool, bytes | str] = {}

    def frame_for(viewer: Viewer) -> bytes | str:
        frame = written.get(viewer.text)
        if frame is None:
            encode = MEDIA_TO_BROWSER.encode_text if viewer.text else MEDIA_TO_BROWSER.encode
            frame = written[viewer.text] = encode(said)
        return frame

    return frame_for
