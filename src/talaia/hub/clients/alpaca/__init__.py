"""The hub as an ASCOM Alpaca server: domes, weather and safety of one site."""
