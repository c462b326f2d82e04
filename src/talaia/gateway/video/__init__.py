"""Pictures at the gateway: from what a camera gives to what viewers and detectors want."""
