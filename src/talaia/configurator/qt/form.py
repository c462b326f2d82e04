"""A form for any thing of the description, made from its rows; it keeps nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QCompleter,
    QGridLayout,
    QLabel,
    QLineEdit,
    QPlainTextEdit,
    QWidget,
)

from talaia.configurator.errors import BadValue
from talaia.configurator.form_rows import Row, RowKind, parse_text, shown_text, value_of
from talaia.configurator.qt.palette import SPACE
from talaia.configurator.qt.widgets import ComboBox, Switch, make_label, mark_wrong

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from PySide6.QtGui import QFocusEvent

__all__ = ["Form"]

_HEADINGS = {
    "source": "Where it comes from",
    "stop": "Software stop",
    "detect": "Object detection",
}
# Of a list's field; longer ones scroll in it.
_LINES = 3


class _Lines(QPlainTextEdit):
    """A few lines of text, done when the focus leaves; Tab leaves."""

    done = Signal()

    def __init__(self) -> None:
        super().__init__()
        # Tab leads on, or who has no mouse could not leave the field.
        self.setTabChangesFocus(True)
        height = self.fontMetrics().lineSpacing() * _LINES + 16
        self.setFixedHeight(height)

    def focusOutEvent(self, event: QFocusEvent) -> None:  # noqa: N802 - Qt's name
        super().focusOutEvent(event)
        self.done.emit()


class _Field:
    """A row with its widget and the line below it that says what is wrong."""

    def __init__(self, form: Form, row: Row) -> None:
        self.row = row
        self._form = form
        self.widget = self._make_widget()
        self.widget.setAccessibleName(row.label)
        self.widget.setAccessibleDescription(row.help)
        self.widget.setToolTip(row.help)
        self.widget.setObjectName(row.key)
        self.wrong = make_label("", "bad", wrap=True)
        self.wrong.hide()
        # As the description has it; what is typed is compared with it.
        self.text = ""

    def _make_widget(self) -> QWidget:
        row = self.row
        if row.kind in (RowKind.TRUTH, RowKind.PART):
            switch = Switch("")
            # Clicked, not toggled: showing a value must not count as a change by a person.
            switch.clicked.connect(lambda on=False: self._apply_text("true" if on else "false"))
            return switch
        if row.kind is RowKind.CHOICE:
            choice = ComboBox()
            choice.addItems(list(row.choices))
            # Activated: by a person only, not when a value is shown.
            choice.textActivated.connect(self._apply_text)
            return choice
        if row.kind in (RowKind.LIST, RowKind.PAIRS):
            lines = _Lines()
            lines.done.connect(lambda: self._apply_text(lines.toPlainText()))
            return lines
        line = QLineEdit()
        if row.offers:
            completer = QCompleter([offer for offer in row.offers if offer], line)
            completer.setCompletionMode(QCompleter.CompletionMode.PopupCompletion)
            line.setCompleter(completer)
        line.editingFinished.connect(lambda: self._apply_text(line.text()))
        return line

    def _apply_text(self, text: str) -> None:
        # Leaving a field without a change is no step for undo.
        if text == self.text:
            return
        try:
            value = parse_text(self.row, text)
        except BadValue as error:
            self.show_problem(str(error))
            return
        self.text = text
        self._form.edited.emit(self.row, value)

    def show(self, value: object, problem: str) -> None:
        text = shown_text(self.row, value)
        widget = self.widget
        self.text = text
        if isinstance(widget, Switch):
            widget.setChecked(value is True)
        elif isinstance(widget, QComboBox):
            widget.setCurrentText(text)
        elif isinstance(widget, QPlainTextEdit):
            # Setting the same text again would put the cursor to its start.
            if widget.toPlainText() != text:
                widget.setPlainText(text)
        elif isinstance(widget, QLineEdit) and widget.text() != text:
            widget.setText(text)
        self.show_problem(problem)

    def show_problem(self, problem: str) -> None:
        self.wrong.setText(problem)
        self.wrong.setVisible(bool(problem))
        mark_wrong(self.widget, wrong=bool(problem))
        told = f"{problem}. {self.row.help}" if problem else self.row.help
        self.widget.setAccessibleDescription(told)


class Form(QWidget):
    """Labels and fields of one thing.

    Signals:
        edited: a row and its new value.

    """

    edited = Signal(object, object)

    def __init__(self, parent: QWidget | None = None) -> None:
        """Begin empty."""
        super().__init__(parent)
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setVerticalSpacing(SPACE[0])
        self._grid.setHorizontalSpacing(SPACE[2])
        self._grid.setColumnStretch(1, 1)
        # By `Row.key`; made anew by `_make`.
        self._fields: dict[str, _Field] = {}
        # What the fields were made for, and of which thing; others make them anew.
        self._rows: tuple[Row, ...] = ()
        self._for: object = None

    def minimumSizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Be scrolled rather than squeezed."""
        return QSize(super().minimumSizeHint().width(), self.sizeHint().height())

    def show_thing(
        self, rows: Sequence[Row], thing: object, problems: Mapping[str, str], key: object = None
    ) -> None:
        """Show a thing.

        Args:
            rows: its fields.
            thing: a shape of the model.
            problems: what is wrong, by `Row.key`.
            key: which thing; for another one, fields are made anew and forget what was typed.

        """
        focused = ""
        if tuple(rows) != self._rows or key != self._for:
            # The same thing with other rows: a switch was used, and the focus may be on it.
            if key == self._for:
                focused = next((k for k, f in self._fields.items() if f.widget.hasFocus()), "")
            self._make(rows)
            self._for = key
        if focused:
            self.go_to(focused)
        for field in self._fields.values():
            field.show(value_of(thing, field.row), problems.get(field.row.key, ""))

    def clear(self) -> None:
        """Show nothing."""
        self._make(())
        self._for = None

    def go_to(self, key: str) -> bool:
        """Put the focus into a field, or the nearest one above; false where there is none."""
        while key:
            if field := self._fields.get(key):
                field.widget.setFocus(Qt.FocusReason.OtherFocusReason)
                if isinstance(field.widget, QLineEdit):
                    field.widget.selectAll()
                return True
            key = key.rpartition(".")[0]
        return False

    def field(self, key: str) -> QWidget:
        """Give the widget of a field."""
        return self._fields[key].widget

    def _make(self, rows: Sequence[Row]) -> None:
        # Hidden at once: `deleteLater` waits for the event loop, and the old ones would show
        # through.
        while item := self._grid.takeAt(0):
            if widget := item.widget():
                widget.hide()
                widget.deleteLater()
        self._fields = {}
        self._rows = tuple(rows)
        at, above = 0, ""
        # Own fields first, then each group below its heading.
        flat = [row for row in rows if len(row.path) == 1]
        for row in [*flat, *(row for row in rows if len(row.path) > 1)]:
            group = row.path[0] if len(row.path) > 1 else ""
            if group != above:
                self._grid.addWidget(
                    make_label(_HEADINGS.get(group, group), "heading"), at, 0, 1, 2
                )
                at, above = at + 1, group
            field = _Field(self, row)
            name = QLabel(row.label)
            name.setTextFormat(Qt.TextFormat.PlainText)
            name.setToolTip(row.help)
            name.setBuddy(field.widget)
            lines = row.kind in (RowKind.LIST, RowKind.PAIRS)
            side = Qt.AlignmentFlag.AlignTop if lines else Qt.AlignmentFlag.AlignVCenter
            self._grid.addWidget(name, at, 0, side)
            self._grid.addWidget(field.widget, at, 1)
            # A row of its own for what is wrong; hidden it takes no room.
            self._grid.addWidget(field.wrong, at + 1, 1)
            self._fields[row.key] = field
            at += 2
        # The rest of the height goes below the last field, not between them.
        self._grid.setRowStretch(at, 1)
        # In the order on the screen, whatever order Qt has them in.
        previous: QWidget | None = None
        for field in self._fields.values():
            if previous is not None:
                QWidget.setTabOrder(previous, field.widget)
            previous = field.widget
