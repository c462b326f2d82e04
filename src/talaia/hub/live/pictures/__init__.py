"""Pictures of cameras: from gateways to pages."""
