"""The rosbridge adapter (rosbridge v2 protocol, JSON or CBOR)."""
