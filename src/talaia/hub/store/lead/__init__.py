"""Which of several hubs on one database leads."""
