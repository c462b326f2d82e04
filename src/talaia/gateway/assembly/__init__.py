"""Builds groups of the gateway's parts."""
