"""The process beside the robot: reads it, drives it, keeps it safe, and dials the hub."""
