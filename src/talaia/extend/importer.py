"""For a format of files that ``talaia import`` reads (entry point ``talaia.importers``)."""

from __future__ import annotations

from talaia.extensions.declarations import (
    ImportedSample,
    ImporterExtension,
    ImportProblem,
    ImportRequest,
)

__all__ = ["ImportProblem", "ImportRequest", "ImportedSample", "ImporterExtension"]
