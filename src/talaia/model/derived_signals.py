"""What a description implies where a camera detects: a signal that counts for each class. Pure.

These signals are never in a person's file. Whoever runs or checks a description puts them in.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.model.coco_classes import COCO
from talaia.model.detection import CLOUDS, LANE, Detect, DetectionSource
from talaia.model.site import Signal

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.detection import Clip, LaneView, ObjectModel, SkyLens
    from talaia.model.site import Device, Site, Source, Stream

__all__ = [
    "DetectionSetup",
    "camera_meaning",
    "classes_of",
    "clip_lengths",
    "clips_of",
    "counts_of",
    "detect_of",
    "detecting_cameras",
    "detection_setup_of",
    "lane_signals",
    "sky_cameras",
    "with_counts",
]

# What `checks.identifiers` allows.
_LONGEST_ID, _LONGEST_NAME = 63, 100
_NO_WORD = re.compile(r"[^a-z0-9_]+")
# A count is told at least once a second, or with each picture where they are rarer.
_MAX_AGE_S, _PICTURES = 5.0, 3.0


def detect_of(site: Site, stream: Stream) -> Detect | None:
    """Say what is to be seen on a camera's pictures; none when nothing is."""
    if stream.detect is not None:
        return stream.detect
    wanted = site.services is not None and site.services.object_detection
    return Detect() if wanted else None


def classes_of(site: Site, model: str) -> tuple[str, ...]:
    """Name the classes of a detector; none of one that is not described."""
    if not model:
        return COCO
    described = site.object_models.get(model)
    return () if described is None else described.classes


def detecting_cameras(site: Site) -> Iterator[tuple[str, Detect]]:
    """Give every camera that detects, as ``device/stream``, and what."""
    for device_id, device in site.devices.items():
        for stream_id, stream in device.streams.items():
            detect = detect_of(site, stream)
            if detect is not None:
                yield f"{device_id}/{stream_id}", detect


def counts_of(site: Site) -> dict[str, tuple[str, Detect]]:
    """Give by the address of each signal that counts: its camera, and what is to be seen there."""
    cameras = dict(detecting_cameras(site))
    counts = {}
    for device_id, device in site.devices.items():
        for signal_id, signal in device.signals.items():
            if not isinstance(signal.source, DetectionSource) or signal.source.model:
                continue
            camera = f"{device_id}/{signal.source.stream}"
            stream = device.streams.get(signal.source.stream)
            # Told by another look at the same pictures.
            if stream is not None and stream.lane is not None and signal.source.sees in LANE:
                continue
            if camera in cameras:
                counts[f"{device_id}/{signal_id}"] = (camera, cameras[camera])
    return counts


def sky_cameras(site: Site) -> dict[str, tuple[str, SkyLens]]:
    """Give by the address of each signal of clouds: its camera, and where the sky is on it."""
    told = {}
    for device_id, device in site.devices.items():
        for signal_id, signal in device.signals.items():
            source = signal.source
            if not isinstance(source, DetectionSource) or source.sees != CLOUDS or source.model:
                continue
            stream = device.streams.get(source.stream)
            if stream is not None and stream.sky is not None:
                told[f"{device_id}/{signal_id}"] = (f"{device_id}/{source.stream}", stream.sky)
    return told


class LaneSignal(NamedTuple):
    """What a signal tells of a lane, and where."""

    camera: str
    sees: str
    view: LaneView


def lane_signals(site: Site) -> dict[str, LaneSignal]:
    """Give by the address of each signal of a lane: its camera, what it tells, and the lane."""
    told = {}
    for device_id, device in site.devices.items():
        for signal_id, signal in device.signals.items():
            source = signal.source
            if not isinstance(source, DetectionSource) or source.sees not in LANE or source.model:
                continue
            stream = device.streams.get(source.stream)
            if stream is not None and stream.lane is not None:
                told[f"{device_id}/{signal_id}"] = LaneSignal(
                    f"{device_id}/{source.stream}", source.sees, stream.lane
                )
    return told


