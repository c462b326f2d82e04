"""Which of the AI services are wanted for a site. Values only: the hub runs them."""

from __future__ import annotations

from talaia.model.shape import Shape

__all__ = ["AiServices"]


class AiServices(Shape, frozen=True, kw_only=True):
    """What the hub works out from a site's data. Visualization is always on.

    Attributes:
        anomaly_detection: readings that are out of the ordinary are marked.
        object_detection: what the cameras see is named and framed.

    """

    anomaly_detection: bool = False
    object_detection: bool = False
