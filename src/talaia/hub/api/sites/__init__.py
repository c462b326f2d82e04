"""Sites over HTTP: what they are, their gateways, alarms and anomalies."""
