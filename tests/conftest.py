"""Settings of all tests."""

from hypothesis import settings

# How long an example takes says how busy the machine is; timings are `bench/`'s matter.
settings.register_profile("talaia", deadline=None)
settings.load_profile("talaia")
