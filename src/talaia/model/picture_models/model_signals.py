"""Which models look at which cameras, and which signals tell of them. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.model.detection import DetectionSource

if TYPE_CHECKING:
    from talaia.model.detection import ObjectModel
    from talaia.model.picture_models.picture_model import PictureModel
    from talaia.model.site import Signal, Site

__all__ = ["ModelCamera", "model_cameras"]


class ModelCamera(NamedTuple):
    """A model at work on a camera.

    Attributes:
        camera: its address, ``device/stream``.
        name: the model's, of `Site.object_models`.
        signals: what tells of it, by address.

    """

    camera: str
    name: str
    model: ObjectModel
    use: PictureModel
    signals: dict[str, Signal]


def model_cameras(site: Site) -> list[ModelCamera]:
    """List each model that is at work on a camera; those that are not described are left out."""
    found = []
    for device_id, device in site.devices.items():
        for stream_id, stream in device.streams.items():
            for name, use in stream.models.items():
                model = site.object_models.get(name)
                if model is None or model.kind.tells_boxes:
                    continue
                signals = {
                    f"{device_id}/{signal_id}": signal
                    for signal_id, signal in device.signals.items()
                    if isinstance(signal.source, DetectionSource)
                    and (signal.source.stream, signal.source.model) == (stream_id, name)
                }
                camera = f"{device_id}/{stream_id}"
                found.append(ModelCamera(camera, name, model, use, signals))
    return found
