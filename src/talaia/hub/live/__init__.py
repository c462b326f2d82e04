"""What happens now: links, sockets, newest values, driving and pictures."""
