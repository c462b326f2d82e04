"""``talaia watch``: live values, a line for each."""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING

from talaia.cli.scripting.hub_options import add_hub_options, hub_parser, open_client, quiet_pipe

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.client import Reading

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Print values until Ctrl-C, or once."""
    parser = hub_parser(
        "watch",
        "Print live values, a line for each as it comes, the newest known ones first. What is no"
        " longer to be believed is printed once more, as STALE and with the reason.",
    )
    parser.add_argument(
        "signal", nargs="+", help="SITE/DEVICE/SIGNAL; * and ? stand for other letters"
    )
    parser.add_argument("--once", action="store_true", help="print what is known now, and end")
    parser.add_argument(
        "--every",
        type=float,
        default=0.1,
        metavar="SECONDS",
        help="at most so often for each, spikes kept (default: 0.1; 0: every sample)",
    )
    parser.add_argument("--json", action="store_true", help="print a JSON object on each line")
    add_hub_options(parser)
    options = parser.parse_args(argv)
    show = _as_json if options.json else _as_text
    with quiet_pipe(), open_client(options) as client:
        if options.once:
            for reading in client.read_values(options.signal):
                print(show(reading))
            return 0
        for reading in client.watch_values(
            options.signal, every_s=options.every, report=_print_report
        ):
            # One by one: whoever reads a pipe waits for them.
            print(show(reading), flush=True)
    return 0


def _print_report(text: str) -> None:
    print(f"talaia watch: {text}", file=sys.stderr, flush=True)


def _as_text(reading: Reading) -> str:
    value = reading.value if isinstance(reading.value, str) else f"{reading.value:.9g}"
    when = reading.time.astimezone().strftime("%H:%M:%S.%f")[:-3]
    stale = f"  STALE: {reading.stale}" if reading.stale else ""
    # One line for each, whatever a robot says.
    return f"{when}  {reading.address}  {_one_line(f'{value} {reading.unit}')}{stale}"


def _as_json(reading: Reading) -> str:
    import msgspec

    value = reading.value
    # JSON has no word for what is not a number.
    shown = None if isinstance(value, float) and not math.isfinite(value) else value
    return msgspec.json.encode({**reading._asdict(), "value": shown}).decode()


def _one_line(text: str) -> str:
    return "".join(letter if letter.isprintable() else "�" for letter in text.strip())
