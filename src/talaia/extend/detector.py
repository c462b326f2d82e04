"""For a detector of anomalies at the hub (entry point ``talaia.detectors``)."""

from __future__ import annotations

from talaia.extensions.declarations import DetectorExtension, ExtensionKeys
from talaia.hub.anomaly.base import AnomalyDetector

__all__ = ["AnomalyDetector", "DetectorExtension", "ExtensionKeys"]
