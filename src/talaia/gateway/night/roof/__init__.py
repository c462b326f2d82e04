"""What opens a night's roof, and what brings roof and telescope to rest."""
