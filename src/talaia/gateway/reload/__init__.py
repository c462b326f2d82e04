"""Changes of the site description while the gateway runs."""
