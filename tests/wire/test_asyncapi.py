"""The AsyncAPI document holds for what is really said: every message, in its JSON form."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import msgspec
import pytest
import yaml

from talaia.wire.message import Codec

from .test_codec import full, shapes

DOCUMENT: dict[str, Any] = yaml.safe_load(
    (Path(__file__).parents[2] / "docs" / "reference" / "asyncapi.yaml").read_text()
)


def at(reference: str) -> Any:
    found: Any = DOCUMENT
    for key in reference.removeprefix("#/").split("/"):
        found = found[key]
    return found


def name_of(shape: type[msgspec.Struct]) -> str:
    subject = shape.__module__.rpartition(".")[0]
    room = "frames" if subject.endswith("gateway_messages") else "browser"
    return f"{room}.{shape.__name__}"


@pytest.mark.parametrize(
    ("codec", "shape"), shapes(), ids=lambda each: getattr(each, "__name__", "")
)
def test_the_json_form_of_every_message_is_what_the_document_says(
    codec: Codec, shape: type[msgspec.Struct]
) -> None:
    message = DOCUMENT["components"]["messages"][name_of(shape)]
    assert message["name"] == shape.__struct_config__.tag
    said = json.loads(codec.encode_text(full(shape)))
    schema = {**message["payload"], "components": DOCUMENT["components"]}
    properties = set(at(message["payload"]["$ref"])["properties"])
    assert properties == {"t", *(each.encode_name for each in msgspec.structs.fields(shape))}
    jsonschema.validate(said, schema)
    # A later version may say more, and a wrong kind is none.
    jsonschema.validate({**said, "later": [1]}, schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({**said, "t": "another"}, schema)


def test_every_message_is_sent_one_way_on_a_channel_that_has_it() -> None:
    told = {
        at(each["$ref"])["$ref"].rpartition("/")[2]
        for operation in DOCUMENT["operations"].values()
        for each in operation["messages"]
    }
    assert told == {name_of(shape) for _, shape in shapes()}
    assert {each["action"] for each in DOCUMENT["operations"].values()} == {"send", "receive"}
    for operation in DOCUMENT["operations"].values():
        assert at(operation["channel"]["$ref"])["address"].startswith("/")
        assert at(operation["security"][0]["$ref"])["type"] in {"http", "httpApiKey"}
