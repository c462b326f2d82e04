"""Where a signal comes from that is worked out from others."""

from __future__ import annotations

from talaia.model.base import SourceShape

__all__ = ["DerivedSource"]


class DerivedSource(SourceShape, frozen=True, kw_only=True, tag="derived"):
    """A signal that the gateway works out from other signals, whatever the connection.

    Attributes:
        expression: a sum over signals, as ``{weather/outside} - {weather/dew_point}``, or a
            condition for a state of two words; see the how-to page on derived signals.

    """

    expression: str = ""
