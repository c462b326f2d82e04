"""Hub and gateway of one site on this machine, for `talaia up`."""
