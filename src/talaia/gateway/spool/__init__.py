"""What the hub has not stored yet, on disk, bounded."""
