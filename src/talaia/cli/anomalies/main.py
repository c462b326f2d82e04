"""``talaia anomalies backtest``: what a detector would have said of a table's rows."""

from __future__ import annotations

import csv
import sys
from typing import TYPE_CHECKING, TextIO
from zoneinfo import ZoneInfo

import numpy as np

from talaia.cli.anomalies.judges import RowVerdict, make_judge
from talaia.cli.anomalies.signal_rows import SignalRows
from talaia.cli.errors import BadRows, CliError
from talaia.cli.scripting.hub_options import quiet_pipe

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from talaia.cli.anomalies.judges import RowJudge
    from talaia.cli.anomalies.signal_rows import MeasuredRow

__all__ = ["judge_table"]

# So many rows are judged at once: detectors are many times faster so.
_BLOCK = 512


def judge_table(options: argparse.Namespace) -> int:
    """Judge a table and print what is said of it; 0: it was judged."""
    rows = SignalRows(
        options.file,
        time_column=options.time,
        chosen=options.signals or (),
        ignored=options.ignore,
        zone=_find_zone(options.zone),
    )
    try:
        judge = make_judge(options.detector, rows.signals, options.learn_rows)
        if rows.left_out:
            print(f"not looked at: {', '.join(rows.left_out)}", file=sys.stderr)
        judging = _Judging(options.file, judge, options.learn_rows)
        with quiet_pipe():
            said = judging.judge_rows(rows.read_rows())
            (_print_rows if options.rows else _print_anomalies)(said, sys.stdout)
            judging.check_end()
    finally:
        rows.close()
    return 0


class _Judging:
    """Passes rows to a judge, and counts what was odd about them."""

    def __init__(self, file: Path, judge: RowJudge, learn_rows: int) -> None:
        self._file, self._judge, self._learn_rows = file, judge, learn_rows
        self._count = self._not_newer = 0

    def judge_rows(self, rows: Iterator[MeasuredRow]) -> Iterator[tuple[MeasuredRow, RowVerdict]]:
        newest_us, verdict = None, RowVerdict(0.0, anomalous=False, signals=[])
        for some in _in_blocks(rows):
            newer: list[MeasuredRow] = []
            for row in some:
                if newest_us is None or row.time_us > newest_us:
                    newest_us = row.time_us
                    newer.append(row)
            judged = self._judge_newer(newer)
            self._count += len(some)
            self._not_newer += len(some) - len(newer)
            if len(newer) == len(some):
                # As nearly always, and in a third of the time.
                yield from zip(some, judged, strict=True)
                verdict = judged[-1] if judged else verdict
                continue
            said, left = iter(judged), iter(newer)
            awaited = next(left, None)
            for row in some:
                # As at the hub: what comes late is not looked at. The row's line says the last.
                if row is awaited:
                    verdict, awaited = next(said), next(left, None)
                yield row, verdict

    def _judge_newer(self, rows: Sequence[MeasuredRow]) -> list[RowVerdict]:
        if not rows:
            return []
        times = np.array([row.time_us for row in rows])
        return self._judge.judge_rows(times, np.array([row.values for row in rows]))

    def check_end(self) -> None:
        """Tell what a person should know of the rows that were read."""
        sys.stdout.flush()
        if self._not_newer:
            print(
                f"{self._not_newer} rows are not newer than the row before them and were not looked"
                " at; sort the file by its times",
                file=sys.stderr,
            )
        looked = self._count - self._not_newer
        if looked <= self._learn_rows:
            raise BadRows(
                str(self._file),
                "",
                f"expected more than the {self._learn_rows} rows to learn from, found {looked}:"
                " nothing was judged",
                "learn from fewer with --learn-rows",
            )


def _in_blocks(rows: Iterator[MeasuredRow]) -> Iterator[list[MeasuredRow]]:
    """Give rows so many at a time; those before one that cannot be read, and then raise."""
    some: list[MeasuredRow] = []
    try:
        for row in rows:
            some.append(row)
            if len(some) == _BLOCK:
                yield some
                some = []
    except BadRows:
        yield some
        raise
    yield some


def _print_rows(said: Iterator[tuple[MeasuredRow, RowVerdict]], out: TextIO) -> None:
    table = csv.writer(out, lineterminator="\n")
    table.writerow(("time", "score", "anomalous", "signals"))
    table.writerows(
        (row.time, f"{verdict.score:.4f}", int(verdict.anomalous), "; ".join(verdict.signals))
        for row, verdict in said
    )


def _print_anomalies(said: Iterator[tuple[MeasuredRow, RowVerdict]], out: TextIO) -> None:
    table = csv.writer(out, lineterminator="\n")
    table.writerow(("began", "ended", "rows", "score", "signals"))
    began, ended, count, worst = "", "", 0, RowVerdict(0.0, anomalous=False, signals=[])
    for row, verdict in said:
        if verdict.anomalous:
            # The signals are those of its worst row: at its beginning little is to be seen yet.
            worst = verdict if not count or verdict.score > worst.score else worst
            began, ended, count = began if count else row.time, row.time, count + 1
        elif count:
            signals = "; ".join(worst.signals)
            table.writerow((began, ended, count, f"{worst.score:.4f}", signals))
            count = 0
    if count:
        table.writerow((began, ended, count, f"{worst.score:.4f}", "; ".join(worst.signals)))


def _find_zone(name: str) -> ZoneInfo:
    try:
        return ZoneInfo(name)
    except (KeyError, ValueError, OSError) as error:
        raise CliError(
            f"--zone: expected a zone like Europe/Madrid or UTC, found {name!r}"
        ) from error
