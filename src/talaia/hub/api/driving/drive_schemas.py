"""What is said about joints that are driven."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

__all__ = ["DrivenJointShape"]


class DrivenJointShape(BaseModel):
    """A joint that is driven by its velocity: rad/s and rad, or m/s and m where it slides.

    ``position`` is the address of the signal with where it stands; empty: nothing says that.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    id: str
    name: str
    max_speed: float
    minimum: float | None
    maximum: float | None
    position: str
    slides: bool
