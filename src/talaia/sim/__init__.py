"""Robots that are not there: simulators that ship with the product and are its test peers."""
