"""``talaia support-bundle``: what a helper needs to know, without secrets."""
