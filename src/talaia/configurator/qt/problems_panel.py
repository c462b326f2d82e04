"""What `talaia check` would say, below every page; one click or Enter leads to the field."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QListWidget, QListWidgetItem, QVBoxLayout, QWidget

from talaia.configurator.qt.palette import SPACE
from talaia.configurator.qt.widgets import make_label

if TYPE_CHECKING:
    from talaia.configurator.document import Problem
    from talaia.configurator.qt.editor import Editor

__all__ = ["ProblemsPanel"]

# More are found again when the first ones are mended.
MAX_LISTED = 200


class ProblemsPanel(QWidget):
    """A sentence, and a list when something is wrong."""

    def __init__(self, editor: Editor) -> None:
        """Show the open document's problems."""
        super().__init__()
        self._editor = editor
        body = QVBoxLayout(self)
        body.setContentsMargins(SPACE[4], SPACE[0], SPACE[4], SPACE[1])
        body.setSpacing(SPACE[0])
        self.sentence = make_label("")
        body.addWidget(self.sentence)
        self.list = QListWidget()
        self.list.setObjectName("problems")
        self.list.setAccessibleName("Problems")
        self.list.setAccessibleDescription("Press Enter to go to the field")
        self.list.setVerticalScrollMode(QListWidget.ScrollMode.ScrollPerPixel)
        self.list.itemClicked.connect(self._open_problem)
        # Enter; a click comes by the signal above.
        self.list.itemActivated.connect(self._open_problem)
        body.addWidget(self.list)
        editor.changed.connect(self.show_problems)
        self.show_problems()

    def show_problems(self) -> None:
        """List the problems as they are now."""
        problems = self._editor.document.problems
        count = len(problems)
        self.sentence.setText(
            "✓ No problems: this description can run."
            if not count
            else f"✗ {count} problem{'s' if count > 1 else ''}; click one to go to its field (F8)"
        )
        self._paint_sentence("bad" if count else "ok")
        # The same ones keep their place under the pointer.
        listed = [self.list.item(index).text() for index in range(self.list.count())]
        wanted = [_problem_line(problem) for problem in problems[:MAX_LISTED]]
        if listed != wanted:
            self.list.clear()
            for text in wanted:
                self.list.addItem(QListWidgetItem(text))
        self.list.setVisible(bool(count))
        # More are scrolled to: the page above needs the room.
        rows = min(count, 3)
        self.list.setFixedHeight(rows * (self.fontMetrics().lineSpacing() + 8) + 6)

    def go_to_next(self) -> None:
        """Go to the problem after the selected one."""
        count = self.list.count()
        if count:
            # No selection is row -1, so that the first comes next; after the last the first again.
            number = (self.list.currentRow() + 1) % count
            self.list.setCurrentRow(number)
            self.go_to(number)

    def go_to(self, number: int) -> None:
        """Go to the field of a problem."""
        problem = self._editor.document.problems[number]
        self._editor.show_thing(problem.spot.node, problem.spot.field)

    def _open_problem(self, item: QListWidgetItem) -> None:
        self.go_to(self.list.row(item))

    def _paint_sentence(self, part: str) -> None:
        if self.sentence.property("part") != part:
            self.sentence.setProperty("part", part)
            # Qt reads a property for the style sheet only once, unless it is told to style anew.
            self.sentence.style().unpolish(self.sentence)
            self.sentence.style().polish(self.sentence)
            self.sentence.setTextInteractionFlags(Qt.TextInteractionFlag.NoTextInteraction)


def _problem_line(problem: Problem) -> str:
    where = problem.where.removeprefix("$.") or "site"
    return f"{where}: {problem}".replace("\n", " ")
