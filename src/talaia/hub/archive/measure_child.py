"""A process that measures pictures: ``python -m talaia.hub.archive.measure_child SECONDS``.

It reads names of FITS files, one in a line, and writes for each a line of JSON, a `MeasuredFile`.
Where something was found it writes the file anew beside the old one (``.measured``), with the
cards added and every byte of the pixels as it came. A process of its own, because to solve a large
picture takes seconds in which no STOP could be relayed, and because a hostile file may kill it.
One that takes more than so many seconds of a processor ends the process (SIGPROF).
"""

from __future__ import annotations

import os
import shutil
import signal
import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.hub.archive.child_limits import limit_this_process

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["MeasuredFile", "main"]

# So large a file takes minutes, and gigabytes of memory.
MOST_BYTES = 400_000_000
_ROUGH_WCS = ("CDELT1", "CDELT2", "CROTA1", "CROTA2", "PC1_1", "PC1_2", "PC2_1", "PC2_2")
# On pictures of these kinds there are no stars.
_STARLESS = ("dark", "bias", "flat", "zero")


class MeasuredFile(NamedTuple):
    """What was found out of a file.

    Attributes:
        note: why it was not solved, or not measured; empty when all was done.
        stars: how many; None where they were not counted.
        fwhm: of its stars (arc seconds).
        background: of the sky (counts).
        zero_point: magnitude of a star that gives one count in a second.
        wcs: where its pixels stand: ``[ra, dec, x, y, cd1_1, cd1_2, cd2_1, cd2_2]``, degrees and
            pixels from 0; empty where it was not solved.
        center: of the picture (RA and Dec, °, J2000); empty where it was not solved.
        made: a new file with these cards lies beside it.

    """

    note: str = ""
    stars: int | None = None
    fwhm: float | None = None
    background: float | None = None
    zero_point: float | None = None
    wcs: tuple[float, ...] = ()
    center: tuple[float, ...] = ()
    made: bool = False


def main() -> None:
    """Measure what is named on the input, until it ends."""
    limit_this_process(most_written=2 * MOST_BYTES)
    # Whoever looks after robots on this machine goes first.
    os.nice(10)
    most_s = float(sys.argv[1])
    for line in sys.stdin:
        # Of the processor, not of the clock: this process gives way to all others, and how long it
        # waits for them is no matter of the picture's.
        signal.setitimer(signal.ITIMER_PROF, most_s)
        path = Path(msgspec.json.decode(line, type=str))
        try:
            measured = measure_file(path)
        except Exception as error:  # noqa: BLE001 - a hostile file can raise anything there
            measured = MeasuredFile(note=f"{type(error).__name__}: {error}"[:300])
        sys.stdout.write(msgspec.json.encode(measured).decode() + "\n")
        sys.stdout.flush()


def measure_file(path: Path) -> MeasuredFile:
    """Measure one file."""
    if path.stat().st_size > MOST_BYTES:
        return MeasuredFile(note="it is too large to be measured")
    try:
        from talaia.imaging.errors import UnreadableFrame
        from talaia.imaging.fits_pixels import read_frame
        from talaia.imaging.frame_tasks import solve_frame
        from talaia.imaging.tangent_plane import TanWcs
    except ImportError as error:
        return MeasuredFile(note=f"the hub cannot measure stars: {error}")
    data = path.read_bytes()
    try:
        header, pixels = read_frame(data)
    except UnreadableFrame as error:
        return MeasuredFile(note=str(error))
    solved = solve_frame(data)
    cards: dict[str, tuple[str | float, str]] = {
        key: (value, said) for key, value, said in solved.cards
    }
    kind = str(header.get("IMAGETYP", header.get("FRAME", ""))).lower()
    if any(word in kind for word in _STARLESS):
        # What looks like a star there is a hot pixel.
        cards = {key: cards[key] for key in ("SKYLEVEL", "SKYNOISE") if key in cards}
        solved = solved._replace(problem="")
    wcs = TanWcs.from_header({key: value for key, (value, _) in cards.items()})
    if header.get("PLTSOLVD") is True or "-SIP" in str(header.get("CTYPE1", "")):
        # What its camera's program has solved stays: it may know of distortions, too.
        cards = {key: card for key, card in cards.items() if key not in header}
        wcs = TanWcs.from_header(header) or wcs
    elif wcs is not None:
        cards["PLTSOLVD"] = (True, "solved from its stars")

    center: tuple[float, ...] = ()
    if wcs is not None:
        rows, columns = pixels.shape
        ra, dec = wcs.pixel_to_sky([(columns - 1) / 2], [(rows - 1) / 2])
        center = (float(ra[0]), float(dec[0]))

    def number(key: str) -> float | None:
        value = cards.get(key, (None, ""))[0]
        return float(value) if isinstance(value, (int, float)) else None

    stars = number("NSTARS")
    return MeasuredFile(
        note=solved.problem[:300] if wcs is None else "",
        stars=None if stars is None else int(stars),
        fwhm=number("FWHM"),
        background=number("SKYLEVEL"),
        zero_point=number("MAGZP"),
        wcs=(wcs.ra, wcs.dec, wcs.x, wcs.y, *wcs.cd) if wcs is not None else (),
        center=center,
        made=bool(cards) and _write_anew(path, cards),
    )


def _write_anew(path: Path, cards: Mapping[str, tuple[str | float, str]]) -> bool:
    """Write the file beside itself with these cards in its header, whole and on the disk."""
    from astropy.io import fits

    with warnings.catch_warnings(), path.open("rb") as old:
        warnings.simplefilter("ignore")
        # The header alone: astropy would scale the pixels.
        header = fits.Header.fromfile(old)
        if "CD1_1" in cards:
            # Of an estimate from where the mount points, which would contradict the matrix.
            for key in _ROUGH_WCS:
                header.remove(key, ignore_missing=True, remove_all=True)
        for key, (value, said) in cards.items():
            header[key] = (value, said)
        text = header.tostring().encode("ascii")
        with path.with_suffix(".measured").open("wb") as new:
            new.write(text)
            # Behind the old header's last block.
            shutil.copyfileobj(old, new, 1024 * 1024)
            new.flush()
            os.fsync(new.fileno())
    return True


if __name__ == "__main__":
    main()
