"""The devices of the simulated observatory; what they are made of is imported by their catalog."""

from __future__ import annotations

from talaia.model.units.astronomy import Observer

__all__ = ["DEVICES", "ENCLOSURES", "MONTSEC"]

# The Montsec observatory in Catalonia: degrees north, degrees east, metres.
MONTSEC = Observer(42.0517, 0.7297, 1568.0)
# Kinds of roof: a dome with a slit, which turns, and a clamshell, which does not.
ENCLOSURES = ("dome", "clamshell")
DEVICES = (
    "dome",
    "telescope",
    "weather",
    "camera",
    "focuser",
    "wheel",
    "pdu",
    "cctv",
    "allsky",
    "observatory",
)
