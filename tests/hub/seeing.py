"""The example vehicle with a camera that looks for things."""

from __future__ import annotations

import msgspec

from talaia.model.derived_signals import with_counts
from talaia.model.detection import Detect
from talaia.model.yaml_text.load import load_site
from talaia.model.yaml_text.write import write_description

from .conftest import DESCRIPTION

__all__ = ["seeing"]


def seeing(detect: Detect) -> str:
    """Describe the example vehicle as its gateway does, with what its camera looks for."""
    site = load_site(DESCRIPTION)
    camera = site.devices["camera"]
    front = msgspec.structs.replace(camera.streams["front"], detect=detect)
    camera = msgspec.structs.replace(camera, streams={"front": front})
    devices = {**site.devices, "camera": camera}
    return write_description(with_counts(msgspec.structs.replace(site, devices=devices)))
