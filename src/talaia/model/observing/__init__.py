"""What is asked of an observatory's nights: proposals, requests, their states, plans. Pure values.

The vocabulary is Las Cumbres Observatory's (proposal, request group, request, configuration,
window, constraints). Times are seconds since the epoch (UTC), angles degrees, coordinates ICRS.
"""
