"""How long tests wait for what must come.

Only what never comes takes so long: a machine that stands still for a minute fails no test. What
the product promises about time has a bound of its own, in the test that is about it.
"""

PATIENCE_S = 180.0
PATIENCE_MS = PATIENCE_S * 1000
