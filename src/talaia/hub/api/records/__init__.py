"""What is kept, over HTTP: history, archive, recordings, sightings, audit log."""
