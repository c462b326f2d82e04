"""Finds the definition that a publisher speaks, and never another: hashes are compared."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from talaia.gateway.adapters.ros2.type_definitions.action_definition import (
    ACTION_PARTS,
    TIME,
    UUID,
    ActionDefinition,
    action_definition,
)
from talaia.gateway.adapters.ros2.type_definitions.definition_files import (
    DefinitionSource,
    FolderDefinitions,
    RecordedDefinitions,
    ros_prefixes,
)
from talaia.gateway.adapters.ros2.type_definitions.distribution_stores import (
    DistributionDefinitions,
)
from talaia.gateway.adapters.ros2.type_definitions.driving_definitions import DrivingDefinitions
from talaia.gateway.adapters.ros2.type_definitions.installed_package import installed_definition
from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    BadDefinition,
    TypeDefinition,
    type_hash,
)
from talaia.gateway.adapters.ros2.type_definitions.service_definition import (
    EVENT_INFO,
    ServiceDefinition,
    service_hash,
)
from talaia.gateway.errors import GatewayError, TypeMissing

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from pathlib import Path

__all__ = ["DefinitionFinder", "DefinitionMismatch"]


# Beside installing the package.
_HELP = (
    "or name its .msg files or a recording in the connection's key 'definitions': its publisher "
    "does not describe it"
)


class DefinitionMismatch(GatewayError):
    """A publisher speaks another version of a type than all that are known here."""

    def __init__(self, type_name: str, used_by: str, wanted: str, known: dict[str, str]) -> None:
        """Keep the hash that is published, and who has which instead: sources by their hashes."""
        super().__init__(type_name, used_by, wanted, known)
        self.type_name = type_name
        self.used_by = used_by
        self.wanted = wanted
        self.known = known

    def __str__(self) -> str:
        have = "; ".join(f"{source} has {found}" for found, source in self.known.items())
        return (
            f"{self.used_by}: its publisher's {self.type_name} is {self.wanted}, and {have}. "
            "It is not read, for its fields would be taken for others: bring the publisher and "
            "this machine to the same version of the package, or name the publisher's .msg files "
            "or a recording in the connection's key 'definitions'"
        )


class DefinitionFinder:
    """All ways to a definition, in order. Reads files: not for a thread that must not wait."""

    def __init__(self, named: Path | None) -> None:
        """Know the installed ones, and those in a folder or a recording that is ``named``."""
        # None where nothing is named, or it cannot be read; see `problem`.
        self._named: DefinitionSource | None = None
        self.problem = ""
        self._files = FolderDefinitions.of_prefixes(ros_prefixes())
        try:
            if named is not None:
                self._named = _named_source(named, self._files)
        except BadDefinition as error:
            self.problem = str(error)
        self._distributions = DistributionDefinitions()
        self._driving = DrivingDefinitions()

    def find(
        self, type_name: str, wanted: str, used_by: str, described: TypeDefinition | None = None
    ) -> TypeDefinition:
        """Give the definition of a type.

        Args:
            type_name: ``package/msg/Name``.
            wanted: the publisher's hash; empty where the graph does not tell it (ROS 2 Humble),
                and then the first definition counts.
            used_by: what needs it, for the error.
            described: what the publisher's node says.

        Raises:
            DefinitionMismatch: what is known has other hashes.
            TypeMissing: nothing is known of it.

        """
        # Hashes of what was found and is another version, for the error.
        others: dict[str, str] = {}
        problems = [self.problem] if self.problem else []
        for definition in self._candidates(type_name, described, problems):
            found = type_hash(definition)
            if found == wanted or not wanted:
                return definition
            others.setdefault(found, definition.source)
        if others:
            raise DefinitionMismatch(type_name, used_by, wanted, others)
        raise TypeMissing(type_name, used_by, "; ".join([*problems, _HELP]))

    def find_service(self, type_name: str, used_by: str) -> tuple[ServiceDefinition, str]:
        """Give the first definition of ``package/srv/Name`` in files, and its hash.

        The graph tells no hashes of services, and rosbags brings none: whoever calls one has to
        let its robot confirm the hash.

        Raises:
            TypeMissing: nothing is known of it.

        """
        problems = [self.problem] if self.problem else []
        # Without it (before Iron) there are no hashes, and no node that could confirm one.
        info = next(iter(_one(installed_definition(EVENT_INFO))), None)
        for source in (self._files, self._named):
            if source is None or info is None:
                continue
            parts = [
                next(_read(partial(source.find, f"{type_name}_{part}"), problems), None)
                for part in ("Request", "Response")
            ]
            if parts[0] is not None and parts[1] is not None:
                service = ServiceDefinition(type_name, parts[0], parts[1])
                return service, service_hash(service, info)
        raise TypeMissing(type_name, used_by, "; ".join(problems))

    def find_action(self, type_name: str, used_by: str) -> ActionDefinition:
        """Give the first definition of ``package/action/Name`` in files.

        Raises:
            TypeMissing: nothing is known of it.
            BadDefinition: what is known defines no action.

        """
        problems = [self.problem] if self.problem else []
        uuid, time = installed_definition(UUID), installed_definition(TIME)
        for source in (self._files, self._named):
            if source is None or uuid is None or time is None:
                continue
            found = [
                next(_read(partial(source.find, f"{type_name}_{part}"), problems), None)
                for part in ACTION_PARTS
            ]
            parts = tuple(part for part in found if part is not None)
            if len(parts) == len(found):
                return action_definition(type_name, parts, uuid, time)
        raise TypeMissing(type_name, used_by, "; ".join(problems))

    def hash_of_service(self, service: ServiceDefinition) -> str:
        """Give the hash of a service's type; empty where this ROS has none."""
        info = installed_definition(EVENT_INFO)
        return "" if info is None else service_hash(service, info)

    def _candidates(
        self, type_name: str, described: TypeDefinition | None, problems: list[str]
    ) -> Iterator[TypeDefinition]:
        yield from _read(lambda: _one(installed_definition(type_name)), problems)
        yield from _one(described)
        named = self._named
        for source in (self._files, named, self._distributions, self._driving):
            if source is not None:
                yield from _read(partial(source.find, type_name), problems)


def _one(definition: TypeDefinition | None) -> tuple[TypeDefinition, ...]:
    return () if definition is None else (definition,)


def _read(
    find: Callable[[], Iterable[TypeDefinition]], problems: list[str]
) -> Iterator[TypeDefinition]:
    """Go through one source; what it has wrong must not hide what others have."""
    try:
        yield from find()
    except BadDefinition as error:
        problems.append(str(error))


def _named_source(path: Path, beside: FolderDefinitions) -> DefinitionSource:
    if path.suffix not in (".mcap", ".db3") and not (path / "metadata.yaml").is_file():
        return FolderDefinitions.of_folder(path).with_parts_of(beside)
    return RecordedDefinitions(path)
