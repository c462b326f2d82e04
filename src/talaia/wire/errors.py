"""The other side broke the protocol, or a code was not written as it should be."""

from __future__ import annotations

from talaia.errors import TalaiaError

__all__ = ["CodeMistyped", "PeerError", "UnknownKind"]


class PeerError(TalaiaError):
    """A frame that cannot be accepted; the connection is closed with `code`.

    Codes are WebSocket close codes (RFC 6455 section 7.4): 1002 for a frame that is not in the
    protocol, 1009 for one that is too large, 4000 and above for our own reasons.
    """

    def __init__(self, problem: str, code: int = 1002) -> None:
        """Keep the sentence and the close code."""
        super().__init__(problem, code)
        self.problem = problem
        self.code = code

    def __str__(self) -> str:
        return f"{self.problem} (close code {self.code})"


class CodeMistyped(TalaiaError):
    """A one-time code that cannot be one."""

    def __init__(self, problem: str) -> None:
        """Keep what is wrong with it."""
        super().__init__(problem)
        self.problem = problem

    def __str__(self) -> str:
        return f"the code was mistyped: {self.problem}; compare it with the page, or paste it"


class UnknownKind(PeerError):
    """A frame of a kind that this version does not know; whoever reads a running link skips it."""

    def __init__(self, kind: str) -> None:
        """Keep the tag."""
        # The peer chose the word: only its beginning goes into logs.
        super().__init__(f"a message of the unknown kind {kind[:40]!r}")
        self.kind = kind
