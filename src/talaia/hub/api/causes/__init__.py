"""From an anomaly, alarm or event to its cause."""
