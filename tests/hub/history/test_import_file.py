"""Recordings and tables come into the history as the gateway would have brought them."""

# ruff: noqa: E501 - a table of refusals reads best with a line for each
# ruff: noqa: ASYNC110 - what is waited for happens in another process

from __future__ import annotations

import asyncio
import signal
from contextlib import asynccontextmanager

import numpy as np
import pytest
import sqlalchemy as sa
from async_program import start_program
from patience import PATIENCE_S

from talaia.cli.errors import CliError
from talaia.cli.importing.delivery import deliver_parcels
from talaia.cli.main import main
from talaia.clock import SystemClock
from talaia.hub.history.import_file import FOLDER, READY
from talaia.hub.history.queries.export_formats import ExportColumn, FileForm
from talaia.hub.history.store import HistoryStore
from talaia.hub.live.files.import_inbox import BAD
from talaia.hub.lock import hub_lock
from talaia.hub.settings import Settings
from talaia.hub.store import history_tables as tables
from talaia.hub.store.database import Database
from talaia.hub.store.database_url import parse_database_url
from talaia.hub.store.sites.site_registry import SiteRegistry

from .. import recordings
from ..recordings import FORMATS, SITE, STEPS, expected

ALL = (0, 2**61)
ADDRESSES = (
    "base/speed", "base/pose.x", "base/pose.yaw", "base/mode", "base/speed1", "mast/wind",
)  # fmt: skip


@pytest.fixture
def data(tmp_path):
    """Give a hub's data folder with a description beside it."""
    (tmp_path / "data").mkdir()
    (tmp_path / "rover.yaml").write_text(SITE)
    return tmp_path / "data"


def imported(data, *words, site="rover.yaml"):
    """Run the command as a person would, in this process."""
    return main(
        ["import", "--site", str(data.parent / site), "--data", str(data), *map(str, words)]
    )


@asynccontextmanager
async def history(url):
    blocking = parse_database_url(url, blocking=True).url.render_as_string(hide_password=False)
    store = HistoryStore(blocking, SystemClock())
    await store.open()
    try:
        yield store
    finally:
        await store.close()


async def read(url, *addresses, site="rover"):
    async with history(url) as store:
        return await store.read_series(site, addresses, *ALL, width=100_000)


def own_url(data):
    return Settings(data=data).url


async def same_as_told(url, count=STEPS):
    for series, address in zip(await read(url, *ADDRESSES), ADDRESSES, strict=True):
        times, values = expected(address, count)
        assert series.exact
        assert series.time_us.tolist() == times, address
        assert np.allclose(series.value, values, rtol=1e-7, atol=1e-9), address
    (said,) = await read(url, "base/said")
    times, texts = expected("base/said", count)
    assert said.time_us.tolist() == times
    assert [said.texts[at] for at in range(len(times))] == texts


@pytest.mark.parametrize("form", FORMATS)
def test_what_a_recording_holds_is_in_the_history_afterwards(form, data, capsys) -> None:
    path = FORMATS[form](data.parent)
    assert imported(data, path) == 0
    asyncio.run(same_as_told(own_url(data)))
    said = capsys.readouterr().out
    assert "base/speed   " in said
    assert "100 samples" in said
    assert "not in the file: mast/absent (the file has no topic /nowhere)" in said
    assert "not read: /unread" in said
    assert "samples are in the history now" in said
    assert not list((data / FOLDER).iterdir())


async def test_each_database_takes_an_import_once(database_url, data, monkeypatch, capsys) -> None:
    monkeypatch.setenv("TALAIA_DATABASE_URL", database_url)
    # Enough for blocks and their rollups.
    values = [at % 977 / 8 for at in range(24_000)]
    path = data.parent / "long.csv"
    rows = "".join(f"{1_700_000_000 + at},{value}\n" for at, value in enumerate(values))
    path.write_text("t,base/speed\n" + rows)
    assert await asyncio.to_thread(imported, data, path) == 0
    async with history(database_url) as store:
        before = await store.read_statistics("rover", ["base/speed"], *ALL)
        (series,) = await store.read_series("rover", ["base/speed"], *ALL, width=30_000)
    assert series.value.tolist() == values
    assert before[0].low.value == min(values)
    assert before[0].high.value == max(values)
    assert before[0].mean == pytest.approx(sum(values) / 24_000)
    assert [each.samples for each in before] == [24_000]
    capsys.readouterr()
    assert await asyncio.to_thread(imported, data, path) == 0
    assert "all of its 24,000 samples were there already" in capsys.readouterr().out
    async with history(database_url) as store:
        assert await store.read_statistics("rover", ["base/speed"], *ALL) == before
    # Commits that follow also write the blocks with their rollups.
    more = [table(data, f"t,base/speed\n180000000{at},1\n", f"more{at}.csv") for at in range(4)]
    assert await asyncio.to_thread(imported, data, *more) == 0
    engine = sa.create_engine(parse_database_url(database_url, blocking=True).url)
    query = sa.select(sa.func.sum(tables.rollup.c.samples)).where(
        tables.rollup.c.width_us == 21_600_000_000
    )
    with engine.connect() as connection:
        rolled_up = connection.scalar(query)
    engine.dispose()
    assert rolled_up >= 4_096


