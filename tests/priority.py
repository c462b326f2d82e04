"""Gives work that gives way to all other work its turn: beside tests it would stand still."""

from __future__ import annotations

import contextlib
import os

import psutil


def let_children_run(pid: int) -> None:
    """Give all threads of a process's children the priority of this one, where one may."""
    with contextlib.suppress(PermissionError, ProcessLookupError, psutil.NoSuchProcess):
        for child in psutil.Process(pid).children():
            let_run(child)


def let_run(process: psutil.Process) -> None:
    """Give all threads of a process the priority of this one, where one may."""
    with contextlib.suppress(PermissionError, ProcessLookupError, psutil.NoSuchProcess):
        for thread in process.threads():
            os.sched_setscheduler(thread.id, os.SCHED_OTHER, os.sched_param(0))
            os.setpriority(os.PRIO_PROCESS, thread.id, os.getpriority(os.PRIO_PROCESS, 0))
