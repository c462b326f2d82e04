"""Who has armed a night, and until when. Pure."""

from __future__ import annotations

import msgspec

__all__ = ["NightArming"]


class NightArming(msgspec.Struct, frozen=True, kw_only=True):
    """What is kept on disk of it.

    Attributes:
        armed_by: who; empty: nobody.
        until: it disarms itself then (s since the epoch, UTC); 0: until somebody disarms it.
        fault: what failed, so that nothing goes on by itself until somebody arms again.
        opened: it has opened the roof, and not brought roof and telescope to rest since. Whoever
            comes after it does so, armed or not.

    """

    armed_by: str = ""
    until: float = 0.0
    fault: str = ""
    opened: bool = False

    def holds_at(self, time: float) -> bool:
        """Tell whether it is armed at a time (s since the epoch, UTC)."""
        return bool(self.armed_by) and not self.fault and (not self.until or time < self.until)
