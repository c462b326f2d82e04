"""Look into a FITS file: what it says of itself, whether it is sound, and how it looks.

astropy is imported when the first file comes (half a second), and only here. Everything in this
module takes a while and belongs on a thread.
"""

from __future__ import annotations

import math
import struct
import warnings
import zlib
from contextlib import contextmanager
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from talaia.hub.errors import HubError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from numpy.typing import NDArray

__all__ = [
    "PREVIEW_PX",
    "SMALL_PX",
    "STRETCHES",
    "Facts",
    "Looks",
    "NotKept",
    "TooMuchToRead",
    "facts_of",
    "looks_of",
    "preview_of",
    "unread_facts",
]

# What pages may ask for; the first is what they ask for by themselves.
STRETCHES = ("asinh", "linear", "log")
# As the header says, before any memory is taken for them; and so many bytes of them, for a pixel
# may have eight.
MOST_PIXELS = 250_000_000
MOST_BYTES = 1_000_000_000
# What a file begins with (FITS 4.0, 4.4.1.1). astropy opens more than that, by itself: what gzip
# and others have packed, and unpacks it whole.
_FIRST_CARD = b"SIMPLE  ="
PREVIEW_PX, SMALL_PX = 1024, 320
BINS = 64
_MOST_CARDS = 600  # shown of a header
_SAMPLE = 200_000  # pixels that statistics and histogram are made of, evenly spread


class NotKept(HubError):
    """A file that cannot go into the archive."""


class TooMuchToRead(HubError):
    """A file that may be a picture in FITS, and takes more to read than may be had."""


class Facts(NamedTuple):
    """What a header says.

    Attributes:
        time_us: when the exposure began (UTC); 0 where the header does not say.
        kind: light, dark, flat, bias, in the camera's own word.
        exposure_s: NaN where it is not said.
        ra_deg: J2000; NaN where it is not said.
        problems: what the verification found, one sentence each; none is good.

    """

    time_us: int
    target: str
    filter: str
    kind: str
    exposure_s: float
    ra_deg: float
    dec_deg: float
    width: int
    height: int
    problems: tuple[str, ...]


class Looks(NamedTuple):
    """How a picture's values lie.

    Attributes:
        low: of the histogram's first bin; the darkest that is shown by most displays.
        high: of its last.
        counts: pixels in each of `BINS` bins of equal width.

    """

    minimum: float
    maximum: float
    median: float
    deviation: float
    low: float
    high: float
    counts: tuple[int, ...]
    cards: tuple[tuple[str, str, str], ...]


def facts_of(path: Path) -> Facts:
    """Check a file and read its facts.

    Raises:
        NotKept: it is not FITS, has no picture, or astropy is not installed.

    """
    said: list[str] = []
    with _open_fits(path, said) as hdus:
        # Kept with the file, which is taken all the same: it may be all that there is of a night.
        problems = (*said, *_verify_fits(hdus))[:20]
        hdu = _find_picture(hdus)
        first, header = hdus[0].header, hdu.header

        def word(*keys: str) -> str:
            # The picture's own header goes before the primary one.
            found = (_header_value(part, key) for key in keys for part in (header, first))
            return next((str(text).strip()[:200] for text in found if text not in (None, "")), "")

        def number(*keys: str) -> float:
            for key in keys:
                for part in (header, first):
                    value = _header_value(part, key)
                    # A text in the place of a number is as if it were not said.
                    if isinstance(value, int | float) and math.isfinite(value):
                        return float(value)
            return math.nan

        # numpy's order is the reverse of NAXIS1, NAXIS2, …
        height, width = hdu.shape[-2:]
        return Facts(
            _time_us(word("DATE-OBS")),
            word("OBJECT"),
            word("FILTER"),
            word("IMAGETYP", "FRAME") or "unknown",
            number("EXPTIME", "EXPOSURE"),
            number("RA", "CRVAL1"),
            number("DEC", "CRVAL2"),
            int(width),
            int(height),
            problems,
        )


def unread_facts(why: str) -> Facts:
    """Give what is said of a file that could not be read."""
    unknown = math.nan
    return Facts(0, "", "", "unknown", unknown, unknown, unknown, 0, 0, (f"not read: {why}",))


