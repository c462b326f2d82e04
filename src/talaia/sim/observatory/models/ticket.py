"""What a server answers when it is asked to do something that takes time."""

from __future__ import annotations

__all__ = ["Ticket"]


class Ticket:
    """One request: under way until it ends once, well or not, with words for people.

    Attributes:
        ended: nothing more will change.
        good: how it ended.
        message: in the server's words.

    """

    def __init__(self) -> None:
        """Begin under way."""
        self.ended = False
        self.good = False
        self.message = ""

    def end_with(self, message: str, *, good: bool) -> Ticket:
        """End it; the first end counts."""
        if not self.ended:
            self.ended, self.good, self.message = True, good, message
        return self

    @classmethod
    def done(cls, message: str) -> Ticket:
        """Give one that ended well at once."""
        return cls().end_with(message, good=True)

    @classmethod
    def refused(cls, message: str) -> Ticket:
        """Give one that never began."""
        return cls().end_with(message, good=False)
