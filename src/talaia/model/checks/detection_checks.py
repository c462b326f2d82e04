"""Cross-checks of object detection: cameras that see, their models, and what counts; of `check`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import Finding, check_above, finding_of, id_fits, name_fits
from talaia.model.checks.zone_checks import floor_fits, measure_fits, zones_fit
from talaia.model.closed_lists import SignalType
from talaia.model.derived_signals import classes_of, counts_of, detect_of
from talaia.model.detection import CLOUDS, LANE, DetectAt, DetectionSource, ModelKind
from talaia.model.errors import UnknownWord
from talaia.model.picture_models.model_checks import kind_fits, model_signal_fits

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.detection import Detect, LaneView, ObjectModel, SkyLens
    from talaia.model.interlocks.interlock import Condition
    from talaia.model.site import Device, Signal, Site, Stream

__all__ = [
    "blur_fits",
    "count_fits",
    "detect_fits",
    "hub_sight_findings",
    "lane_fits",
    "models_findings",
    "sky_fits",
]

_MOST_RATE = 60.0
_LONGEST_HOLD_S = 60.0
_LONGEST_CLIP_S = 60.0
_MOST_CLASSES = 1000
_SIDES = (32, 2048)
_BLUR_SIDES = (160, 1920)
_LONGEST_BLUR_S = 10.0
# Of a lane: a road's.
_FARTHEST_M, _WIDEST_M = 50.0, 8.0


def models_findings(site: Site) -> Iterator[Finding]:
    """List what is wrong with a site's own detectors."""
    for name, model in site.object_models.items():
        where = f"$.object_models.{name}"
        yield from id_fits(where, name)
        yield from _check_model(where, model)


def _check_model(where: str, model: ObjectModel) -> Iterator[Finding]:
    # A NUL ends a path for the system, and Python refuses it with an error of its own.
    if not model.file.strip() or "\0" in model.file:
        yield Finding(f"{where}.file", "there is no file", "write: file: models/ours.onnx")
    yield from kind_fits(where, model)
    least = 0 if model.kind is ModelKind.DEPTH else 1
    if not least <= len(model.classes) <= _MOST_CLASSES:
        problem = f"expected 1 to {_MOST_CLASSES} classes, found {len(model.classes)}"
        remedy = "write their names in the order in which the file numbers them"
        yield Finding(f"{where}.classes", problem, remedy)
    for index, label in enumerate(model.classes):
        yield from name_fits(f"{where}.classes[{index}]", label)
        if label in model.classes[:index]:
            yield Finding(f"{where}.classes[{index}]", f"{label!r} is there twice", "rename one")
    low, high = _SIDES
    # Detectors' grids have steps of up to 32 px; of the others Depth Anything has steps of 14.
    step = 32 if model.kind.tells_boxes or model.kind is ModelKind.KEYPOINTS else 1
    if not low <= model.side <= high or model.side % step:
        steps = f", a multiple of {step}" if step > 1 else ""
        problem = f"expected {low} to {high} pixels{steps}, found {model.side}"
        yield Finding(f"{where}.side", problem, "640 is usual")
    for index, value in enumerate(model.mean):
        if not math.isfinite(value):
            yield Finding(f"{where}.mean[{index}]", f"expected a finite number, found {value}")
    for index, value in enumerate(model.spread):
        yield from check_above(f"{where}.spread[{index}]", value, 0)


def _clip_fits(site: Site, where: str, detect: Detect) -> Iterator[Finding]:
    clip = detect.clip
    if clip is None:
        return
    if not 0 <= clip.before <= _LONGEST_CLIP_S:
        problem = f"expected 0 to {_LONGEST_CLIP_S:g} s, found {clip.before}"
        yield Finding(f"{where}.before", problem)
    if not 0 < clip.after <= _LONGEST_CLIP_S:
        problem = f"expected more than 0 to {_LONGEST_CLIP_S:g} s, found {clip.after}"
        yield Finding(f"{where}.after", problem)
    if site.recording is None:
        yield Finding(where, "a clip is a film, and this site records none", "write: recording: {}")
    if detect.at is DetectAt.HUB:
        problem = "what is seen at the hub is not filmed at the gateway"
        yield Finding(where, problem, "write: at: gateway, or leave the clip out")


