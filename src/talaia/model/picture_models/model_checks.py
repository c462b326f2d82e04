"""Cross-checks of models that tell something else than boxes, and of the signals that tell of them.

Parts of `check`, beside those of detectors (`checks.detection_checks`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import Finding, finding_of, name_fits
from talaia.model.checks.zone_checks import picture_zones_fit
from talaia.model.closed_lists import SignalType
from talaia.model.connection import source_as
from talaia.model.detection import DepthScale, DetectionSource, Measured, ModelKind
from talaia.model.errors import UnknownWord
from talaia.model.picture_models.picture_model import MEASURES, measured_unit, points_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.detection import ObjectModel
    from talaia.model.picture_models.picture_model import PictureModel
    from talaia.model.site import Signal, Site, Stream

__all__ = ["kind_fits", "model_signal_fits", "picture_models_fit"]

_MOST_MODELS = 8
_MOST_RATE, _LONGEST_HOLD_S = 60.0, 60.0
_MOST_POINTS = 64
# Cells of a class map are bytes, and one of them says nothing.
_MOST_SEGMENTS = 250


def kind_fits(where: str, model: ObjectModel) -> Iterator[Finding]:
    """List which of a model's keys do not go with its kind."""
    kind, count = model.kind, len(model.classes)
    if kind is ModelKind.DEPTH and count:
        yield Finding(f"{where}.classes", "depth has no classes", "leave them out")
    if kind is ModelKind.KEYPOINTS and count > 1:
        problem = f"expected the one class whose points it tells, found {count}"
        yield Finding(f"{where}.classes", problem, "write: classes: [person]")
    if kind is ModelKind.SEGMENTATION and not 2 <= count <= _MOST_SEGMENTS:
        problem = f"expected 2 to {_MOST_SEGMENTS} classes, found {count}"
        yield Finding(f"{where}.classes", problem, "what is none of them is a class, too: other")
    if kind is not ModelKind.DEPTH and model.scale is not DepthScale.NEARNESS:
        yield Finding(f"{where}.scale", "only depth has a scale", "leave it out")
    if kind is not ModelKind.KEYPOINTS:
        for key in ("points", "bones"):
            if getattr(model, key):
                yield Finding(f"{where}.{key}", f"only keypoints have {key}", "leave them out")
        return
    yield from _points_fit(where, model)


def _points_fit(where: str, model: ObjectModel) -> Iterator[Finding]:
    if len(model.points) > _MOST_POINTS:
        problem = f"expected at most {_MOST_POINTS} points, found {len(model.points)}"
        yield Finding(f"{where}.points", problem)
    for index, point in enumerate(model.points):
        yield from name_fits(f"{where}.points[{index}]", point)
        if point in model.points[:index] or point in model.classes:
            yield Finding(f"{where}.points[{index}]", f"{point!r} is there twice", "rename one")
    if model.bones and not model.points:
        problem = "which points are joined is said of points that are named"
        yield Finding(f"{where}.bones", problem, "write points as well")
        return
    for index, bone in enumerate(model.bones):
        for point in bone:
            if point not in model.points:
                at = f"{where}.bones[{index}]"
                yield finding_of(UnknownWord(at, "point", point, model.points))


def picture_models_fit(site: Site, where: str, stream: Stream) -> Iterator[Finding]:
    """List what is wrong with the models that look at a camera's pictures."""
    if len(stream.models) > _MOST_MODELS:
        yield Finding(where, f"expected at most {_MOST_MODELS}, found {len(stream.models)}")
    for name, use in stream.models.items():
        at = f"{where}.{name}"
        model = site.object_models.get(name)
        if model is None and not site.object_models:
            yield Finding(at, f"there is no model {name!r}", "describe it in object_models")
        elif model is None:
            yield finding_of(UnknownWord(at, "model", name, site.object_models))
        elif model.kind.tells_boxes:
            remedy = f"write at the stream: detect: {{model: {name}}}"
            yield Finding(at, f"a model of the kind {model.kind} is a detector", remedy)
        yield from _use_fits(at, use)


def _use_fits(where: str, use: PictureModel) -> Iterator[Finding]:
    # Written so that NaN is found as well.
    if not 0 <= use.confidence <= 1:
        yield Finding(f"{where}.confidence", f"expected 0 to 1, found {use.confidence}")
    if not 0 < use.max_rate <= _MOST_RATE:
        problem = f"expected more than 0 to {_MOST_RATE:g} Hz, found {use.max_rate}"
        yield Finding(f"{where}.max_rate", problem)
    if not 0 <= use.hold <= _LONGEST_HOLD_S:
        yield Finding(f"{where}.hold", f"expected 0 to {_LONGEST_HOLD_S:g} s, found {use.hold}")
    yield from picture_zones_fit(where, use.zones)


