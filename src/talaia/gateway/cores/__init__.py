"""What the cores of the gateway's computer bear, and how it is shared out."""
