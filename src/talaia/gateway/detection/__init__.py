"""What the gateway sees on its cameras: counts, boxes and sightings."""
