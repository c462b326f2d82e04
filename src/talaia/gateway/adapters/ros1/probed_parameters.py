"""What a probe reads of a ROS 1 parameter server; nothing is set.

https://wiki.ros.org/ROS/Parameter%20Server%20API
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.errors import AdapterLost
from talaia.model.connections.ros import is_parameter_name
from talaia.model.discovery.left_out_parameters import is_secret, reason_to_leave
from talaia.model.discovery.probe_report import NodeFound, ParameterFound
from talaia.model.list_texts import list_text

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping

    from talaia.gateway.adapters.ros1.master import GraphState, RosMaster

__all__ = ["arrange_parameters", "find_parameters"]

# A robot with more is asked for these, and no longer than that.
_MAX_PARAMETERS = 500
_MAX_SECONDS = 5.0
# What roslaunch and ROS itself keep there.
_COMMON = ("/rosdistro", "/rosversion", "/run_id", "/use_sim_time")
_COMMON_PREFIXES = ("/roslaunch/",)
_TYPES = {bool: "boolean", int: "integer", float: "number", str: "text"}
_LISTS = (
    ({bool}, "booleans"),
    ({int}, "integers"),
    # Written as YAML, a number without a point is an int.
    ({int, float}, "numbers"),
    ({str}, "texts"),
)
_WHEN_READ = "Many nodes of ROS 1 read it only when they start."
_NOT_READ = "the master did not tell it in time"


def find_parameters(master: RosMaster, system: GraphState) -> tuple[NodeFound, ...]:
    """Read what is set, by node. On a worker thread.

    What is a secret by its name is not asked for.

    Raises:
        AdapterLost: no master answers when it is asked for the names.

    """
    until = time.monotonic() + _MAX_SECONDS
    names = [
        name
        for name in sorted(master.parameter_names())
        if name not in _COMMON and not name.startswith(_COMMON_PREFIXES)
    ]
    parameters: dict[str, ParameterFound | str] = {}
    for name in names[:_MAX_PARAMETERS]:
        if is_secret(name):
            parameters[name] = reason_to_leave(name, None)
        elif time.monotonic() > until:
            parameters[name] = _NOT_READ
        else:
            parameters[name] = _read_parameter(master, name)
    nodes = {
        node
        for part in (system.published, system.heard, system.services)
        for those in part.values()
        for node in those
    }
    return arrange_parameters(
        parameters, nodes, system.published, more=max(0, len(names) - _MAX_PARAMETERS)
    )


def _read_parameter(master: RosMaster, name: str) -> ParameterFound | str:
    """Ask for one; gives why it is left out where it is."""
    try:
        is_set, value = master.read_parameter(name)
    except AdapterLost:
        return _NOT_READ
    if not is_set:
        return "it was taken away meanwhile"
    kind = _kind_of(value)
    shown = list_text(value) if kind is not None and isinstance(value, list) else str(value)
    reason = reason_to_leave(name, kind, len(shown))
    if reason or kind is None:
        return reason
    return ParameterFound(parameter=name, type=kind, description=_WHEN_READ)


def _kind_of(value: object) -> str | None:
    """Name the type of a parameter as `ParameterFound` has it; none for maps and mixed lists."""
    if not isinstance(value, list):
        return _TYPES.get(type(value))
    types = {type(item) for item in value}
    # An empty list does not say of what.
    return next((kind for of, kind in _LISTS if types and types <= of), None)


def arrange_parameters(
    parameters: Mapping[str, ParameterFound | str],
    nodes: Collection[str],
    published: Mapping[str, Iterable[str]],
    *,
    more: int = 0,
) -> tuple[NodeFound, ...]:
    """Give each node its parameters. Pure.

    Args:
        parameters: by absolute name; of those that are left out, the reason.
        nodes: absolute names of those that run.
        published: the nodes that publish a topic, by topic.
        more: how many there are beside these.

    """
    kept: dict[str, list[ParameterFound]] = {}
    left_out: dict[str, list[str]] = {}
    for name, found in parameters.items():
        owner = _owner_of(name, nodes)
        own = name[len(owner) :].lstrip("/")
        if isinstance(found, str):
            left_out.setdefault(owner, []).append(f"{own}: {found}")
        elif not owner:
            left_out.setdefault(owner, []).append(f"{own}: it stands in no node's name space")
        elif not is_parameter_name(name):
            left_out.setdefault(owner, []).append(f"{own}: a description cannot have this name")
        else:
            kept.setdefault(owner, []).append(msgspec.structs.replace(found, parameter=own))
    if more:
        left_out.setdefault("", []).append(f"{more} more parameters")
    return tuple(
        NodeFound(
            node=node or "/",
            publishes=tuple(sorted(topic for topic, by in published.items() if node in by)),
            parameters=tuple(kept.get(node, ())),
            left_out=tuple(left_out.get(node, ())),
        )
        for node in sorted(kept.keys() | left_out.keys())
    )


def _owner_of(name: str, nodes: Collection[str]) -> str:
    """Give the node in whose name space a parameter is; else that name space itself."""
    space = name.rpartition("/")[0]
    owner = space
    while owner:
        if owner in nodes:
            return owner
        owner = owner.rpartition("/")[0]
    return space
