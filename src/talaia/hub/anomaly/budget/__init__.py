"""How often detectors may cry: thresholds from what they said of the past."""
