"""Which of the AI services are wanted for a site. Values only: hub and gateway run them."""

from __future__ import annotations

from talaia.model.base import Shape

__all__ = ["AiServices"]


class AiServices(Shape, frozen=True, kw_only=True):
    """What is worked out from a site's data. Visualization is always on.

    Attributes:
        anomaly_detection: every number of the first page without detectors of its own is watched
            by ``together``, at most one sample a second, and those of each device together.
        object_detection: every camera without `Detect` of its own gets the default one: persons,
            bicycles, cars, cats and dogs are counted, at the gateway.

    """

    anomaly_detection: bool = False
    object_detection: bool = False