def detect_fits(site: Site, where: str, stream: Stream) -> Iterator[Finding]:
    """List what is wrong with what is to be seen on a camera."""
    detect = stream.detect
    if detect is None:
        return
    if not 0 <= detect.confidence <= 1:
        yield Finding(f"{where}.confidence", f"expected 0 to 1, found {detect.confidence}")
    if not 0 < detect.max_rate <= _MOST_RATE:
        problem = f"expected more than 0 to {_MOST_RATE:g} Hz, found {detect.max_rate}"
        yield Finding(f"{where}.max_rate", problem)
    if not 0 <= detect.hold <= _LONGEST_HOLD_S:
        problem = f"expected 0 to {_LONGEST_HOLD_S:g} s, found {detect.hold}"
        yield Finding(f"{where}.hold", problem, "the interlock's own dwell may be longer")
    yield from zones_fit(where, detect)
    yield from _clip_fits(site, f"{where}.clip", detect)
    if detect.model and detect.model not in site.object_models:
        yield _unknown_model(site, f"{where}.model", detect.model)
        return
    if detect.model and not site.object_models[detect.model].kind.tells_boxes:
        yield _no_detector(site, f"{where}.model", detect.model)
        return
    known = classes_of(site, detect.model)
    for index, label in enumerate(detect.classes):
        if label not in known:
            yield finding_of(UnknownWord(f"{where}.classes[{index}]", "class", label, known))
        elif label in detect.classes[:index]:
            yield Finding(f"{where}.classes[{index}]", f"{label!r} is there twice", "leave it out")


def _unknown_model(site: Site, where: str, model: str) -> Finding:
    if not site.object_models:
        return Finding(where, f"there is no model {model!r}", "describe it in object_models")
    return finding_of(UnknownWord(where, "model", model, site.object_models))


def _no_detector(site: Site, where: str, model: str) -> Finding:
    problem = f"a model of the kind {site.object_models[model].kind} tells no boxes"
    return Finding(where, problem, f"write at the stream: models: {{{model}: {{}}}}")


def blur_fits(site: Site, where: str, stream: Stream) -> Iterator[Finding]:
    """List what is wrong with what is to be blurred on a camera."""
    blur = stream.blur
    if blur is None:
        return
    if not blur.faces and not blur.plates:
        remedy = "write faces: true, or name a model for plates, or leave blur out"
        yield Finding(where, "nothing is to be blurred", remedy)
    if blur.plates and blur.plates not in site.object_models:
        yield _unknown_model(site, f"{where}.plates", blur.plates)
    elif blur.plates and not site.object_models[blur.plates].kind.tells_boxes:
        yield _no_detector(site, f"{where}.plates", blur.plates)
    # Written so that NaN is found as well. Nothing at all would be found with a confidence of 1.
    for key, least, most in (
        ("confidence", 0.05, 0.9),
        ("looks", 0.0, _MOST_RATE),
        ("hold", 0.0, _LONGEST_BLUR_S),
    ):
        found = getattr(blur, key)
        if not least <= found <= most:
            yield Finding(f"{where}.{key}", f"expected {least:g} to {most:g}, found {found}")
    if blur.looks > 0 and blur.hold < 1 / blur.looks:
        problem = f"what is found {blur.looks:g} times a second is forgotten after {blur.hold:g} s"
        yield Finding(f"{where}.hold", problem, f"write: hold: {1.5 / blur.looks:.2g}, or more")
    low, high = _BLUR_SIDES
    if not low <= blur.side <= high or blur.side % 32:
        problem = f"expected {low} to {high} pixels, a multiple of 32, found {blur.side}"
        yield Finding(f"{where}.side", problem, "480 is usual")


def count_fits(site: Site, where: str, device: Device, signal: Signal) -> Iterator[Finding]:
    """List what is wrong with where a signal that counts what a camera sees comes from."""
    source = signal.source
    if not isinstance(source, DetectionSource):
        return
    if signal.type is not SignalType.NUMBER and not source.model:
        yield Finding(where, f"a {signal.type} counts nothing", "write: type: number")
    for key in source.foreign:
        problem = "what a camera sees comes from nowhere else"
        yield Finding(f"{where}.{key}", problem, "leave it out")
    if source.within is not None:
        yield from _check_area(f"{where}.within", source.within)
    if not source.stream:
        remedy = "write: stream: front_camera"
        yield Finding(f"{where}.stream", "on which camera is it to be seen?", remedy)
        return
    stream = device.streams.get(source.stream)
    if not source.sees and not source.model:
        yield Finding(f"{where}.sees", "what is to be counted?", "write: sees: person")
        return
    if stream is None:
        yield finding_of(UnknownWord(f"{where}.stream", "stream", source.stream, device.streams))
        return
    if source.model:
        yield from model_signal_fits(site, where, stream, signal)
        return
    if source.sees == CLOUDS and stream.sky is not None:
        yield from _clouds_fit(site, where, signal, stream.sky)
        return
    if source.sees in LANE and stream.lane is not None:
        yield from _lane_signal_fits(where, signal, LANE[source.sees], stream.lane)
        return
    if source.sees in LANE:
        problem = f"{source.stream} does not say where the lane is on its pictures"
        yield Finding(f"{where}.sees", problem, "write at the stream: lane: {floor: …}")
        return
    detect = detect_of(site, stream)
    if detect is None:
        problem = f"nothing is detected on {source.stream}"
        yield Finding(f"{where}.stream", problem, "write at the stream: detect: {}")
        return
    yield from measure_fits(where, source, detect)
    # None are known of a model that is not described; that is said at the stream.
    known = classes_of(site, detect.model)
    if known and source.sees not in known:
        yield finding_of(UnknownWord(f"{where}.sees", "class", source.sees, known))


