"""What the routes of robots' logs give."""

from __future__ import annotations

from pydantic import BaseModel, Field

__all__ = ["LogLineShape", "LogNodeList", "LogPageShape"]


class LogLineShape(BaseModel):
    """One line of a robot's log."""

    id: str
    time_us: int = Field(description="when it was said (µs, UTC)")
    level: int = Field(
        description="10 debug, 20 info, 30 warning, 40 error, 50 fatal, as ROS 2 counts"
    )
    node: str = Field(description="who said it")
    text: str = Field(description="may have several lines; nothing unseen is in it")
    function: str = Field(description="in which it was said; empty: unknown")
    file: str = Field(description="of the source; empty: unknown")
    line: int = Field(description="of that file; 0: unknown")
    left_out: int = Field(description="so many lines were not kept, and ``text`` says why; 0: none")


class LogPageShape(BaseModel):
    """Lines, the newest first."""

    lines: list[LogLineShape]
    next: str | None = Field(description="``before`` of the next page; none: there is no more")


class LogNodeList(BaseModel):
    """Nodes of which lines are kept."""

    nodes: list[str]