class DetectionSetup(NamedTuple):
    """All that decides what is seen on a camera."""

    source: Source
    max_rate: float
    detect: Detect
    model: ObjectModel | None


def detection_setup_of(site: Site, device: str, stream: str) -> DetectionSetup | None:
    """Give what sees on a camera of a device; none where there is none, or nothing is seen."""
    described = site.devices[device].streams.get(stream)
    detect = None if described is None else detect_of(site, described)
    if described is None or detect is None:
        return None
    return DetectionSetup(
        described.source, described.max_rate, detect, site.object_models.get(detect.model)
    )


def camera_meaning(site: Site, device: str, stream: str) -> tuple[object, ...]:
    """Give all that decides what a camera tells: of things, sky and lane, and by models."""
    described = site.devices[device].streams.get(stream)
    if described is None:
        return None, None, None, {}, None
    lens, lane = described.sky, described.lane
    models = {name: (use, site.object_models.get(name)) for name, use in described.models.items()}
    at = described.source if lens is not None or lane is not None or models else None
    return detection_setup_of(site, device, stream), lens, lane, models, at


def with_counts(site: Site) -> Site:
    """Give ``site`` with all that its cameras imply; once or twice is the same.

    A camera that has no `Detect` of its own gets the default one where the site asks for it, and
    each of its classes a signal, unless one with the same source is there already.
    """
    devices = {name: _with_counts(site, device) for name, device in site.devices.items()}
    if devices == site.devices:
        return site
    return msgspec.structs.replace(site, devices=devices)


def _with_counts(site: Site, device: Device) -> Device:
    signals, streams = dict(device.signals), dict(device.streams)
    has = {
        (signal.source.stream, signal.source.sees)
        for signal in signals.values()
        # A count of a part of the picture does not stand for the whole.
        if isinstance(signal.source, DetectionSource) and signal.source.counts_all
    }
    for stream_id, stream in device.streams.items():
        detect = detect_of(site, stream)
        if detect is None:
            continue
        streams[stream_id] = msgspec.structs.replace(stream, detect=detect)
        for label in dict.fromkeys(detect.classes):
            if (stream_id, label) not in has:
                word = _free_word(f"{stream_id}_{_NO_WORD.sub('_', label.lower())}", signals)
                signals[word] = _count_signal(stream_id, stream, label, detect)
    if signals == device.signals and streams == device.streams:
        return device
    return msgspec.structs.replace(device, signals=signals, streams=streams)


def _free_word(word: str, taken: dict[str, Signal]) -> str:
    """Give a word that no other signal has."""
    found, number = word[:_LONGEST_ID], 2
    while found in taken:
        tail = f"_{number}"
        found, number = word[: _LONGEST_ID - len(tail)] + tail, number + 1
    return found


def _count_signal(stream_id: str, stream: Stream, label: str, detect: Detect) -> Signal:
    rare = _PICTURES / detect.max_rate if detect.max_rate > 0 else 0.0
    return Signal(
        name=f"{label[:1].upper()}{label[1:]}, {stream.name}"[:_LONGEST_NAME],
        source=DetectionSource(stream=stream_id, sees=label),
        minimum=0,
        decimals=0,
        max_age=max(_MAX_AGE_S, rare),
        primary=False,
        # Who may not see the camera may not learn what it sees.
        visibility=stream.visibility,
    )


def clips_of(site: Site) -> dict[str, Clip]:
    """Give the clips by camera (``device/stream``); none where the site records nothing."""
    if site.recording is None:
        return {}
    return {
        camera: detect.clip for camera, detect in detecting_cameras(site) if detect.clip is not None
    }


def clip_lengths(site: Site) -> dict[str, float]:
    """Give how much of before each clip wants (s), by camera."""
    return {camera: clip.before for camera, clip in clips_of(site).items()}
