"""Finding a signal, a command or an argument by the words of its id and name. Pure."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from talaia.model.site import ArgumentType

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.model.site import Argument, Command, Signal

__all__ = ["argument_with", "first_named", "first_of", "has_word", "is_number", "signals_that"]

# For ``\W`` an underscore is a letter, hence beside it.
_NO_WORD = re.compile(r"[\W_]+")


def _words_of(name: str, title: str) -> frozenset[str]:
    return frozenset(_NO_WORD.split(f"{name} {title}".lower()))


def has_word(name: str, title: str, *words: str) -> bool:
    """Tell whether an id or a name has one of these words."""
    return not _words_of(name, title).isdisjoint(words)


def argument_with(command: Command, *words: str) -> str:
    """Name the first argument whose id or name has one of these words; empty for none."""
    return next(
        (
            name
            for name, argument in command.arguments.items()
            if has_word(name, argument.name or name, *words)
        ),
        "",
    )


def is_number(argument: Argument) -> bool:
    """Tell whether it is a number, whole or not."""
    return argument.type in {ArgumentType.NUMBER, ArgumentType.INTEGER}


def first_named(signals: Mapping[str, Signal], *words: str) -> str | None:
    """Name the first whose id is one of these words, or else whose words have one."""
    by_id = next((name for name in signals if name in words), None)
    return by_id or next(
        (name for name, signal in signals.items() if has_word(name, signal.name, *words)), None
    )


def first_of(signals: Mapping[str, Signal]) -> str | None:
    """Name the first."""
    return next(iter(signals), None)


def signals_that(
    signals: Mapping[str, Signal], fits: Callable[[Signal], bool]
) -> dict[str, Signal]:
    """Keep those that fit."""
    return {name: signal for name, signal in signals.items() if fits(signal)}
