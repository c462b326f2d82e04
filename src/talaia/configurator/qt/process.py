"""A process whose lines and end are told as Qt signals."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QProcess, QProcessEnvironment, QTimer, Signal

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

__all__ = ["Process"]

# Hub and gateway have five seconds each to end in order.
PATIENCE_MS = 12_000


class Process(QObject):
    """One process at a time; its words are a list, and no shell sees them.

    Signals:
        said: a line of its output, and of its errors where they are ``together``.
        ended: exit code, and all output and errors that were not told line by line.
        not_started: the program could not be started.

    """

    said = Signal(str)
    ended = Signal(int, bytes, str)
    not_started = Signal()

    def __init__(self, parent: QObject, *, together: bool) -> None:
        """Choose whether lines are told as they come, or all is kept until the end."""
        super().__init__(parent)
        # Whether errors come among the lines, as a log shows them, or apart, beside JSON.
        self._together = together
        # The same object for every run; Qt's signals come on the window's thread.
        self._process = QProcess(self)
        if together:
            self._process.setProcessChannelMode(QProcess.ProcessChannelMode.MergedChannels)
            self._process.readyReadStandardOutput.connect(self._read_output)
        self._process.finished.connect(self._on_finished)
        self._process.errorOccurred.connect(self._on_failed)
        # Runs from `stop` on; ended by the process's end.
        self._end = QTimer(self, singleShot=True, interval=PATIENCE_MS)
        self._end.timeout.connect(self._process.kill)

    @property
    def is_running(self) -> bool:
        """Whether there is a process."""
        return self._process.state() is not QProcess.ProcessState.NotRunning

    def start(self, words: Sequence[str], more: Mapping[str, str] | None = None) -> None:
        """Start it; the first word is the program, ``more`` what its environment has besides."""
        environment = QProcessEnvironment.systemEnvironment()
        # Python holds output to a pipe back otherwise, and the log would come in blocks.
        for name, value in {"PYTHONUNBUFFERED": "1", **(more or {})}.items():
            environment.insert(name, value)
        self._process.setProcessEnvironment(environment)
        # Nothing may wait for an answer that nobody can type.
        self._process.setStandardInputFile(QProcess.nullDevice())
        self._process.start(words[0], list(words[1:]))

    def stop(self) -> None:
        """Ask it to end, and end it when it does not."""
        # SIGTERM, which `talaia up` takes for Ctrl-C.
        self._process.terminate()
        self._end.start()

    def wait(self) -> None:
        """Stand still until it has ended; for the window's last moment."""
        if not self._process.waitForFinished(PATIENCE_MS):
            self._process.kill()
            self._process.waitForFinished(PATIENCE_MS)

    def _read_output(self) -> None:
        while self._process.canReadLine():
            line = bytes(self._process.readLine().data())
            self.said.emit(line.decode(errors="replace").rstrip("\r\n"))

    def _on_finished(self, code: int, status: QProcess.ExitStatus) -> None:
        self._end.stop()
        if self._together:
            self._read_output()
            # A last line without an end, as of a program that was killed.
            if rest := bytes(self._process.readAll().data()):
                self.said.emit(rest.decode(errors="replace").rstrip())
            out, errors = b"", ""
        else:
            out = bytes(self._process.readAllStandardOutput().data())
            errors = bytes(self._process.readAllStandardError().data()).decode(errors="replace")
        # A crash has no exit code; Qt's number is none.
        self.ended.emit(-1 if status is QProcess.ExitStatus.CrashExit else code, out, errors)

    def _on_failed(self, error: QProcess.ProcessError) -> None:
        # A crash is told by `finished`, too.
        if error is QProcess.ProcessError.FailedToStart:
            self.not_started.emit()
