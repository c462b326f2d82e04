"""``talaia anomalies``: detectors tried on tables."""
