"""What a killed run of the tests leaves on a server is dropped by the next, and nothing else."""

import pytest

from .databases import SERVERS, Run, empty_database, server_of


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
        assert living.rpartition("/")[2] in names