def test_a_signal_that_was_described_later_is_added_alone(data, capsys) -> None:
    path = recordings.write_rosbag2_sqlite(data.parent)
    less = SITE.replace("/weather", "/elsewhere")
    (data.parent / "less.yaml").write_text(less)
    assert imported(data, path, site="less.yaml") == 0
    capsys.readouterr()
    assert imported(data, path) == 0
    assert "100 samples are in the history now, 610 were there already" in capsys.readouterr().out
    asyncio.run(same_as_told(own_url(data)))


def test_a_dry_run_tells_all_and_writes_nothing(data, capsys) -> None:
    path = recordings.write_rosbag1(data.parent)
    assert imported(data, path, "--dry-run") == 0
    said = capsys.readouterr().out
    assert "base/speed   " in said
    assert "2023-11-14 22:13:20Z to 2023-11-14 22:13:21Z" in said
    assert "nothing was written" in said
    assert list(data.iterdir()) == []


def test_thinning_is_that_of_the_description(data) -> None:
    rule = "unit: km/h\n        max_rate: 10\n        max_age: 60"
    (data.parent / "slow.yaml").write_text(SITE.replace("unit: km/h", rule))
    assert imported(data, recordings.write_mcap_ros2(data.parent), site="slow.yaml") == 0
    (series,) = asyncio.run(read(own_url(data), "base/speed"))
    apart = np.diff(series.time_us)
    assert apart.min() >= 100_000
    assert apart.max() <= 120_100
    assert series.value[-1] == pytest.approx(99 / 7 * 3.6)


@pytest.mark.parametrize("form", ["rosbag1", "db3", "mcap-ros2", "rosbag2-mcap"])
@pytest.mark.parametrize("part", [0.4, 0.99])
def test_a_file_that_was_cut_off_is_named_and_nothing_of_it_stays(form, part, data, capsys) -> None:
    path = FORMATS[form](data.parent)
    cut = next(path.glob("*.mcap")) if path.is_dir() else path
    whole = recordings.write_mcap_json(data.parent)
    with cut.open("r+b") as file:
        file.truncate(int(cut.stat().st_size * part))
    assert imported(data, whole, path) == 2
    said = capsys.readouterr().err
    assert str(path) in said
    assert "nothing was imported" in said
    assert list((data / FOLDER).iterdir()) == []
    assert not (data / "talaia.db").exists()


@pytest.mark.parametrize("place", range(200, 40_000, 7_989))
def test_a_damaged_byte_is_an_error_or_harmless_but_never_half_an_import(place, data, capsys):
    path = recordings.write_mcap_ros2(data.parent)
    with path.open("r+b") as file:
        place %= path.stat().st_size
        file.seek(place)
        byte = file.read(1)
        file.seek(place)
        file.write(bytes([byte[0] ^ 0x5A]))
    if imported(data, path) == 2:
        assert "it cannot be read as MCAP" in capsys.readouterr().err
        assert not (data / "talaia.db").exists()


def test_a_file_that_is_no_recording_is_refused(data, capsys) -> None:
    for name, body, said in (
        ("empty.bag", b"", "it is empty"),
        ("noise.bag", b"\0\1\2\3" * 9, "its format is none of"),
        ("noise.mcap", b"hello", "its format is none of"),
        ("missing.bag", None, "cannot be opened: No such file"),
    ):
        path = data.parent / name
        if body is not None:
            path.write_bytes(body)
        assert imported(data, path) == 2
        assert said in capsys.readouterr().err
    (data.parent / "folder").mkdir()
    assert imported(data, data.parent / "folder") == 2
    assert "ros2 bag reindex" in capsys.readouterr().err


def test_another_type_than_the_described_one_is_not_read(data, capsys) -> None:
    other = SITE.replace(
        "/wandering, type: std_msgs/msg/Bool", "/wandering, type: std_msgs/msg/UInt8"
    )
    (data.parent / "other.yaml").write_text(other)
    assert (
        imported(data, recordings.write_rosbag1(data.parent), "--dry-run", site="other.yaml") == 0
    )
    said = capsys.readouterr().out
    assert "base/mode (/wandering is std_msgs/msg/Bool in the file, and std_msgs/msg/UInt8" in said


# ── tables ──


def table(data, text, name="log.csv"):
    path = data.parent / name
    path.write_text(text, encoding="utf-8")
    return path


