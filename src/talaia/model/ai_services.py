"""Which of the AI services are wanted for a site. Values only: hub and gateway run them."""

from __future__ import annotations

from talaia.model.base import Shape

__all__ = ["FEWEST_A_WEEK", "MOST_A_WEEK", "AiServices"]

# False alarms that can be asked for: one in 20 weeks needs a year to be counted, and by more than
# seven a day nobody is called any more.
FEWEST_A_WEEK, MOST_A_WEEK = 0.05, 50.0


class AiServices(Shape, frozen=True, kw_only=True):
    """What is worked out from a site's data. Visualization is always on.

    Attributes:
        anomaly_detection: every number of the first page without detectors of its own is watched
            by ``together``, at most one sample a second, and those of each device together.
        false_alarms_a_week: so many false alarms of all its anomaly detectors are borne; their
            thresholds are set from the site's history for that. 0: their own bars hold. A person
            may say another number on the page *Anomalies*.
        object_detection: every camera without `Detect` of its own gets the default one: persons,
            bicycles, cars, cats and dogs are counted, at the gateway.

    """

    anomaly_detection: bool = False
    false_alarms_a_week: float = 0.0
    object_detection: bool = False
