"""Whether pyarrow is here, which is an extra: it is as large as all else that a hub installs."""

from __future__ import annotations

import importlib.util

from talaia.hub.errors import LibraryMissing

__all__ = ["has_arrow", "require_arrow"]


def has_arrow() -> bool:
    """Tell whether pyarrow is installed, without importing it."""
    return importlib.util.find_spec("pyarrow") is not None


def require_arrow(what: str) -> None:
    """Refuse what cannot be done without pyarrow.

    Args:
        what: begins the sentence: "Parquet files".

    Raises:
        LibraryMissing: it is not installed; says which extra brings it.

    """
    if not has_arrow():
        raise LibraryMissing(
            f"{what} need the Python package 'pyarrow', which is not installed at the hub",
            "run there: pip install 'talaia[arrow]'",
        )
