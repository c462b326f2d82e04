"""What is said about driving."""
