"""What the command line cannot do."""

from __future__ import annotations

from talaia.errors import TalaiaError

__all__ = ["CliError", "PartMissing", "PartStopped"]


class CliError(TalaiaError):
    """What was asked for cannot be started."""


class PartMissing(CliError):
    """A room of the product is not installed here."""

    def __init__(self, what: str, module: str, extra: str) -> None:
        """Name the extra that brings it."""
        super().__init__(what, module, extra)
        self.what, self.module, self.extra = what, module, extra

    def __str__(self) -> str:
        return (
            f"{self.what} needs the Python package {self.module!r}, which is not installed; "
            f"run: pip install 'talaia[{self.extra}]'"
        )


class PartStopped(CliError):
    """A process that must run has ended by itself."""

    def __init__(self, part: str, code: int, words: str) -> None:
        """Keep its name, its exit code and its last words."""
        super().__init__(part, code, words)
        self.part, self.code, self.words = part, code, words

    def __str__(self) -> str:
        last = f"\n{self.words}" if self.words else ""
        return f"the {self.part} stopped (exit code {self.code}){last}"
