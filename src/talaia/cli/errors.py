"""What the command line cannot do."""

from __future__ import annotations

from talaia.errors import TalaiaError

__all__ = ["BadFile", "BadRows", "CliError", "PartMissing", "PartStopped"]


class CliError(TalaiaError):
    """What was asked for cannot be started."""


class PartMissing(CliError):
    """A room of the product is not installed here."""

    def __init__(self, what: str, module: str, extra: str) -> None:
        """Name the extra that brings it."""
        # All of it, so that the error can be pickled and copied.
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


class BadFile(CliError):
    """A file cannot be imported; nothing of it was."""

    def __init__(self, file: str, place: str, problem: str, remedy: str = "") -> None:
        """Say where in the file what is wrong, and what can be done."""
        super().__init__(file, place, problem, remedy)
        self.file, self.place, self.problem, self.remedy = file, place, problem, remedy

    def __str__(self) -> str:
        where = f"{self.file}, {self.place}" if self.place else self.file
        remedy = f"; {self.remedy}" if self.remedy else ""
        return f"{where}: {self.problem}{remedy}; nothing was imported"


class BadRows(CliError):
    """A table cannot be judged row by row."""

    def __init__(self, file: str, place: str, problem: str, remedy: str = "") -> None:
        """Say where in the file what is wrong, and what can be done."""
        super().__init__(file, place, problem, remedy)
        self.file, self.place, self.problem, self.remedy = file, place, problem, remedy

    def __str__(self) -> str:
        where = f"{self.file}, {self.place}" if self.place else self.file
        return f"{where}: {self.problem}" + (f"; {self.remedy}" if self.remedy else "")
