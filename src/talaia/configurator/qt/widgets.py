"""Small things that the pages are made of: a switch, a card, labels, a page that scrolls."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFont, QPainter, QPaintEvent, QPen, QWheelEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFrame,
    QHBoxLayout,
    QLabel,
    QLayout,
    QPushButton,
    QScrollArea,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from talaia.configurator.qt.palette import SPACE, colours_now

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = [
    "Card",
    "ComboBox",
    "Inner",
    "Number",
    "Page",
    "Switch",
    "make_button",
    "make_label",
    "make_output_label",
    "make_row",
    "mark_wrong",
]

_TRACK = QSize(36, 20)


class Switch(QCheckBox):
    """A check box that is drawn as a switch."""

    def __init__(self, text: str, parent: QWidget | None = None) -> None:
        """Say what is switched."""
        super().__init__(text, parent)
        self.setAccessibleName(text)
        self.setCursor(Qt.CursorShape.PointingHandCursor)

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Leave room for the track, the text and the focus ring."""
        words = self.fontMetrics().size(Qt.TextFlag.TextShowMnemonic.value, self.text())
        gap = 10 if self.text() else 0
        return QSize(_TRACK.width() + gap + words.width() + 8, max(words.height(), 20) + 8)

    def minimumSizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Nothing of it is ever cut off."""
        return self.sizeHint()

    def hitButton(self, pos: object) -> bool:  # noqa: N802 - Qt's name
        """Take a click anywhere on it."""
        return True

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw a track with a knob, and a ring when it has the focus."""
        c = colours_now()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        top = (self.height() - _TRACK.height()) / 2
        track = QRectF(4, top, _TRACK.width(), _TRACK.height())
        on = self.isChecked()
        fill = QColor((c.accent if on else c.raised) if self.isEnabled() else c.line)
        painter.setPen(QPen(QColor(c.accent if on and self.isEnabled() else c.edge), 1))
        painter.setBrush(fill)
        painter.drawRoundedRect(track, 10, 10)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(c.on_accent if on else c.edge))
        left = track.right() - 17 if on else track.left() + 3
        painter.drawEllipse(QRectF(left, top + 3, 14, 14))
        painter.setPen(QColor(c.text if self.isEnabled() else c.edge))
        words = QRectF(_TRACK.width() + 14, 0, self.width() - _TRACK.width() - 14, self.height())
        flags = Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft
        painter.drawText(words, int(flags) | int(Qt.TextFlag.TextShowMnemonic), self.text())
        if self.hasFocus():
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(QColor(c.accent), 2))
            painter.drawRoundedRect(track.adjusted(-3, -3, 3, 3), 13, 13)
        painter.end()


class ComboBox(QComboBox):
    """A list to choose from, no wider than it must be."""

    def __init__(self, parent: QWidget | None = None) -> None:
        """Begin without a choice."""
        super().__init__(parent)
        self.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        # Else the longest choice decides how wide the whole page is.
        self.setMinimumContentsLength(8)

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw the arrow, which a style sheet could only take from a picture."""
        super().paintEvent(event)
        c = colours_now()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(QColor(c.muted if self.isEnabled() else c.line), 1.6))
        x, y = self.width() - 15.0, self.height() / 2
        painter.drawPolyline([QPointF(x - 4, y - 2), QPointF(x, y + 2), QPointF(x + 4, y - 2)])
        painter.end()

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802 - Qt's name
        """Leave the wheel to the page: a choice is not changed by scrolling past it."""
        event.ignore()


class Number(QSpinBox):
    """A whole number; the arrow keys count."""

    def __init__(self, low: int, high: int, value: int, suffix: str = "") -> None:
        """Give its limits."""
        super().__init__(minimum=low, maximum=high, value=value, suffix=suffix)

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802 - Qt's name
        """Leave the wheel to the page."""
        event.ignore()


class Inner(QScrollArea):
    """Something that may be longer than its place in a card."""

    def __init__(self, inner: QWidget) -> None:
        """Scroll this."""
        super().__init__()
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setWidget(inner)
        inner.setProperty("part", "page")
        # `setWidget` has both fill their background.
        inner.setAutoFillBackground(False)
        self.viewport().setAutoFillBackground(False)


class Card(QFrame):
    """A frame with a heading, on the page's ground."""

    def __init__(self, heading: str = "", parent: QWidget | None = None) -> None:
        """Give its heading, if it has one."""
        super().__init__(parent)
        self.setProperty("part", "card")
        self.body = QVBoxLayout(self)
        self.body.setContentsMargins(SPACE[3], SPACE[2], SPACE[3], SPACE[3])
        self.body.setSpacing(SPACE[1])
        if heading:
            self.body.addWidget(make_label(heading, "heading"))


class Page(QScrollArea):
    """A page of the window: a title, a sentence, and what follows, which scrolls."""

    def __init__(self, title: str, sentence: str, parent: QWidget | None = None) -> None:
        """Give the title and what the page is for."""
        super().__init__(parent)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setAccessibleName(title)
        inner = QWidget()
        inner.setProperty("part", "page")
        self.body = QVBoxLayout(inner)
        self.body.setContentsMargins(SPACE[4], SPACE[3], SPACE[4], SPACE[3])
        self.body.setSpacing(SPACE[2])
        self.body.addWidget(make_label(title, "title"))
        self.body.addWidget(make_label(sentence, "muted", wrap=True))
        self.setWidget(inner)


def make_label(text: str, part: str = "", *, wrap: bool = False) -> QLabel:
    """Make a label of one of the style sheet's parts; it shows text, never markup."""
    made = QLabel(text)
    # Names and answers come from files and robots: markup in them must not be drawn.
    made.setTextFormat(Qt.TextFormat.PlainText)
    made.setWordWrap(wrap)
    if part:
        made.setProperty("part", part)
    if part == "title":
        font = QFont(made.font())
        font.setWeight(QFont.Weight.DemiBold)
        made.setFont(font)
    return made


def make_output_label(part: str) -> QLabel:
    """Make a label for what a program said: selectable, wrapped, hidden until it has text."""
    made = make_label("", part, wrap=True)
    made.setTextInteractionFlags(
        Qt.TextInteractionFlag.TextSelectableByMouse
        | Qt.TextInteractionFlag.TextSelectableByKeyboard
    )
    made.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    made.hide()
    return made


def make_button(text: str, pressed: Callable[[], object], part: str = "") -> QPushButton:
    """Make a button; Enter presses it as well as the space bar."""
    made = QPushButton(text)
    made.setAutoDefault(True)
    made.setAccessibleName(text.replace("&", ""))
    if part:
        made.setProperty("part", part)
    made.clicked.connect(lambda _=False: pressed())
    return made


def make_row(*items: QWidget | QLayout | int) -> QHBoxLayout:
    """Lay things out side by side; a number is a stretch."""
    made = QHBoxLayout()
    made.setSpacing(SPACE[1])
    for item in items:
        if isinstance(item, int):
            made.addStretch(item)
        elif isinstance(item, QLayout):
            made.addLayout(item)
        else:
            made.addWidget(item)
    return made


def mark_wrong(widget: QWidget, *, wrong: bool) -> None:
    """Draw a field's border as wrong, or as usual."""
    if bool(widget.property("wrong")) != wrong:
        widget.setProperty("wrong", wrong)
        # Qt reads a property for the style sheet only once, unless it is told to style anew.
        widget.style().unpolish(widget)
        widget.style().polish(widget)
