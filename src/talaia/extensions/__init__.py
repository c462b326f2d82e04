"""Parts that other Python packages bring: what they declare, and how they are found."""
