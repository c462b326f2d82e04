"""Messages of recordings, read at a moment for pages that look back."""
