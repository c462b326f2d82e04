"""Whether this machine can see objects on the pictures of a site's cameras."""

from __future__ import annotations

import importlib.util
from typing import TYPE_CHECKING, NamedTuple

from talaia.model.derived_signals import detecting_cameras
from talaia.model.picture_models.model_signals import model_cameras
from talaia.objects.worker import OWN_FILE, OWN_REMEDY

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from talaia.model.site import Site

__all__ = ["DetectionAvailability", "detection_availability"]


class DetectionAvailability(NamedTuple):
    """Whether a camera's pictures could be looked at here, and the sentence that says so."""

    well: bool
    said: str


def detection_availability(site: Site, folder: Path) -> Iterator[DetectionAvailability]:
    """Say of each camera that is looked at whether that could be done on this machine.

    Args:
        site: a description in which nothing is wrong.
        folder: where relative paths of its detectors begin.

    """
    for looking in model_cameras(site):
        who = f"{looking.camera}: model {looking.name} ({looking.model.kind})"
        problem = _missing_part(site, folder, looking.name)
        if problem:
            said = f"{who} cannot run on this machine: {problem}"
        else:
            said = f"{who} can run on this machine (at the gateway)"
        yield DetectionAvailability(well=not problem, said=said)
    for camera, detect in detecting_cameras(site):
        problem = _missing_part(site, folder, detect.model)
        what = ", ".join(detect.classes) or "nothing that counts"
        if problem:
            yield DetectionAvailability(
                well=False, said=f"{camera}: objects cannot be seen on this machine: {problem}"
            )
        else:
            said = f"{camera}: objects can be seen on this machine ({what}; at the {detect.at})"
            yield DetectionAvailability(well=True, said=said)


def _missing_part(site: Site, folder: Path, model: str) -> str:
    # Not imported: the library takes a while to load, and nothing is to be looked at here.
    if importlib.util.find_spec("onnxruntime") is None:
        return "onnxruntime is not installed; run: pip install 'talaia[objects]'"
    if not model:
        # The empty name is the detector that comes with the package.
        return "" if OWN_FILE.is_file() else f"{OWN_FILE} is missing; {OWN_REMEDY}"
    # An absolute path stays itself when it is joined.
    file = folder / site.object_models[model].file
    if file.is_file():
        return ""
    return f"{file} is missing; put it there, or correct object_models.{model}.file"
