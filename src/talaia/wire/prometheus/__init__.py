"""What Prometheus says to a server of past values, and is answered. No I/O here."""
