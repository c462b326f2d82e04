"""From values of a robot to numbered, rate-limited, ordered samples."""
