"""``talaia update``: signs releases, installs them beside the one that runs, and starts them."""
