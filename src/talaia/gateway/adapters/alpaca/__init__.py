"""The ASCOM Alpaca adapter: devices of a server that speaks HTTP and JSON."""
