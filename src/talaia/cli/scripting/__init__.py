"""Commands that ask a hub by a person's token: watch, get, call, record."""
