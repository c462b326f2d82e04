"""What the runs found, as the table that is published. Pure."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from .ledgers import Findings, spread

if TYPE_CHECKING:
    from typing import Protocol

    class Row(Protocol):
        """What a row says of itself."""

        @property
        def name(self) -> str: ...

        @property
        def what(self) -> str: ...


ENCLOSURE = "The enclosure has a table of its own: [enclosure-table.md](enclosure-table.md)."


class Table:
    """Rows and what their runs found."""

    def __init__(self, about: str = ENCLOSURE) -> None:
        """Begin empty; ``about`` stands below it."""
        self._about = about
        self._rows: dict[str, tuple[Row, list[int], list[Findings]]] = {}

    def add(self, row: Row, seed: int, findings: Findings) -> None:
        _, seeds, found = self._rows.setdefault(row.name, (row, [], []))
        seeds.append(seed)
        found.append(findings)

    def text(self) -> str:
        """Write the table, in Markdown."""
        lines = [
            "| # | fault | runs | seeds | violations | zero after (least / median / most, ms)"
            " | back after (s) | memory after / before, most | what was counted and measured |",
            "| --- | --- | --: | --- | --: | --- | --- | --: | --- |",
        ]
        notes = []
        for row, seeds, found in self._rows.values():
            stops = spread(ms for each in found for ms in each.stops_ms)
            back = spread(s for each in found for s in each.back_s)
            counted: Counter[str] = Counter()
            for each in found:
                counted.update(each.counted)
            violations = [text for each in found for text in each.violations]
            figures: dict[str, list[float]] = {}
            for each in found:
                for name, numbers in each.figures.items():
                    figures.setdefault(name, []).extend(numbers)
            told = ", ".join(
                [f"{number:,} {name}" for name, number in sorted(counted.items())]
                + [f"{name} {_three(spread(each), 1)}" for name, each in sorted(figures.items())]
            )
            memory = max((ratio for each in found for ratio in each.memory), default=None)
            lines.append(
                f"| {row.name} | {row.what} | {len(seeds)} | {seeds[0]}–{seeds[-1]}"
                f" | {len(violations)} | {_three(stops, 0)} | {_three(back, 1)}"
                f" | {'–' if memory is None else f'{memory:.2f}'} | {told} |"
            )
            notes += [f"- {row.name}: {text}" for text in violations]
        return "\n".join([*lines, "", *notes, "", self._about]).rstrip() + "\n"


def _three(numbers: tuple[float, float, float] | None, digits: int) -> str:
    return "–" if numbers is None else " / ".join(f"{each:.{digits}f}" for each in numbers)
