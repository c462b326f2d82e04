"""Find on robot: run a probe here or over ssh, and bring what it found into the description."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QElapsedTimer, QTimer
from PySide6.QtWidgets import (
    QButtonGroup,
    QDialog,
    QGridLayout,
    QLabel,
    QLineEdit,
    QMessageBox,
    QPlainTextEdit,
    QProgressBar,
    QRadioButton,
    QVBoxLayout,
    QWidget,
)

from talaia.configurator.errors import BadHost
from talaia.configurator.merge import merge_findings
from talaia.configurator.qt.palette import SPACE
from talaia.configurator.qt.process import Process
from talaia.configurator.qt.widgets import (
    Number,
    make_button,
    make_label,
    make_output_label,
    make_row,
    mark_wrong,
)
from talaia.configurator.robot_discovery import (
    SECONDS,
    DiscoveryPhase,
    RobotDiscovery,
    probe_command,
)
from talaia.model.discovery.rules.stop_choice import (
    ABOUT_STOP,
    StopAnswers,
    question_of_signal,
    question_of_topic,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from PySide6.QtGui import QCloseEvent

    from talaia.configurator.merge import Merged
    from talaia.configurator.qt.editor import Editor

__all__ = ["FindDialog"]


class FindDialog(QDialog):
    """Where to look, how far it is, and what came of it."""

    def __init__(self, editor: Editor, talaia: Sequence[str], parent: QWidget | None) -> None:
        """Be told how Talaia is started here."""
        super().__init__(parent)
        self.setWindowTitle("Find on robot")
        self.setMinimumWidth(560)
        self._editor, self._talaia = editor, tuple(talaia)
        # Asks a person a question that is answered by yes or no.
        self.confirm: Callable[[str], bool] = self._ask_question
        # What has come of the search; the process below only brings it words.
        self.look = RobotDiscovery()
        # Apart, not together: the output must be JSON, whatever ssh says beside it.
        self._process = Process(self, together=False)
        self._process.ended.connect(self._on_ended)
        self._process.not_started.connect(self._not_started)
        # Monotonic: the bar must not jump with the machine's clock.
        self._since = QElapsedTimer()
        # Moves the bar (ms) while a probe runs.
        self._tick = QTimer(self, interval=100)
        self._tick.timeout.connect(self._show_progress)
        body = QVBoxLayout(self)
        body.setSpacing(SPACE[1])
        body.addWidget(
            make_label(
                "Lists the topics, services, actions and cameras of a robot that is running, and "
                "fills in what the description does not have yet. It only listens.",
                "muted",
                wrap=True,
            )
        )
        body.addWidget(self._make_target_fields())
        self.bar = QProgressBar(maximum=1000, textVisible=False)
        self.bar.setAccessibleName("Progress")
        body.addWidget(self.bar)
        self.told = make_output_label("")
        body.addWidget(self.told)
        self.problem = make_output_label("bad")
        body.addWidget(self.problem)
        self.left_out = QPlainTextEdit(readOnly=True)
        self.left_out.setAccessibleName("Left out, and why")
        self.left_out.setTabChangesFocus(True)
        self.left_out.setFixedHeight(110)
        self.left_out.hide()
        body.addWidget(self.left_out)
        self.start_button = make_button("&Look", self.start, "main")
        self.start_button.setDefault(True)
        self.close_button = make_button("Close", self.close)
        body.addLayout(make_row(1, self.close_button, self.start_button))
        self._show_phase()

    def _make_target_fields(self) -> QWidget:
        self.here = QRadioButton("On &this machine")
        self.there = QRadioButton("On the &robot, over ssh")
        choice = QButtonGroup(self)
        choice.addButton(self.here)
        choice.addButton(self.there)
        self.here.setChecked(True)
        self.host = QLineEdit(placeholderText="user@robot.local")
        self.host.setAccessibleName("Robot's computer, user@name")
        self.program = QLineEdit("talaia")
        self.program.setAccessibleName("The talaia program there")
        self.program.setToolTip("its whole path where a plain ssh command does not find it")
        self.seconds = Number(1, 600, int(SECONDS), " s")
        self.seconds.setAccessibleName("How long to listen, in seconds")
        self.there.toggled.connect(lambda _: self._show_phase())
        inner = QWidget()
        grid = QGridLayout(inner)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setColumnStretch(1, 1)
        grid.addWidget(self.here, 0, 0, 1, 2)
        grid.addWidget(self.there, 1, 0, 1, 2)
        fields: tuple[tuple[str, QWidget], ...] = (
            ("&Computer", self.host),
            ("&Program there", self.program),
            ("L&isten for", self.seconds),
        )
        for number, (text, widget) in enumerate(fields, 2):
            title = QLabel(text)
            title.setBuddy(widget)
            grid.addWidget(title, number, 0)
            grid.addWidget(widget, number, 1)
        self._choices = inner
        return inner

    # ── what happens ──

    def start(self) -> None:
        """Look, or say why that cannot be asked."""
        # A blank name is no computer; an empty one would be this machine.
        host = (self.host.text().strip() or " ?") if self.there.isChecked() else ""
        mark_wrong(self.host, wrong=False)
        try:
            words = probe_command(
                self._talaia, host, self.program.text().strip(), self.seconds.value()
            )
        except BadHost as error:
            mark_wrong(self.host, wrong=True)
            self._show_message("", str(error))
            self.host.setFocus()
            return
        self._show_message("Looking …", "")
        self.left_out.hide()
        # Before the process: it may fail to start at once, and that must find a search that runs.
        self.look.mark_started(host, self.seconds.value())
        self._since.start()
        self._tick.start()
        self._show_phase()
        self._process.start(words)

    def cancel(self) -> None:
        """End the look; nothing is changed."""
        if self.look.phase is DiscoveryPhase.RUNNING:
            self.look.mark_cancelled()
            self._process.stop()
            self._show_phase()

    def reject(self) -> None:
        """Cancel on Escape while looking; close else."""
        if self.look.phase is DiscoveryPhase.RUNNING:
            self.cancel()
        elif self.look.phase is not DiscoveryPhase.CANCELLING:
            super().reject()

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802 - Qt's name
        """A look does not go on behind a closed window."""
        if self._process.is_running:
            self.cancel()
            event.ignore()
            return
        super().closeEvent(event)

    def _show_progress(self) -> None:
        self.bar.setValue(int(1000 * self.look.expected_progress(self._since.elapsed() / 1000)))

    def _not_started(self) -> None:
        program = "ssh" if self.there.isChecked() else self._talaia[0]
        self.look.not_started(program)
        self._finish_search()

    def _on_ended(self, code: int, said: bytes, complained: str) -> None:
        self.look.handle_exit(code, said, complained)
        self._finish_search()

    def _finish_search(self) -> None:
        self._tick.stop()
        self._show_phase()
        if self.look.phase is DiscoveryPhase.CANCELLED:
            self._show_message("Cancelled; nothing was changed.", "")
        elif self.look.phase is DiscoveryPhase.FAILED:
            self._show_message("", self.look.problem)
        elif self.look.found is not None:
            # Into the site as it is now: the person may have changed it while the probe ran.
            site, found = self._editor.site, self.look.found
            answers = self._ask_about_stop(merge_findings(site, found))
            result = merge_findings(site, found, answers)
            # One step, so that one undo takes all of it back.
            self._editor.apply("find on robot", lambda _: result.site)
            self._show_message(_summary_text(result), "")
            self.left_out.setPlainText("Left out:\n" + "\n".join(result.left_out))
            self.left_out.setVisible(bool(result.left_out))
            self.close_button.setFocus()

    def _ask_about_stop(self, result: Merged) -> StopAnswers:
        """Ask what only the robot's owner knows; neither topic nor polarity is assumed."""
        topics = dict.fromkeys(name for stop in result.stops for name in stop.topics)
        # A description has room for one topic: the first that is meant.
        topic = next((name for name in topics if self.confirm(question_of_topic(name))), "")
        signals = dict.fromkeys(one for stop in result.stops for one in stop.signals)
        confirmed = [one for one in signals if self.confirm(question_of_signal(one))]
        return StopAnswers(topic, tuple(confirmed))

    def _ask_question(self, question: str) -> bool:
        buttons = QMessageBox.StandardButton.Yes | QMessageBox.StandardButton.No
        # Return and Escape both say no: a yes is never an accident.
        no = QMessageBox.StandardButton.No
        asked = QMessageBox.question(self, "STOP", f"{ABOUT_STOP}\n\n{question}", buttons, no)
        return asked is QMessageBox.StandardButton.Yes

    def _show_phase(self) -> None:
        busy = self.look.phase in (DiscoveryPhase.RUNNING, DiscoveryPhase.CANCELLING)
        over = self.there.isChecked()
        self._choices.setEnabled(not busy)
        self.host.setEnabled(over)
        self.program.setEnabled(over)
        self.start_button.setEnabled(not busy)
        self.close_button.setText("Cancel" if busy else "Close")
        self.close_button.setAccessibleName(self.close_button.text())
        self.bar.setVisible(busy)

    def _show_message(self, told: str, problem: str) -> None:
        self.told.setText(told)
        self.told.setVisible(bool(told))
        self.problem.setText(problem)
        self.problem.setVisible(bool(problem))


def _summary_text(result: Merged) -> str:
    if not result.added:
        return f"Nothing new: all {result.known} things that were found are described already."
    names = {"signals": "sensors", "streams": "cameras", "commands": "commands"}
    counts = [f"{n} {name}" for key, name in names.items() if (n := result.count(key))]
    if any(path[-1] == "drive" for path in result.added):
        counts.append("driving (at a careful speed)")
    known = f" {result.known} were described already." if result.known else ""
    return f"Added {', '.join(counts)}.{known} Undo reverts it."
