"""What models tell of a camera's pictures, as a person may see it. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.schemas.sighting_schemas import (
    BoneShape,
    MarkCountShape,
    PictureMarkShape,
    PictureModelShape,
    PicturePlace,
)
from talaia.hub.auth.permissions import sees_signal
from talaia.model.connection import DetectionSource, source_as
from talaia.model.detection import ModelKind
from talaia.model.picture_models.model_signals import model_cameras
from talaia.model.picture_models.picture_model import bones_of, points_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.hub.auth.permissions import Grants
    from talaia.model.detection import PictureLine, PictureZone
    from talaia.model.picture_models.model_signals import ModelCamera
    from talaia.model.site import Site

__all__ = ["describe_models", "mark_shapes"]


def describe_models(
    site: Site, device_id: str, stream_id: str, grants: Grants
) -> list[PictureModelShape]:
    """Say which models look at a camera, and what is drawn of them over its picture."""
    camera = f"{device_id}/{stream_id}"
    return [
        _model_shape(site, looking, grants)
        for looking in model_cameras(site)
        if looking.camera == camera
    ]


def _model_shape(site: Site, looking: ModelCamera, grants: Grants) -> PictureModelShape:
    model, told = looking.model, looking.model.kind is ModelKind.KEYPOINTS
    points = points_of(model) if told else ()
    counts: dict[str, list[MarkCountShape]] = {}
    for address, signal in looking.signals.items():
        source = source_as(signal.source, DetectionSource)
        if source.zone and sees_signal(grants, site, *address.split("/")):
            count = MarkCountShape(
                signal=address,
                label=source.sees,
                measure=source.measure,
                max_age=signal.stale_after,
            )
            counts.setdefault(source.zone, []).append(count)
    return PictureModelShape(
        id=looking.name,
        kind=model.kind,
        classes=list(model.classes),
        points=list(points),
        bones=[
            BoneShape(start=points.index(start), end=points.index(end))
            for start, end in bones_of(model)
        ]
        if told
        else [],
        confidence=looking.use.confidence,
        max_rate=looking.use.max_rate,
        zones=mark_shapes(looking.use.zones, counts),
    )


def mark_shapes(
    marks: Mapping[str, PictureZone | PictureLine], counts: Mapping[str, list[MarkCountShape]]
) -> list[PictureMarkShape]:
    """Give zones or lines of a picture with the signals that count at each."""
    return [
        PictureMarkShape(
            id=mark_id,
            name=mark.name,
            points=[PicturePlace(x=x, y=y) for x, y in mark.points],
            counts=counts.get(mark_id, []),
        )
        for mark_id, mark in marks.items()
    ]
