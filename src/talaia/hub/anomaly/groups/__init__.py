"""Several signals judged together, in each way of running of a machine."""
