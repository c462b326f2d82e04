"""Colours and spaces of the dashboard, for Qt: light and dark as the machine asks for it.

They are those of the pages' `tokens.css`; a test holds the two together.
"""

from __future__ import annotations

from typing import NamedTuple

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QGuiApplication, QPalette

__all__ = [
    "DARK",
    "LIGHT",
    "SPACE",
    "Colours",
    "asked_for",
    "colours_now",
    "qt_palette",
    "style_sheet",
]


class Colours(NamedTuple):
    """The tokens of one theme, by their names there."""

    bg: str
    surface: str
    raised: str
    text: str
    muted: str
    line: str
    edge: str
    accent: str
    on_accent: str
    ok: str
    warn: str
    bad: str


LIGHT = Colours(
    bg="#f3f5f4",
    surface="#ffffff",
    raised="#e9edeb",
    text="#182025",
    muted="#51606a",
    line="#d3dad7",
    edge="#7b8a92",
    accent="#155e78",
    on_accent="#ffffff",
    ok="#1a6437",
    warn="#7f4a00",
    bad="#ad2019",
)
DARK = Colours(
    bg="#0f1417",
    surface="#182025",
    raised="#222c32",
    text="#e9eef0",
    muted="#a6b3ba",
    line="#2e3a41",
    edge="#6d7d86",
    accent="#74c5df",
    on_accent="#08212b",
    ok="#74d197",
    warn="#f0b65e",
    bad="#ff948a",
)
_HALF = 128
# --t-space-1 to 6, in pixels at the pages' usual size.
SPACE = (4, 8, 12, 16, 24, 40)


def asked_for() -> Colours:
    """Give the theme that the machine asks for; where it does not say, the one that is on."""
    match QGuiApplication.styleHints().colorScheme():
        case Qt.ColorScheme.Dark:
            return DARK
        case Qt.ColorScheme.Light:
            return LIGHT
        case _:
            return colours_now()


def colours_now() -> Colours:
    """Give the theme that is on, for what draws itself."""
    ground = QGuiApplication.palette().color(QPalette.ColorRole.Window)
    return DARK if ground.lightness() < _HALF else LIGHT


def qt_palette(colours: Colours) -> QPalette:
    """Give Qt's roles their colours, for all that the style sheet does not name."""
    role = QPalette.ColorRole
    palette = QPalette()
    # A role that is not named keeps the system's colour, which may be unreadable on this theme.
    for colour_role, colour in (
        (role.Window, colours.bg),
        (role.WindowText, colours.text),
        (role.Base, colours.surface),
        (role.AlternateBase, colours.raised),
        (role.Text, colours.text),
        (role.PlaceholderText, colours.muted),
        (role.Button, colours.surface),
        (role.ButtonText, colours.text),
        (role.ToolTipBase, colours.raised),
        (role.ToolTipText, colours.text),
        (role.Highlight, colours.accent),
        (role.HighlightedText, colours.on_accent),
        (role.Link, colours.accent),
        (role.Accent, colours.accent),
        (role.Light, colours.line),
        (role.Midlight, colours.line),
        (role.Mid, colours.line),
        (role.Dark, colours.edge),
    ):
        palette.setColor(colour_role, QColor(colour))
    for colour_role in (role.Text, role.WindowText, role.ButtonText):
        # The roles above are set for all states; disabled text would look as if it could be used.
        palette.setColor(QPalette.ColorGroup.Disabled, colour_role, QColor(colours.edge))
    return palette


def style_sheet(colours: Colours) -> str:
    """Give the style sheet in these colours."""
    groups = (_page_styles, _button_styles, _field_styles, _table_styles)
    return "".join(styles(colours) for styles in groups)


def _page_styles(c: Colours) -> str:
    """Style windows, labels, cards and the list of steps."""
    return f"""
QMainWindow, QDialog {{ background: {c.bg}; }}
QWidget {{ color: {c.text}; }}
QLabel {{ background: transparent; }}
QLabel[part="title"] {{ font-size: 20px; font-weight: 600; }}
QLabel[part="heading"] {{ font-weight: 600; }}
QLabel[part="muted"] {{ color: {c.muted}; }}
QLabel[part="bad"] {{ color: {c.bad}; }}
QLabel[part="ok"] {{ color: {c.ok}; }}
QFrame[part="card"] {{
  background: {c.surface}; border: 1px solid {c.line}; border-radius: 10px;
}}
QFrame[part="notice"] {{
  background: {c.surface}; border: 1px solid {c.bad}; border-radius: 6px;
}}
QScrollArea, QWidget[part="page"] {{ background: transparent; border: 0; }}
QListWidget#steps {{
  background: {c.surface}; border: 2px solid {c.surface}; outline: 0; padding: 6px;
}}
QListWidget#steps:focus {{ border-color: {c.accent}; }}
QListWidget#steps::item {{ padding: 11px 12px; border-radius: 6px; }}
QListWidget#steps::item:selected {{ background: {c.raised}; color: {c.accent}; font-weight: 600; }}
"""


