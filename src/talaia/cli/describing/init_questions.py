"""What `talaia init` asks: which devices to take, and of STOP what only the robot's owner knows.

No answer takes all devices and assumes nothing of STOP.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from talaia.model.discovery.ros_units import NO_WORD, word_of
from talaia.model.discovery.rules.stop_choice import (
    ABOUT_STOP,
    StopAnswers,
    question_of_signal,
    question_of_topic,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.model.discovery.generate_description import DescriptionProposal
    from talaia.model.discovery.rules.stop_choice import StopChoice
    from talaia.model.site import Stop

__all__ = ["ask_about_devices", "ask_about_stop", "ask_for_name", "names_called", "stop_lines"]

_YES = ("y", "yes")


def ask_for_name(proposed: str, ask: Callable[[str], str]) -> str:
    """Ask what people call the robot: the name of a machine says little on a page."""
    try:
        return ask(f"What do people call it? (Enter: {proposed}) ").strip() or proposed
    except EOFError:
        return proposed


def names_called(names: tuple[str, str, str], name: str, site: str | None) -> tuple[str, str, str]:
    """Give the names of a site with what people call it, which its short one follows.

    Args:
        names: short name, name and time zone so far.
        name: what people call it; empty as it is.
        site: the short name that was asked for, which stays.

    """
    short = names[0]
    if not site and name not in {"", names[1]}:
        word = word_of(name)[:40].rstrip("_")
        # Of other scripts it keeps nothing.
        short = short if word == NO_WORD else word
    return short, name or names[1], names[2]


def ask_about_devices(made: DescriptionProposal, ask: Callable[[str], str]) -> frozenset[str]:
    """List the devices with what each has, and give the words of those that are not wanted.

    Args:
        made: the description so far.
        ask: shows a question and gives the line that was typed.

    """
    words = tuple(made.site.devices)
    if not words:
        return frozenset()
    print("\nFound:", file=sys.stderr)
    for number, (word, device) in enumerate(made.site.devices.items(), start=1):
        counts = (
            (len(device.signals), "signal"),
            (len(device.streams), "camera"),
            (len(device.commands), "command"),
        )
        said = [f"{count} {name}{'s' if count > 1 else ''}" for count, name in counts if count]
        if device.drive is not None:
            said.append(f"driven by {device.drive.topic or device.drive.message}")
        shown = f"{device.name} ({word})"
        print(f"{number:>3}  {shown:<40} {', '.join(said)}", file=sys.stderr)
    while True:
        try:
            line = ask("Which do you not want? Numbers or words; an empty line takes all: ")
        except EOFError:
            return frozenset()
        named = [word for word in line.replace(",", " ").split() if word]
        chosen = {_device_named(name, words) for name in named}
        if None not in chosen:
            return frozenset(word for word in chosen if word is not None)
        wrong = next(name for name in named if _device_named(name, words) is None)
        print(f"There is no device {wrong}: 1 to {len(words)}, or a word.", file=sys.stderr)


def _device_named(name: str, words: tuple[str, ...]) -> str | None:
    if name.isascii() and name.isdigit():
        return words[int(name) - 1] if 1 <= int(name) <= len(words) else None
    return name if name in words else None


def ask_about_stop(made: DescriptionProposal, ask: Callable[[str], str]) -> StopAnswers:
    """Ask by which topic STOP reaches the robot, what its true means, and what confirms it.

    Args:
        made: the description so far.
        ask: shows a question and gives the line that was typed.

    """
    print(f"\n{ABOUT_STOP}", file=sys.stderr)
    # One topic, for a description has room for one: the first that is meant.
    topic = ""
    topics = dict.fromkeys(name for choice in made.stops for name in choice.topics)
    for name in topics:
        if _is_yes(ask, question_of_topic(name)):
            topic = name
            break
    confirmed: list[str] = []
    for address in dict.fromkeys(one for choice in made.stops for one in choice.signals):
        signal = made.site.signal(address)
        shown = f"{address} ({signal.name})" if signal is not None else address
        if _is_yes(ask, question_of_signal(shown)):
            confirmed.append(address)
    return StopAnswers(topic, tuple(confirmed))


def _is_yes(ask: Callable[[str], str], question: str) -> bool:
    try:
        return ask(f"{question} [y/N] ").strip().lower() in _YES
    except EOFError:
        # Whoever ends the input has nothing more to say.
        return False


def stop_lines(choice: StopChoice, stop: Stop) -> list[str]:
    """Say in a description's first lines what STOP of a device may go by and was not said."""
    lines = [
        f"STOP of {choice.device} sends a velocity of zero. Say under `drive` what else it does:",
        *(
            f"  stop: {{topic: {topic}}} if `true` on it stops the robot (and `false` not)"
            for topic in choice.topics
            if not stop.topic
        ),
    ]
    if choice.signals and not stop.confirmed_by:
        named = ", ".join(choice.signals)
        lines.append(f"  stop: {{confirmed_by: [{named}]}} if these move when the robot moves")
    return lines if len(lines) > 1 else []
