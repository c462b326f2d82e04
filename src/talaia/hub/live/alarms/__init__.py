"""Live alarms: conditions judged, states kept and shown."""
