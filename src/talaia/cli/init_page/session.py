"""One visit to the page: reads the robot, serves the questions, and ends with the answers."""

from __future__ import annotations

import asyncio
import sys
import tempfile
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.cli.init_page.live_values import reading_values
from talaia.cli.init_page.questions import questions_of
from talaia.cli.init_page.server import InitPage, serve_page

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.model.discovery.generate_description import DescriptionProposal
    from talaia.model.discovery.rules.proposal_answers import ProposalAnswers

__all__ = ["ask_in_page"]


def ask_in_page(
    made: DescriptionProposal,
    *,
    output: str,
    domain: int | None,
    finish: Callable[[ProposalAnswers], list[str]],
    browse: bool,
) -> bool:
    """Ask; tells whether it was answered, and not ended by Ctrl-C.

    Args:
        made: what is proposed.
        output: the file that ``finish`` writes.
        domain: of ROS 2; none where it is not spoken.
        finish: see `InitPage`.
        browse: open the browser of this machine.

    """

    async def run() -> None:
        with tempfile.TemporaryDirectory(prefix="talaia-init-") as folder:
            async with reading_values(made.site, Path(folder), domain) as values:
                questions = questions_of(made, output)
                page = InitPage(questions, lambda: values.newest, values.picture_of, finish)
                await serve_page(page, lambda address: _show_address(address, browse=browse))

    try:
        asyncio.run(run())
    except KeyboardInterrupt:
        print("\nnothing was written", file=sys.stderr)
        return False
    return True


def _show_address(address: str, *, browse: bool) -> None:
    print(
        f"Answer in your browser (good once, on this machine): {address}",
        file=sys.stderr,
        flush=True,
    )
    if browse:
        webbrowser.open(address)
