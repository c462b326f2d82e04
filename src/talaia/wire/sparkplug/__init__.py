"""Sparkplug B: topics of `spBv1.0`, and payloads of metrics. No I/O here."""
