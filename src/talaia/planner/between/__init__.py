"""What stands between exposures: the way to a block, and what it has in it beside frames."""
