"""The example vehicle with a camera at which models look that tell no boxes."""

from __future__ import annotations

from msgspec import structs

from talaia.model.detection import (
    DepthScale,
    DetectionSource,
    Measured,
    ModelKind,
    ObjectModel,
    PictureZone,
)
from talaia.model.picture_models.picture_model import PictureModel
from talaia.model.site import Signal
from talaia.model.yaml_text.load import dump_site, load_site

from .conftest import DESCRIPTION

__all__ = ["modelled"]

MODELS = {
    "ground": ObjectModel(
        file="g.onnx", kind=ModelKind.SEGMENTATION, classes=("other", "floor", "wall")
    ),
    "room": ObjectModel(file="r.onnx", kind=ModelKind.CLASSIFICATION, classes=("hall", "bath")),
    "pose": ObjectModel(file="p.onnx", kind=ModelKind.KEYPOINTS, classes=("person",)),
    "far": ObjectModel(file="f.onnx", kind=ModelKind.DEPTH, scale=DepthScale.METRES),
}
PATH = PictureZone(name="Path", points=((0.3, 0.6), (0.7, 0.6), (1.0, 1.0), (0.0, 1.0)))


def modelled() -> str:
    """Describe it; its signal tells how much of the path before it is floor."""
    site = load_site(DESCRIPTION)
    camera = site.devices["camera"]
    uses = {name: PictureModel() for name in MODELS}
    uses["ground"] = PictureModel(zones={"path": PATH})
    front = structs.replace(camera.streams["front"], detect=None, models=uses)
    source = DetectionSource(
        stream="front", model="ground", sees="floor", measure=Measured.SHARE, zone="path"
    )
    signals = {"free": Signal(name="Free", unit="%", source=source)}
    camera = structs.replace(camera, streams={"front": front}, signals=signals)
    devices = {**site.devices, "camera": camera}
    return dump_site(
        structs.replace(site, devices=devices, object_models=MODELS, interlocks={}, alarms={})
    )
