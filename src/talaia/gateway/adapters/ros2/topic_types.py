"""How topics are subscribed to and read, whether or not their message package is installed.

A class makes the subscription, and a definition the decoder: the class is the installed one or is
made by name, the definition is the one whose hash the publisher tells. On the wait-set thread;
files are read, and decoders compiled, on a thread of its own.
"""

from __future__ import annotations

import logging
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from rclpy.serialization import deserialize_message

from talaia.gateway.adapters.ros2.decode import decoder_for
from talaia.gateway.adapters.ros2.made_types.made_message_class import (
    CannotMakeTypes,
    made_class,
    problem_here,
)
from talaia.gateway.adapters.ros2.made_types.self_test import self_test_problem
from talaia.gateway.adapters.ros2.requests import class_of
from talaia.gateway.adapters.ros2.type_definitions.definition_finder import (
    DefinitionFinder,
    DefinitionMismatch,
)
from talaia.gateway.adapters.ros2.type_definitions.definition_text import definition_text
from talaia.gateway.adapters.ros2.type_definitions.installed_package import installed_definition
from talaia.gateway.adapters.ros2.type_definitions.message_decoder import decoder_of
from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    BadDefinition,
    type_hash,
)
from talaia.gateway.errors import GatewayError, TypeMissing

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from talaia.gateway.adapters.ros2.type_definitions.message_definition import TypeDefinition
    from talaia.gateway.adapters.ros2.type_definitions.robot_questions import RobotDescriptions

__all__ = ["TopicType", "TopicTypes"]

log = logging.getLogger(__name__)
_T = TypeVar("_T")


class TopicType(NamedTuple):
    """How the messages of a topic are read.

    Attributes:
        decode: gives a message's fields; raises `FieldError` for what is no such message.
        schema: the definition's text for a recording; empty of an installed package, whose text
            the recorder knows.
        definition: by which messages are written; none of an installed package.

    """

    decode: Callable[[bytes], object]
    schema: str
    definition: TypeDefinition | None = None


class TopicTypes:
    """The types of one connection's topics."""

    def __init__(
        self,
        *,
        named: Path | None,
        descriptions: RobotDescriptions,
        soon: Callable[[Callable[[], None]], None],
        missing: Callable[[TypeMissing], None],
        mismatched: Callable[[str, str], None],
    ) -> None:
        """Know no type yet.

        Args:
            named: a folder or a recording with definitions; none where the description names none.
            descriptions: asks robots.
            soon: runs something on the wait-set thread.
            missing: told of types that cannot be read, each time one is met.
            mismatched: told of a topic and why it is not read, each time that is found.

        """
        self._named = named
        self._descriptions = descriptions
        self._soon = soon
        self._missing = missing
        self._mismatched = mismatched
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="talaia-ros2-types")
        # Made by the worker, for it reads files.
        self._finder: DefinitionFinder | None = None
        # Why no classes can be made; None until it has been tried.
        self._problem: str | None = None
        self._trying = False
        # What waits for that to be known.
        self._untried: list[Callable[[], None]] = []
        # By type and hash.
        self._known: dict[tuple[str, str], TopicType] = {}

    def close(self) -> None:
        """Find nothing more."""
        self._worker.shutdown(wait=False, cancel_futures=True)

    def installed_class(self, type_name: str, used_by: str) -> Any:  # noqa: ANN401 - rclpy ships no types
        """Give the class of a package; none if it is not installed, which is told."""
        try:
            return class_of(type_name, used_by)
        except TypeMissing as error:
            self._missing(error)
            return None

    def class_for(self, type_name: str, used_by: str, spoken: str) -> Any:  # noqa: ANN401
        """Give a class to subscribe with.

        Args:
            type_name: of the topic.
            used_by: the topic.
            spoken: its publisher's hash; empty where that is not told.

        Returns:
            None if there is none, which is told; or none yet: then ask again.

        """
        try:
            return class_of(type_name, used_by)
        except TypeMissing:
            if self._problem is None:
                self._try_making()
                return None
        if not self._problem:
            try:
                return made_class(type_name, spoken)
            except CannotMakeTypes as error:
                self._problem = str(error)
        self._missing(TypeMissing(type_name, used_by, self._problem))
        return None

    def when_tried(self, job: Callable[[], None]) -> None:
        """Run something when it is known whether classes can be made: then `class_for` answers."""
        self._untried.append(job)
        if self._problem is None:
            self._try_making()
        if self._problem is not None:
            self._run_untried()

    def _run_untried(self) -> None:
        jobs, self._untried = self._untried, []
        for job in jobs:
            job()

    def find(
        self, topic: str, type_name: str, spoken: str, done: Callable[[TopicType | None], None]
    ) -> None:
        """Find how a topic is read.

        Args:
            topic: whose publishers may be asked.
            type_name: its type.
            spoken: its publishers' hash; empty where that is not told.
            done: called once with it; with none if there is no way, which is told.

        """
        known = self._known.get((type_name, spoken)) or self._installed(type_name, spoken)
        if known is not None:
            done(self._known.setdefault((type_name, spoken), known))
            return

        def on_description(described: TypeDefinition | None) -> None:
            self._run(lambda: self._find(topic, type_name, spoken, described), on_found)

        def on_found(found: TopicType | GatewayError) -> None:
            if isinstance(found, GatewayError):
                self._report(topic, found)
                done(None)
            else:
                done(self._known.setdefault((type_name, spoken), found))

        self._descriptions.ask(topic, type_name, spoken, on_description)

    def refuse(self, topic: str, why: str) -> None:
        """Tell why a topic is not read."""
        self._mismatched(topic, why)

    def _report(self, topic: str, error: GatewayError) -> None:
        if isinstance(error, TypeMissing):
            self._missing(error)
        else:
            self._mismatched(topic, str(error))

    def _installed(self, type_name: str, spoken: str) -> TopicType | None:
        try:
            kind = class_of(type_name, "")
            definition = installed_definition(type_name)
        except (TypeMissing, BadDefinition):
            return None
        # Its class would read another version's bytes as if they were its own.
        if definition is None or (spoken and type_hash(definition) != spoken):
            return None
        decode = decoder_for(type_name, lambda data: deserialize_message(data, kind))
        return TopicType(decode, "")

    def _try_making(self) -> None:
        # Once for all topics that wait for it.
        if self._trying:
            return
        self._trying = True
        self._problem = problem_here() or None
        if self._problem is None:
            self._run(self_test_problem, self._on_tried)

    def _on_tried(self, problem: str) -> None:
        if problem:
            log.warning("types that are not installed cannot be read: %s", problem)
        self._problem = problem
        self._run_untried()

    # ── on the worker ──

    def _run(self, job: Callable[[], _T], done: Callable[[_T], None]) -> None:
        def work() -> None:
            found = job()
            self._soon(lambda: done(found))

        self._worker.submit(work)

    def _find(
        self, topic: str, type_name: str, spoken: str, described: TypeDefinition | None
    ) -> TopicType | GatewayError:
        try:
            if self._finder is None:
                self._finder = DefinitionFinder(self._named)
            definition = self._finder.find(type_name, spoken, topic, described)
            log.info("%s: %s is read by %s", topic, type_name, definition.source)
            decode = decoder_of(definition, proven=bool(spoken))
            return TopicType(decode, definition_text(definition), definition)
        except (DefinitionMismatch, TypeMissing, BadDefinition) as error:
            return error
        except Exception as error:
            # Whatever a file or a robot's answer brings about, others are found all the same.
            log.exception("%s: its type cannot be read", topic)
            return BadDefinition(f"{type_name} cannot be read: {error}")
