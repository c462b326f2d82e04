"""The hub: accounts, live fan-out, history, commands and the dashboard it serves."""
