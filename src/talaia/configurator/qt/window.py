"""The main window: steps at the left, a page each, problems below, the file above.

Long, because the file's life (new, open, save, ask, close) is the window's own.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QCloseEvent, QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QApplication,
    QFileDialog,
    QFrame,
    QHBoxLayout,
    QListWidget,
    QMainWindow,
    QMessageBox,
    QStackedWidget,
    QToolBar,
    QVBoxLayout,
    QWidget,
)

from talaia.configurator.document import Document
from talaia.configurator.edits import new_site
from talaia.configurator.errors import FileChanged, NotWritten
from talaia.configurator.files import open_document, opening_problems, save_document
from talaia.configurator.qt.ai_page import AiPage
from talaia.configurator.qt.devices_page import DevicesPage
from talaia.configurator.qt.editor import Editor
from talaia.configurator.qt.find_dialog import FindDialog
from talaia.configurator.qt.generate_page import GeneratePage
from talaia.configurator.qt.palette import SPACE, asked_for, qt_palette, style_sheet
from talaia.configurator.qt.problems_panel import ProblemsPanel
from talaia.configurator.qt.robot_page import RobotPage
from talaia.configurator.qt.sensors_page import SensorsPage
from talaia.configurator.qt.widgets import make_button, make_label, make_row
from talaia.model.errors import DescriptionError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from talaia.configurator.description_paths import Path as Place
    from talaia.configurator.qt.palette import Colours

__all__ = ["ConfiguratorWindow", "Means"]

_STEPS = ("AI services", "Sensors", "Services", "Devices and commands", "Generate")
# Of one file; the rest is told after these are mended.
_MOST_PROBLEMS = 8
_FILTER = "Site description (*.yaml *.yml);;Observatory's command file (*.json)"


class Means(NamedTuple):
    """What the window needs of the machine it runs on.

    Attributes:
        talaia: how Talaia is started: the interpreter and its arguments.
        zone: the machine's IANA time zone, for new descriptions.
        open_page: opens an address in the browser.
        data: folder of accounts and history; empty for the usual one.

    """

    talaia: Sequence[str]
    zone: str
    open_page: Callable[[str], None]
    data: str = ""


class ConfiguratorWindow(QMainWindow):
    """One document from empty to running."""

    def __init__(self, means: Means) -> None:
        """Begin with a new description."""
        super().__init__()
        self._means = means
        # First: each page below shows its document at once, and listens to its changes.
        self.editor = Editor(self._new_document())
        self.ai, self.sensors = AiPage(self.editor), SensorsPage(self.editor)
        self.robot, self.devices = RobotPage(self.editor), DevicesPage(self.editor)
        self.generate = GeneratePage(
            self.editor,
            talaia=means.talaia,
            save=self.save,
            open_page=means.open_page,
            data=means.data,
        )
        # One for the window's life, so that it keeps the robot's name between searches.
        self.finder = FindDialog(self.editor, means.talaia, self)
        self.problems = ProblemsPanel(self.editor)
        self._build_layout()
        self._make_actions()
        self.editor.changed.connect(self._show_state)
        self.editor.refused.connect(self._show_message)
        self.editor.wanted.connect(self.go_to)
        # The machine's theme may change while the window is open, at sunset for example.
        QApplication.styleHints().colorSchemeChanged.connect(lambda _: self.paint())
        self.paint()
        self._show_state()
        self.resize(1080, 760)
        self.steps.setFocus()

    def _new_document(self) -> Document:
        return Document(new_site("robot", "Robot", self._means.zone))

    # ── building ──

    def _build_layout(self) -> None:
        self.steps = QListWidget()
        self.steps.setObjectName("steps")
        self.steps.setAccessibleName("Steps")
        self.steps.addItems([f"{number}  {name}" for number, name in enumerate(_STEPS, 1)])
        self.steps.setFixedWidth(206)
        self.steps.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.pages = QStackedWidget()
        for page in (self.ai, self.sensors, self.robot, self.devices, self.generate):
            self.pages.addWidget(page)
        # The list leads and the pages follow, so that both never show different steps.
        self.steps.currentRowChanged.connect(self._turn_page)
        self.back = make_button("&Back", lambda: self.show_page(self.pages.currentIndex() - 1))
        self.next = make_button(
            "Ne&xt", lambda: self.show_page(self.pages.currentIndex() + 1), "main"
        )
        turning = make_row(1, self.back, self.next)
        turning.setContentsMargins(SPACE[4], 0, SPACE[4], SPACE[0])
        self.notice = self._make_notice()
        right = QWidget()
        body = QVBoxLayout(right)
        body.setContentsMargins(0, SPACE[0], 0, 0)
        body.setSpacing(SPACE[0])
        body.addWidget(self.notice)
        body.addWidget(self.pages, 1)
        body.addLayout(turning)
        body.addWidget(self.problems)
        whole = QWidget()
        across = QHBoxLayout(whole)
        across.setContentsMargins(0, 0, 0, 0)
        across.setSpacing(0)
        across.addWidget(self.steps)
        across.addWidget(right, 1)
        self.setCentralWidget(whole)
        self.steps.setCurrentRow(0)

    def _make_notice(self) -> QFrame:
        frame = QFrame()
        frame.setProperty("part", "notice")
        self.notice_text = make_label("", "bad", wrap=True)
        inner = QHBoxLayout(frame)
        inner.setContentsMargins(SPACE[2], SPACE[0], SPACE[0], SPACE[0])
        inner.addWidget(self.notice_text, 1)
        inner.addWidget(make_button("Dismiss", lambda: self._show_message("")))
        frame.hide()
        return frame

    def _make_actions(self) -> None:
        bar = QToolBar("File", movable=False)
        # Its menu could hide the tool bar, and nothing here would show it again.
        bar.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
        bar.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
        self.addToolBar(bar)
        keys = QKeySequence.StandardKey

        def action(
            text: str, key: QKeySequence.StandardKey | str, do: Callable[[], object]
        ) -> QAction:
            made = QAction(text, self)
            made.setShortcut(QKeySequence(key))
            made.triggered.connect(lambda _=False: do())
            bar.addAction(made)
            shortcut = made.shortcut().toString(QKeySequence.SequenceFormat.NativeText)
            made.setToolTip(f"{text.rstrip(' …')} ({shortcut})" if shortcut else text)
            tool = bar.widgetForAction(made)
            # Tool buttons are left out of the Tab key's way otherwise.
            tool.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            tool.setAccessibleName(text.rstrip(" …"))
            return made

        action("New", keys.New, self.new)
        action("Open …", keys.Open, self.open)
        action("Save", keys.Save, self.save)
        action("Save as …", "Ctrl+Shift+S", self.save_as)
        bar.addSeparator()
        self.undo_action = action("Undo", keys.Undo, self.editor.undo)
        self.redo_action = action("Redo", "Ctrl+Shift+Z", self.editor.redo)
        bar.addSeparator()
        self.find_action = action("Find on robot …", "Ctrl+R", self.finder.open)
        for number in range(len(_STEPS)):
            QShortcut(
                QKeySequence(f"Ctrl+{number + 1}"), self, lambda at=number: self.show_page(at)
            )
        QShortcut(QKeySequence("F8"), self, self.problems.go_to_next)
        QShortcut(QKeySequence("Ctrl+G"), self, self._show_generate)

    # ── turning pages ──

    def show_page(self, number: int) -> None:
        """Turn to a page, and put the focus on its first field."""
        if 0 <= number < len(_STEPS):
            self.steps.setCurrentRow(number)
            page = self.pages.currentWidget()
            if page is not None:
                _focus_first(page)

    def _turn_page(self, number: int) -> None:
        self.pages.setCurrentIndex(number)
        self.back.setEnabled(number > 0)
        self.next.setEnabled(number < len(_STEPS) - 1)

    def _show_generate(self) -> None:
        self.show_page(len(_STEPS) - 1)
        self.generate.start()

    def go_to(self, node: Place, field: Place) -> None:
        """Show a thing, and put the focus into a field of it, on the page that has it."""
        if field == ("devices",) and not node:
            self.show_page(1)
            return
        if not node:
            self.steps.setCurrentRow(0)
            if self.ai.go_to(field):
                return
        if len(node) == 4 and node[2] == "signals":
            self.steps.setCurrentRow(1)
            if self.sensors.select(node, field):
                return
        self.steps.setCurrentRow(3)
        if not self.devices.select(node, field):
            self._show_message(f"{'.'.join((*node, *field))} is written in the file, not here.")

    # ── the file ──

    def new(self) -> None:
        """Begin a new description."""
        if self._may_close():
            self.editor.replace(self._new_document(), None)

    def open(self) -> None:
        """Ask for a file and open it."""
        if self._may_close():
            name, _ = QFileDialog.getOpenFileName(self, "Open", self._dialog_folder(), _FILTER)
            if name:
                self.open_file(Path(name))

    def open_file(self, file: Path) -> bool:
        """Open a file; false, with what is wrong in it, where it cannot be."""
        try:
            document = open_document(file)
        except DescriptionError as error:
            wrong = opening_problems(file)
            if len(wrong) > _MOST_PROBLEMS:
                wrong[_MOST_PROBLEMS:] = [f"and {len(wrong) - _MOST_PROBLEMS} more"]
            said = "\n".join(wrong) or str(error)
            self._show_message(f"{file.name} cannot be opened: {said}")
            return False
        self._show_message("")
        # A command file of an observatory is only read: what comes of it is saved elsewhere.
        self.editor.replace(document, file if document.opened else None)
        return True

    def save(self) -> bool:
        """Save to the file it is from, or ask for one; false when it was not saved."""
        self._commit_editing()
        if self.editor.file is None:
            return self.save_as()
        # Nothing to write: the file's time stays as it is.
        if self.editor.document.opened and not self.editor.document.is_changed:
            return True
        return self._write_file(self.editor.file)

    def save_as(self) -> bool:
        """Ask for a file and save to it."""
        self._commit_editing()
        start = str(
            self.editor.file or Path(self._dialog_folder()) / f"{self.editor.site.site}.yaml"
        )
        name, _ = QFileDialog.getSaveFileName(self, "Save as", start, _FILTER.split(";;")[0])
        # The dialog has asked whether to write over a file of that name.
        return bool(name) and self._write_file(Path(name), over=True)

    def _write_file(self, file: Path, *, over: bool = False) -> bool:
        try:
            save_document(self.editor.document, file, over=over)
        except FileChanged as error:
            # Asked only now: until the file is compared nobody knows that it was changed.
            sure = self._ask_person(f"{error}. Overwrite it?", QMessageBox.StandardButton.Save)
            return sure is QMessageBox.StandardButton.Save and self._write_file(file, over=True)
        except (NotWritten, DescriptionError) as error:
            self._show_message(str(error))
            return False
        self._show_message("")
        self.editor.file = file
        self.editor.changed.emit()
        return True

    def _dialog_folder(self) -> str:
        return str(self.editor.file.parent if self.editor.file else Path.cwd())

    def _commit_editing(self) -> None:
        """Take in what is being typed: a field tells its value when the focus leaves it."""
        focused = QApplication.focusWidget()
        if focused is not None and self.isAncestorOf(focused):
            # A field commits when the focus leaves it; then it gets it back.
            focused.clearFocus()
            focused.setFocus()

    def _may_close(self) -> bool:
        """Ask about unsaved changes; false to stay."""
        self._commit_editing()
        if not self.editor.document.is_changed:
            return True
        buttons = QMessageBox.StandardButton
        answer = self._ask_person(
            f"Save the changes of {self.editor.site.name}?", buttons.Save | buttons.Discard
        )
        return self.save() if answer is buttons.Save else answer is buttons.Discard

    def _ask_person(
        self, question: str, buttons: QMessageBox.StandardButton
    ) -> QMessageBox.StandardButton:
        return QMessageBox.question(
            self, "Talaia", question, buttons | QMessageBox.StandardButton.Cancel
        )

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802 - Qt's name
        """Ask about changes and about what runs; end what runs."""
        if not self._may_close():
            event.ignore()
            return
        # After the question about changes: who stays for those keeps the dashboard, too.
        if self.generate.run.is_alive:
            buttons = QMessageBox.StandardButton
            question = "The dashboard runs as long as this window. Stop it and close?"
            if self._ask_person(question, buttons.Close) is not buttons.Close:
                event.ignore()
                return
        self.generate.stop_and_wait()
        super().closeEvent(event)

    # ── showing ──

    def paint(self, colours: Colours | None = None) -> None:
        """Take these colours, or those that the machine asks for."""
        colours = colours or asked_for()
        application = QApplication.instance()
        if isinstance(application, QApplication):
            application.setPalette(qt_palette(colours))
            sheet = style_sheet(colours)
            # Every widget is styled anew, which takes a while.
            if application.styleSheet() != sheet:
                application.setStyleSheet(sheet)

    def _show_message(self, text: str) -> None:
        self.notice_text.setText(text)
        self.notice.setVisible(bool(text))
        self.notice.setAccessibleName(text)

    def _show_state(self) -> None:
        document = self.editor.document
        name = self.editor.file.name if self.editor.file else "new description"
        # Qt shows ``[*]`` as a star while the window is modified.
        self.setWindowTitle(f"{self.editor.site.name} — {name}[*] — Talaia")
        self.setWindowModified(document.is_changed)
        for action, word, what in (
            (self.undo_action, "Undo", document.undoes),
            (self.redo_action, "Redo", document.redoes),
        ):
            action.setEnabled(bool(what))
            action.setToolTip(f"{word}: {what}" if what else word)


def _focus_first(page: QWidget) -> None:
    """Put the focus on the first field of a page."""
    first = page.nextInFocusChain()
    while first is not None and first is not page:
        wanted = first.focusPolicy() & Qt.FocusPolicy.TabFocus
        if page.isAncestorOf(first) and first.isEnabled() and first.isVisible() and wanted:
            first.setFocus(Qt.FocusReason.TabFocusReason)
            return
        first = first.nextInFocusChain()
