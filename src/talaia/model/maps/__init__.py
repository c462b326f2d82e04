"""Where a site is on a map: its local frame on Earth, zones, and plans of floors."""
