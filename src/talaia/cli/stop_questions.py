"""What `talaia init` asks of STOP: nobody but the robot's owner knows it. No answer is none."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from talaia.model.discovery.rules.stop_choice import StopAnswers

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.model.discovery.generate_description import DescriptionProposal
    from talaia.model.discovery.rules.stop_choice import StopChoice

__all__ = ["ask_about_stop", "stop_lines"]

_YES = ("y", "yes")


def ask_about_stop(made: DescriptionProposal, ask: Callable[[str], str]) -> StopAnswers:
    """Ask by which topic STOP reaches the robot, what its true means, and what confirms it.

    Args:
        made: the description so far.
        ask: shows a question and gives the line that was typed.

    """
    print(
        "\nSTOP always sends a velocity of zero. What else it does, only you know; an empty line "
        "means no.",
        file=sys.stderr,
    )
    # One topic, for a description has room for one: the first that is meant.
    topic = ""
    topics = dict.fromkeys(name for choice in made.stops for name in choice.topics)
    for name in topics:
        if _is_yes(
            ask, f"{name} listens. Does `true` on it stop the robot, and `false` let it go?"
        ):
            topic = name
            break
    confirmed: list[str] = []
    for address in dict.fromkeys(one for choice in made.stops for one in choice.signals):
        signal = made.site.signal(address)
        shown = f"{address} ({signal.name})" if signal is not None else address
        question = (
            f"Have you seen {shown} move while the robot moves, and stand at 0 when it stands?"
        )
        if _is_yes(ask, question):
            confirmed.append(address)
    return StopAnswers(topic, tuple(confirmed))


def _is_yes(ask: Callable[[str], str], question: str) -> bool:
    try:
        return ask(f"{question} [y/N] ").strip().lower() in _YES
    except EOFError:
        # Whoever ends the input has nothing more to say.
        return False


def stop_lines(choice: StopChoice) -> list[str]:
    """Say in a description's first lines what STOP of a device may go by."""
    lines = [
        f"STOP of {choice.device} sends a velocity of zero. Say under `drive` what else it does:",
        *(
            f"  stop: {{topic: {topic}}} if `true` on it stops the robot (and `false` not)"
            for topic in choice.topics
        ),
    ]
    if choice.signals:
        named = ", ".join(choice.signals)
        lines.append(f"  stop: {{confirmed_by: [{named}]}} if these move when the robot moves")
    return lines if len(lines) > 1 else []
