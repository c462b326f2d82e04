"""Talaia: a self-hosted control room for robots and robotic observatories."""

__version__: str


def __getattr__(name: str) -> str:
    """Give `__version__`, which git is asked for in a checkout: only where somebody wants it."""
    if name != "__version__":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from talaia.own_version import own_version

    return own_version()
