"""Pictures of the sky: stars on them, focus, plate solving, guiding. Pure, by numpy and sep."""
