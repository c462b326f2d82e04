"""What the route of raw topics gives."""

from __future__ import annotations

from pydantic import BaseModel, Field

from talaia.model.topics import TopicRight  # noqa: TC001 - pydantic reads it at run time

__all__ = ["GraphNodeShape", "GraphShape", "TopicShape", "TopicTable"]


class TopicShape(BaseModel):
    """A raw topic that you may tap."""

    topic: str = Field(description="its absolute name")
    type: str = Field(description="of its messages: package/msg/Name")
    latched: bool = Field(description="who comes later gets its last messages, too")
    max_rate: float = Field(description="at most so many messages a second (Hz); 0: all")
    problem: str = Field(description="why it cannot be tapped now; empty: it can")
    described: bool = Field(description="whether a rule of the description names it")
    right: TopicRight = Field(description="what a person needs to have it")
    device: str = Field(description="on which device; empty: on the whole site")
    rate: float = Field(
        description="how often it comes (Hz), while somebody follows it; 0: not known"
    )
    camera: str = Field(
        default="",
        description="of a calibration (CameraInfo): the described camera, device/stream, whose"
        " pictures it speaks of; empty: none that you may see",
    )


class TopicTable(BaseModel):
    """The raw topics of a site that you may tap."""

    online: bool = Field(description="whether its gateway is connected")
    topics: list[TopicShape]


class GraphNodeShape(BaseModel):
    """A node of a robot, with those of its topics that you may tap."""

    name: str
    publishes: list[str]
    subscribes: list[str]


class GraphShape(BaseModel):
    """The nodes of a site that have a topic that you may tap, by name."""

    online: bool = Field(description="whether its gateway is connected")
    nodes: list[GraphNodeShape]
