"""The version of the description's format: which one this Talaia reads, and which a text is of."""

from __future__ import annotations

from talaia.model.errors import DescriptionError

__all__ = ["FORMAT", "OLDEST", "require_current", "version_of"]

FORMAT = 1
# The first one that was ever published; `upgrade` leads from each to the newest.
OLDEST = 1


def version_of(found: object, newest: int = FORMAT, oldest: int = OLDEST) -> int:
    """Give the version that the key ``talaia`` names.

    Raises:
        DescriptionError: it names none, or one that is not known here.

    """
    where, remedy = "$.talaia", f"write: talaia: {newest}"
    # For Python True is an int.
    if found is None or isinstance(found, bool) or not isinstance(found, int):
        said = "it is missing" if found is None else f"found {found!r}"
        raise DescriptionError(where, f"expected the format version {newest}, {said}", remedy)
    if found > newest:
        raise DescriptionError(
            where,
            f"the description is of format version {found}, and this Talaia knows {newest}",
            "use a newer Talaia: pip install --upgrade talaia",
        )
    if found < oldest:
        raise DescriptionError(
            where, f"there never was a format version {found}; the oldest is {oldest}", remedy
        )
    return found


def require_current(found: object) -> None:
    """See that a description is of the version that is read here.

    Raises:
        DescriptionError: it is not.

    """
    version = version_of(found)
    if version < FORMAT:
        raise DescriptionError(
            "$.talaia",
            f"the description is of format version {version}, and now it is {FORMAT}",
            "run: talaia upgrade --write FILE",
        )