def looks_of(path: Path) -> Looks:
    """Give statistics, histogram and header cards (keyword, value, comment).

    Raises:
        NotKept: it cannot be read any more.

    """
    with _open_fits(path) as hdus:
        hdu = _find_picture(hdus)
        values = _sample_pixels(_read_plane(hdu))
        cards = [
            card
            for unit in ([hdu] if hdu is hdus[0] else [hdus[0], hdu])
            for card in unit.header.cards
        ]
        shown = tuple(
            (str(card.keyword), "" if card.is_blank else str(card.value)[:200], str(card.comment))
            for card in cards[:_MOST_CARDS]
        )
    if not values.size:
        return Looks(*(math.nan,) * 6, (), shown)
    # Hot and dead pixels would otherwise leave all others in one bin.
    low, high = (float(percentile) for percentile in np.percentile(values, (0.1, 99.9)))
    # A picture of one value, such as a bias of a simulator, has no width.
    high = high if high > low else low + 1.0
    try:
        counts, _ = np.histogram(values, BINS, (low, high))
    except ValueError:
        # So large, and so near to each other, that no bins fit between them.
        counts = np.zeros(BINS, np.intp)
    return Looks(
        float(values.min()),
        float(values.max()),
        float(np.median(values)),
        float(values.std()),
        low,
        high,
        tuple(int(count) for count in counts),
        shown,
    )


def preview_of(path: Path, stretch: str, most_px: int = PREVIEW_PX) -> bytes:
    """Draw a picture as a grey PNG, north as the file has it (first row at the bottom).

    Limits are IRAF's zscale; ``asinh`` and ``log`` lift what is faint.

    Raises:
        NotKept: it cannot be read any more.

    """
    with _open_fits(path) as hdus:
        plane = _read_plane(_find_picture(hdus))
        step = max(1, math.ceil(max(plane.shape) / most_px))
        # Made small first: limits and curve then go over far fewer pixels.
        small = _bin_pixels(plane, step)
    low, high = _stretch_limits(small, stretch)
    with np.errstate(invalid="ignore"):
        part = np.clip((small - low) / (high - low), 0.0, 1.0)
    # The curves of astropy's AsinhStretch(0.1) and LogStretch(1000), which are its defaults.
    if stretch == "asinh":
        part = np.arcsinh(part * 10.0) / math.asinh(10.0)
    elif stretch == "log":
        part = np.log1p(part * 1000.0) / math.log1p(1000.0)
    # Pixels without a value are black.
    grey = np.nan_to_num(part * 255.0).astype(np.uint8)
    return _encode_png(grey[::-1])


# ── inside ──


@contextmanager
def _open_fits(path: Path, said: list[str] | None = None) -> Iterator[Any]:
    """Open a file; what a hostile one makes astropy raise, anywhere, becomes `NotKept`.

    Warnings at opening go to ``said``.
    """
    try:
        # Here, since half a second of import is not for a hub that has no telescope.
        from astropy.io import fits
    except ImportError as error:
        raise NotKept("the hub cannot read FITS: install talaia[observatory]") from error
    with path.open("rb") as file:
        if file.read(len(_FIRST_CARD)) != _FIRST_CARD:
            raise NotKept("it is not a FITS file: its first card is not SIMPLE")
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            # Every part is read now, so that what is wrong with any of them is said here.
            hdus = fits.open(path, mode="readonly", memmap=False, lazy_load_hdus=False)
    except MemoryError:
        raise
    except Exception as error:
        # A damaged or hostile header can raise nearly anything in astropy.
        raise NotKept(f"it is not a FITS file: {error}") from error
    if said is not None:
        said += _warning_texts(caught)
    with hdus, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            yield hdus
        except (NotKept, MemoryError):
            raise
        except Exception as error:
            raise NotKept(f"it cannot be read: {type(error).__name__}: {error}"[:500]) from error


