"""Anomaly detection: pure, one sample at a time, without clock or socket."""
