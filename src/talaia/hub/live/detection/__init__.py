"""What is detected: objects on pictures and anomalies of signals."""
