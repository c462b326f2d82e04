"""The text of an alarm's condition, or of a derived signal, read into a tree. Never `eval`.

::

    {power/battery} < 11.5 and not {power/charger} == "on"
    max({base/motor_left}, {base/motor_right}) - {weather/outside} > 40

A signal stands in braces by its channel's address; a state and a text compare with a text in
quotes, a number with a number. There are ``and``, ``or``, ``not``, ``< <= > >= == !=``,
``+ - * /``, ``abs(a)``, ``min(a, b, …)`` and ``max(a, b, …)``, and parentheses.

What cannot be known is `None`, and stays so: with it a sum is unknown, and a comparison; ``and`` is
false if one side is, ``or`` is true if one side is, and else they are unknown (Kleene's logic).

Long, because the grammar, its kinds and its judgement are one thing and are read together.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

from talaia.errors import TalaiaError
from talaia.model.alarms.sign_remedies import sign_remedy
from talaia.model.errors import UnknownWord

__all__ = [
    "MAX_LENGTH",
    "Expression",
    "ExpressionError",
    "ExpressionNode",
    "Value",
    "ValueKind",
    "parse_condition",
    "parse_expression",
]

MAX_LENGTH = 1000
# Of parentheses and calls. Each level is some ten calls of the reader, far from Python's limit.
_MAX_DEPTH = 24
# Sums and products of the whole text; see `_parse_chain`.
_MAX_LINKS = 100
# Of ``min`` and ``max``.
_MAX_ARGUMENTS = 20

Value = float | str | bool | None


class ValueKind(StrEnum):
    """What a part of an expression gives."""

    NUMBER = "number"
    TEXT = "text"
    TRUTH = "yes or no"


class ExpressionError(TalaiaError):
    """The text is no condition."""

    def __init__(self, at: int, problem: str, remedy: str = "") -> None:
        """Say where: the place of the letter it stumbled on, counted from 0; and what to do."""
        super().__init__(at, problem, remedy)
        self.remedy = remedy
        self.at = at
        self.problem = problem

    def __str__(self) -> str:
        return f"at letter {self.at + 1}: {self.problem}"


@dataclass(frozen=True, slots=True)
class ExpressionNode:
    """One part: what it does, to which parts, and what it gives.

    Attributes:
        kind: what it gives.
        judge: gets what is known by address, and what the parts gave.
        parts: what it is made of.
        form: what it does: an operator's sign, a function's name, ``signal``, ``number``,
            ``compare``; empty for all that units have no part in.
        address: of a signal: its channel.
        at: the place of the letter where it is written, counted from 0.

    """

    kind: ValueKind
    judge: Callable[[Mapping[str, Value], tuple[Value, ...]], Value]
    parts: tuple[ExpressionNode, ...] = ()
    form: str = ""
    address: str = ""
    at: int = 0

    def evaluate_node(self, values: Mapping[str, Value]) -> Value:
        """Judge the parts, and then this."""
        return self.judge(values, tuple(part.evaluate_node(values) for part in self.parts))


@dataclass(frozen=True, slots=True)
class Expression:
    """A condition, or a sum, that was read.

    Attributes:
        text: as it was written.
        signals: addresses of the channels in it, each once.
        tree: the whole of it.

    """

    text: str
    signals: tuple[str, ...]
    tree: ExpressionNode

    def evaluate_expression(self, values: Mapping[str, Value]) -> bool | None:
        """Tell whether it holds; None when that cannot be known.

        Args:
            values: by address; None, not a number, or missing: unknown.

        """
        found = self.tree.evaluate_node(values)
        return found if isinstance(found, bool) else None

    def evaluate_value(self, values: Mapping[str, Value]) -> Value:
        """Give what it amounts to; None when that cannot be known. See `evaluate_expression`."""
        return self.tree.evaluate_node(values)


def parse_condition(text: str, kinds: Mapping[str, ValueKind]) -> Expression:
    """Read a condition over the channels in ``kinds``.

    Raises:
        ExpressionError: with the place of the mistake.

    """
    found = parse_expression(text, kinds)
    if found.tree.kind is not ValueKind.TRUTH:
        # Where it begins: blanks before it are no part of it.
        start = len(text) - len(text.lstrip())
        problem = f"expected a {ValueKind.TRUTH}, found a {found.tree.kind}"
        remedy = "compare it, as in {device/signal} > 1"
        raise ExpressionError(start, problem, remedy)
    return found


def parse_expression(text: str, kinds: Mapping[str, ValueKind]) -> Expression:
    """Read a condition, a sum or a text over the channels in ``kinds``.

    Raises:
        ExpressionError: with the place of the mistake.

    """
    if len(text) > MAX_LENGTH:
        raise ExpressionError(MAX_LENGTH, f"longer than {MAX_LENGTH} letters")
    if not text.strip():
        raise ExpressionError(0, "there is no expression", "write one, as {device/signal} > 1")
    reader = _Reader(text, kinds)
    tree = reader.read_expression()
    # Each once, in the order of the text.
    return Expression(text, tuple(dict.fromkeys(reader.signals)), tree)


class _Token(NamedTuple):
    """A word, where it stands, and of which sort: number, text, signal, word, sign, end."""

    sort: str
    text: str
    at: int


# Every repetition is bounded but that of blanks and words, which cannot overlap with a neighbour.
# ``<=`` stands before ``<``: the first alternative that fits is taken.
_TOKEN = re.compile(
    r"""(?P<space>\s+)
    |(?P<number>(?:\d{1,30}(?:\.\d{0,30})?|\.\d{1,30})(?:[eE][+-]?\d{1,3})?)
    |"(?P<text>[^"\n]{0,200})"
    |\{(?P<signal>[^{}\n]{1,200})\}
    |(?P<word>[A-Za-z_]+)
    |(?P<sign><=|>=|==|!=|[-+*/<>(),])""",
    re.VERBOSE,
)


def _split_tokens(text: str) -> list[_Token]:
    found, at = [], 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None or match.lastgroup is None:
            raise ExpressionError(at, f"{text[at]!r} is not expected here", sign_remedy(text[at]))
        if match.lastgroup != "space":
            found.append(_Token(match.lastgroup, match[match.lastgroup], at))
        at = match.end()
    return [*found, _Token("end", "", len(text))]


class _Reader:
    """Recursive descent, one method for each level of binding."""

    def __init__(self, text: str, kinds: Mapping[str, ValueKind]) -> None:
        # Never empty: the last is of the sort ``end``, so that there is always a next one.
        self._words = _split_tokens(text)
        # What each channel is, by its address.
        self._kinds = kinds
        # Index of the token to be read next.
        self._next = 0
        # Levels of parentheses and calls that are open.
        self._depth = 0
        # Sums and products so far; never taken back.
        self._links = 0
        # Channels in the order of the text, with repeats.
        self.signals: list[str] = []

    def read_expression(self) -> ExpressionNode:
        tree = self._parse_or()
        # Something is left over: an operator is missing, or a parenthesis too many.
        if self._word.sort != "end":
            problem = f"{self._quote_token(self._word)} is not expected here"
            raise ExpressionError(self._word.at, problem, sign_remedy(self._word.text))
        return tree

    @property
    def _word(self) -> _Token:
        return self._words[self._next]

    def _take_token(self, *texts: str) -> _Token | None:
        word = self._word
        if word.sort in {"word", "sign"} and word.text in texts:
            self._next += 1
            return word
        return None

    def _expect_token(self, text: str) -> None:
        if self._take_token(text) is None:
            problem = f"expected {text!r}, found {self._quote_token(self._word)}"
            raise ExpressionError(self._word.at, problem, f"write the missing {text}")

    @staticmethod
    def _quote_token(word: _Token) -> str:
        return "the end" if word.sort == "end" else repr(word.text)

    def _parse_or(self) -> ExpressionNode:
        self._depth += 1
        if self._depth > _MAX_DEPTH:
            raise ExpressionError(self._word.at, f"nested deeper than {_MAX_DEPTH} levels")
        start, parts = self._word, [self._parse_and()]
        while self._take_token("or"):
            parts.append(self._parse_and())
        self._depth -= 1
        return self._join_conditions(parts, _any_true, start)

    def _parse_and(self) -> ExpressionNode:
        start, parts = self._word, [self._parse_not()]
        while self._take_token("and"):
            parts.append(self._parse_not())
        return self._join_conditions(parts, _all_true, start)

    @staticmethod
    def _join_conditions(
        parts: list[ExpressionNode], judge: Callable[[tuple[Value, ...]], Value], start: _Token
    ) -> ExpressionNode:
        # Of one part the kind is free: every sum comes through here, too.
        if len(parts) == 1:
            return parts[0]
        for part in parts:
            _want_kind(part, ValueKind.TRUTH, start)
        return ExpressionNode(ValueKind.TRUTH, lambda _, values: judge(values), tuple(parts))

    def _parse_not(self) -> ExpressionNode:
        turns = 0
        # Counted, not nested: a row of them needs no stack.
        while self._take_token("not"):
            turns += 1
        start, part = self._word, self._parse_comparison()
        if not turns:
            return part
        _want_kind(part, ValueKind.TRUTH, start)
        if turns % 2 == 0:
            return part
        # Kleene: what is not unknown is unknown.
        return ExpressionNode(
            ValueKind.TRUTH, lambda _, v: None if v[0] is None else not v[0], (part,)
        )

    def _parse_comparison(self) -> ExpressionNode:
        left = self._parse_sum()
        sign = self._take_token(*_COMPARE)
        if sign is None:
            return left
        right = self._parse_sum()
        if left.kind is not right.kind or left.kind is ValueKind.TRUTH:
            raise ExpressionError(sign.at, f"a {left.kind} cannot be compared with a {right.kind}")
        if left.kind is ValueKind.TEXT and sign.text not in {"==", "!="}:
            raise ExpressionError(sign.at, "texts can only be == or !=")
        # Of ``a < b < c`` some languages compare the first outcome with c; here it is not guessed.
        again = self._word
        if self._take_token(*_COMPARE):
            raise ExpressionError(again.at, "write two comparisons with `and` between them")
        compare = _COMPARE[sign.text]
        return ExpressionNode(
            ValueKind.TRUTH,
            lambda _, v: _if_all_known(compare, v),
            (left, right),
            form="compare",
            at=sign.at,
        )

    def _parse_sum(self) -> ExpressionNode:
        return self._parse_chain(self._parse_product, "+", "-")

    def _parse_product(self) -> ExpressionNode:
        return self._parse_chain(self._parse_signed, "*", "/")

    def _parse_chain(self, inner: Callable[[], ExpressionNode], *signs: str) -> ExpressionNode:
        start, left = self._word, inner()
        while (sign := self._take_token(*signs)) is not None:
            at, right = self._word, inner()
            _want_kind(left, ValueKind.NUMBER, start)
            _want_kind(right, ValueKind.NUMBER, at)
            left = _arithmetic_node(sign, left, right)
            # A long chain leans to the left: its tree is as deep as the chain is long.
            self._links += 1
            if self._links > _MAX_LINKS:
                raise ExpressionError(sign.at, "too many sums and products")
        return left

    def _parse_signed(self) -> ExpressionNode:
        minus = False
        # Counted, as ``not`` is.
        while self._take_token("-"):
            minus = not minus
        start, part = self._word, self._parse_atom()
        if not minus:
            return part
        _want_kind(part, ValueKind.NUMBER, start)
        return ExpressionNode(
            ValueKind.NUMBER, lambda _, v: _if_all_known(_negate_value, v), (part,), form="negate"
        )

    def _parse_atom(self) -> ExpressionNode:
        word = self._word
        self._next += word.sort != "end"
        match word.sort:
            case "number":
                number = float(word.text)
                # ``1e999`` is infinite as a float, and so unknown.
                return ExpressionNode(
                    ValueKind.NUMBER, lambda _, __: _finite_or_none(number), form="number"
                )
            case "text":
                return ExpressionNode(ValueKind.TEXT, lambda _, __: word.text)
            case "signal":
                return self._parse_signal(word)
            case "word" if word.text in _CALLS:
                return self._parse_call(word)
        if word.text == "(":
            inner = self._parse_or()
            self._expect_token(")")
            return inner
        if word.sort == "end":
            raise ExpressionError(word.at, "it ends too soon", "write what is missing at its end")
        if word.sort != "word":
            problem = f"{self._quote_token(word)} is not expected here"
            raise ExpressionError(word.at, problem, sign_remedy(word.text))
        # A name before a parenthesis is one of a function.
        if self._word.text == "(":
            problem = f"there is no function {word.text!r}"
            raise ExpressionError(word.at, problem, f"use one of: {', '.join(sorted(_CALLS))}")
        remedy = 'write {device/signal}, and a text or a state as "on"'
        raise ExpressionError(word.at, f"{word.text!r} is no signal: those stand in braces", remedy)

    def _parse_signal(self, word: _Token) -> ExpressionNode:
        address = word.text.strip()
        kind = self._kinds.get(address)
        if kind is None:
            unknown = UnknownWord("", "signal", address, self._kinds)
            raise ExpressionError(word.at, f"there is no signal {address!r}", unknown.remedy)
        self.signals.append(address)
        return ExpressionNode(
            kind,
            lambda values, _: _finite_or_none(values.get(address)),
            form="signal",
            address=address,
            at=word.at,
        )

    def _parse_call(self, word: _Token) -> ExpressionNode:
        self._expect_token("(")
        parts = []
        while True:
            start, part = self._word, self._parse_or()
            _want_kind(part, ValueKind.NUMBER, start)
            parts.append(part)
            if self._take_token(",") is None:
                break
        self._expect_token(")")
        low, high = (1, 1) if word.text == "abs" else (2, _MAX_ARGUMENTS)
        if not low <= len(parts) <= high:
            wants = "one number" if high == 1 else f"{low} to {high} numbers"
            remedy = f"write: {word.text}({'…' if high == 1 else '…, …'})"
            raise ExpressionError(word.at, f"{word.text} takes {wants}", remedy)
        work = _CALLS[word.text]
        return ExpressionNode(
            ValueKind.NUMBER,
            lambda _, v: _if_all_known(work, v),
            tuple(parts),
            form=word.text,
            at=word.at,
        )


def _arithmetic_node(sign: _Token, left: ExpressionNode, right: ExpressionNode) -> ExpressionNode:
    work = _WORK[sign.text]
    return ExpressionNode(
        ValueKind.NUMBER,
        lambda _, values: _if_all_known(work, values),
        (left, right),
        form=sign.text,
        at=sign.at,
    )


def _want_kind(node: ExpressionNode, kind: ValueKind, word: _Token) -> None:
    if node.kind is not kind:
        remedy = {
            ValueKind.TEXT: 'compare a state or a text with another: {device/mode} == "on"',
            ValueKind.NUMBER: "compare numbers: {device/signal} > 1",
        }.get(node.kind, "join conditions with and, or, not")
        raise ExpressionError(word.at, f"expected a {kind}, found a {node.kind}", remedy)


def _negate_value(values: tuple[Value, ...]) -> Value:
    return -_only_numbers(values)[0]


def _two_numbers(values: tuple[Value, ...]) -> tuple[float, float]:
    left, right = _only_numbers(values)
    return left, right


def _only_numbers(values: tuple[Value, ...]) -> list[float]:
    return [value for value in values if isinstance(value, float)]


def _if_all_known(work: _Work, values: tuple[Value, ...]) -> Value:
    """Do it if all is known, and the outcome is a number that is one."""
    if any(value is None for value in values):
        return None
    try:
        return _finite_or_none(work(values))
    except (ZeroDivisionError, OverflowError):
        return None


def _finite_or_none(value: Value) -> Value:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _all_true(values: tuple[Value, ...]) -> Value:
    # Whatever the others are, known or not.
    if any(value is False for value in values):
        return False
    return None if None in values else True


def _any_true(values: tuple[Value, ...]) -> Value:
    # Whatever the others are, known or not.
    if any(value is True for value in values):
        return True
    return None if None in values else False


_Work = Callable[[tuple[Value, ...]], Value]

_COMPARE: Mapping[str, _Work] = {
    "<": lambda v: operator.lt(*_two_numbers(v)),
    "<=": lambda v: operator.le(*_two_numbers(v)),
    ">": lambda v: operator.gt(*_two_numbers(v)),
    ">=": lambda v: operator.ge(*_two_numbers(v)),
    "==": lambda v: v[0] == v[1],
    "!=": lambda v: v[0] != v[1],
}
_WORK: Mapping[str, _Work] = {
    "+": lambda v: float(operator.add(*_two_numbers(v))),
    "-": lambda v: float(operator.sub(*_two_numbers(v))),
    "*": lambda v: float(operator.mul(*_two_numbers(v))),
    "/": lambda v: float(operator.truediv(*_two_numbers(v))),
}
_CALLS: Mapping[str, _Work] = {
    "abs": lambda v: abs(_only_numbers(v)[0]),
    "min": lambda v: min(_only_numbers(v)),
    "max": lambda v: max(_only_numbers(v)),
}
