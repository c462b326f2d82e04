"""Histories on more than one server: which has a site's, and how one moves."""