def model_signal_fits(site: Site, where: str, stream: Stream, signal: Signal) -> Iterator[Finding]:
    """List what is wrong with a signal that tells what a model says of a camera's pictures."""
    source = source_as(signal.source, DetectionSource)
    use, model = stream.models.get(source.model), site.object_models.get(source.model)
    if use is None:
        if stream.models:
            word = UnknownWord(f"{where}.model", "model", source.model, stream.models)
            yield finding_of(word)
        else:
            problem = f"no model looks at {source.stream}"
            remedy = f"write at the stream: models: {{{source.model}: {{}}}}"
            yield Finding(f"{where}.model", problem, remedy)
        return
    # What is wrong with the model itself was said at the stream.
    if model is None or model.kind.tells_boxes:
        return
    measures = MEASURES[model.kind]
    if source.measure not in measures:
        problem = f"of a model of the kind {model.kind} no {source.measure} is told"
        yield Finding(f"{where}.measure", problem, f"one of: {', '.join(measures)}")
        return
    yield from _seen_fits(where, source, model)
    yield from _area_fits(where, source, use, model)
    yield from _type_fits(where.removesuffix(".source"), signal, source, model)
    if signal.max_age > 0.0 and 0.0 < signal.max_age * use.max_rate < 1.0:
        problem = f"it is looked every {1 / use.max_rate:g} s, and old after {signal.max_age:g} s"
        yield Finding(where, problem, f"write: max_age: {3 / use.max_rate:g}")


def _seen_fits(where: str, source: DetectionSource, model: ObjectModel) -> Iterator[Finding]:
    if source.measure in (Measured.SUREST, Measured.NEAREST):
        if source.sees:
            problem = f"{source.measure} is not of one class"
            yield Finding(f"{where}.sees", problem, "leave it out")
        return
    of_points = points_of(model) if model.kind is ModelKind.KEYPOINTS else ()
    known = (*model.classes, *of_points)
    if not source.sees:
        yield Finding(f"{where}.sees", "of which class?", f"write: sees: {known[0]}")
    elif source.sees not in known:
        yield finding_of(UnknownWord(f"{where}.sees", "class", source.sees, known))


def _area_fits(
    where: str, source: DetectionSource, use: PictureModel, model: ObjectModel
) -> Iterator[Finding]:
    if source.line or source.over:
        key = "line" if source.line else "over"
        yield Finding(f"{where}.{key}", "only what is tracked crosses a line", "leave it out")
    if model.kind is ModelKind.CLASSIFICATION:
        if source.zone or source.within is not None:
            key = "zone" if source.zone else "within"
            problem = "a classification is of the whole picture"
            yield Finding(f"{where}.{key}", problem, "leave it out")
        return
    if source.zone and source.zone not in use.zones:
        if use.zones:
            yield finding_of(UnknownWord(f"{where}.zone", "zone", source.zone, use.zones))
        else:
            remedy = f"write at the stream: models: {{{source.model}: {{zones: …}}}}"
            yield Finding(f"{where}.zone", "the model has no zones on this camera", remedy)
    if source.zone and source.within is not None:
        problem = "a zone and a part of the picture exclude each other"
        yield Finding(f"{where}.within", problem, "leave one of them out")


def _type_fits(
    where: str, signal: Signal, source: DetectionSource, model: ObjectModel
) -> Iterator[Finding]:
    if source.measure is not Measured.SUREST:
        if signal.type is not SignalType.NUMBER:
            problem = f"{source.measure} is a number, and no {signal.type}"
            yield Finding(f"{where}.type", problem, "write: type: number")
        unit = measured_unit(model, source.measure)
        if signal.unit not in ("", unit):
            problem = f"it is told in {unit or 'whole numbers'}, found {signal.unit}"
            yield Finding(f"{where}.unit", problem, f"write: {unit}" if unit else "leave it out")
        return
    if signal.type is SignalType.STATE and signal.states and signal.states != model.classes:
        listed = ", ".join(model.classes[:8])
        problem = "the states are not the classes of the model"
        yield Finding(f"{where}.states", problem, f"write them in its order: [{listed}]")
    elif signal.type not in (SignalType.STATE, SignalType.TEXT):
        problem = f"the likeliest class is a text or a state, and no {signal.type}"
        yield Finding(f"{where}.type", problem, "write: type: text")
