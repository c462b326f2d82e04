"""The night planner: requests, sky and time in, plans with reasons out. Pure.

It knows no network, disk nor clock. Times go in and out as seconds since the epoch (UTC); inside
they are whole seconds of the night. The way through it:

    from talaia.planner.from_requests import make_night
    from talaia.planner.session import PlanningSession
    from talaia.planner.sky import TelescopePlace

    problem = make_night(TelescopePlace(42.05, 0.73, 1570.0), now, instrument=instrument,
                         proposals=proposals, groups=groups)
    session = PlanningSession(problem)
    decision = session.decide(now)       # .request and .not_before, or .wait_until; .reason

What happens is handed over by `add_requests`, `remove_requests`, `complete_request`,
`suspend_request` (frames that were read out are kept), `hold_request`, `close_roof`, `open_roof`
and `set_conditions`; then `decide` is asked again. `interrupt` tells whether a rapid request ends
the block under way. `plan` gives the rest of the night as `talaia.model.observing.plan.Plan`, and
`why_not` a reason for each request that is not observed now. The session is plain Python and
numpy: it may live in any process, and calls of it take up to the time that they are given.
"""
