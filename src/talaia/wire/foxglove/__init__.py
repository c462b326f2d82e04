"""The Foxglove WebSocket protocol, as ``foxglove.websocket.v1`` and ``foxglove.sdk.v1`` speak it.

Both carry the same messages (https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md); the
newer name tells that the server may send what was added later.
"""
