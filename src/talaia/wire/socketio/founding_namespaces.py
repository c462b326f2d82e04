"""Namespaces of the founding vehicle's Socket.IO."""

from __future__ import annotations

__all__ = ["CONFIGURATION", "NAMESPACES", "PICTURES_IN", "PICTURES_OUT", "SENSED"]

CONFIGURATION, PICTURES_IN, PICTURES_OUT = "/dynamicDB", "/cv2server", "/server2web"
# The founding designs spell it in two ways.
SENSED = ("/sensedData", "/sensedata")
NAMESPACES = ("/", CONFIGURATION, *SENSED, PICTURES_IN, PICTURES_OUT)