def test_a_table_comes_in_by_address_or_by_name(data, capsys) -> None:
    path = table(
        data,
        "\ufefftime;v;base/mode;base/said;base/pose.x;note\r\n"
        "2024-01-31T12:00:00Z;1.5;on;hello;;x\r\n"
        '2024-01-31T13:00:01.000001+01:00;-inf;0;"a; ""b""";7e3;\r\n'
        "\r\n"
        "2024-01-31 12:00:02.5Z;nan;off;;;\r\n",
    )
    assert imported(data, path, "--column", "v=base/speed") == 0
    start = 1_706_702_400_000_000
    speed, mode, said, x = asyncio.run(
        read(own_url(data), "base/speed", "base/mode", "base/said", "base/pose.x")
    )
    times = [start, start + 1_000_001, start + 2_500_000]
    assert speed.time_us.tolist() == times
    assert speed.value[:2].tolist() == [1.5, -np.inf]
    assert np.isnan(speed.value[2])
    assert mode.value.tolist() == [1, 0, 0]
    assert said.texts == {0: "hello", 1: 'a; "b"'}
    assert (x.time_us.tolist(), x.value.tolist()) == ([times[1]], [7000.0])
    assert "not read: note (no channel of that name)" in capsys.readouterr().out


async def test_a_table_that_was_exported_comes_back(data) -> None:
    path = recordings.write_rosbag2_mcap(data.parent)
    assert await asyncio.to_thread(imported, data, path) == 0
    columns = [
        ExportColumn("base/speed", "km/h"),
        ExportColumn("base/mode", states=("off", "on")),
        ExportColumn("base/said", text=True),
    ]
    async with history(own_url(data)) as store:
        pieces = [p async for p in store.export_samples("rover", columns, *ALL, form=FileForm.CSV)]
    exported = data.parent / "export.csv"
    exported.write_bytes(b"".join(pieces))
    other = data.parent / "other"
    other.mkdir()
    assert await asyncio.to_thread(imported, data, "--data", other, exported) == 0
    for address in ("base/speed", "base/mode", "base/said"):
        (was,), (now,) = await read(own_url(data), address), await read(own_url(other), address)
        assert was.time_us.tolist() == now.time_us.tolist()
        assert np.array_equal(was.value, now.value, equal_nan=True)
        assert was.texts == now.texts


@pytest.mark.parametrize(
    ("text", "words", "said"),
    [
        ("base/speed\n1\n", (), "line 1: which column holds the times?; name it with --time"),
        ("time,base/speed\n2024-01-31T12:00:00,1\n", (), "line 2, column 'time': the time '2024"),
        ("time,base/speed\n0,1\n1,x\n", (), "line 3, column 'base/speed': expected a number"),
        ("time;base/speed\n0;1,5\n", (), "line 2, column 'base/speed': expected a number, found '1,5'; write a point"),
        ("time,base/speed\n0,1\n\n2\n", (), "line 4: expected 2 cells as in the heading, found 1"),
        ("time,base/mode\n0,maybe\n", (), "expected one of off, on, found 'maybe'"),
        ("time,base/mode\n0,0.5\n", (), "expected one of off, on, found '0.5'"),
        ("time,base/mode\n0,inf\n", (), "expected one of off, on, found 'inf'"),
        ("time,base/speed\n2024-13-01,1\n", (), "line 2, column 'time': the time '2024-13-01'"),
        ("time,base/speed\n0,1\nsoon,1\n", (), "line 3, column 'time': expected a time as a number (s)"),
        ("time,base/speed\n1e29,1\n", (), "is too far away"),
        ("time,a\n0,1\n", ("--column", "b=base/speed"), "there is no column 'b'; there are 'time', 'a'"),
        ("time,a\n0,1\n", ("--column", "a=base/nose"), "the description has no channel 'base/nose'"),
        ("time,a\n0,1\n", ("--column", "base/speed"), "expected HEADING=ADDRESS"),
        ("time,base/speed,base/speed\n0,1,1\n", (), "base/speed is in two columns"),
        ("time,a\n0,1\n", ("--time", "when"), "there is no column 'when'"),
        ("time,a\n0,1\n", ("--zone", "Mars"), "--zone Mars: no such time zone"),
        ('time,base/said\n0,"a\nb"\n1,"c\n', (), "line 4"),
        ("time,base/speed\n2024-03-31T02:30:00,1\n", ("--zone", "Europe/Madrid"), "never showed"),
    ],
)  # fmt: skip
def test_a_wrong_table_is_refused_with_the_place(text, words, said, data, capsys) -> None:
    assert imported(data, table(data, text), *words) == 2
    assert said in capsys.readouterr().err
    assert not (data / "talaia.db").exists()


