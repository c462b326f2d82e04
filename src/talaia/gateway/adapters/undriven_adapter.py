"""What adapters have in common that can drive nothing."""

from __future__ import annotations

__all__ = ["UndrivenAdapter"]


class UndrivenAdapter:
    """The part of an `Adapter` that tells nobody to move: `check` refuses a drive here."""

    def drive(self, device: str, linear: float, angular: float, key: str = "") -> None:
        """Tell nobody: nothing here is driven."""

    def stop(self, device: str, *, stopped: bool) -> None:
        """Tell nobody: what is not driven has no STOP of its own."""