def _verify_fits(hdus: Any) -> list[str]:  # noqa: ANN401 - astropy ships no types
    """Give what `astropy.io.fits` finds against the standard."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            hdus.verify("warn")
        except Exception as error:  # noqa: BLE001 - a hostile header can raise anything there
            return [f"{type(error).__name__}: {error}"[:300]]
    return _warning_texts(caught)


def _warning_texts(caught: list[warnings.WarningMessage]) -> list[str]:
    said = [" ".join(str(warning.message).split())[:300] for warning in caught]
    # astropy's own frame round the list of what it found.
    return [line for line in said if not line.startswith(("Verification reported", "Note:"))]


def _header_value(header: Any, key: str) -> object:  # noqa: ANN401
    """Give a value; one that cannot be read is as if it were not there."""
    try:
        return header.get(key)
    except Exception:  # noqa: BLE001 - it is named among the problems
        return None


def _find_picture(hdus: Any) -> Any:  # noqa: ANN401
    """Find the first picture, and see that it is one before its data are touched."""
    for hdu in hdus:
        shape = getattr(hdu, "shape", ())
        # A primary part without data, or a table, which often stand before the picture.
        if not getattr(hdu, "is_image", False) or len(shape) < 2:
            continue
        if math.prod(shape) > MOST_PIXELS or min(shape) < 1:
            raise NotKept(f"a picture of {'x'.join(map(str, shape))} pixels is not kept")
        if math.prod(shape) * abs(int(hdu.header.get("BITPIX", 64))) // 8 > MOST_BYTES:
            raise NotKept(f"a picture of more than {MOST_BYTES} bytes is not kept")
        return hdu
    raise NotKept("there is no picture in it")


def _read_plane(hdu: Any) -> NDArray[np.float64]:  # noqa: ANN401
    try:
        data = hdu.data
    except MemoryError:
        raise
    except Exception as error:
        raise NotKept(f"its picture cannot be read: {error}") from error
    if data is None:
        raise NotKept("its picture has no data")
    while data.ndim > 2:  # a cube: its first plane
        data = data[0]
    return np.asarray(data)


def _sample_pixels(plane: NDArray[Any]) -> NDArray[np.float64]:
    # The same step along both axes.
    step = max(1, math.isqrt(plane.size // _SAMPLE))
    values = plane[::step, ::step].astype(np.float64).ravel()
    # NaN is how FITS marks pixels without a value in floating-point pictures.
    return values[np.isfinite(values)]


def _bin_pixels(plane: NDArray[Any], step: int) -> NDArray[np.float64]:
    """Average blocks, so that noise does not hide what is faint."""
    if step == 1:
        return plane.astype(np.float64)
    # What is left over at the edges makes no whole block.
    rows, columns = (size // step * step for size in plane.shape)
    # A spectrum of a few rows, say: thinner than one block.
    if not rows or not columns:
        return plane[::step, ::step].astype(np.float64)
    cut = plane[:rows, :columns]
    blocks = cut.reshape(rows // step, step, columns // step, step)
    return np.asarray(blocks.mean(axis=(1, 3), dtype=np.float64))


def _stretch_limits(values: NDArray[np.float64], stretch: str) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    if not finite.size:
        return 0.0, 1.0
    # Imported where it is used, like astropy's reader.
    from astropy.visualization import ZScaleInterval

    low, high = (float(limit) for limit in ZScaleInterval().get_limits(finite))
    if stretch != "linear":
        # Stars stand far above what zscale shows; these stretches have room for them.
        high = max(high, float(np.percentile(finite, 99.8)))
    return low, (high if high > low else low + 1.0)


def _encode_png(grey: NDArray[np.uint8]) -> bytes:
    """Write an 8-bit grey PNG (W3C PNG, third edition), which needs no library."""
    height, width = grey.shape
    rows = np.zeros((height, width + 1), np.uint8)  # each row begins with its filter: none
    rows[:, 1:] = grey

    def png_chunk(kind: bytes, body: bytes) -> bytes:
        whole = kind + body
        # Length of the body; the checksum is over kind and body.
        return struct.pack(">I", len(body)) + whole + struct.pack(">I", zlib.crc32(whole))

    # 8 bits of grey (colour type 0), the only compression and filter method, not interlaced.
    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    data = zlib.compress(rows.tobytes(), 4)
    return (
        b"\x89PNG\r\n\x1a\n"
        + png_chunk(b"IHDR", head)
        + png_chunk(b"IDAT", data)
        + png_chunk(b"IEND", b"")
    )


def _time_us(text: str) -> int:
    try:
        found = datetime.fromisoformat(text.strip())
    except ValueError:
        return 0
    # DATE-OBS has no zone: FITS times are UTC unless TIMESYS says otherwise.
    found = found.replace(tzinfo=UTC) if found.tzinfo is None else found
    return max(0, round(found.timestamp() * 1e6))
