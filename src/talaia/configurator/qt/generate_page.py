"""Last page: start everything here and open the dashboard, or write a deployment.

Long, because both cards start a process, and share its phases, its problem and one log.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtWidgets import (
    QCheckBox,
    QFileDialog,
    QGridLayout,
    QLabel,
    QLineEdit,
    QPlainTextEdit,
    QProgressBar,
    QSizePolicy,
    QWidget,
)

from talaia.configurator.program_run import (
    MAX_LINES,
    ProgramPhase,
    ProgramRun,
    deploy_command,
    up_command,
)
from talaia.configurator.qt.database_choice import DATABASE_NAMES, DatabaseChoice
from talaia.configurator.qt.palette import SPACE
from talaia.configurator.qt.process import Process
from talaia.configurator.qt.widgets import (
    Card,
    ComboBox,
    Page,
    make_button,
    make_label,
    make_output_label,
    make_row,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from talaia.configurator.qt.editor import Editor

__all__ = ["GeneratePage"]


class GeneratePage(Page):
    """Two ways from a description to something that runs, and the log of what was started."""

    def __init__(
        self,
        editor: Editor,
        *,
        talaia: Sequence[str],
        save: Callable[[], bool],
        open_page: Callable[[str], None],
        data: str = "",
    ) -> None:
        """Take what is needed.

        Args:
            editor: the open document.
            talaia: how Talaia is started here: the interpreter and its arguments.
            save: saves the document, asking where to if need be; false when it did not.
            open_page: opens an address in the browser.
            data: folder of accounts and history; empty for the usual one.

        """
        super().__init__("Generate", "Save the description and start everything that it needs.")
        self._editor, self._talaia, self._save = editor, tuple(talaia), save
        self._open_page, self._data = open_page, data
        # What has come of the site that runs here, and of the deployment that is written.
        self.run, self.made = ProgramRun(), ProgramRun()
        # Their processes; the two may run at the same time.
        self._site = self._connect_process(self.run)
        self._deploy = self._connect_process(self.made)
        self.body.addWidget(self._make_run_card())
        self.body.addWidget(self._make_deployment_card())
        self.log = QPlainTextEdit(readOnly=True, maximumBlockCount=MAX_LINES)
        self.log.setAccessibleName("Log")
        self.log.setPlaceholderText("Output of the started programs.")
        self.log.setTabChangesFocus(True)
        self.log.setMinimumHeight(110)
        self.log.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Ignored)
        self.body.addWidget(self.log, 1)
        editor.changed.connect(self.show_state)
        self.show_state()

    def _connect_process(self, run: ProgramRun) -> Process:
        process = Process(self, together=True)
        process.said.connect(lambda line: self._show_line(run, line))
        process.ended.connect(lambda code, _out, _errors: self._on_ended(run, code))
        process.not_started.connect(lambda: self._not_started(run))
        return process

    def _make_run_card(self) -> QWidget:
        card = Card("Start it on this machine")
        card.body.addWidget(
            make_label(
                "The hub with accounts, tables and history, and the gateway to the robot; the "
                "dashboard opens in your browser.",
                "muted",
                wrap=True,
            )
        )
        self.start_button = make_button("&Generate", self.start, "main")
        self.stop_button = make_button("S&top", self.stop)
        self.open_button = make_button("Open &dashboard", self.open_dashboard)
        self.local_database = DatabaseChoice(os.environ)
        card.body.addWidget(self.local_database)
        card.body.addLayout(make_row(self.start_button, self.open_button, self.stop_button, 1))
        self.bar = QProgressBar(textVisible=False, maximum=0)
        self.bar.setAccessibleName("Starting")
        card.body.addWidget(self.bar)
        self.state = make_label("", "muted", wrap=True)
        card.body.addWidget(self.state)
        self.problem = make_output_label("bad")
        card.body.addWidget(self.problem)
        return card

    def _make_deployment_card(self) -> QWidget:
        card = Card("Make a deployment")
        card.body.addWidget(
            make_label(
                "A folder with containers for a server, and systemd units for the robot's own "
                "computer. No default password.",
                "muted",
                wrap=True,
            )
        )
        self.folder = QLineEdit(placeholderText="a new folder")
        self.folder.setAccessibleName("Folder of the deployment")
        self.database = ComboBox()
        for word, name in DATABASE_NAMES.items():
            self.database.addItem(name, word)
        self.database.setAccessibleName("Database of the deployment")
        self.over = QCheckBox("&Overwrite existing files")
        self.over.setToolTip("secrets are kept")
        self.make_button = make_button("&Make deployment", self.make)
        grid = QGridLayout()
        grid.setHorizontalSpacing(SPACE[1])
        grid.setColumnStretch(0, 3)
        grid.setColumnStretch(2, 2)
        for column, text, widget in ((0, "&Folder", self.folder), (2, "D&atabase", self.database)):
            title = QLabel(text)
            title.setBuddy(widget)
            grid.addWidget(title, 0, column)
            grid.addWidget(widget, 1, column)
        grid.addWidget(make_button("&Choose …", self._choose_folder), 1, 1)
        grid.addWidget(self.make_button, 1, 3)
        grid.addWidget(self.over, 2, 0, 1, 2)
        card.body.addLayout(grid)
        self.made_state = make_label("", "ok", wrap=True)
        card.body.addWidget(self.made_state)
        self.made_problem = make_output_label("bad")
        card.body.addWidget(self.made_problem)
        return card

    # ── starting ──

    def start(self) -> None:
        """Save, and start hub and gateway; what runs already is started anew."""
        # In this order: a dialog for the file is opened only when it can start.
        environment = self.local_database.environment()
        if environment is None and not self.run.is_alive:
            self.problem.setText("write the database server as user@host/database")
            self.problem.show()
            self.local_database.address.setFocus()
            return
        if self._editor.document.problems or self.run.is_alive or not self._save():
            self.show_state()
            return
        words = up_command(self._talaia, str(self._editor.file), self._data)
        self._begin_run(self.run, self._site, words, environment)

    def stop(self) -> None:
        """End hub and gateway; stored data is kept."""
        if self.run.phase in (ProgramPhase.STARTING, ProgramPhase.UP):
            self.run.stop()
            self._site.stop()
            self.show_state()

    def stop_and_wait(self) -> None:
        """End hub and gateway before the window goes."""
        for run, process in ((self.run, self._site), (self.made, self._deploy)):
            if run.is_alive:
                # Else it was asked to end already, and is only waited for.
                if run.phase is not ProgramPhase.STOPPING:
                    run.stop()
                    process.stop()
                process.wait()

    def make(self) -> None:
        """Save, and write the deployment's folder."""
        if self._editor.document.problems or self.made.is_alive:
            return
        folder = self.folder.text().strip()
        if not folder:
            self.made_problem.setText("choose a folder first")
            self.made_problem.show()
            self.folder.setFocus()
            return
        if not self._save():
            return
        words = deploy_command(
            self._talaia,
            str(self._editor.file),
            str(Path(folder).expanduser()),
            self.database.currentData(),
            over=self.over.isChecked(),
        )
        self._begin_run(self.made, self._deploy, words)

    def open_dashboard(self) -> None:
        """Open the browser, at the first admin's page where there is nobody yet."""
        if self.run.phase is ProgramPhase.UP:
            self._open_page(self.run.page)

    def _begin_run(
        self,
        run: ProgramRun,
        process: Process,
        words: list[str],
        environment: Mapping[str, str] | None = None,
    ) -> None:
        # Before the process: it may fail to start at once, and that must find a run that starts.
        run.start(words)
        self.log.appendPlainText(f"$ {run.lines[0]}")
        process.start(words, environment)
        self.show_state()

    def _show_line(self, run: ProgramRun, line: str) -> None:
        before = run.phase
        run.add_line(line)
        if line.strip():
            self.log.appendPlainText(line)
        if run.phase is not before:
            self.show_state()
            # The only change of phase by a line is that the site is up.
            if run is self.run:
                self.open_button.setFocus()
                self.open_dashboard()

    def _on_ended(self, run: ProgramRun, code: int) -> None:
        run.handle_exit(code)
        self.show_state()

    def _not_started(self, run: ProgramRun) -> None:
        run.not_started(self._talaia[0])
        self.show_state()

    def _choose_folder(self) -> None:
        folder = QFileDialog.getExistingDirectory(self, "Folder of the deployment")
        if folder:
            self.folder.setText(folder)

    # ── showing ──

    def show_state(self) -> None:
        """Show what runs, and what stands in the way."""
        problems = len(self._editor.document.problems)
        phase = self.run.phase
        self.start_button.setEnabled(not problems and not self.run.is_alive)
        self.make_button.setEnabled(not problems and not self.made.is_alive)
        self.stop_button.setEnabled(phase in (ProgramPhase.STARTING, ProgramPhase.UP))
        self.open_button.setEnabled(phase is ProgramPhase.UP)
        self.bar.setVisible(phase in (ProgramPhase.STARTING, ProgramPhase.STOPPING))
        if problems and not self.run.is_alive:
            few = "1 problem stands" if problems == 1 else f"{problems} problems stand"
            self.state.setText(f"{few} in the way; they are listed below.")
        else:
            self.state.setText(_TOLD[phase].format(self.run.address))
        self._show_problem(self.problem, self.run)
        self._show_problem(self.made_problem, self.made)
        self.made_state.setText(
            f"Written to {self.folder.text().strip()}; README.md there says how to start."
            if self.made.phase is ProgramPhase.ENDED
            else ""
        )
        self.made_state.setVisible(bool(self.made_state.text()))

    def _show_problem(self, where: QLabel, run: ProgramRun) -> None:
        where.setText(run.problem if run.phase is ProgramPhase.FAILED else "")
        where.setVisible(bool(where.text()))


_TOLD = {
    ProgramPhase.IDLE: "",
    ProgramPhase.STARTING: "Starting the hub and the gateway …",
    ProgramPhase.UP: (
        "Running: {}. To apply changes of the description, press Stop and then Generate."
    ),
    ProgramPhase.STOPPING: "Stopping …",
    ProgramPhase.ENDED: "Stopped. Stored data is kept.",
    ProgramPhase.FAILED: "It is not running.",
}
