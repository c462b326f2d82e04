"""Alarms and anomaly detection as values."""
