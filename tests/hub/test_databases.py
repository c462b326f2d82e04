"""What a killed run of the tests leaves on a server is dropped by the next, and nothing else."""

import pytest
import sqlalchemy as sa

from .databases import SERVERS, Run, empty_database, needed_run_of, origin_of, server_of


@pytest.mark.parametrize("kind", sorted(SERVERS))
def test_a_killed_run_s_databases_are_dropped_and_a_living_one_s_are_not(kind) -> None:
    with empty_database(kind) as living:
        url = server_of(kind)[0]
        killed = Run(kind, url)
        left = killed.make()
        next_one = Run(kind, url)
        assert left in next_one.names()
        killed.end()
        next_one.tidy()
        names = next_one.names()
        next_one.end()
        assert left not in names
        assert sa.make_url(living).database in names


def rows_in(run: Run, name: str) -> dict[str, list]:
    """Give all that a database holds, and the number of the next row of each table."""
    tables = [row[0] for row in run.execute(f"SHOW TABLES FROM {name}")]
    rows = {table: list(run.execute(f"SELECT * FROM {name}.{table}")) for table in tables}  # noqa: S608 - names of ours
    return {**rows, "numbers": sorted(run.counters(name).items())}


def test_a_database_that_is_lent_again_is_as_if_it_were_new() -> None:
    run, origin = needed_run_of("mariadb"), origin_of("mariadb")
    lent = run.lend(origin)
    new = rows_in(run, lent)
    run.execute(f"INSERT INTO {lent}.roles (name, seeded) VALUES ('somebody', 0)")  # noqa: S608 - names of ours
    run.execute(f"DELETE FROM {lent}.role_permissions")  # noqa: S608 - names of ours
    run.execute(f"UPDATE {lent}.alembic_version SET version_num = 'none'")  # noqa: S608 - names of ours
    assert rows_in(run, lent) != new
    run.take_back(lent, origin)
    assert run.lend(origin) == lent
    assert rows_in(run, lent) == new == rows_in(run, origin)
    run.execute(f"CREATE VIEW {lent}.more AS SELECT 1")
    run.take_back(lent, origin)
    assert lent not in run.names()
