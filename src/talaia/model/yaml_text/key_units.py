"""What to write for a number with its unit behind it, at a key that has one unit. Pure."""

from __future__ import annotations

from talaia.model.units.conversion import conversion_between

__all__ = ["number_remedy"]

# At these the unit is the one of the signal that is named beside them.
_OF_SIGNALS = {"above", "below", "until_above", "until_below", "minimum", "maximum", "deadband"}
_SECONDS = """after alarm_every before clear_delay delay disagree_after dwell flip_after
    frozen_after hand_over lasting link_lost longest longest_override max_age mount_within
    move_within over poll repeat reset_after timeout ttl watchdog_after within"""
_UNITS: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(_SECONDS.split(), ("s",)),
    **dict.fromkeys(("elevation", "margin", "resolution", "track_width", "wheelbase"), ("m",)),
    **dict.fromkeys(("latitude", "longitude", "heading", "rotation", "horizon"), ("°",)),
    # Of a vehicle, and of joints.
    **dict.fromkeys(("max_speed", "max_reverse", "max_sideways"), ("m/s", "rad/s")),
    **dict.fromkeys(("max_turn", "turn_step"), ("rad/s",)),
    "max_rate": ("Hz",),
}
# As durations are written elsewhere; a metre is no time, so an m of one is a minute.
_OF_TIME = {"m": "min", "sec": "s", "secs": "s", "mins": "min", "hr": "h", "hrs": "h"}


def number_remedy(key: str, number: str, unit: str) -> str:
    """Say how a number with a unit is written at a key.

    Args:
        key: the key's own name, as ``max_turn``.
        number: what stands before the unit, in digits.
        unit: what stands behind the number.

    """
    if key in _OF_SIGNALS:
        return "write the number alone, in the unit of the signal"
    units = _UNITS.get(key, ())
    if not units:
        return "write the number alone, in the unit of this key: seconds, metres, m/s"
    written = _OF_TIME.get(unit, unit) if units == ("s",) else unit
    for own in units:
        if (found := conversion_between(written, own)) is not None:
            # Six digits: a seventh of a limit says nothing to anybody.
            value = f"{found.convert(float(number)):.6g}"
            return f"write the number alone, in {own}: {value}"
    return f"write the number alone, in {' or '.join(units)}"
