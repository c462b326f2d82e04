"""A scrape and a remote read of several shards are what Prometheus would get of one hub."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest
from prometheus_client import CollectorRegistry, Counter, Gauge
from prometheus_client.exposition import generate_latest
from prometheus_client.openmetrics.exposition import generate_latest as generate_open
from prometheus_client.openmetrics.parser import text_string_to_metric_families as parse_open
from prometheus_client.parser import text_string_to_metric_families as parse_text

from talaia.hub.sharding.merged_metrics import join_metrics, join_past_series
from talaia.wire.errors import PeerError
from talaia.wire.prometheus.remote_read import PastSeries, encode_read_response
from talaia.wire.protobuf import bytes_field, read_bytes, read_fields


def scrape(write, pages: int, **sites: float) -> bytes:
    registry = CollectorRegistry()
    Gauge("talaia_pages_connected", "Pages", registry=registry).set(pages)
    clients = Gauge("talaia_clients_connected", "Clients", ["protocol"], registry=registry)
    clients.labels(protocol='a",site="b').set(pages)
    Counter("process_cpu_seconds", "Time", registry=registry).inc(pages)
    values = Gauge("talaia_signal_value", "Value", ["signal", "site"], registry=registry)
    for site, value in sites.items():
        values.labels(signal='odd "\\\n# TYPE x', site=site).set(value)
    return write(registry)


@pytest.mark.parametrize(
    ("write", "parse"), [(generate_open, parse_open), (generate_latest, parse_text)]
)
def test_each_family_stands_once_and_what_shards_tell_of_themselves_says_whose_it_is(
    write, parse
) -> None:
    bodies = {
        "main": scrape(write, 1, lab=1.5),
        "east": scrape(write, 2, agv=2.5, arm=3.5),
        "west": scrape(write, 3),
    }
    joined = join_metrics(bodies, "main").decode()
    families = list(parse(joined))
    assert len({family.name for family in families}) == len(families)
    samples = {
        (sample.name, *sorted(sample.labels.items())): sample.value
        for family in families
        for sample in family.samples
    }
    assert len(samples) == sum(len(family.samples) for family in families)
    pages = {key[1:]: value for key, value in samples.items() if key[0] == "talaia_pages_connected"}
    assert pages == {(): 1, (("shard", "east"),): 2, (("shard", "west"),): 3}
    by_protocol = [key[1:] for key in samples if key[0] == "talaia_clients_connected"]
    assert sorted(dict(labels).get("shard", "") for labels in by_protocol) == ["", "east", "west"]
    assert {dict(labels)["protocol"] for labels in by_protocol} == {'a",site="b'}
    values = {
        dict(key[1:])["site"]: (value, "shard" in dict(key[1:]))
        for key, value in samples.items()
        if key[0] == "talaia_signal_value"
    }
    assert values == {"lab": (1.5, False), "agv": (2.5, False), "arm": (3.5, False)}


@pytest.mark.parametrize("write", [generate_open, generate_latest])
def test_what_the_main_shard_alone_says_stays_as_it_is(write) -> None:
    body = scrape(write, 1, lab=1.5)
    assert join_metrics({"main": body}, "main") == body


def series(site: str) -> PastSeries:
    return PastSeries({"site": site}, np.array([1, 2]), np.array([0.5, 1.5]))


def packed(*results: list[PastSeries]) -> bytes:
    return pa.compress(encode_read_response(results), codec="snappy", asbytes=True)


def test_each_query_s_series_are_those_of_all_shards() -> None:
    joined = join_past_series(
        [
            packed([series("lab")], [], [series("lab")]),
            packed([series("agv"), series("arm")], [], []),
            packed([], [], [series("moon")]),
        ]
    )
    whole = [[series("lab"), series("agv"), series("arm")], [], [series("lab"), series("moon")]]
    expected = encode_read_response(whole)
    assert pa.decompress(joined, len(expected), codec="snappy", asbytes=True) == expected
    results = [read_bytes(value) for _, value in read_fields(expected)]
    assert [sum(1 for _ in read_fields(result)) for result in results] == [3, 0, 2]


def test_an_answer_that_says_it_is_endless_is_not_unpacked() -> None:
    with pytest.raises(PeerError, match="is over"):
        join_past_series([b"\xff\xff\xff\xff\x0f" + bytes_field(1, b"")])
