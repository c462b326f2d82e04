"""``talaia get``: the history, as a table or into a file."""

from __future__ import annotations

import json
import math
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from talaia.cli.scripting.hub_options import add_hub_options, hub_parser, open_client, quiet_pipe

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.client.history_reading import HistoryForm

__all__ = ["main"]

# By the ending of the file's name.
_FORMS = {".csv": "csv", ".parquet": "parquet", ".arrow": "arrow", ".arrows": "arrow"}


def main(argv: Sequence[str]) -> int:
    """Print or save a window of the history."""
    parser = hub_parser(
        "get",
        "Read every stored sample of some signals of one site: one row for each time stamp, one"
        " column for each channel.",
    )
    parser.add_argument("signal", nargs="+", help="SITE/DEVICE/SIGNAL")
    parser.add_argument(
        "--since",
        default="1h",
        metavar="TIME",
        help="so long ago (90s, 15m, 2h, 7d), or 2026-05-01T20:00Z (default: 1h)",
    )
    parser.add_argument("--until", default="now", metavar="TIME", help="not included")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="save as .csv, .parquet or .arrow"
    )
    parser.add_argument("--json", action="store_true", help="print a JSON object on each line")
    add_hub_options(parser)
    options = parser.parse_args(argv)
    with quiet_pipe(), open_client(options) as client:
        if options.output is not None:
            form = _FORMS.get(options.output.suffix.lower())
            if form is None:
                from talaia.client import BadSettings

                raise BadSettings(f"{options.output}: expected .csv, .parquet or .arrow")
            size = client.save_history(
                options.output,
                options.signal,
                options.since,
                options.until,
                form=cast("HistoryForm", form),
            )
            print(f"{options.output}: {size} bytes")
            return 0
        headed = options.json
        for batch in client.stream_history(options.signal, options.since, options.until):
            names = list(batch.schema.names)
            if not headed:
                print("  ".join(_padded(name, names[at]) for at, name in enumerate(names)))
                headed = True
            for row in batch.to_pylist():
                print(_json_row(row) if options.json else _text_row(row, names))
    return 0


def _text_row(row: dict[str, Any], names: list[str]) -> str:
    return "  ".join(_padded(_cell_text(row[name]), name) for name in names).rstrip()


def _padded(text: str, name: str) -> str:
    return text.ljust(max(len(name), 26 if name == "time" else 12))


def _cell_text(value: Any) -> str:  # noqa: ANN401 - a cell of any column
    if value is None:
        return ""
    if isinstance(value, datetime):
        return value.isoformat(timespec="milliseconds").replace("+00:00", "Z")
    if isinstance(value, float):
        return f"{value:.9g}"
    # One line for each row, whatever a robot said.
    return "".join(letter if letter.isprintable() else "�" for letter in str(value))


def _json_row(row: dict[str, Any]) -> str:
    def plain(value: Any) -> object:  # noqa: ANN401 - a cell of any column
        if isinstance(value, datetime):
            return value.isoformat()
        return None if isinstance(value, float) and not math.isfinite(value) else value

    return json.dumps({name: plain(value) for name, value in row.items()}, ensure_ascii=False)