def _clouds_fit(site: Site, where: str, signal: Signal, lens: SkyLens) -> Iterator[Finding]:
    if site.place is None:
        problem = "which stars stand in the sky is not known without a place"
        yield Finding(where, problem, "write: place: {latitude: 42.05, longitude: 0.73}")
    if 0.0 < signal.max_age < lens.every:
        problem = f"it is looked every {lens.every:g} s, and is old after {signal.max_age:g} s"
        yield Finding(where, problem, f"write: max_age: {3 * lens.every:g}")


def _lane_signal_fits(where: str, signal: Signal, unit: str, lane: LaneView) -> Iterator[Finding]:
    if signal.unit not in ("", unit):
        at = where.removesuffix(".source")
        yield Finding(f"{at}.unit", f"it is told in {unit}, found {signal.unit}", f"write: {unit}")
    if 0.0 < signal.max_age < lane.every:
        problem = f"it is looked every {lane.every:g} s, and is old after {signal.max_age:g} s"
        yield Finding(where, problem, f"write: max_age: {5 * lane.every:g}")


def lane_fits(where: str, stream: Stream) -> Iterator[Finding]:
    """List what is wrong with where the lane is on a camera's pictures."""
    lane = stream.lane
    if lane is None:
        return
    yield from floor_fits(f"{where}.floor", lane.floor)
    near, far = lane.ahead
    # Written so that NaN is found as well.
    if not 0 <= near < far <= _FARTHEST_M:
        problem = f"expected from where to where is looked, 0 to {_FARTHEST_M:g} m"
        yield Finding(f"{where}.ahead", problem, "as [0.5, 2.5]")
    if not 0.1 <= lane.narrowest < lane.widest <= _WIDEST_M:
        problem = f"expected 0.1 to {_WIDEST_M:g} m, and less than widest"
        yield Finding(f"{where}.narrowest", problem, "as narrowest: 0.6, widest: 1.6")
    if not 0.01 <= lane.marking <= lane.narrowest / 2:
        problem = "expected how wide a marking is, 0.01 m to half of the narrowest lane"
        yield Finding(f"{where}.marking", problem, "write: marking: 0.05")
    if not 0.05 <= lane.every <= _LONGEST_HOLD_S:
        yield Finding(f"{where}.every", f"expected 0.05 to {_LONGEST_HOLD_S:g} s")


def sky_fits(where: str, stream: Stream) -> Iterator[Finding]:
    """List what is wrong with where the sky is on a camera's pictures."""
    lens = stream.sky
    if lens is None:
        return
    for key in ("x", "y", "radius", "every"):
        yield from check_above(f"{where}.{key}", getattr(lens, key), 0)
    # Written so that NaN is found as well.
    for key, least, most in (("lowest", 0, 80), ("faintest", 1, 8), ("turned", -360, 360)):
        if not least <= getattr(lens, key) <= most:
            yield Finding(f"{where}.{key}", f"expected {least} to {most}")


def _check_area(where: str, within: tuple[float, float, float, float]) -> Iterator[Finding]:
    if not all(0 <= share <= 1 for share in within):
        yield Finding(where, "expected four parts of the picture, 0 to 1", "as [0.3, 0.5, 0.7, 1]")
    elif within[0] >= within[2] or within[1] >= within[3]:
        problem = "expected left, top, right, bottom in this order, from the upper left"
        yield Finding(where, problem, "as [0.3, 0.5, 0.7, 1]")


def hub_sight_findings(site: Site) -> Iterator[Finding]:
    """List what the gateway is to guard by, and only the hub sees; ``site`` has its counts."""
    # What the hub sees comes to the gateway late, or not at all.
    far = {address for address, (_, detect) in counts_of(site).items() if detect.at is DetectAt.HUB}
    problem = "it is seen at the hub, and the gateway guards by what it knows itself"
    remedy = "write at the stream's detect: at: gateway"
    told = set()
    for name, interlock in site.interlocks.items():
        for where, address in _list_conditions(f"$.interlocks.{name}.when", interlock.when):
            if address in far:
                told.add(address)
                yield Finding(where, problem, remedy)
    # Enclosures, STOP and all else that `Site.safety_signals` names.
    for address in sorted((site.safety_signals() & far) - told):
        device, _, signal = address.partition("/")
        yield Finding(f"$.devices.{device}.signals.{signal}", problem, remedy)


def _list_conditions(where: str, conditions: tuple[Condition, ...]) -> Iterator[tuple[str, str]]:
    for index, condition in enumerate(conditions):
        if condition.signal:
            yield f"{where}[{index}].signal", condition.signal
        yield from _list_conditions(f"{where}[{index}].all", condition.all_of)