def test_bytes_that_are_not_utf8_are_named(data, capsys) -> None:
    path = data.parent / "latin.csv"
    path.write_bytes("time,base/said\n0,ok\n1,caf\xe9\n".encode("latin-1"))
    assert imported(data, path) == 2
    assert "it is not UTF-8" in capsys.readouterr().err


def test_a_column_in_another_unit_is_not_read(data, capsys) -> None:
    assert imported(data, table(data, "t,base/speed (m/s),base/pose.x\n0,1,2\n"), "--dry-run") == 0
    assert "not read: base/speed (m/s) (base/speed is in km/h)" in capsys.readouterr().out


# ── beside a hub ──


async def running_hub(data, url):
    words = ["-m", "talaia", "hub", "--data", str(data), "--port", "0", "--plain"]
    process = await start_program(*words, TALAIA_DATABASE_URL=url)
    assert "is ready" in (await asyncio.wait_for(process.stdout.readline(), PATIENCE_S)).decode()
    return process


async def test_an_import_beside_a_running_hub_is_taken_over_by_it(
    data, monkeypatch, capsys
) -> None:
    # What each database does with an import is seen without a program above.
    database_url = own_url(data)
    monkeypatch.setenv("TALAIA_DATABASE_URL", database_url)
    path = recordings.write_rosbag2_sqlite(data.parent)
    process = await running_hub(data, database_url)
    try:
        assert await asyncio.to_thread(imported, data, path) == 0
        said = capsys.readouterr()
        assert "the hub is running and imports it" in said.err
        assert "710 samples are in the history now" in said.out
        # Nothing else of the site is known to it; now it knows the description, too.
        assert await asyncio.to_thread(imported, data, path, "--site", "rover") == 0
        assert "were there already" in capsys.readouterr().out
    finally:
        process.send_signal(signal.SIGTERM)
        assert await asyncio.wait_for(process.wait(), PATIENCE_S) == 0
    await same_as_told(database_url)
    database = Database(database_url)
    assert [each.site for each in await SiteRegistry(database, SystemClock()).list_sites()] == [
        "rover"
    ]
    await database.close()


async def test_an_import_that_was_broken_off_is_taken_up_by_the_hub(data, monkeypatch) -> None:
    """Kill the importer when its parcel is complete, and then the hub in the middle of taking it."""
    path = recordings.write_mcap_ros2(data.parent, 1_000)
    words = ["import", str(path), "--site", str(data.parent / "rover.yaml"), "--data", str(data)]
    # While somebody else has the folder, the import waits.
    with hub_lock(data):
        process = await start_program("-m", "talaia", *words)
        while not list((data / FOLDER).glob(f"*{READY}")) and process.returncode is None:
            await asyncio.sleep(0.05)
        process.kill()
        await process.wait()
    (parcel,) = (data / FOLDER).glob(f"*{READY}")
    for _ in range(2):
        hub = await running_hub(data, "")
        await asyncio.sleep(0)
        hub.kill()
        await hub.wait()
    hub = await running_hub(data, "")
    while parcel.exists():
        await asyncio.sleep(0.05)
    hub.send_signal(signal.SIGTERM)
    assert await asyncio.wait_for(hub.wait(), PATIENCE_S) == 0
    await same_as_told(own_url(data), 1_000)


async def test_a_damaged_parcel_is_set_aside_and_the_hub_goes_on(data) -> None:
    (data / FOLDER).mkdir()
    (data / FOLDER / f"a{READY}").write_bytes(b"talaia import 1\n\x05\0\0\0\0\0\0\0hello")
    (data / FOLDER / "b.part").write_bytes(b"left behind")
    hub = await running_hub(data, "")
    while not (data / FOLDER / "a.bad").exists():
        await asyncio.sleep(0.05)
    hub.send_signal(signal.SIGTERM)
    assert await asyncio.wait_for(hub.wait(), PATIENCE_S) == 0
    assert {each.name for each in (data / FOLDER).iterdir()} == {"a.bad"}


async def test_an_import_that_the_hub_set_aside_is_an_error_and_not_there_already(data) -> None:
    (data / FOLDER).mkdir()
    parcel = data / FOLDER / f"a{READY}"
    # As a hub leaves it that could not read it.
    parcel.with_suffix(BAD).write_bytes(b"damaged on its way")
    with hub_lock(data), pytest.raises(CliError, match=r"a\.bad and set it aside"):
        deliver_parcels(Settings(data=data), [parcel], lambda _: None)


async def test_two_hubs_never_share_a_data_folder(data) -> None:
    hub = await running_hub(data, "")
    words = ["-m", "talaia", "hub", "--data", str(data), "--port", "0", "--plain"]
    other = await start_program(*words, with_errors=True)
    _, said = await asyncio.wait_for(other.communicate(), PATIENCE_S)
    assert other.returncode == 2
    assert "is used by another hub" in said.decode()
    hub.send_signal(signal.SIGTERM)
    await hub.wait()
