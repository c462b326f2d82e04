"""Units, time zones, astronomy and what single words of a description must look like."""