def _button_styles(c: Colours) -> str:
    """Style tool bars and buttons."""
    return f"""
QToolBar {{
  background: {c.surface}; border: 0; border-bottom: 1px solid {c.line}; padding: 4px;
  spacing: 4px;
}}
QToolButton {{ padding: 5px 9px; border: 2px solid transparent; border-radius: 6px; }}
QToolButton:hover {{ background: {c.raised}; }}
QToolButton:focus {{ border-color: {c.accent}; }}
QToolButton:disabled {{ color: {c.edge}; }}
QPushButton {{
  background: {c.surface}; border: 1px solid {c.edge}; border-radius: 6px; padding: 6px 14px;
  min-height: 18px;
}}
QPushButton:hover {{ background: {c.raised}; }}
QPushButton:focus {{ border: 2px solid {c.accent}; padding: 5px 13px; }}
QPushButton:disabled {{ color: {c.edge}; border-color: {c.line}; }}
QPushButton[part="main"] {{
  background: {c.accent}; color: {c.on_accent}; border-color: {c.accent}; font-weight: 600;
}}
QPushButton[part="main"]:focus {{ border: 2px solid {c.text}; }}
QPushButton[part="main"]:disabled {{
  background: {c.raised}; color: {c.edge}; border-color: {c.line};
}}
"""


def _field_styles(c: Colours) -> str:
    """Style fields to write in and to choose from."""
    return f"""
QLineEdit, QComboBox, QSpinBox, QPlainTextEdit {{
  background: {c.surface}; border: 1px solid {c.edge}; border-radius: 6px; padding: 4px 7px;
  selection-background-color: {c.accent}; selection-color: {c.on_accent};
}}
QLineEdit, QComboBox, QSpinBox {{ min-height: 18px; }}
QLineEdit:focus, QComboBox:focus, QSpinBox:focus, QPlainTextEdit:focus {{
  border: 2px solid {c.accent}; padding: 3px 6px;
}}
QLineEdit:disabled, QComboBox:disabled, QSpinBox:disabled {{
  color: {c.edge}; border-color: {c.line}; background: {c.bg};
}}
QLineEdit[wrong="true"], QComboBox[wrong="true"], QPlainTextEdit[wrong="true"] {{
  border: 2px solid {c.bad};
}}
QSpinBox::up-button, QSpinBox::down-button {{ width: 0; border: 0; }}
QSpinBox QLineEdit {{ border: 0; padding: 0; min-height: 0; background: transparent; }}
QComboBox::drop-down {{ border: 0; width: 22px; }}
QComboBox QAbstractItemView {{
  background: {c.surface}; border: 1px solid {c.edge};
  selection-background-color: {c.accent}; selection-color: {c.on_accent};
}}
"""


def _table_styles(c: Colours) -> str:
    """Style tables, trees, progress, menus and scroll bars."""
    return f"""
QTableView, QTreeView, QListView#problems {{
  background: {c.surface}; border: 1px solid {c.line}; border-radius: 6px; outline: 0;
  gridline-color: {c.line}; alternate-background-color: {c.bg};
  selection-background-color: {c.raised}; selection-color: {c.text};
}}
QTableView:focus, QTreeView:focus, QListView#problems:focus {{ border: 2px solid {c.accent}; }}
QTableView::item, QTreeView::item, QListView#problems::item {{ padding: 3px 6px; }}
QHeaderView::section {{
  background: {c.raised}; color: {c.muted}; border: 0; border-bottom: 1px solid {c.line};
  padding: 5px 6px; text-align: left;
}}
QProgressBar {{
  background: {c.raised}; border: 0; border-radius: 4px; max-height: 8px; min-height: 8px;
}}
QProgressBar::chunk {{ background: {c.accent}; border-radius: 4px; }}
QTableView::indicator:unchecked {{
  width: 12px; height: 12px; border: 1px solid {c.edge}; border-radius: 2px;
}}
QToolBar::separator {{ background: {c.line}; width: 1px; margin: 5px 6px; }}
QMenuBar, QMenu {{ background: {c.surface}; }}
QMenuBar::item:selected, QMenu::item:selected {{ background: {c.raised}; }}
QStatusBar {{ background: {c.surface}; color: {c.muted}; border-top: 1px solid {c.line}; }}
QScrollBar {{ background: transparent; border: 0; }}
QScrollBar:vertical {{ width: 10px; }}
QScrollBar:horizontal {{ height: 10px; }}
QScrollBar::handle {{ background: {c.edge}; border: 2px solid {c.surface}; border-radius: 5px; }}
QScrollBar::handle:vertical {{ min-height: 28px; }}
QScrollBar::handle:horizontal {{ min-width: 28px; }}
QScrollBar::add-line, QScrollBar::sub-line, QScrollBar::add-page, QScrollBar::sub-page {{
  background: transparent; border: 0; width: 0; height: 0;
}}
QSplitter::handle {{ background: transparent; }}
"""
