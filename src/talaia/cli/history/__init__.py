"""``talaia history``: which server has a site's history, and how it moves."""
