"""Checking a site description."""
