"""What the route of raw topics gives."""

from __future__ import annotations

from pydantic import BaseModel, Field

__all__ = ["TopicShape", "TopicTable"]


class TopicShape(BaseModel):
    """A raw topic that you may tap."""

    topic: str = Field(description="its absolute name")
    type: str = Field(description="of its messages: package/msg/Name")
    latched: bool = Field(description="who comes later gets its last messages, too")
    max_rate: float = Field(description="at most so many messages a second (Hz); 0: all")
    problem: str = Field(description="why it cannot be tapped now; empty: it can")


class TopicTable(BaseModel):
    """The raw topics of a site that you may tap."""

    online: bool = Field(description="whether its gateway is connected")
    topics: list[TopicShape]
