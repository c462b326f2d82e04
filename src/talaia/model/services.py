"""Which of the AI services are wanted for a site. Values only: the hub runs them."""

from __future__ import annotations

from talaia.model.shape import Shape

__all__ = ["AiServices"]


class AiServices(Shape, frozen=True, kw_only=True):
    """What the hub works out from a site's data. Visualization is always on.

    Attributes:
        anomaly_detection: every number of the first page without detectors of its own is watched
            by ``together``, at most one sample a second.
        object_detection: what the cameras see is to be named and framed; nothing does it yet.

    """

    anomaly_detection: bool = False
    object_detection: bool = False
