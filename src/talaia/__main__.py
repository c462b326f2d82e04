"""``python -m talaia`` is the ``talaia`` command."""

from talaia.cli.main import main

if __name__ == "__main__":
    raise SystemExit(main())
