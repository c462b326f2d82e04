"""``talaia import``: recordings and tables into a site's history."""
