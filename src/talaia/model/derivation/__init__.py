"""Signals that are worked out from other signals: their source, their order, their units."""
