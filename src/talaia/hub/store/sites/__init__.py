"""Sites in the database: gateways, descriptions, recordings, sightings."""
